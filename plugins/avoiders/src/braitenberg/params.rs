//! Parameters of the vehicle.

use super::vehicle::{StopTurn, VehicleTuning};
use crate::faults::Faults;
use crate::memory_params::MemoryParams;
use rumbo_core::registry::Params;
use rumbo_core::robot::Robot;
use rumbo_core::stages::BuildError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Wanders and flees from what is near: straight on where nothing is, in a curve away from what is near, in place where it
/// is very near. It has no goal and follows no path.
///
/// Valverde Moreno (2015), table 4, for a Pioneer P3-DX with a depth camera; defaults are the source's, but for `stop_turn`.
/// Sees depth cameras, laser scanners and sonars, in any mix. For differential drives. Leave out `[mission]` to let it
/// wander.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct BraitenbergParams {
    /// At this distance and nearer the robot turns in place, meters.
    pub stop_distance_m: f64,
    /// Nearer than this it turns while it drives, meters.
    pub slow_distance_m: f64,
    /// Speed where nothing is near, m/s; at most the robot's own.
    pub speed_m_s: f64,
    /// Speed of the inner wheel at the stop distance, m/s; at the slow distance it is `speed_m_s`.
    pub least_m_s: f64,
    /// Speed of the wheels while turning in place, m/s.
    pub spin_m_s: f64,
    /// Which way it turns in place: away from what is near and the same way until it is free (`latched`), or by how the
    /// bearing changed (`compare_bearing`, as published, which dithers in corners).
    pub stop_turn: StopTurn,
    /// The law heeds what is in this sector ahead, degrees: a camera's whole view, and not what a sonar hears beside the
    /// robot, which is for the brakes only.
    pub view_deg: f64,
    /// What left the view of the sensors.
    pub memory: MemoryParams,
    /// Slows and stops in front of everything that the hull would meet; off, as published, this is left to the guard.
    pub brakes: bool,
    /// Room around the hull that the brakes keep, meters; more than the guard's margin.
    pub clearance_m: f64,
    /// Points of clouds lower than this over the floor are floor, meters; higher than the robot and `headroom_m` they are
    /// ceiling.
    pub floor_m: f64,
    /// See `floor_m`, meters.
    pub headroom_m: f64,
    /// A reading older than this stops the robot, seconds.
    pub stale_after_s: f64,
}

impl Default for BraitenbergParams {
    fn default() -> Self {
        BraitenbergParams {
            stop_distance_m: 0.5,
            slow_distance_m: 0.75,
            speed_m_s: 1.2,
            least_m_s: 0.6,
            spin_m_s: 0.6,
            stop_turn: StopTurn::Latched,
            view_deg: 75.0,
            memory: MemoryParams::default(),
            brakes: true,
            clearance_m: 0.05,
            floor_m: 0.05,
            headroom_m: 0.10,
            stale_after_s: 1.0,
        }
    }
}

impl Params for BraitenbergParams {
    fn check(&self) -> Vec<BuildError> {
        let mut faults = Faults::default();
        faults.above("stop_distance_m", self.stop_distance_m);
        faults.above("slow_distance_m", self.slow_distance_m);
        if self.slow_distance_m <= self.stop_distance_m {
            let found = format!("is {}", self.slow_distance_m);
            faults.add("slow_distance_m", format!("{found}, expected more than stop_distance_m"));
        }
        faults.above("speed_m_s", self.speed_m_s);
        faults.least("least_m_s", self.least_m_s);
        if self.least_m_s > self.speed_m_s {
            let found = format!("is {}", self.least_m_s);
            faults.add("least_m_s", format!("{found}, expected at most speed_m_s"));
        }
        faults.above("spin_m_s", self.spin_m_s);
        faults.range("view_deg", self.view_deg, 1.0, 360.0);
        self.memory.check(&mut faults);
        faults.least("clearance_m", self.clearance_m);
        faults.finite("floor_m", self.floor_m);
        faults.least("headroom_m", self.headroom_m);
        faults.above("stale_after_s", self.stale_after_s);
        faults.into_list()
    }
}

impl BraitenbergParams {
    /// The law for a robot: a slow one has all speeds in the same proportion.
    pub fn vehicle(&self, robot: &Robot) -> VehicleTuning {
        let share = (robot.max_speed_m_s / self.speed_m_s).min(1.0);
        VehicleTuning {
            stop_distance_m: self.stop_distance_m,
            slow_distance_m: self.slow_distance_m,
            speed_m_s: self.speed_m_s * share,
            least_m_s: self.least_m_s * share,
            spin_m_s: self.spin_m_s * share,
            stop_turn: self.stop_turn,
        }
    }
}
