//! Parameters of the potential field.

use super::classical::Classical;
use super::descent::Descent;
use super::field::{Attraction, Repulsion};
use super::near_rule::{Corridor, NearRule, NearTuning};
use super::push::{PushFrom, PushLaw};
use crate::faults::Faults;
use crate::memory_params::MemoryParams;
use crate::wheels::Saturation;
use rumbo_core::registry::Params;
use rumbo_core::robot::Robot;
use rumbo_core::stages::BuildError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which field.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FieldForm {
    /// Bounded pull and push, multiples of the full speed.
    #[default]
    Gradient,
    /// The negative gradient of a potential, without bounds.
    Classical,
}

/// Drives down a potential field: the path draws the robot, what is near pushes it off.
///
/// Valverde Moreno (2015), for a Pioneer P3-DX with a depth camera, GPS and waypoints; defaults are the source's, but for
/// the corrections that its specification calls better. Sees depth cameras, laser scanners and sonars, in any mix. For
/// differential drives. Local minima are not escaped: a planner's path, or waypoints, lead around them. Headings of
/// waypoints are turned to at the end.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PotentialFieldParams {
    /// Speed of the wheels at full pull, m/s (V); at most the robot's own.
    pub speed_m_s: f64,
    /// `gradient`, or `classical`, which does not read `attraction` and `repulsion`.
    pub field: FieldForm,
    /// The pull of the path.
    pub attraction: Attraction,
    /// The push of what is near.
    pub repulsion: Repulsion,
    /// What pushes: the `closest` point, as published, or the closest of all `sectors` of 10 degrees.
    pub repulsion_from: PushFrom,
    /// Numbers of the field `classical`.
    pub classical: Classical,
    /// What is done where something is very near: `clear_corridor`, or `spin_in_place` as published, which gets stuck beside
    /// doors.
    pub near_rule: NearRule,
    /// Something is very near from here on, meters.
    pub near_distance_m: f64,
    /// The corridor of the rule `clear_corridor`.
    pub corridor: Corridor,
    /// Wheels that should be faster than `speed_m_s` are slowed together (`scale`), or each by itself (`clamp`, as
    /// published).
    pub saturation: Saturation,
    /// Points of the path nearer than this are passed, but for the last, meters.
    pub passed_within_m: f64,
    /// A heading at the end of the path is good within this, degrees.
    pub yaw_within_deg: f64,
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
    /// A hit this near to an occupied cell of the map is not told as an obstacle, meters: it is known.
    pub expected_within_m: f64,
    /// A reading older than this stops the robot, seconds.
    pub stale_after_s: f64,
    /// A robot that hardly moves for this long although it should is blocked, seconds.
    pub stuck_after_s: f64,
}

impl Default for PotentialFieldParams {
    fn default() -> Self {
        PotentialFieldParams {
            speed_m_s: 1.2,
            field: FieldForm::Gradient,
            attraction: Attraction::default(),
            repulsion: Repulsion::default(),
            repulsion_from: PushFrom::Closest,
            classical: Classical::default(),
            near_rule: NearRule::ClearCorridor,
            near_distance_m: 0.5,
            corridor: Corridor::default(),
            saturation: Saturation::Scale,
            passed_within_m: 0.7,
            yaw_within_deg: 3.0,
            memory: MemoryParams::default(),
            brakes: true,
            clearance_m: 0.05,
            floor_m: 0.05,
            headroom_m: 0.10,
            expected_within_m: 0.20,
            stale_after_s: 1.0,
            stuck_after_s: 4.0,
        }
    }
}

impl Params for PotentialFieldParams {
    fn check(&self) -> Vec<BuildError> {
        let Attraction { s_m, r_m, alpha } = self.attraction;
        let mut faults = Faults::default();
        faults.above("speed_m_s", self.speed_m_s);
        faults.above("attraction.s_m", s_m);
        faults.least("attraction.r_m", r_m);
        faults.above("attraction.alpha", alpha);
        faults.above("repulsion.s_m", self.repulsion.s_m);
        faults.least("repulsion.r_m", self.repulsion.r_m);
        faults.least("repulsion.beta", self.repulsion.beta);
        faults.least("repulsion.gamma", self.repulsion.gamma);
        faults.above("classical.xi", self.classical.xi);
        faults.least("classical.eta", self.classical.eta);
        faults.above("classical.reach_m", self.classical.reach_m);
        faults.least("near_distance_m", self.near_distance_m);
        faults.least("corridor.half_width_m", self.corridor.half_width_m);
        faults.least("corridor.length_m", self.corridor.length_m);
        faults.above("corridor.spin_m_s", self.corridor.spin_m_s);
        faults.above("corridor.beside_m_s", self.corridor.beside_m_s);
        faults.above("corridor.turn_m_s", self.corridor.turn_m_s);
        faults.above("passed_within_m", self.passed_within_m);
        faults.range("yaw_within_deg", self.yaw_within_deg, 0.1, 90.0);
        self.memory.check(&mut faults);
        faults.least("clearance_m", self.clearance_m);
        faults.finite("floor_m", self.floor_m);
        faults.least("headroom_m", self.headroom_m);
        faults.least("expected_within_m", self.expected_within_m);
        faults.above("stale_after_s", self.stale_after_s);
        faults.above("stuck_after_s", self.stuck_after_s);
        faults.into_list()
    }
}

impl PotentialFieldParams {
    /// Full speed of the wheels of this robot, m/s.
    pub fn full_m_s(&self, robot: &Robot) -> f64 {
        self.speed_m_s.min(robot.max_speed_m_s)
    }

    /// The push of what is near.
    pub fn push_law(&self) -> PushLaw {
        match self.field {
            FieldForm::Gradient => PushLaw::Gradient(self.repulsion),
            FieldForm::Classical => PushLaw::Classical(self.classical),
        }
    }

    /// The field.
    pub fn descent(&self) -> Descent {
        Descent { attraction: self.attraction, push: self.push_law(), push_from: self.repulsion_from }
    }

    /// Numbers of the rule for what is very near.
    pub fn near(&self, robot: &Robot) -> NearTuning {
        NearTuning {
            rule: self.near_rule,
            near_distance_m: self.near_distance_m,
            corridor: self.corridor,
            full_m_s: self.full_m_s(robot),
            saturation: self.saturation,
        }
    }
}
