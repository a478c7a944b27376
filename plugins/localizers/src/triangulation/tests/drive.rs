//! Drives through the offices, with a laser, an odometer that errs, and somebody who walks ahead of the robot.

use super::super::scan::SeenScan;
use super::super::tracker::{Anchor, Tracker, TrackerSettings};
use super::place::Office;
use nalgebra::{Matrix3, Vector3};
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use rumbo_core::frames::{Pose2, wrap_angle};
use rumbo_core::messages::Status;
use rumbo_core::rng::{Rng, stream};
use rumbo_core::time::Time;
use rumbo_kit::landmarks::BeamFan;
use std::f64::consts::{FRAC_PI_2, PI};

/// Between scans.
const STEP_S: f64 = 0.5;
/// The laser is a LMS200: errors are uniform.
const RANGE_ERROR_M: f64 = 0.015;

/// What makes a drive hard.
#[derive(Debug, Clone, Copy)]
pub struct Hardship {
    /// The odometer has a wrong scale, drifts, and errs on turns; else it is perfect.
    pub odometer_errs: bool,
    /// The odometer claims to be much better than it is.
    pub odometer_boasts: bool,
    /// A disc goes to and fro ahead of the robot.
    pub has_walker: bool,
    /// This share of the scans is tilted: ranges of one half are too long.
    pub tilted: f64,
    /// The robot starts some millimeters from where it is told.
    pub start_is_off: bool,
    /// Beams in half a turn.
    pub n_beams: usize,
}

impl Default for Hardship {
    fn default() -> Self {
        Hardship {
            odometer_errs: true,
            odometer_boasts: false,
            has_walker: true,
            tilted: 0.0,
            start_is_off: true,
            n_beams: 361,
        }
    }
}

/// A half turn ahead.
pub fn fan(n_beams: usize) -> BeamFan {
    BeamFan {
        first_bearing_rad: -FRAC_PI_2,
        bearing_step_rad: PI / (n_beams - 1) as f64,
        min_range_m: 0.05,
        max_range_m: 8.0,
    }
}

/// A scan at a pose; `error_m` is the largest error of a range.
pub fn scan(
    office: &Office,
    pose: &Pose2,
    (time_s, hardship): (f64, &Hardship),
    error_m: f64,
    rng: &mut Rng,
) -> Vec<f32> {
    let fan = fan(hardship.n_beams);
    // A disc of 0.2 m that goes to and fro 1.5 m ahead at 0.5 m/s.
    let phase = (time_s * 0.5 / 4.0).fract() * 4.0;
    let walker = [1.5, if phase < 2.0 { phase - 1.0 } else { 3.0 - phase }];
    let tilted_side = (rng.random::<f64>() < hardship.tilted).then(|| rng.random::<bool>());
    let beam = |k: usize| {
        let bearing = fan.first_bearing_rad + fan.bearing_step_rad * k as f64;
        let at = [pose.translation.x, pose.translation.y];
        let mut range = office.range_m(at, pose.rotation.angle() + bearing, fan.max_range_m);
        let (along, across) = (
            walker[0] * bearing.cos() + walker[1] * bearing.sin(),
            walker[1] * bearing.cos() - walker[0] * bearing.sin(),
        );
        if hardship.has_walker && along > 0.0 && across.abs() < 0.2 {
            range = range.min(along - (0.04 - across * across).sqrt());
        }
        if tilted_side == Some(bearing > 0.0) {
            range *= 1.03;
        }
        let range = range + error_m * rng.random_range(-1.0..1.0);
        if range >= fan.max_range_m { f32::INFINITY } else { range as f32 }
    };
    (0..hardship.n_beams).map(beam).collect()
}

/// What came of a drive.
#[derive(Debug, Clone, Default)]
pub struct Outcome {
    /// Errors at the end: x, y (meters), heading (degrees).
    pub end: [f64; 3],
    /// The same by odometry alone.
    pub odometry_end: [f64; 3],
    /// Largest distance from the truth on the way, meters.
    pub worst_m: f64,
    /// Squared errors in terms of the claimed covariance, at every tenth scan.
    pub nees: Vec<f64>,
    /// The same of the heading alone.
    pub yaw_nees: Vec<f64>,
    /// Relations and estimates of all scans that were looked at, and how many these are.
    pub counts: [usize; 3],
    /// Scans with too few landmarks.
    pub n_starved: u64,
    /// Anything but tracking was said at some time.
    pub doubted: bool,
    /// The robot was called lost.
    pub was_lost: bool,
}

