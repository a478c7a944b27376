//! Keys that the plugins with this filter share.

use super::clock::Clock;
use super::noise_params::SensorNoiseParams;
use super::odometer_params::OdometerErrorParams;
use super::schedule::Schedule;
use super::steering::SteeringModel;
use super::tracker::TrackerSettings;
use super::{FilterSettings, Gates, Growth, MotionModel, Steering, Wheels};
use crate::lines::{FitWeights, LineSettings, PointNoise};
use rumbo_core::robot::{Drive, Robot};
use rumbo_core::time::Span;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// When readings of a scan are a line.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ExtractionParams {
    /// A reading farther than this from the chord splits a piece, meters; about 3.3 deviations of a range.
    pub split_m: f64,
    /// Pieces with fewer readings are no lines.
    pub min_points: usize,
    /// Shorter pieces are no lines, meters.
    pub min_length_m: f64,
    /// Pieces whose readings scatter more than this about their line are none, meters; about 1.5 deviations of a range.
    pub max_rms_m: f64,
    /// Neighbors whose readings scatter less than this about one line are one, meters; about 0.9 deviations of a range.
    pub merge_rms_m: f64,
    /// Steepest incidence at which neighboring readings are still of one wall, degrees (lambda).
    pub grazing_deg: f64,
    /// How much each reading counts in the fit: `equal`, or `noise`, by how sure it is across the line.
    pub weights: FitWeights,
}

impl Default for ExtractionParams {
    fn default() -> Self {
        let lines = LineSettings::default();
        ExtractionParams {
            split_m: lines.split_m,
            min_points: lines.min_points,
            min_length_m: lines.min_length_m,
            max_rms_m: lines.max_rms_m,
            merge_rms_m: lines.merge_rms_m,
            grazing_deg: 10.0,
            weights: lines.weights,
        }
    }
}

/// Periods that readings are thinned to; then predictions are steps of their greatest common divisor (from reading to
/// reading where that is below 1 ms). All 0 takes every reading at its stamp.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PeriodParams {
    /// Of the wheels, seconds.
    pub wheels_s: f64,
    /// Of the steered wheel, seconds.
    pub steering_s: f64,
    /// Of the lasers, seconds.
    pub laser_s: f64,
    /// Of the test of lines that are no walls yet, seconds (T_tm); 0 tests them with every scan. Localization has none.
    pub tentative_s: f64,
}

/// What both plugins have, from their own keys.
#[derive(Debug, Clone)]
pub struct SharedParams<'a> {
    /// How the robot may move.
    pub motion: MotionModel,
    /// How lines are found.
    pub extraction: &'a ExtractionParams,
    /// How unsure the sensors are.
    pub noise: &'a SensorNoiseParams,
    /// What wheels and odometers do wrong all the time.
    pub odometer: &'a OdometerErrorParams,
    /// When readings are taken in.
    pub periods: &'a PeriodParams,
    /// What the steering angle has to do with the motion.
    pub steering_model: SteeringModel,
    /// Below this speed the steering angle says nothing, m/s.
    pub steering_min_speed_m_s: f64,
    /// Squared distance from which on a wheel slips.
    pub slip_gate: f64,
    /// Squared distance of the farthest line that is a wall.
    pub gate: f64,
    /// Farthest line beside its wall that still is it, meters.
    pub gate_distance_m: f64,
    /// Most that it may be turned, degrees.
    pub gate_normal_deg: f64,
    /// A scan is taken in once the robot went so far since the last, meters,
    pub look_every_m: f64,
    /// or turned so far, degrees.
    pub look_every_deg: f64,
    /// Pairs must fit together.
    pub joint: bool,
    /// Largest gap along a wall, meters.
    pub max_gap_m: f64,
    /// Oldest reading that is taken in, seconds before the state.
    pub late_s: f64,
    /// Scans without a wall until the robot is lost.
    pub lost_after_scans: u32,
}

/// A key and what is wrong with it.
pub type KeyFault = (String, String);

