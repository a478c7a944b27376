//! Scans that are joined.

use super::super::panorama::{Panorama, union_of_landmarks};
use super::super::sighting::Sighting;
use super::super::traced_beams::TracedBeams;
use super::*;
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Pose2, Pose3, lift, pose2};
use rumbo_core::messages::LaserScan;
use rumbo_core::time::Time;
use rumbo_kit::landmarks::{BeamFan, Extractor, LandmarkSettings};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// The exact scan of half a turn ahead, from a base in the room.
pub fn half(known: &Knowledge, map_from_base: &Pose2, mount: &Pose2, odom_from_base: Pose2) -> Sighting {
    let fan = BeamFan {
        first_bearing_rad: -FRAC_PI_2,
        bearing_step_rad: 0.5_f64.to_radians(),
        min_range_m: 0.02,
        max_range_m: 8.0,
    };
    let sensor = known.grid.grid_from_map() * map_from_base * mount;
    let direction = |k: usize| {
        let (sin, cos) = (fan.first_bearing_rad + fan.bearing_step_rad * k as f64).sin_cos();
        [cos, sin]
    };
    let directions: Vec<[f64; 2]> = (0..361).map(direction).collect();
    let origin = [sensor.translation.x / CELL_M, sensor.translation.y / CELL_M];
    let mut ranges_m = Vec::new();
    known.surroundings.scan(origin, sensor.rotation.angle(), &directions, 8.0, &mut ranges_m);
    Sighting { stamp: Time::ZERO, odom_from_base, base_from_sensor: *mount, fan, ranges_m }
}

/// Both halves, seen from the second.
pub fn both(known: &Knowledge, map_from_base: &Pose2, mount: &Pose2) -> Vec<Sighting> {
    let before = map_from_base * Pose2::rotation(PI);
    let odom = pose2(3.0, -1.0, 0.7);
    vec![half(known, &before, mount, odom * Pose2::rotation(PI)), half(known, map_from_base, mount, odom)]
}

const AT: [f64; 3] = [2.3, 1.7, 0.4];

#[test]
fn two_halves_joined_are_what_is_around_wherever_the_laser_sits() {
    let known = knowledge(&room([0.0; 3]));
    let base = pose2(AT[0], AT[1], AT[2]);
    // Beside the axis, a laser does not see quite all around.
    for (mount, n_least) in [(Pose2::identity(), 360), (pose2(0.12, -0.05, 0.1), 340)] {
        let panorama = Panorama::of(&both(&known, &base, &mount), 360);
        assert!(panorama.n_readings() >= n_least, "{}", panorama.n_readings());
        let readings = panorama.readings().iter().enumerate();
        for (idx, reading) in readings.filter(|(_, reading)| reading.is_valid()) {
            let bearing = reading.place[1].atan2(reading.place[0]);
            let middle = TAU * idx as f64 / 360.0;
            assert!(rumbo_core::frames::wrap_angle(bearing - middle).abs() < 1.1_f64.to_radians());
            // Its end lies on the edge of something.
            let [x, y] = reading.place;
            let end = base * rumbo_core::frames::Point2::new(x, y);
            let on_wall = (-1..=1).any(|d_col| {
                (-1..=1).any(|d_row| {
                    let by = 0.012;
                    let near = end + nalgebra::Vector2::new(by * f64::from(d_col), by * f64::from(d_row));
                    known
                        .grid
                        .cell_at(near)
                        .is_some_and(|cell| known.grid.cells[known.grid.index_of(cell)] > 0.0)
                })
            });
            assert!(on_wall, "{mount}: direction {idx} ends at {end}");
        }
    }
}

#[test]
fn walls_at_the_seams_are_whole_in_the_panorama_and_cut_in_the_union() {
    let known = knowledge(&room([0.0; 3]));
    // The seams, on the left and the right, lie in the lower wall and the upper.
    let sightings = both(&known, &pose2(AT[0], AT[1], 0.0), &Pose2::identity());
    let mut extractor = Extractor::new(LandmarkSettings::default());
    let joined = Panorama::of(&sightings, 360).landmarks(&mut extractor, 8.0);
    let union = union_of_landmarks(&sightings, &mut extractor, TAU / 360.0);
    let lower = |landmarks: &[rumbo_kit::landmarks::Landmark]| -> Vec<f64> {
        let is_lower =
            |l: &&rumbo_kit::landmarks::Landmark| l.is_wall() && (l.bearing_rad + FRAC_PI_2).abs() < 0.05;
        landmarks.iter().filter(is_lower).filter_map(|l| l.extent_m()).collect()
    };
    let (joined, union) = (lower(&joined), lower(&union));
    assert!(joined.len() == 1 && (joined[0] - 5.0).abs() < 0.15, "{joined:?}");
    assert!(union.len() == 2 && union.iter().all(|length| *length < 3.0), "{union:?}");
}

