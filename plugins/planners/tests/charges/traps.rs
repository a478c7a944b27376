//! Where the method ends: FC-A9.

use super::scene::{Scene, has_arrived};
use rumbo_core::frames::Point2;
use rumbo_kit::potential::{Group, Obstacles, Piece, outlines_of_lines};
use rumbo_planners::fictitious_charges::FictitiousChargesParams;
use rumbo_planners::field_descent::descent::{End, Walk};

fn line(x0: f64, y0: f64, x1: f64, y1: f64) -> Piece {
    Piece::between(Point2::new(x0, y0), Point2::new(x1, y1))
}

/// The hall's walls and a U that is open towards the start.
fn trap(width_m: f64, depth_m: f64) -> Scene {
    let (left, right, back, legs) = (20.0 - 0.5 * width_m, 20.0 + 0.5 * width_m, 18.0, 18.0 - depth_m);
    let mut groups: Vec<Group> = super::warehouse::groups().into_iter().take(4).collect();
    groups.push(vec![
        line(left, back, right, back),
        line(left, legs, left, back),
        line(right, legs, right, back),
    ]);
    Scene { groups, goal: super::warehouse::goal() }
}

fn each_trap(mut look: impl FnMut(f64, f64, Point2, Scene)) {
    for width_m in [4.0, 6.0, 8.0] {
        for depth_m in [1.0, 2.0, 3.0, 4.0, 6.0] {
            for start in [[20.0, 4.0], [18.5, 6.0], [20.0, 16.5]] {
                look(width_m, depth_m, Point2::from(start), trap(width_m, depth_m));
            }
        }
    }
}

fn crosses(groups: &[Group], walk: &Walk) -> bool {
    let side = |a: Point2, b: Point2, c: Point2| (b - a).perp(&(c - a));
    walk.points.windows(2).any(|step| {
        groups.iter().flatten().any(|piece| {
            side(piece.from, piece.to, step[0]) * side(piece.from, piece.to, step[1]) < 0.0
                && side(step[0], step[1], piece.from) * side(step[0], step[1], piece.to) < 0.0
        })
    })
}

/// As published: without a clearance that is kept.
#[test]
fn at_least_forty_of_forty_five_traps_are_left_by_the_sources_method() {
    let params =
        FictitiousChargesParams { minimum_clearance_m: Some(0.0), ..FictitiousChargesParams::default() };
    let (mut n_arrived, mut failures) = (0, Vec::new());
    each_trap(|width_m, depth_m, start, scene| {
        let walk = scene.charged(&params, start);
        assert!(!crosses(&scene.groups, &walk), "{width_m} {depth_m} {start}");
        n_arrived += usize::from(has_arrived(&walk));
        if !has_arrived(&walk) {
            failures.push(format!("{width_m} x {depth_m} from {start}: {:?}", walk.end));
        }
    });
    // Exactly those that the reference failed in.
    let published = [
        "4 x 6 from {20, 4}: TooManyCharges",
        "4 x 6 from {18.5, 6}: TooManyCharges",
        "4 x 6 from {20, 16.5}: TooManyCharges",
        "6 x 3 from {18.5, 6}: TooManyCharges",
        "6 x 6 from {18.5, 6}: TooManyCharges",
    ];
    assert_eq!((n_arrived, failures), (40, published.map(String::from).to_vec()));
}

/// With the clearance that a robot needs: every run arrives and keeps it, or ends with a name.
#[test]
fn with_a_clearance_every_trap_is_left_or_named() {
    let params = FictitiousChargesParams::default();
    let (mut n_arrived, mut failures) = (0, Vec::new());
    each_trap(|width_m, depth_m, start, scene| {
        let walk = scene.charged(&params, start);
        assert!(!crosses(&scene.groups, &walk), "{width_m} {depth_m} {start}");
        assert!(walk.clearance_m >= 0.3 - 1e-9, "{width_m} x {depth_m} from {start}: {}", walk.clearance_m);
        n_arrived += usize::from(has_arrived(&walk));
        if !has_arrived(&walk) {
            assert!(matches!(walk.end, End::TooManyCharges | End::OutOfSteps), "{:?}", walk.end);
            failures.push(format!("{width_m} x {depth_m} from {start}: {:?}", walk.end));
        }
    });
    assert!(n_arrived >= 44, "{n_arrived}: {failures:#?}");
}

/// As the planner itself groups lines: the U's legs and its back are obstacles of their own, since it bends inwards between
/// them. All runs arrive.
#[test]
fn every_trap_is_left_where_it_is_parted_at_its_inward_corners() {
    let params = FictitiousChargesParams::default();
    each_trap(|width_m, depth_m, start, scene| {
        let lines: Vec<[Point2; 2]> =
            scene.groups.iter().flatten().map(|piece| [piece.from, piece.to]).collect();
        let scene = Scene { groups: outlines_of_lines(&lines, start), ..scene };
        assert_eq!(scene.groups.len(), 7);
        let walk = scene.charged(&params, start);
        assert!(has_arrived(&walk), "{width_m} x {depth_m} from {start}: {:?}", walk.end);
        assert!(!crosses(&scene.groups, &walk), "{width_m} {depth_m} {start}");
        assert!(walk.clearance_m >= 0.3 - 1e-9, "{width_m} x {depth_m} from {start}: {}", walk.clearance_m);
    });
}

/// FC-A10: a closed cell around the goal.
#[test]
fn a_closed_cell_around_the_goal_ends_with_all_charges_placed() {
    let mut groups: Vec<Group> = super::warehouse::groups().into_iter().take(4).collect();
    groups.push(vec![
        line(17.0, 22.0, 23.0, 22.0),
        line(23.0, 22.0, 23.0, 28.0),
        line(23.0, 28.0, 17.0, 28.0),
        line(17.0, 28.0, 17.0, 22.0),
    ]);
    let scene = Scene { groups, goal: super::warehouse::goal() };
    let walk = scene.charged(&FictitiousChargesParams::default(), Point2::new(20.0, 10.0));
    assert_eq!((walk.end, walk.charges.len()), (End::TooManyCharges, 40));
    assert!(!crosses(&scene.groups, &walk));
    let obstacles = Obstacles::new(&scene.groups, 2.0).unwrap();
    assert!(walk.points.iter().all(|at| obstacles.clearance_m(*at) >= 0.3 - 1e-9));
}
