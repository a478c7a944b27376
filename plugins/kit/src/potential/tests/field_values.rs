use super::warehouse::{REPULSION, field, groups};
use crate::potential::{
    Attraction, ChargeForce, ChargeLaw, Field, Form, Obstacles, Piece, Repulsion, without_approach,
};
use nalgebra::{Point2, Vector2};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

const LAW: ChargeLaw =
    ChargeLaw { strength: 8.0, exponent: 2.0, force: ChargeForce::Consistent, range_m: f64::INFINITY };
const CHARGES: [[f64; 2]; 2] = [[20.7071, 15.7071], [18.0, 15.6]];

/// FC-A1, first part.
#[test]
fn potentials_and_forces_are_the_published_ones() {
    let text = include_str!("../../../tests/data/potential/fc_field_samples.csv");
    let obstacles = Obstacles::new(&groups(), 2.0).unwrap();
    let charges = CHARGES.map(Point2::from);
    let mut n_rows = 0;
    for line in text.lines().skip(1) {
        let v: Vec<f64> = line.split(',').map(|word| word.trim().parse().unwrap()).collect();
        let at = Point2::new(v[0], v[1]);
        let same = |found: f64, column: usize| {
            // The file has nine digits.
            let allowed = 1e-8 * v[column].abs().max(1.0);
            assert!((found - v[column]).abs() <= allowed, "{at} column {column}: {found} {}", v[column]);
        };
        let bare = Obstacles::new(&[], 2.0).unwrap();
        for (form, first) in [(Form::Conic, 2), (Form::Quadratic, 5)] {
            let drawn = field(&bare, form).sample(at);
            same(drawn.potential, first);
            same(drawn.force.x, first + 1);
            same(drawn.force.y, first + 2);
            let whole = field(&obstacles, form).sample(at);
            same(whole.potential - drawn.potential, 8);
            same(whole.repulsion.x, 9);
            same(whole.repulsion.y, 10);
            assert!((whole.force - drawn.force - whole.repulsion).norm() < 1e-12);
        }
        same(LAW.potential_at(at, &charges), 11);
        let force = LAW.force_at(at, &charges);
        same(force.x, 12);
        same(force.y, 13);
        let printed = ChargeLaw { force: ChargeForce::Printed, ..LAW }.force_at(at, &charges);
        same(printed.x, 14);
        same(printed.y, 15);
        n_rows += 1;
    }
    assert_eq!(n_rows, 13);
}

/// FC-A1, second part: every form, inflated obstacles, fading repulsion, charges of other exponents.
#[test]
fn forces_are_central_differences_of_the_potential() {
    const STEP: f64 = 1e-5;
    let obstacles = Obstacles::new(&groups(), 2.5).unwrap();
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(8);
    let charges: Vec<Point2<f64>> =
        (0..5).map(|_| Point2::new(rng.random_range(0.0..40.0), rng.random_range(0.0..30.0))).collect();
    let mut n_points = 0;
    while n_points < 1000 {
        let at = Point2::new(rng.random_range(0.2..39.8), rng.random_range(0.2..29.8));
        let form = [Form::Conic, Form::Quadratic, Form::Combined { radius_m: 5.0 }][n_points % 3];
        let inflation_m = [0.0, 0.3][n_points % 2];
        let goal_scaling_m = [None, Some(6.0)][n_points / 2 % 2];
        let goal = [Point2::new(20.0, 25.0), Point2::new(8.0, 24.3)][n_points / 4 % 2];
        let repulsion = Repulsion { inflation_m, ..REPULSION };
        let field = Field { repulsion, goal_scaling_m, goal, ..field(&obstacles, form) };
        let law = ChargeLaw { exponent: [2.0, 3.5][n_points % 2], ..LAW };
        let d = (at - goal).norm();
        let mut is_smooth = d > 0.05 && (d - 5.0).abs() > 0.01 && (d - 6.0).abs() > 0.01;
        obstacles.near(at, |nearest| {
            let rho = nearest.distance_m - inflation_m;
            is_smooth &= rho > 0.05 && (rho - 2.0).abs() > 0.05;
        });
        is_smooth &= charges.iter().all(|charge| (at - charge).norm() > 0.5);
        if !is_smooth || beside_a_medial_line(at) {
            continue;
        }
        let potential = |at: Point2<f64>| field.sample(at).potential + law.potential_at(at, &charges);
        let slope =
            |axis: Vector2<f64>| (potential(at - axis * STEP) - potential(at + axis * STEP)) / (2.0 * STEP);
        let force = field.sample(at).force + law.force_at(at, &charges);
        let difference = Vector2::new(slope(Vector2::x()), slope(Vector2::y()));
        let allowed = 1e-5 * force.norm().max(1.0);
        assert!((force - difference).norm() < allowed, "{at}: {force:?} {difference:?}");
        n_points += 1;
    }
}

