//! A ring of corridors around a block, with rooms that look different, and a robot that is driven around in it.

use rumbo_core::frames::{Pose2, Pose3, pose2};
use rumbo_core::messages::{Data, LaserScan, Observation, Odometry, SensorId};
use rumbo_core::time::Time;

/// Walls as segments: x and y of both ends, meters.
pub fn walls() -> Vec<[f64; 4]> {
    let mut walls = Vec::new();
    let mut block = |x0: f64, y0: f64, x1: f64, y1: f64| {
        walls.extend([[x0, y0, x1, y0], [x1, y0, x1, y1], [x1, y1, x0, y1], [x0, y1, x0, y0]]);
    };
    block(0.0, 0.0, 20.0, 14.0);
    block(3.0, 3.0, 17.0, 11.0);
    for (x, y, size) in [
        (0.0, 4.0, 0.5),
        (2.6, 7.3, 0.4),
        (5.0, 0.0, 0.7),
        (9.5, 2.5, 0.5),
        (14.0, 0.0, 0.4),
        (19.4, 5.0, 0.6),
    ] {
        block(x, y, x + size, y + 0.8 * size);
    }
    for (x, y, size) in [(17.0, 8.5, 0.5), (12.0, 13.2, 0.8), (7.5, 11.0, 0.6), (4.0, 13.5, 0.5)] {
        block(x, y, x + size, y + 0.8 * size);
    }
    walls
}

/// Range along a ray, meters.
fn range_m(walls: &[[f64; 4]], from: [f64; 2], angle: f64) -> f64 {
    let (sin, cos) = angle.sin_cos();
    let hit = |[x0, y0, x1, y1]: &[f64; 4]| {
        let (ex, ey) = (x1 - x0, y1 - y0);
        let det = ex * sin - ey * cos;
        let (dx, dy) = (x0 - from[0], y0 - from[1]);
        let along = (ex * dy - ey * dx) / det;
        let share = (cos * dy - sin * dx) / det;
        (det.abs() > 1e-12 && along > 0.0 && (0.0..=1.0).contains(&share)).then_some(along)
    };
    walls.iter().filter_map(hit).fold(f64::INFINITY, f64::min)
}

/// Numbers that look like chance, between -0.5 and 0.5, the same every time.
pub fn scattered(k: usize) -> f64 {
    (k as f64 * 0.618_033_988_7).fract() - 0.5
}

/// A scan of 270 degrees with a centimeter of noise.
pub fn scan(walls: &[[f64; 4]], pose: &Pose2, seed: usize) -> LaserScan {
    let (n, first) = (270, -135f64.to_radians());
    let from = [pose.translation.x, pose.translation.y];
    let range = |k: usize| {
        let angle = pose.rotation.angle() + first + (k as f64).to_radians();
        let noise_m = 0.02 * (scattered(seed * 270 + k) + scattered(seed * 31 + 7 * k + 3));
        (range_m(walls, from, angle) + noise_m) as f32
    };
    LaserScan {
        first_bearing_rad: first,
        bearing_step_rad: 1f64.to_radians(),
        max_range_m: 30.0,
        ranges_m: (0..n).map(range).collect::<Vec<f32>>().into(),
        ..LaserScan::default()
    }
}

/// Poses of rounds through the corridors, 0.1 m apart, with turns in place of 3 degrees a scan.
pub fn rounds(n_rounds: usize) -> Vec<Pose2> {
    let corners = [[1.5, 1.5], [18.5, 1.5], [18.5, 12.5], [1.5, 12.5]];
    let mut poses = Vec::new();
    for side in 0..4 * n_rounds {
        let (from, to) = (corners[side % 4], corners[(side + 1) % 4]);
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        let (length, yaw) = (f64::hypot(dx, dy), dy.atan2(dx));
        let n = (length / 0.1) as usize;
        let along = (0..n).map(|k| k as f64 / n as f64);
        poses.extend(along.map(|share| pose2(from[0] + share * dx, from[1] + share * dy, yaw)));
        poses.extend((0..30).map(|k| pose2(to[0], to[1], yaw + (3.0 * f64::from(k)).to_radians())));
    }
    poses
}

/// What the robot sees at its poses, ten scans a second; the odometer turns too far and goes too far.
pub fn log(poses: &[Pose2], has_odometer: bool) -> Vec<Vec<Observation>> {
    let walls = walls();
    let mut odom_from_base = Pose2::identity();
    let mut last = poses[0];
    let observe = |stamp, data| Observation {
        sensor: SensorId(0),
        stamp,
        base_from_sensor: Pose3::identity(),
        valid: true,
        data,
    };
    (0..)
        .zip(poses)
        .map(|(k, pose)| {
            let motion = last.inverse() * pose;
            last = *pose;
            let turn = motion.rotation.angle() * 1.04 + 0.001;
            odom_from_base *= pose2(motion.translation.x * 1.03, motion.translation.y, turn);
            let stamp = Time::from_secs(0.1 * f64::from(k));
            let odometry = Data::Odometry(Odometry { odom_from_base, ..Odometry::default() });
            let scan = Data::LaserScan(scan(&walls, pose, k as usize));
            let mut seen = vec![observe(stamp, scan)];
            if has_odometer {
                seen.insert(0, observe(stamp, odometry));
            }
            seen
        })
        .collect()
}