impl SharedParams<'_> {
    /// All faults.
    pub fn faults(&self) -> Vec<KeyFault> {
        let mut faults = Vec::new();
        let mut expect = |fine: bool, key: &str, value: &dyn std::fmt::Display, expected: &str| {
            if !fine {
                faults.push((key.to_owned(), format!("is {value}, expected {expected}")));
            }
        };
        let (extraction, noise, periods) = (self.extraction, self.noise, self.periods);
        for (key, value) in [
            ("sigma_linear_acceleration", self.motion.acceleration_m_s2),
            ("sigma_angular_acceleration", self.motion.turn_acceleration_rad_s2),
            ("gate", self.gate),
            ("gate_distance_m", self.gate_distance_m),
            ("gate_normal_deg", self.gate_normal_deg),
            ("slip_gate", self.slip_gate),
            ("extraction.split_m", extraction.split_m),
            ("extraction.max_rms_m", extraction.max_rms_m),
            ("extraction.merge_rms_m", extraction.merge_rms_m),
            ("noise.wheel_speed_m_s", noise.wheel_speed_m_s),
            ("noise.steering_deg", noise.steering_deg),
            ("noise.range_m", noise.range_m),
            ("noise.least_distance_m", noise.least_distance_m),
            ("noise.least_normal_deg", noise.least_normal_deg),
            ("noise.odometer.standing_m", noise.odometer.standing_m),
            ("noise.odometer.standing_deg", noise.odometer.standing_deg),
        ] {
            expect(value > 0.0 && value.is_finite(), key, &value, "a finite number above 0");
        }
        for (key, value) in [
            ("sigma_lateral", self.motion.lateral_m),
            ("max_gap_m", self.max_gap_m),
            ("steering_min_speed_m_s", self.steering_min_speed_m_s),
            ("late_s", self.late_s),
            ("look_every_m", self.look_every_m),
            ("look_every_deg", self.look_every_deg),
            ("extraction.min_length_m", extraction.min_length_m),
            ("noise.bearing_deg", noise.bearing_deg),
            ("noise.surface_m", noise.surface_m),
            ("noise.odometer.distance", noise.odometer.distance),
            ("noise.odometer.direction_deg_m", noise.odometer.direction_deg_m),
            ("noise.odometer.turn", noise.odometer.turn),
        ] {
            expect(value >= 0.0 && value.is_finite(), key, &value, "a finite number, 0 or more");
        }
        for (key, value, most) in self.odometer.limits() {
            expect((0.0..=most).contains(&value), key, &value, &format!("0 to {most}"));
        }
        let grazing = extraction.grazing_deg;
        expect(
            grazing > 0.0 && grazing < 90.0,
            "extraction.grazing_deg",
            &grazing,
            "more than 0 and less than 90",
        );
        expect(extraction.min_points >= 3, "extraction.min_points", &extraction.min_points, "3 or more");
        expect(self.lost_after_scans >= 1, "lost_after_scans", &self.lost_after_scans, "1 or more");
        let all = [
            ("periods.wheels_s", periods.wheels_s),
            ("periods.steering_s", periods.steering_s),
            ("periods.laser_s", periods.laser_s),
        ];
        let is_on = all.iter().any(|(_, value)| *value != 0.0);
        for (key, value) in all.into_iter().filter(|_| is_on) {
            let is_period = (1e-3..=3600.0).contains(&value);
            expect(is_period, key, &value, "0.001 to 3600 seconds for all three, or 0 for all");
        }
        let test_s = periods.tentative_s;
        expect((0.0..=3600.0).contains(&test_s), "periods.tentative_s", &test_s, "0 to 3600 seconds");
        faults
    }

    /// What the tracker needs for this robot; `growth` where it builds its map.
    pub fn tracker_settings(&self, robot: &Robot, growth: Growth) -> TrackerSettings {
        let track_m = match robot.drive {
            Drive::Tricycle { track_m, .. } | Drive::Differential { track_m } => track_m,
            // The manifest leaves other drives out.
            _ => robot.radius_m,
        };
        let noise = self.noise;
        let filter = FilterSettings {
            motion: self.motion,
            wheels: Wheels {
                half_track_m: track_m / 2.0,
                speed_m_s: noise.wheel_speed_m_s,
                slip_gate: self.slip_gate,
                ..Wheels::default()
            },
            odometer: self.odometer.model(),
            steering: Steering {
                model: self.steering_model,
                behind_m: -robot.drive.steered_ahead_m().unwrap_or(0.0),
                angle_rad: noise.steering_deg.to_radians(),
                min_speed_m_s: self.steering_min_speed_m_s,
            },
            gates: Gates {
                distance2: self.gate,
                gap_m: self.max_gap_m,
                joint: self.joint,
                distance_m: self.gate_distance_m,
                normal_rad: self.gate_normal_deg.to_radians(),
                ..Gates::default()
            },
            growth: Growth { gap_m: self.max_gap_m, test_period_s: self.periods.tentative_s, ..growth },
        };
        TrackerSettings {
            filter,
            lines: self.lines(),
            drive: robot.drive,
            start_motion: [robot.max_speed_m_s, robot.max_turn_rad_s()],
            clock: self.clock(),
            look_every: [self.look_every_m, self.look_every_deg.to_radians()],
            odometer: noise.odometer.noise(),
            lost_after_scans: self.lost_after_scans,
        }
    }

    fn lines(&self) -> LineSettings {
        let (extraction, noise) = (self.extraction, self.noise);
        LineSettings {
            grazing_rad: extraction.grazing_deg.to_radians(),
            split_m: extraction.split_m,
            min_points: extraction.min_points,
            min_length_m: extraction.min_length_m,
            max_rms_m: extraction.max_rms_m,
            merge_rms_m: extraction.merge_rms_m,
            weights: extraction.weights,
            noise: PointNoise {
                range_m: noise.range_m,
                bearing_rad: noise.bearing_deg.to_radians(),
                surface_m: noise.surface_m,
            },
            floor_distance_m: noise.least_distance_m,
            floor_normal_rad: noise.least_normal_deg.to_radians(),
        }
    }

    fn clock(&self) -> Clock {
        let late = Span::from_secs(self.late_s);
        let periods_ns = [self.periods.wheels_s, self.periods.steering_s, self.periods.laser_s]
            .map(|s| Span::from_secs(s).0);
        match Schedule::new(&periods_ns) {
            Ok(schedule) => Clock::scheduled(late, schedule, periods_ns),
            // No periods: every reading is taken in.
            Err(_) => Clock::new(late),
        }
    }
}
