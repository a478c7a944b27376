mod as_a_localizer;
mod cases;
mod drive;
mod joint;
mod place;
mod tracking;

mod worked_examples;

use super::correspondence::{Relation, Tolerances, keep_consistent, predicted, relate};
use rumbo_core::frames::{Pose2, pose2};
use rumbo_kit::landmarks::{Landmark, LandmarkKind};

fn wall(distance_m: f64, bearing_deg: f64) -> Landmark {
    let kind = LandmarkKind::Wall { length_m: 1.0, unit_covariance: [0.05, 0.0, 0.05], unevenness_m: 0.0 };
    Landmark { distance_m, bearing_rad: bearing_deg.to_radians(), kind, beams: [0; 2] }
}

fn corner([x, y]: [f64; 2]) -> Landmark {
    Landmark {
        distance_m: x.hypot(y),
        bearing_rad: y.atan2(x),
        kind: LandmarkKind::Corner { spacing_m: 0.02 },
        beams: [0; 2],
    }
}

const WITHIN: Tolerances = Tolerances { search_m: 0.30, distance_m: 0.10, angle_rad: 0.1 };

/// Landmarks on all sides.
fn surroundings() -> Vec<Landmark> {
    let mut marks = vec![wall(3.0, 30.0), wall(2.0, -60.0), wall(1.0, 120.0)];
    marks.extend([[4.0, 4.5], [2.5, -1.5], [-0.8, 0.45], [3.0, 0.5]].map(corner));
    marks
}

fn seen_from(a_from_b: &Pose2) -> Vec<Landmark> {
    surroundings().iter().map(|mark| predicted(mark, a_from_b)).collect()
}

#[test]
fn a_landmark_looks_from_the_place_itself_as_it_does_from_there_and_back() {
    for there in [pose2(0.5, -0.3, 0.4), pose2(-1.0, 0.7, -2.9)] {
        for mark in surroundings() {
            let back = predicted(&predicted(&mark, &there), &there.inverse());
            let ([x, y], [bx, by]) = (mark.position(), back.position());
            assert!((x - bx).hypot(y - by) < 1e-12, "{mark:?} {back:?}");
        }
    }
    // One meter beyond a wall that was two meters ahead, its normal points back.
    let behind = predicted(&wall(2.0, 0.0), &pose2(3.0, 0.0, 0.0));
    assert!(
        (behind.distance_m - 1.0).abs() < 1e-12
            && (behind.bearing_rad.abs() - std::f64::consts::PI).abs() < 1e-9
    );
}

#[test]
fn landmarks_find_their_partners_although_the_odometry_is_off() {
    let truth = pose2(0.4, 0.1, 0.2);
    let relations = relate(&surroundings(), &seen_from(&truth), &pose2(0.45, 0.05, 0.22), &WITHIN);
    assert_eq!(relations.len(), surroundings().len());
    for relation in &relations {
        let expected = predicted(&relation.known, &truth);
        assert!((expected.distance_m - relation.seen.distance_m).abs() < 1e-9);
    }
    assert!(relate(&surroundings(), &[], &truth, &WITHIN).is_empty());
    assert!(relate(&[], &surroundings(), &truth, &WITHIN).is_empty());
}

#[test]
fn what_walks_by_is_dropped_and_what_stands_kept() {
    let truth = pose2(0.4, 0.1, 0.2);
    let mut seen = seen_from(&truth);
    let walked = seen.len() - 1;
    let [x, y] = seen[walked].position();
    seen[walked] = corner([x + 0.15, y - 0.12]);
    let relations = relate(&surroundings(), &seen, &truth, &WITHIN);
    assert_eq!(relations.len(), seen.len() - 1);
    assert!(relations.iter().all(|relation| relation.seen != seen[walked]));
    // Walls with turned normals go as well.
    let pair = |known: Landmark, seen: Landmark, off_m| Relation { known, seen, off_m };
    let mut walls = vec![
        pair(wall(1.0, 0.0), wall(1.0, 0.0), 0.0),
        pair(wall(1.0, 90.0), wall(1.0, 90.0), 0.0),
        pair(wall(1.0, 45.0), wall(1.0, 55.0), 0.1),
    ];
    keep_consistent(&mut walls, &WITHIN);
    assert_eq!(walls.len(), 2);
}
