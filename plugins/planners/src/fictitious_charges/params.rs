//! Parameters of `fictitious_charges`.

use crate::field_descent::FieldSettings;
use crate::field_descent::descent::ChargeRules;
use crate::field_descent::placement::{Placement, SideRule};
use crate::field_descent::{check_rules, field_params};
use rumbo_core::stages::BuildError;
use rumbo_kit::potential::{ChargeForce, ChargeLaw};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which force a charge has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ChargeForceKind {
    /// Minus the gradient of the charge's potential.
    Consistent,
    /// As the source prints it: it falls so slowly that goals are not reached.
    Printed,
}

/// On which side of the way to the goal a charge goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ChargeSide {
    /// So that the robot turns least.
    LeastTurn,
    /// Left: it pushes to the right.
    Left,
    /// Right: it pushes to the left.
    Right,
    /// By chance, from the pipeline's seed; every plan draws anew.
    Random,
}

/// How the distance of a charge is meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ChargePlacement {
    /// The charge is exactly that far from the robot.
    Unit,
    /// As the source prints it, with the push of the obstacles as it is.
    Literal,
}

/// A charge that stands for nothing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ChargeParams {
    /// How far from the robot it is placed, meters (`ψ`).
    pub distance_m: f64,
    /// How strong it is (`K_c`).
    pub strength: f64,
    /// How fast its potential falls with the distance (`m_c`).
    pub exponent: f64,
    /// `consistent` (minus the gradient of its potential) or `printed` (as in the source, where goals are not reached).
    pub force: ChargeForceKind,
    /// `least_turn` (the robot is pushed the way that it is heading, to the left on a tie), `left`, `right` (always on that
    /// side of the way to the goal) or `random` (by the seed).
    pub side: ChargeSide,
    /// `unit` (exactly `distance_m` away) or `literal` (as the source prints it).
    pub placement: ChargePlacement,
    /// Farther away than this it has no effect, meters; absent: it has everywhere. Forms other than `conic` need about 4, or
    /// charges move the place of rest away from the goal.
    pub range_m: Option<f64>,
}

impl Default for ChargeParams {
    fn default() -> Self {
        Self {
            distance_m: 1.0,
            strength: 8.0,
            exponent: 2.0,
            force: ChargeForceKind::Consistent,
            side: ChargeSide::LeastTurn,
            placement: ChargePlacement::Unit,
            range_m: None,
        }
    }
}

field_params! {
    /// Walks down an artificial potential, and places repulsive charges that stand for nothing where it would get stuck
    /// (Mora, Armesto and Tornero). Not complete: a `[planner_fallback]` takes over where too many charges were placed.
    pub struct FictitiousChargesParams {
        /// The charges.
        pub charge: ChargeParams = ChargeParams::default(),
        /// Walks that are tried until one arrives. The first is as given. In the next two all lengths of the potential and
        /// of charges are shrunk, in the second so far that the robot comes to rest 0.05 m farther from a wall than
        /// `minimum_clearance_m`: so it gets through doors. Near the goal the repulsion fades in them, also where
        /// `goal_scaling_m` is absent: so it gets to goals beside walls. All further walks are as small, every other one
        /// leads from the goal to the robot, and one in five of their charges goes to the other side, by the seed. 1: only
        /// the published walk.
        pub attempts: usize = 24,
        /// Charges after which a walk ends; a smaller one may place as many more as its floor is larger.
        pub max_charges: usize = 40,
        /// Steps whose net displacement is the heading that `side = "least_turn"` keeps.
        pub heading_window: usize = 50,
        /// A charge has no effect any more once the robot is nearer to the goal than when it was placed, and more than 3 m
        /// away from it.
        pub forget: bool = false,
    }
}

impl FictitiousChargesParams {
    /// Every impossible value.
    pub fn faults(&self) -> Vec<BuildError> {
        let mut faults = self.shared_faults();
        let charge = &self.charge;
        let above_zero = [
            ("charge.distance_m", charge.distance_m),
            ("charge.strength", charge.strength),
            ("charge.exponent", charge.exponent),
            ("charge.range_m", charge.range_m.unwrap_or(1.0)),
        ];
        faults.extend(check_rules(&above_zero, &[]));
        for (key, count) in [("heading_window", self.heading_window), ("attempts", self.attempts)] {
            if count == 0 {
                faults.push(BuildError::at(key, "is 0, expected at least 1"));
            }
        }
        faults
    }

    /// The rules of the walk, and of charges.
    pub fn rules(&self) -> (FieldSettings, ChargeRules) {
        let charge = &self.charge;
        let charges = ChargeRules {
            law: ChargeLaw {
                strength: charge.strength,
                exponent: charge.exponent,
                force: match charge.force {
                    ChargeForceKind::Consistent => ChargeForce::Consistent,
                    ChargeForceKind::Printed => ChargeForce::Printed,
                },
                range_m: charge.range_m.unwrap_or(f64::INFINITY),
            },
            distance_m: charge.distance_m,
            placement: match charge.placement {
                ChargePlacement::Unit => Placement::Unit,
                ChargePlacement::Literal => Placement::Literal,
            },
            side: match charge.side {
                ChargeSide::LeastTurn => SideRule::LeastTurn,
                ChargeSide::Left => SideRule::Left,
                ChargeSide::Right => SideRule::Right,
                ChargeSide::Random => SideRule::Random,
            },
            stray_share: 0.0,
            max_charges: self.max_charges,
            heading_window: self.heading_window,
            forget: self.forget,
        };
        (self.settings(), charges)
    }
}