/// Inside a rack the nearest side of the same obstacle changes with a kink.
fn beside_a_medial_line(at: Point2<f64>) -> bool {
    groups().iter().filter(|group| group.len() == 4).any(|rack| {
        let xs = rack.iter().map(|piece| piece.from.x);
        let ys = rack.iter().map(|piece| piece.from.y);
        let (x0, x1) = (xs.clone().fold(f64::INFINITY, f64::min), xs.fold(0.0, f64::max));
        let (y0, y1) = (ys.clone().fold(f64::INFINITY, f64::min), ys.fold(0.0, f64::max));
        at.x > x0 && at.x < x1 && at.y > y0 && at.y < y1
    })
}

#[test]
fn a_fading_repulsion_makes_a_goal_beside_a_wall_the_lowest_place() {
    let wall = vec![Piece::between(Point2::new(-9.0, 0.0), Point2::new(9.0, 0.0))];
    let obstacles = Obstacles::new(&[wall], 2.0).unwrap();
    let goal = Point2::new(0.0, 0.3);
    let attraction = Attraction { form: Form::Conic, strength: 1.0 };
    let field = |goal_scaling_m| Field {
        goal,
        attraction,
        obstacles: &obstacles,
        repulsion: REPULSION,
        goal_scaling_m,
    };
    let around = |field: Field<'_>| {
        let angles = (0..16).map(|k| f64::from(k) * std::f64::consts::TAU / 16.0);
        let places = angles.map(|a| goal + Vector2::new(a.cos(), a.sin()) * 0.02);
        places.filter(|at| field.sample(*at).force.dot(&(goal - at)) > 0.0).count()
    };
    assert_eq!(around(field(Some(2.0))), 16);
    assert!(around(field(None)) < 16);
}

#[test]
fn the_push_of_an_obstacle_has_its_inverse() {
    for push in [0.01, 0.5, 3.0, 200.0] {
        let repulsion = Repulsion { inflation_m: 0.2, ..REPULSION };
        let distance_m = repulsion.distance_of_push_m(push);
        assert!((repulsion.push(distance_m) - push).abs() < 1e-6 * push, "{push}");
    }
    // In front of a flat face the conic attraction of strength 1 is balanced at 1 m.
    assert!((REPULSION.distance_of_push_m(0.5) - 1.0).abs() < 1e-9);
}

#[test]
fn near_an_obstacle_nothing_is_left_of_the_way_into_it() {
    let p = |x: f64, y: f64| Point2::new(x, y);
    let walls =
        [vec![Piece::between(p(0.0, 0.0), p(9.0, 0.0))], vec![Piece::between(p(0.0, 0.0), p(0.0, 9.0))]];
    let obstacles = Obstacles::new(&walls, 2.0).unwrap();
    let kept = |at, force| without_approach(force, at, &obstacles, 0.3);
    assert_eq!(kept(p(5.0, 0.2), Vector2::new(1.0, -2.0)), Vector2::new(1.0, 0.0));
    assert_eq!(kept(p(5.0, 0.2), Vector2::new(1.0, 2.0)), Vector2::new(1.0, 2.0));
    assert_eq!(kept(p(5.0, 0.4), Vector2::new(1.0, -2.0)), Vector2::new(1.0, -2.0));
    assert_eq!(kept(p(0.2, 0.2), Vector2::new(-1.0, -2.0)).norm(), 0.0);
    // Two walls at a sharp angle: away from one is into the other.
    let wedge =
        [vec![Piece::between(p(0.0, 0.0), p(9.0, 0.0))], vec![Piece::between(p(0.0, 0.0), p(9.0, 2.0))]];
    let obstacles = Obstacles::new(&wedge, 2.0).unwrap();
    let inwards = without_approach(Vector2::new(-1.0, -0.5), p(1.0, 0.1), &obstacles, 0.3);
    assert_eq!(inwards.norm(), 0.0);
}
