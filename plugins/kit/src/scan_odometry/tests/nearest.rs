use super::*;
use rand::RngExt;

fn by_brute_force(key: &KeyScan, [x, y]: [f64; 2], within_m: f64) -> Option<f64> {
    let points = (0..key.len()).map(|idx| key.point(idx).unwrap());
    let distances = points.map(|[px, py]| (px - x).hypot(py - y)).filter(|far_m| *far_m < within_m);
    distances.min_by(f64::total_cmp)
}

/// Scanners of a full turn, a half and a narrow one, upright, upside down, tilted and off the middle.
#[test]
fn the_nearest_point_by_bearing_is_that_of_brute_force() {
    let mut rng = rng(3);
    let mut n_found = 0;
    for (opening_rad, mount) in [
        (6.27, Pose3::identity()),
        (3.2, Pose3::translation(0.4, -0.2, 0.3)),
        (1.0, Pose3::rotation(nalgebra::Vector3::x() * std::f64::consts::PI)),
        (4.7, Pose3::rotation(nalgebra::Vector3::new(0.3, -0.5, 2.0))),
    ] {
        for n_beams in [1usize, 3, 40, 360] {
            let ranges: Vec<f32> = (0..n_beams).map(|_| rng.random_range(0.05..4.0)).collect();
            let scan = LaserScan {
                first_bearing_rad: -opening_rad / 2.0,
                bearing_step_rad: opening_rad / n_beams as f64,
                max_range_m: 3.8,
                ranges_m: ranges.into(),
                ..LaserScan::default()
            };
            let (mut points, mut key) = (ScanPoints::default(), KeyScan::default());
            points.place(&scan, &mount);
            key.take(&points, &ScanOdometrySettings::default());
            assert_eq!(key.len(), points.len());
            for _ in 0..2000 {
                let at = [rng.random_range(-5.0..5.0), rng.random_range(-5.0..5.0)];
                let within_m = [0.05, 0.3, 20.0][rng.random_range(0..3)];
                let found = key.nearest(at, within_m).map(|idx| key.point(idx).unwrap());
                let found_m = found.map(|[x, y]| (x - at[0]).hypot(y - at[1]));
                assert_eq!(found_m, by_brute_force(&key, at, within_m), "{n_beams} beams, {at:?}");
                n_found += usize::from(found_m.is_some());
            }
        }
    }
    assert!(n_found > 10_000, "{n_found}");
    assert_eq!(KeyScan::default().nearest([0.0, 0.0], 1.0), None);
    let mut empty = KeyScan::default();
    empty.take(&ScanPoints::default(), &ScanOdometrySettings::default());
    assert_eq!(empty.nearest([0.0, 0.0], 1.0), None);
}

/// The angle between the normal of a line and one that is known, radians.
fn off_rad(line: &Line, [x, y]: [f64; 2]) -> f64 {
    (line.normal[0] * y - line.normal[1] * x).abs().asin()
}

#[test]
fn fitted_lines_have_the_direction_of_walls_beside_corners_too_and_say_how_surely() {
    let walls = around(&[[-3.0, -2.0], [3.0, -2.0], [3.0, 2.0], [-3.0, 2.0]]);
    let settings = ScanOdometrySettings::default();
    let clean = key_of(&seen(&walls, &Pose2::identity(), 361, 0.0, &mut rng(0)), &settings);
    for idx in 0..clean.len() {
        let [x, y] = clean.point(idx).unwrap();
        let line = clean.line(idx).unwrap();
        let of_side = off_rad(line, [0.0, 1.0]);
        let of_front = off_rad(line, [1.0, 0.0]);
        let (is_front, is_corner) = ((x - 3.0).abs() < 1e-3, x > 2.75 && y.abs() > 1.75);
        let off = if is_front { of_front } else { of_side };
        assert!(off < if is_corner { 0.05 } else { 1e-6 }, "{x} {y}: {off}");
    }
    let kinds = [LineKind::Neighbor, LineKind::Fitted].map(|lines| {
        let settings = ScanOdometrySettings { lines, ..settings };
        let (mut squares, mut told, mut n) = (0.0, 0.0, 0);
        for seed in 0..20 {
            let key = key_of(&seen(&walls, &Pose2::identity(), 361, 0.01, &mut rng(seed)), &settings);
            for idx in 0..key.len() {
                let [x, y] = key.point(idx).unwrap();
                if y.abs() > 1.9 && x < 2.5 && x > 0.3 {
                    let line = key.line(idx).unwrap();
                    squares += off_rad(line, [0.0, 1.0]).powi(2);
                    told += line.normal_rad2;
                    n += 1;
                }
            }
        }
        [(squares / f64::from(n)).sqrt(), (told / f64::from(n)).sqrt()]
    });
    let [[neighbor, _], [fitted, told]] = kinds;
    assert!(neighbor > 0.15 && fitted < 0.05, "rad: {neighbor}, {fitted}");
    assert!((0.6..1.6).contains(&(told / fitted)), "it says {told} and is off by {fitted}");
}
