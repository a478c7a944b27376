//! What the robot does where something is very near: Valverde Moreno (2015), section 4.3, and a rule without its deadlock.
//!
//! The published rule turns in place while anything is within 0.5 m: in front of a door it turns until it faces its way,
//! still has the jamb beside it, and turns to and fro for ever. The corridor rule looks only at what is in the way.

use crate::near_points::NearPoint;
use crate::nearest::{Side, Stimulus};
use crate::wheels::{Saturation, WheelPair};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_2, PI};

/// What is done where something is very near.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum NearRule {
    /// Turn away only while something is in a corridor ahead; slow down beside things.
    #[default]
    ClearCorridor,
    /// Turn in place toward the way as long as anything is near, as published.
    SpinInPlace,
}

/// The corridor ahead that is kept free, and how the robot drives in it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Corridor {
    /// Half of its width, meters.
    pub half_width_m: f64,
    /// Its length, from the middle of the robot, meters.
    pub length_m: f64,
    /// Speed of the wheels while the robot turns away, m/s.
    pub spin_m_s: f64,
    /// Fastest speed while something is within `near_distance_m`, m/s.
    pub beside_m_s: f64,
    /// Speed of the wheels, to both sides, for half a turn to go, m/s.
    pub turn_m_s: f64,
}

impl Default for Corridor {
    fn default() -> Self {
        Corridor { half_width_m: 0.30, length_m: 0.55, spin_m_s: 0.5, beside_m_s: 0.25, turn_m_s: 1.8 }
    }
}

/// What the rule is told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pull {
    /// Length of the field, multiples of the full speed.
    pub strength: f64,
    /// From the heading to the field, radians.
    pub turn_error_rad: f64,
    /// The nearest thing.
    pub nearest: Option<Stimulus>,
}

/// Numbers of both rules.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearTuning {
    /// Which rule.
    pub rule: NearRule,
    /// Something is near from here on, meters.
    pub near_distance_m: f64,
    /// The corridor.
    pub corridor: Corridor,
    /// Full speed of the wheels, m/s.
    pub full_m_s: f64,
    /// What is done with wheels that should be faster.
    pub saturation: Saturation,
}

/// The rule with what it remembers.
#[derive(Debug, Clone)]
pub struct NearControl {
    tuning: NearTuning,
    side: Option<Side>,
}

impl NearControl {
    /// Turning away, a robot that looks about along its way chooses by where the obstacle is, radians.
    const ALONG_THE_WAY_RAD: f64 = 0.3;

    /// Nothing in the way.
    pub fn new(tuning: NearTuning) -> NearControl {
        NearControl { tuning, side: None }
    }

    /// Something stands in the corridor ahead.
    pub fn is_blocked(&self, points: &[NearPoint]) -> bool {
        let Corridor { half_width_m, length_m, .. } = self.tuning.corridor;
        self.tuning.rule == NearRule::ClearCorridor
            && points.iter().any(|near| {
                let point = near.in_base;
                point.x > 0.0 && point.x < length_m && point.y.abs() < half_width_m
            })
    }

    /// Speeds of the wheels.
    pub fn steer(&mut self, pull: &Pull, is_blocked: bool) -> WheelPair {
        let NearTuning { rule, near_distance_m, full_m_s, saturation, .. } = self.tuning;
        let is_near = pull.nearest.is_some_and(|nearest| nearest.distance_m <= near_distance_m);
        if rule == NearRule::ClearCorridor {
            return self.in_corridor(pull, is_blocked, is_near);
        }
        if is_near {
            return WheelPair::spin(if pull.turn_error_rad < 0.0 { -full_m_s } else { full_m_s });
        }
        WheelPair::toward(full_m_s, pull.strength, pull.turn_error_rad).saturated(full_m_s, saturation)
    }

    /// A turn in place to where the robot gets out, the same one until nothing is in the way.
    fn turn_away(&mut self, pull: &Pull) -> WheelPair {
        let NearTuning { corridor, full_m_s, .. } = self.tuning;
        let side = *self.side.get_or_insert(Self::way_out(pull));
        WheelPair::spin(side.sign() * corridor.spin_m_s.min(full_m_s))
    }

    fn in_corridor(&mut self, pull: &Pull, is_blocked: bool, is_near: bool) -> WheelPair {
        let NearTuning { corridor, full_m_s, saturation, .. } = self.tuning;
        if is_blocked {
            return self.turn_away(pull);
        }
        self.side = None;
        let error_rad = pull.turn_error_rad;
        let ahead = if error_rad.abs() < FRAC_PI_2 { error_rad.cos() } else { 0.0 };
        let free_m_s = full_m_s * pull.strength.min(1.0) * ahead;
        let speed_m_s = if is_near { free_m_s.min(corridor.beside_m_s) } else { free_m_s };
        let turn_m_s = corridor.turn_m_s * error_rad / PI;
        let wheels = WheelPair { left_m_s: speed_m_s - turn_m_s, right_m_s: speed_m_s + turn_m_s };
        wheels.saturated(full_m_s, saturation)
    }

    fn way_out(pull: &Pull) -> Side {
        if pull.turn_error_rad.abs() < Self::ALONG_THE_WAY_RAD {
            return Side::away_from(pull.nearest.map_or(0.0, |nearest| nearest.bearing_rad));
        }
        if pull.turn_error_rad > 0.0 { Side::Left } else { Side::Right }
    }
}
