//! One inertial sample, and one step over the floor that comes 50 ms late.
//!
//! The bound of the specification is 20 µs a sample.

use divan::{Bencher, black_box};
use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::pose2;
use rumbo_core::time::Time;
use rumbo_kit::nav_filter::{Fusion, GRAVITY_M_S2, ImuSample, NavFilter, NavSettings, PlanarPose};

fn main() {
    divan::main();
}

fn sample() -> ImuSample {
    ImuSample {
        rates_rad_s: Vector3::new(0.01, -0.02, 0.2),
        forces_m_s2: Vector3::new(0.1, 0.2, GRAVITY_M_S2),
    }
}

/// A filter after a second of 200 samples.
fn warm(aid_period_ms: i64) -> (NavFilter, i64) {
    let aid_period = rumbo_core::time::Span(aid_period_ms * 1_000_000);
    let settings = NavSettings { aid_period, ..NavSettings::default() };
    let Ok(mut filter) = NavFilter::new(settings) else { std::process::exit(1) };
    for k in 0..200 {
        filter.take_imu(Time(k * 5_000_000), &sample());
    }
    (filter, 200)
}

#[divan::bench(args = [50, 0])]
fn one_sample(bencher: Bencher<'_, '_>, aid_period_ms: i64) {
    let (mut filter, mut k) = warm(aid_period_ms);
    bencher.bench_local(|| {
        k += 1;
        black_box(filter.take_imu(Time(k * 5_000_000), black_box(&sample())))
    });
}

#[divan::bench]
fn one_late_step(bencher: Bencher<'_, '_>) {
    let (mut filter, mut k) = warm(50);
    let covariance = Matrix3::identity() * 1e-5;
    let step = PlanarPose { pose: pose2(0.005, 0.0, 0.001), covariance };
    bencher.bench_local(|| {
        k += 1;
        filter.take_imu(Time(k * 5_000_000), &sample());
        black_box(filter.take_step(Time((k - 10) * 5_000_000), Some((&step, Fusion::Alone))))
    });
}