#[test]
fn ways_are_open_only_where_everything_was_seen_to_be_free() {
    let known = knowledge(&room([0.0; 3]));
    let base = pose2(AT[0], AT[1], 0.0);
    let panorama = Panorama::of(&both(&known, &base, &Pose2::identity()), 360);
    // To the right wall there are 2.75 m.
    assert!(panorama.is_open(0.0, 2.4, 0.3) && !panorama.is_open(0.0, 2.5, 0.3));
    assert!(panorama.is_open(PI, 1.9, 0.3) && !panorama.is_open(PI, 2.1, 0.3));
    // A gap between beams is no gap for a robot.
    assert!(!panorama.is_open(0.93, 1.6, 0.3));
    // Nobody looked back.
    let ahead = Panorama::of(&[half(&known, &base, &Pose2::identity(), Pose2::identity())], 360);
    assert!(ahead.is_open(0.0, 1.0, 0.3) && !ahead.is_open(PI, 0.5, 0.3));
    assert!(!Panorama::of(&[], 360).is_open(0.0, 0.1, 0.1));
}

#[test]
fn beams_at_the_true_pose_end_where_they_are_expected() {
    for origin in [[0.0; 3], [-4.0, 3.0, 0.6]] {
        let known = knowledge(&room(origin));
        let base = known.grid.map_from_grid() * pose2(AT[0], AT[1], AT[2]);
        for mount in [Pose2::identity(), pose2(0.2, 0.1, 0.3)] {
            let sightings = both(&known, &base, &mount);
            let comparisons = TracedBeams::of(&sightings, 360).compare(&known, &base, &[0.0; 2]);
            assert!((350..=370).contains(&comparisons.len()), "{}", comparisons.len());
            for comparison in comparisons {
                let super::super::sighting::Beam::Hit(range_m) = comparison.beam else { panic!("a wall") };
                assert!((range_m - comparison.expected_m).abs() < 1e-6);
            }
        }
    }
}

fn scan(ranges_m: Vec<f32>, first_bearing_rad: f64, bearing_step_rad: f64) -> LaserScan {
    LaserScan {
        first_bearing_rad,
        bearing_step_rad,
        max_range_m: 20.0,
        ranges_m: Buffer::from(ranges_m),
        ..LaserScan::default()
    }
}

#[test]
fn odd_scans_make_panoramas_without_readings() {
    let ranges = [vec![], vec![f32::NAN; 181], vec![f32::INFINITY; 181], vec![-1.0; 181], vec![0.0; 5]];
    for ranges in ranges {
        for step in [1f64.to_radians(), 0.0, 1e9, -0.01] {
            let odd = scan(ranges.clone(), -1.0, step);
            let sighting = Sighting::of(&odd, Time::ZERO, &Pose3::identity(), Pose2::identity(), 8.0);
            let sightings = [sighting.unwrap()];
            let panorama = Panorama::of(&sightings, 360);
            assert_eq!(panorama.n_readings(), 0, "{ranges:?}");
            let mut extractor = Extractor::new(LandmarkSettings::default());
            assert!(panorama.landmarks(&mut extractor, 8.0).is_empty());
            assert!(union_of_landmarks(&sightings, &mut extractor, TAU / 360.0).is_empty());
        }
    }
    let nowhere = scan(vec![1.0; 9], f64::NAN, 0.1);
    assert!(Sighting::of(&nowhere, Time::ZERO, &Pose3::identity(), Pose2::identity(), 8.0).is_none());
    let leaning = Pose3::rotation(nalgebra::Vector3::new(0.0, 0.4, 0.0));
    assert!(
        Sighting::of(&scan(vec![1.0; 9], 0.0, 0.1), Time::ZERO, &leaning, Pose2::identity(), 8.0).is_none()
    );
    // An odometer at not-a-number makes readings nowhere, not anywhere.
    let good = scan(vec![1.0; 361], -FRAC_PI_2, 0.5_f64.to_radians());
    let at = |odom: Pose2| Sighting::of(&good, Time::ZERO, &lift(&Pose2::identity()), odom, 8.0).unwrap();
    let panorama = Panorama::of(&[at(pose2(f64::NAN, 0.0, 0.0)), at(Pose2::identity())], 360);
    assert!((179..=183).contains(&panorama.n_readings()), "{}", panorama.n_readings());
}

#[test]
fn a_laser_upside_down_sweeps_the_other_way() {
    let known = knowledge(&room([0.0; 3]));
    let upright = half(&known, &pose2(AT[0], AT[1], AT[2]), &Pose2::identity(), Pose2::identity());
    let mut ranges: Vec<f32> = upright.ranges_m.iter().map(|range| *range as f32).collect();
    ranges.reverse();
    let turned = Pose3::rotation(nalgebra::Vector3::new(PI, 0.0, 0.0));
    let scan = scan(ranges, -FRAC_PI_2, 0.5_f64.to_radians());
    let sighting = Sighting::of(&scan, Time::ZERO, &turned, Pose2::identity(), 8.0).unwrap();
    let [one, other] = [upright, sighting].map(|sighting| Panorama::of(&[sighting], 360));
    for (a, b) in one.readings().iter().zip(other.readings()) {
        assert!(a.range_m.is_nan() && b.range_m.is_nan() || (a.range_m - b.range_m).abs() < 1e-3);
    }
}
