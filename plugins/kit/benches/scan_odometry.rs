//! One scan of a laser with 541 beams over 270 degrees taken in by the odometer, in a hall of boxes. Bar: 3 ms a scan, goal
//! 0.3 ms.

use nalgebra::Matrix3;
use rumbo_core::frames::{Pose2, Pose3, Twist};
use rumbo_core::messages::LaserScan;
use rumbo_kit::scan_odometry::{ScanOdometer, ScanOdometrySettings};

fn main() {
    divan::main();
}

/// Boxes from corner to corner, meters; the first is the hall.
const BOXES: [[f64; 4]; 5] = [
    [-8.0, -6.0, 12.0, 7.0],
    [-0.8, 1.5, 0.4, 2.6],
    [4.0, -3.0, 5.0, -2.1],
    [-4.5, 2.0, -3.5, 4.0],
    [7.0, 0.5, 8.5, 1.4],
];

fn range_m(at: &Pose2, bearing_rad: f64) -> f64 {
    let (sine, cosine) = (at.rotation.angle() + bearing_rad).sin_cos();
    let (x, y) = (at.translation.x, at.translation.y);
    let mut nearest_m = f64::INFINITY;
    for [x0, y0, x1, y1] in BOXES {
        for wall in [x0, x1] {
            let range = (wall - x) / cosine;
            if range > 0.0 && (y0..=y1).contains(&(y + range * sine)) {
                nearest_m = nearest_m.min(range);
            }
        }
        for wall in [y0, y1] {
            let range = (wall - y) / sine;
            if range > 0.0 && (x0..=x1).contains(&(x + range * cosine)) {
                nearest_m = nearest_m.min(range);
            }
        }
    }
    nearest_m
}

/// Scans at 10 Hz of a robot on a circle, with a fixed pattern of a centimeter in place of noise.
fn scans(n_beams: usize) -> Vec<LaserScan> {
    let step_rad = 270f64.to_radians() / (n_beams - 1) as f64;
    let mut at = Pose2::identity();
    let mut scans = Vec::new();
    for idx in 0..100usize {
        let ranges = (0..n_beams).map(|k| {
            let pattern_m = 0.01 * ((k * 37 + idx * 11) % 17) as f64 / 8.0 - 0.01;
            (range_m(&at, step_rad * k as f64 - 135f64.to_radians()) + pattern_m) as f32
        });
        scans.push(LaserScan {
            first_bearing_rad: -135f64.to_radians(),
            bearing_step_rad: step_rad,
            max_range_m: 30.0,
            ranges_m: ranges.collect::<Vec<_>>().into(),
            ..LaserScan::default()
        });
        at *= Twist::new(0.08, 0.04).integrate(1.0);
    }
    scans
}

#[divan::bench(args = [181, 541])]
fn scan_of_a_drive(bencher: divan::Bencher, n_beams: usize) {
    let scans = scans(n_beams);
    let step = Twist::new(0.08, 0.04).integrate(1.0);
    bencher.counter(divan::counter::ItemsCount::new(scans.len())).bench_local(|| {
        let settings = ScanOdometrySettings::default();
        let mut odometer = ScanOdometer::new(settings, Pose2::identity(), Matrix3::zeros());
        for scan in &scans {
            odometer.take(scan, &Pose3::identity(), &step, &(Matrix3::identity() * 1e-3));
        }
        odometer.odom_from_base()
    });
}

/// The dearest case: what is seen is another place, so that everything is tried, in vain.
#[divan::bench]
fn scan_that_fits_nothing(bencher: divan::Bencher) {
    let here = scans(541).into_iter().next().unwrap_or_default();
    let mut elsewhere = here.clone();
    for (k, range_m) in elsewhere.ranges_m.make_mut().iter_mut().enumerate() {
        *range_m = 3.0 + ((k * 7919) % 541) as f32 / 100.0;
    }
    let settings = ScanOdometrySettings { far_retries: 3, ..ScanOdometrySettings::default() };
    let mut odometer = ScanOdometer::new(settings, Pose2::identity(), Matrix3::zeros());
    let no_step = (Pose2::identity(), Matrix3::identity() * 1e-3);
    odometer.take(&here, &Pose3::identity(), &no_step.0, &no_step.1);
    bencher.bench_local(|| {
        let mut odometer = odometer.clone();
        odometer.take(&elsewhere, &Pose3::identity(), &no_step.0, &no_step.1)
    });
}
