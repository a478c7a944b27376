//! Half an hour of a navigation filter with 200 inertial samples and 40 scans a second: no number that is none, and no more
//! memory than after the first minute.
//!
//! `cargo run --release -p rumbo-localizers --example nav_endurance [-- SECONDS]`
#![allow(clippy::print_stdout)]

use rumbo_core::frames::{Pose3, Twist, pose2};
use rumbo_core::map::Map;
use rumbo_core::messages::{Check, Data, Imu, LaserScan, Observation, Prior, Seen, SensorId};
use rumbo_core::registry::Plugin;
use rumbo_core::stages::{BuildContext, Cx, Localizer};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;
use rumbo_localizers::nav_filter::NavFilterParams;
use std::error::Error;
use std::process::ExitCode;

/// A hall of this half width and depth around the origin, meters.
const HALF_M: [f64; 2] = [8.0, 6.0];
const IMU_HZ: usize = 200;
const LASER_HZ: usize = 40;
/// Once around in 63 s on a circle of 2 m.
const TWIST: Twist = Twist { forward_m_s: 0.2, left_m_s: 0.0, turn_rad_s: 0.1 };

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let seconds: usize = std::env::args().nth(1).map_or(Ok(1800), |text| text.parse())?;
    let mut localizer: Box<dyn Localizer> =
        NavFilterParams::default().build(&BuildContext::bare("odometer"))?;
    let covariance = nalgebra::Matrix3::zeros();
    let (map_from_base, odom_from_base) = (pose2(0.0, -2.0, 0.0), pose2(0.0, 0.0, 0.0));
    localizer.start(&Prior::Pose { map_from_base, odom_from_base, covariance }, &Map::default())?;
    let (trace, map) = (Trace::unwatched(), Map::default());
    let mut memory = Vec::new();
    let mut worst_m = 0f64;
    for k in 0..seconds * IMU_HZ {
        let now = Time::from_secs(k as f64 / IMU_HZ as f64);
        let truth = map_from_base * TWIST.integrate(now.as_secs());
        let mut seen = vec![observation(0, now, Data::Imu(sample(k)))];
        if k % (IMU_HZ / LASER_HZ) == 0 {
            seen.push(observation(1, now, Data::LaserScan(scan(&truth, k))));
        }
        let estimate = localizer.update(&mut Cx { now, trace: &trace }, Seen::sorted(&seen), &map)?;
        estimate.check()?;
        worst_m = worst_m.max((estimate.pose2().translation.vector - truth.translation.vector).norm());
        if k % (60 * IMU_HZ) == 0 {
            memory.push(resident_kib());
            println!("{:>4} min: {:>6} KiB, at most {worst_m:.3} m off", k / (60 * IMU_HZ), resident_kib());
        }
    }
    let after_a_minute = memory.get(1).copied().unwrap_or_default();
    let most = memory.iter().skip(1).max().copied().unwrap_or_default();
    let is_bounded = most as f64 <= 1.01 * after_a_minute as f64;
    println!("{after_a_minute} KiB after a minute, at most {most} KiB; {worst_m:.3} m off at most");
    Ok(if is_bounded { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn observation(sensor: u16, stamp: Time, data: Data) -> Observation {
    let base_from_sensor = Pose3::identity();
    Observation { sensor: SensorId(sensor), stamp, base_from_sensor, valid: true, data }
}

/// Noise that is the same in each run: a hash of where it is used.
fn noise(seed: usize) -> f64 {
    let mixed = (seed as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let mixed = (mixed ^ (mixed >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    (mixed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
}

fn sample(k: usize) -> Imu {
    let rates_rad_s =
        [0.02 * noise(7 * k), 0.02 * noise(7 * k + 1), TWIST.turn_rad_s + 0.02 * noise(7 * k + 2)];
    let inward = TWIST.forward_m_s * TWIST.turn_rad_s;
    let forces = [0.2 * noise(7 * k + 3), inward + 0.2 * noise(7 * k + 4), 9.80665 + 0.2 * noise(7 * k + 5)];
    Imu { attitude_rad: None, rates_rad_s, accelerations_m_s2: forces }
}

fn scan(truth: &rumbo_core::frames::Pose2, k: usize) -> LaserScan {
    let step = 1f64.to_radians();
    let first = -135f64.to_radians();
    let range = |beam: usize| {
        let bearing = truth.rotation.angle() + first + step * beam as f64;
        let (sine, cosine) = bearing.sin_cos();
        let wall = |along: f64, at: f64, half: f64| {
            if along.abs() < 1e-9 { f64::INFINITY } else { (half * along.signum() - at) / along }
        };
        let exact =
            wall(cosine, truth.translation.x, HALF_M[0]).min(wall(sine, truth.translation.y, HALF_M[1]));
        (exact + 0.03 * noise(k * 271 + beam)) as f32
    };
    LaserScan {
        first_bearing_rad: first,
        bearing_step_rad: step,
        max_range_m: 30.0,
        ranges_m: (0..271).map(range).collect::<Vec<f32>>().into(),
        ..LaserScan::default()
    }
}

/// Memory of this process, KiB; 0 where the system does not tell.
fn resident_kib() -> usize {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmRSS"));
    line.and_then(|line| line.split_whitespace().nth(1)).and_then(|kib| kib.parse().ok()).unwrap_or_default()
}
