//! The law of the vehicle: distance and bearing of the nearest thing become speeds of the wheels.
//!
//! Valverde Moreno (2015), section 4.1.2.2, tables 3 and 4, equation 4.6: a vehicle that flees from the stimulus
//! (Braitenberg's vehicle 2a). The source counts pixels; here the bearing tells the side, so no picture is needed.

use crate::nearest::{Side, Stimulus};
use crate::wheels::WheelPair;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which way a robot turns in front of what is too near.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum StopTurn {
    /// Away from it, and the same way until the place ahead is free.
    #[default]
    Latched,
    /// Right where its bearing grew since the last look, else left, as published: this dithers in corners.
    CompareBearing,
}

/// Numbers of the law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VehicleTuning {
    /// At this distance and nearer the vehicle turns in place, meters.
    pub stop_distance_m: f64,
    /// Nearer than this it turns while it drives, meters.
    pub slow_distance_m: f64,
    /// Speed where nothing is near, m/s.
    pub speed_m_s: f64,
    /// Speed of the inner wheel at the stop distance, m/s.
    pub least_m_s: f64,
    /// Speed of the wheels while turning in place, m/s.
    pub spin_m_s: f64,
    /// Which way it turns in place.
    pub stop_turn: StopTurn,
}

/// The law with what it remembers.
#[derive(Debug, Clone)]
pub struct Vehicle {
    tuning: VehicleTuning,
    /// The way it turns in place since it came too near.
    latched: Option<Side>,
    previous_bearing_rad: Option<f64>,
}

impl Vehicle {
    /// Nothing met yet.
    pub fn new(tuning: VehicleTuning) -> Vehicle {
        Vehicle { tuning, latched: None, previous_bearing_rad: None }
    }

    /// Speeds of the wheels in front of the nearest thing, or of nothing.
    pub fn steer(&mut self, nearest: Option<Stimulus>) -> WheelPair {
        let previous_bearing_rad = self.previous_bearing_rad;
        self.previous_bearing_rad = nearest.map(|stimulus| stimulus.bearing_rad);
        let tuning = self.tuning;
        let Some(Stimulus { distance_m, bearing_rad }) = nearest else {
            self.latched = None;
            return WheelPair::straight(tuning.speed_m_s);
        };
        if distance_m > tuning.stop_distance_m {
            self.latched = None;
            return tuning.on_the_move(distance_m, bearing_rad);
        }
        let side = match tuning.stop_turn {
            StopTurn::Latched => *self.latched.get_or_insert(Side::away_from(bearing_rad)),
            StopTurn::CompareBearing => {
                let grew = previous_bearing_rad.is_some_and(|previous_rad| bearing_rad > previous_rad);
                if grew { Side::Right } else { Side::Left }
            }
        };
        WheelPair::spin(side.sign() * tuning.spin_m_s)
    }
}

impl VehicleTuning {
    /// Beyond the stop distance: straight on, or a curve away from what is near.
    fn on_the_move(&self, distance_m: f64, bearing_rad: f64) -> WheelPair {
        let VehicleTuning { stop_distance_m, slow_distance_m, speed_m_s, least_m_s, .. } = *self;
        if distance_m > slow_distance_m {
            return WheelPair::straight(speed_m_s);
        }
        let share = (distance_m - stop_distance_m) / (slow_distance_m - stop_distance_m);
        let inner_m_s = least_m_s + (speed_m_s - least_m_s) * share;
        match Side::away_from(bearing_rad) {
            Side::Left => WheelPair { left_m_s: inner_m_s, right_m_s: speed_m_s },
            Side::Right => WheelPair { left_m_s: speed_m_s, right_m_s: inner_m_s },
        }
    }
}
