//! One scan into thirty maps: matched, weighed, drawn anew where it is due, and painted. The hall is that of the tests.

use divan::{Bencher, black_box};
use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::{Pose2, Pose3, pose2};
use rumbo_core::messages::LaserScan;
use rumbo_core::rng::stream;
use rumbo_kit::scan_match::ScanPoints;
use rumbo_kit::streams::Streams;
use rumbo_slam::rbpf_slam::RbpfSlamParams;
use rumbo_slam::rbpf_slam::filter::Filter;
use rumbo_slam::rbpf_slam::follower::Followed;
use rumbo_slam::rbpf_slam::particle::{Doubt, KeyScan};

fn main() {
    divan::main();
}

/// A hall of 20 m by 14 m with a block in its middle, as 541 beams see it.
fn scan(pose: &Pose2) -> LaserScan {
    let boxes =
        [[-10.0, -7.0, 10.0, 7.0], [-4.0, -2.2, 4.0, 2.2], [5.0, 5.0, 5.6, 5.4], [-7.0, 5.0, -6.0, 6.0]];
    let at = pose.translation;
    let range = |k: usize| {
        let (sin, cos) = (pose.rotation.angle() + (-135.0 + 0.5 * k as f64).to_radians()).sin_cos();
        let side = |position: f64, along: f64, other: f64, across: f64, wall: f64, low: f64, high: f64| {
            let range = (wall - position) / along;
            let beside = other + range * across;
            if range > 1e-6 && beside >= low && beside <= high { range } else { f64::INFINITY }
        };
        let hits = boxes.iter().flat_map(|[x0, y0, x1, y1]| {
            [
                side(at.x, cos, at.y, sin, *x0, *y0, *y1),
                side(at.x, cos, at.y, sin, *x1, *y0, *y1),
                side(at.y, sin, at.x, cos, *y0, *x0, *x1),
                side(at.y, sin, at.x, cos, *y1, *x0, *x1),
            ]
        });
        hits.fold(f64::INFINITY, f64::min) as f32
    };
    LaserScan {
        first_bearing_rad: -135f64.to_radians(),
        bearing_step_rad: 0.5f64.to_radians(),
        max_range_m: 30.0,
        ranges_m: (0..541).map(range).collect::<Vec<f32>>().into(),
        ..LaserScan::default()
    }
}

#[divan::bench(args = [30, 80])]
fn one_scan_that_is_taken_in(bencher: Bencher, particles: u32) {
    let params = RbpfSlamParams { particles, ..RbpfSlamParams::default() };
    let Ok(settings) = params.settings() else { return };
    let preparation = settings.filter.preparation;
    let mut filter = Filter::new(settings.filter, Streams::new(stream(1, "bench")));
    let start = pose2(-5.5, -4.6, 0.0);
    filter.begin(&start);
    let mut points = ScanPoints::default();
    let mut k = 0u32;
    // To and fro over 4 m, half a meter a step.
    let place = |k: u32| {
        let along = 0.5 * f64::from(k % 16);
        start * pose2(if along > 4.0 { 8.0 - along } else { along }, 0.0, 0.0)
    };
    bencher.bench_local(|| {
        let (before, pose) = (place(k.saturating_sub(1)), place(k));
        k += 1;
        let scan = scan(&pose);
        preparation.prepare(&scan, &Pose3::identity(), &mut points);
        let covariance = Matrix3::from_diagonal(&Vector3::new(1e-4, 1e-4, 1e-5));
        let followed = Followed { before_from_after: before.inverse() * pose, covariance };
        black_box(filter.take(&KeyScan {
            scan: &scan,
            base_from_sensor: Pose3::identity(),
            points: &points,
            followed,
            explores: true,
            doubt: Doubt::None,
        }))
    });
}
