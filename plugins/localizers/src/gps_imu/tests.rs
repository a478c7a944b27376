//! The localizer against known answers, slow twins, and robots that err as they say.

mod alignments;
mod as_a_localizer;
mod consistency;
mod derivatives;
mod office_tour;
mod one_step;

use nalgebra::{Matrix3, Vector2};
use rumbo_core::frames::{Pose2, Pose3, Twist, pose2, wrap_angle};
use rumbo_core::map::Map;
use rumbo_core::messages::{
    Data, Estimate, Imu, Observation, Odometry, PositionFix, Prior, Seen, SensorId, Status,
};
use rumbo_core::registry::Plugin as _;
use rumbo_core::stages::{BuildContext, Cx, LocalizeError, Localizer};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;

use super::*;

fn observation(seconds: f64, base_from_sensor: Pose3, data: Data) -> Observation {
    Observation { sensor: SensorId(0), stamp: Time::from_secs(seconds), base_from_sensor, valid: true, data }
}

fn odometry(seconds: f64, odom_from_base: Pose2) -> Observation {
    let reading = Odometry { odom_from_base, twist: Twist::ZERO, noise: [0.02, 0.01, 0.02] };
    observation(seconds, Pose3::identity(), Data::Odometry(reading))
}

fn imu(seconds: f64, yaw_rad: f64) -> Observation {
    let attitude_rad = Some([0.0, 0.0, wrap_angle(yaw_rad)]);
    observation(seconds, Pose3::identity(), Data::Imu(Imu { attitude_rad, ..Imu::default() }))
}

/// A fix that claims to err evenly within `error_m`.
fn fix(seconds: f64, at_m: Vector2<f64>, error_m: f64) -> Observation {
    let fix = PositionFix { position_m: [at_m.x, at_m.y, 0.0], deviation_m: [error_m / 3f64.sqrt(); 3] };
    observation(seconds, Pose3::identity(), Data::PositionFix(fix))
}

fn localizer(params: &GpsImuParams) -> Box<dyn Localizer> {
    params.build(&BuildContext::bare("localizer")).unwrap()
}

fn started(params: &GpsImuParams, prior: &Prior) -> Box<dyn Localizer> {
    let mut localizer = localizer(params);
    localizer.start(prior, &Map::default()).unwrap();
    localizer
}

fn at(pose: Pose2, deviation: f64) -> Prior {
    let covariance = Matrix3::identity() * deviation * deviation;
    Prior::Pose { map_from_base: pose, odom_from_base: Pose2::identity(), covariance }
}

fn update(
    localizer: &mut dyn Localizer,
    seconds: f64,
    seen: &[Observation],
) -> Result<Estimate, LocalizeError> {
    let trace = Trace::unwatched();
    let mut cx = Cx { now: Time::from_secs(seconds), trace: &trace };
    localizer.update(&mut cx, Seen::sorted(seen), &Map::default())
}

fn apart_m(estimate: &Estimate, truth: &Pose2) -> f64 {
    (estimate.pose2().translation.vector - truth.translation.vector).norm()
}
