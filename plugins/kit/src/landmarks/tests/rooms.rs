//! Rooms whose corners and walls are known.

use super::*;

/// The longest of the walls found with this normal, in degrees.
fn wall_at(found: &[Landmark], normal_deg: f64) -> Landmark {
    let is_it = |mark: &&Landmark| {
        let off = rumbo_core::frames::wrap_angle(mark.bearing_rad - normal_deg.to_radians());
        mark.is_wall() && off.abs() < 0.03
    };
    *found.iter().filter(is_it).max_by(|a, b| a.extent_m().partial_cmp(&b.extent_m()).unwrap()).unwrap()
}

#[test]
fn walls_corners_and_edges_of_a_room_are_where_they_are() {
    for (turn_deg, settings) in
        [0.0, 17.0, -31.0].into_iter().flat_map(|t| [(t, LandmarkSettings::default()), (t, with_hough())])
    {
        let angle = f64::to_radians(turn_deg);
        let fan = BeamFan { first_bearing_rad: -2.3, ..half_turn(0.5) };
        let found = extract(settings, &fan, &scan(&room(angle), &fan, 530));
        let is_hough = settings.wall_fit == WallFit::Hough;
        let [far, turn] = if is_hough { [0.008, 0.006] } else { [1e-9, 1e-9] };
        for (normal_deg, distance) in [(0.0, 4.0), (90.0, 2.5), (-90.0, 1.5), (0.0, 1.5)] {
            let is_box = distance == 1.5 && normal_deg == 0.0;
            let wall = if is_box {
                let near = |m: &&Landmark| {
                    m.is_wall() && (m.distance_m - 1.5).abs() < 0.02 && m.extent_m().unwrap() < 0.9
                };
                *found.iter().find(near).unwrap()
            } else {
                wall_at(&found, normal_deg + turn_deg)
            };
            let off = rumbo_core::frames::wrap_angle(wall.bearing_rad - (normal_deg + turn_deg).to_radians());
            let near_distance = is_box || (wall.distance_m - distance).abs() <= far;
            assert!(near_distance && off.abs() <= turn, "{turn_deg} {normal_deg}: {wall:?}");
        }
        let place = |of: [f64; 2]| turned(of, angle);
        let is_there = |letters: &str, at: [f64; 2], within: f64| {
            found.iter().any(|mark| {
                let [x, y] = mark.position();
                letters.contains(mark.letter()) && (x - at[0]).hypot(y - at[1]) < within
            })
        };
        for corner in [[4.0, -1.5], [4.0, 2.5]] {
            assert!(is_there("e", place(corner), 0.12), "corner {corner:?}, {found:#?}");
        }
        // To the right of the box the far wall is seen first: what the box hides is to the left of its edge.
        assert!(is_there("i", place([1.5, -0.1]), 0.03), "{found:#?}");
        assert!(is_there("d", place([1.5, 0.5]), 0.03), "{found:#?}");
    }
}

#[test]
fn noise_moves_walls_by_little_and_makes_no_landmarks_of_its_own() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(61);
    let fan = half_turn(0.5);
    let exact = scan(&room(0.2), &fan, 361);
    let clean = extract(LandmarkSettings::default(), &fan, &exact);
    let (mut errors, mut n_other) = (Vec::new(), 0);
    for _ in 0..200 {
        let noisy: Vec<f64> = exact.iter().map(|range| range + 0.015 * normal(&mut rng)).collect();
        let found = extract(LandmarkSettings::default(), &fan, &noisy);
        n_other += usize::from(found.len() != clean.len());
        for known in clean.iter().filter(|mark| mark.extent_m().is_some_and(|p| mark.is_wall() && p > 1.0)) {
            let off = |mark: &Landmark| {
                (mark.distance_m - known.distance_m).abs() + (mark.bearing_rad - known.bearing_rad).abs()
            };
            let walls = found.iter().filter(|mark| mark.is_wall());
            let wall = walls.min_by(|a, b| off(a).total_cmp(&off(b))).unwrap();
            let LandmarkKind::Wall { unit_covariance, .. } = wall.kind else { panic!() };
            errors.push((wall.distance_m - known.distance_m) / (0.015 * unit_covariance[0].sqrt()));
        }
    }
    // Beside a corner that is seen from far one more reading may stand out.
    assert!(n_other < 30, "{n_other}");
    let mean_square = errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64;
    assert!((0.6..1.3).contains(&mean_square), "{mean_square}");
}

#[test]
fn a_wall_that_beams_graze_is_one_wall_unless_the_source_is_followed() {
    let wall = vec![[[-1.0, 1.0], [7.5, 1.0]]];
    let fan = half_turn(1.0);
    let ranges = scan(&wall, &fan, 181);
    let found = extract(LandmarkSettings::default(), &fan, &ranges);
    assert_eq!(found.len(), 1, "{found:#?}");
    assert!((found[0].distance_m - 1.0).abs() < 1e-9 && found[0].extent_m().unwrap() > 7.0);
    let as_printed = LandmarkSettings { spares_grazed_walls: false, ..LandmarkSettings::default() };
    let n_jumps =
        extract(as_printed, &fan, &ranges).iter().filter(|mark| "id".contains(mark.letter())).count();
    // From 3.5 m on readings are farther apart than a discontinuity.
    assert!(n_jumps > 4, "{n_jumps}");
}

#[test]
fn a_reading_between_two_surfaces_joins_them_to_no_wall() {
    let mut ranges: Vec<f64> = (0..60).map(|k| if k < 30 { 2.0 } else { 4.0 }).collect();
    ranges[30] = 3.0;
    let found = extract(LandmarkSettings::default(), &half_turn(0.5), &ranges);
    let n_jumps = found.iter().filter(|mark| "id".contains(mark.letter())).count();
    assert_eq!(n_jumps, 2, "{found:#?}");
}

#[test]
fn thresholds_are_exclusive() {
    let jump = |by: f64| extract(LandmarkSettings::default(), &half_turn(1.0), &[2.0, 2.0 + by]).len();
    assert_eq!((jump(0.1875), jump(0.25)), (0, 1));
    let settings = LandmarkSettings { discontinuity_m: 0.25, ..LandmarkSettings::default() };
    assert!(extract(settings, &half_turn(1.0), &[2.0, 2.25]).is_empty());
    let n_walls = |n: usize| {
        let wall = vec![[[2.0, -3.0], [2.0, 3.0]]];
        let fan =
            BeamFan { first_bearing_rad: -0.2, bearing_step_rad: 0.4 / (n - 1) as f64, ..half_turn(1.0) };
        extract(LandmarkSettings::default(), &fan, &scan(&wall, &fan, n)).len()
    };
    assert_eq!((n_walls(6), n_walls(7)), (0, 1));
}

#[test]
fn points_say_how_far_readings_beside_them_are_and_walls_how_uneven_they_are() {
    let fan = half_turn(0.5);
    let found = extract(LandmarkSettings::default(), &fan, &scan(&room(0.0), &fan, 361));
    for mark in &found {
        let beam_m = mark.distance_m * fan.bearing_step_rad;
        match mark.kind {
            // Seen askew, readings are farther apart than beams are.
            LandmarkKind::Corner { spacing_m } => {
                assert!(spacing_m > 1.5 * beam_m && spacing_m < 0.2, "{mark:?}")
            }
            LandmarkKind::Discontinuity { spacing_m, .. } => {
                assert!(spacing_m >= beam_m && spacing_m < 2.0 * beam_m, "{mark:?}");
            }
            LandmarkKind::Wall { unevenness_m, .. } => assert!(unevenness_m < 1e-9, "{mark:?}"),
        }
    }
}