/// How an odometer sees a way.
struct Odometer {
    scale: f64,
    drift_rad_m: f64,
    turn: f64,
}

impl Odometer {
    /// Odometry (b) of the experiments, or one without errors.
    fn new(errs: bool, rng: &mut Rng) -> Odometer {
        let (scale, drift_deg_m) = (rng.random_range(-0.05..0.05), rng.random_range(-3.0..3.0_f64));
        let share = f64::from(u8::from(errs));
        Odometer {
            scale: 1.0 + share * scale,
            drift_rad_m: share * drift_deg_m.to_radians(),
            turn: share * 0.05,
        }
    }

    fn see(&self, step: &Pose2, rng: &mut Rng) -> Pose2 {
        let normal: f64 = StandardNormal.sample(rng);
        let (way, turn) = (step.translation.vector, step.rotation.angle());
        Pose2::new(way * self.scale, turn * (1.0 + self.turn * normal) + self.drift_rad_m * way.norm())
    }
}

/// Standard deviations of the start: x, y (meters), heading (radians).
const START: [f64; 3] = [0.005, 0.005, 0.002];
/// What the odometer claims of itself: m/m, rad/m, rad/rad.
pub const CLAIMED: [f64; 3] = [0.03, 0.03, 0.05];
/// What one that boasts claims: half a percent, and 0.05 degrees a meter.
const BOASTED: [f64; 3] = [0.005, 0.0009, 0.005];

/// A drive of this length.
pub fn drive(
    office: &Office,
    settings: &TrackerSettings,
    length_m: f64,
    hardship: &Hardship,
    seed: u64,
) -> Outcome {
    let mut rng = stream(seed, "drive");
    let route = office.route(length_m, &mut rng);
    let odometer = Odometer::new(hardship.odometer_errs, &mut rng);
    let covariance = Matrix3::from_diagonal(&Vector3::from(START).map(|v| v * v));
    let off = START.map(|sd| -> f64 {
        let normal: f64 = StandardNormal.sample(&mut rng);
        if hardship.start_is_off { sd * normal } else { 0.0 }
    });
    let told =
        Pose2::new(route[0].translation.vector + Vector3::from(off).xy(), route[0].rotation.angle() + off[2]);
    let mut odom_from_base = Pose2::identity();
    let anchor = Anchor { map_from_base: told, covariance, odom_from_base };
    let mut tracker = Tracker::new(*settings, anchor, stream(seed, "landmarks"));
    let claimed = if hardship.odometer_boasts { BOASTED } else { CLAIMED };
    let mut outcome = Outcome::default();
    let mut last = route[0];
    for (k, pose) in route.iter().enumerate() {
        odom_from_base *= odometer.see(&(last.inverse() * pose), &mut rng);
        last = *pose;
        let stamp = Time::from_secs(STEP_S * k as f64);
        let ranges = scan(office, pose, (stamp.as_secs(), hardship), RANGE_ERROR_M, &mut rng);
        if tracker.is_due(stamp, &odom_from_base) {
            let fan = fan(hardship.n_beams);
            let seen = SeenScan { stamp, fan, ranges_m: &ranges, base_from_sensor: Pose2::identity() };
            tracker.look(&seen, &odom_from_base, claimed, Some((1, &office.grid)));
            let report = tracker.report();
            let counts = [report.n_related, report.n_estimates, 1];
            outcome.counts = [0, 1, 2].map(|k| outcome.counts[k] + counts[k]);
            outcome.n_starved = report.n_starved;
            outcome.doubted |= tracker.status() != Status::Tracking;
            outcome.was_lost |= tracker.status() == Status::Lost;
        }
        let (found, covariance) = tracker.carried_to(&odom_from_base, claimed);
        let off = error(&found, pose);
        outcome.worst_m = outcome.worst_m.max(off[0].hypot(off[1]));
        if k % 10 == 9 {
            let off = Vector3::new(off[0], off[1], off[2].to_radians());
            outcome.yaw_nees.push(off.z.powi(2) / covariance[(2, 2)]);
            outcome.nees.push(off.dot(&(covariance.try_inverse().unwrap() * off)));
        }
        outcome.end = off;
        outcome.odometry_end = error(&(told * odom_from_base), pose);
    }
    outcome
}

/// Errors in x, y (meters) and heading (degrees).
pub fn error(found: &Pose2, truth: &Pose2) -> [f64; 3] {
    let way = found.translation.vector - truth.translation.vector;
    [way.x, way.y, wrap_angle(found.rotation.angle() - truth.rotation.angle()).to_degrees()]
}
