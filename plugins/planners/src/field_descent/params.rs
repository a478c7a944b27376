//! Parameters that both planners have: written once, for their documentation and their checks.

use super::descent::{DescentRules, StepRule};
use rumbo_core::map::Layer;
use rumbo_core::stages::BuildError;
use rumbo_kit::potential::{Attraction, Form, Repulsion};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which layer of the map the obstacles are taken from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum MapSource {
    /// The grid, with all that was found on the way: outlines of all cells that are not free.
    Grid,
    /// Wall lines, and discs for what was found on the way.
    Lines,
}

impl MapSource {
    /// The layer's name in manifests.
    pub(crate) fn layer(self) -> Layer {
        match self {
            MapSource::Grid => Layer::Grid,
            MapSource::Lines => Layer::Lines,
        }
    }
}

/// Which lines are one obstacle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Grouping {
    /// Lines that close an outline, up to the corners where it bends towards the robot: a rack is one obstacle.
    Outline,
    /// Each line is an obstacle.
    Segment,
}

/// How the attraction grows with the distance to the goal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum AttractionForm {
    /// The same force everywhere, as published.
    Conic,
    /// A force that grows with the distance.
    Quadratic,
    /// Quadratic near the goal, conic beyond.
    Combined,
}

/// How long steps are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum StepKind {
    /// Always `step_m`.
    Constant,
    /// Longer where there is room.
    Adaptive,
}

/// What the shared parameters mean to the algorithm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldSettings {
    /// Where obstacles come from.
    pub source: MapSource,
    /// Which lines are one obstacle.
    pub grouping: Grouping,
    /// What the goal draws with.
    pub attraction: Attraction,
    /// What obstacles push with, measured from the robot's middle.
    pub repulsion: Repulsion,
    /// Measure from the robot's hull instead.
    pub inflate: bool,
    /// Within this distance of the goal the repulsion fades, meters.
    pub goal_scaling_m: Option<f64>,
    /// The walk, with a clearance of zero where none is given.
    pub descent: DescentRules,
    /// Distance to obstacles that is kept, meters; none: from the robot's hull.
    pub minimum_clearance_m: Option<f64>,
    /// Turn the walk into few straight legs.
    pub straighten: bool,
    /// Radius of rounded corners, meters.
    pub smoothing_radius_m: f64,
}

/// The shared keys as they are written.
pub(crate) struct RuleKeys {
    pub form: AttractionForm,
    pub combined_radius_m: f64,
    pub step: StepKind,
    pub step_m: f64,
    pub largest_step_m: f64,
    pub xi: f64,
    pub eta: f64,
    pub influence_distance_m: f64,
    pub minimum_force: f64,
    pub goal_capture_m: f64,
}

impl RuleKeys {
    /// The combined attraction falls below `minimum_force` near the goal by itself: there nothing is a minimum. Twice that
    /// distance, since the robot comes there with some push of obstacles left.
    pub fn goal_capture_m(&self) -> f64 {
        match self.form {
            AttractionForm::Combined => {
                let weak_m = 2.0 * self.minimum_force / self.xi * self.combined_radius_m;
                self.goal_capture_m.max(2.0 * weak_m)
            }
            _ => self.goal_capture_m,
        }
    }

    pub fn attraction(&self) -> Attraction {
        let form = match self.form {
            AttractionForm::Conic => Form::Conic,
            AttractionForm::Quadratic => Form::Quadratic,
            AttractionForm::Combined => Form::Combined { radius_m: self.combined_radius_m },
        };
        Attraction { form, strength: self.xi }
    }

    pub fn repulsion(&self) -> Repulsion {
        Repulsion { strength: self.eta, influence_m: self.influence_distance_m, inflation_m: 0.0 }
    }

    pub fn step(&self) -> StepRule {
        match self.step {
            StepKind::Constant => StepRule::Constant { step_m: self.step_m },
            StepKind::Adaptive => StepRule::Adaptive { least_m: self.step_m, most_m: self.largest_step_m },
        }
    }
}

/// Every value that is not a finite number above zero, or of at least zero.
pub(crate) fn check_rules(above_zero: &[(&str, f64)], at_least_zero: &[(&str, f64)]) -> Vec<BuildError> {
    let mut faults = Vec::new();
    for (key, value) in above_zero {
        if !(value.is_finite() && *value > 0.0) {
            faults.push(BuildError::at(*key, format!("is {value}, expected a finite number above zero")));
        }
    }
    for (key, value) in at_least_zero {
        if !(value.is_finite() && *value >= 0.0) {
            faults
                .push(BuildError::at(*key, format!("is {value}, expected a finite number of at least zero")));
        }
    }
    faults
}

/// A struct of parameters with the shared ones and its own.
macro_rules! field_params {
    (
        $(#[$about:meta])*
        pub struct $name:ident {
            $( $(#[$doc:meta])* pub $own:ident: $kind:ty = $default:expr, )*
        }
    ) => {
        $(#[$about])*
        #[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
        #[serde(default, deny_unknown_fields)]
        pub struct $name {
            /// Where the obstacles come from: `grid`, the outlines of all cells that are not free, or `lines`, the map's
            /// wall lines, for maps that have them.
            pub map: $crate::field_descent::MapSource,
            /// Which lines are one obstacle, where they come from `lines`: `outline` (those that close an outline, up to the
            /// corners where it bends towards the robot: a rack is one obstacle, the walls of a hall are four) or
            /// `segment` (each is one, for lines that do not meet, as SLAM makes them).
            pub group: $crate::field_descent::Grouping,
            /// Attraction of the goal: `conic` (the same force everywhere, as published), `quadratic` (grows with the
            /// distance, as in textbooks; needs a small `xi`, `goal_capture_m`, and charges of limited range) or
            /// `combined` (quadratic within `combined_radius_m`, conic beyond; needs charges of limited range as well).
            pub form: $crate::field_descent::AttractionForm,
            /// Strength of the attraction (`ξ`): the conic form draws with half of it.
            pub xi: f64,
            /// Strength of the repulsion (`η`).
            pub eta: f64,
            /// Obstacles farther than this have no effect, meters (`d_obs`). With the other defaults, the robot stays about
            /// 1 m from obstacles, and a walk to a goal nearer than 1 m to one is refused: choose less, and a smaller `eta`,
            /// for rooms (with its cube the place of rest shrinks; `fictitious_charges` tries that by itself).
            pub influence_distance_m: f64,
            /// Where `form = "combined"` changes from quadratic to conic, meters (`d_c`).
            pub combined_radius_m: f64,
            /// Distances are measured from the robot's hull (the smallest disc around it), not from its middle.
            pub inflate: bool,
            /// Within this distance of the goal the repulsion fades, so that goals beside obstacles can be reached, meters
            /// (`d_s`). Absent: such goals are refused, but for the further `attempts` of `fictitious_charges`.
            pub goal_scaling_m: Option<f64>,
            /// Steps: `constant`, as published, or `adaptive` (a fifth of the room to the nearest obstacle, from `step_m`
            /// to `largest_step_m`).
            pub step: $crate::field_descent::StepKind,
            /// Length of a step, meters (`l`).
            pub step_m: f64,
            /// Longest adaptive step, meters.
            pub largest_step_m: f64,
            /// A force below this is a local minimum (`F_0`). The robot zigzags across valleys by a step, so choose at least
            /// twice `step_m`: smaller values are missed.
            pub minimum_force: f64,
            /// Arrived within this distance of the goal, meters; the path ends at the goal itself.
            pub goal_tolerance_m: f64,
            /// Within this distance of the goal nothing is taken for a local minimum, meters: the quadratic attraction
            /// vanishes there. Zero for the conic form; the combined one knows by itself where it is too weak.
            pub goal_capture_m: f64,
            /// Steps over which standing still is told, the second detector of local minima.
            pub stall_window: usize,
            /// Standing still is to get no farther than this share of those steps' length.
            pub stall_ratio: f64,
            /// Steps after which the search ends.
            pub max_steps: usize,
            /// Distance to obstacles that the path always keeps, meters: there the force is not followed into them. Absent:
            /// the radius of the robot's hull plus 0.10 m.
            pub minimum_clearance_m: Option<f64>,
            /// Turn the walk in small steps into few straight legs: short cuts that keep `minimum_clearance_m`, rounded
            /// corners.
            pub straighten: bool,
            /// Radius of rounded corners where there is room, meters. Drives that cannot turn in place get at least their
            /// turning radius.
            pub smoothing_radius_m: f64,
            $( $(#[$doc])* pub $own: $kind, )*
        }

        impl Default for $name {
            fn default() -> Self {
                Self {
                    map: $crate::field_descent::MapSource::Grid,
                    group: $crate::field_descent::Grouping::Outline,
                    form: $crate::field_descent::AttractionForm::Conic,
                    xi: 1.0,
                    eta: 1.0,
                    influence_distance_m: 2.0,
                    combined_radius_m: 1.0,
                    inflate: false,
                    goal_scaling_m: None,
                    step: $crate::field_descent::StepKind::Constant,
                    step_m: 0.02,
                    largest_step_m: 0.25,
                    minimum_force: 0.04,
                    goal_tolerance_m: 0.05,
                    goal_capture_m: 0.0,
                    stall_window: 50,
                    stall_ratio: 0.1,
                    max_steps: 20_000,
                    minimum_clearance_m: None,
                    straighten: true,
                    smoothing_radius_m: 0.3,
                    $( $own: $default, )*
                }
            }
        }

        impl $name {
            /// Impossible values of the shared keys.
            fn shared_faults(&self) -> Vec<rumbo_core::stages::BuildError> {
                use rumbo_core::stages::BuildError;
                let above_zero = [
                    ("xi", self.xi),
                    ("eta", self.eta),
                    ("influence_distance_m", self.influence_distance_m),
                    ("combined_radius_m", self.combined_radius_m),
                    ("goal_scaling_m", self.goal_scaling_m.unwrap_or(1.0)),
                    ("step_m", self.step_m),
                    ("minimum_force", self.minimum_force),
                    ("goal_tolerance_m", self.goal_tolerance_m),
                ];
                let at_least_zero = [
                    ("goal_capture_m", self.goal_capture_m),
                    ("stall_ratio", self.stall_ratio),
                    ("minimum_clearance_m", self.minimum_clearance_m.unwrap_or(0.0)),
                    ("smoothing_radius_m", self.smoothing_radius_m),
                    ("largest_step_m", self.largest_step_m),
                ];
                let mut faults = $crate::field_descent::check_rules(&above_zero, &at_least_zero);
                if self.largest_step_m < self.step_m {
                    let message =
                        format!("is {}, expected at least step_m, which is {}", self.largest_step_m, self.step_m);
                    faults.push(BuildError::at("largest_step_m", message));
                }
                for (key, count) in [("stall_window", self.stall_window), ("max_steps", self.max_steps)] {
                    if count == 0 {
                        faults.push(BuildError::at(key, "is 0, expected at least 1"));
                    }
                }
                faults
            }

            /// The shared keys as the algorithm wants them.
            fn settings(&self) -> $crate::field_descent::params::FieldSettings {
                let keys = $crate::field_descent::params::RuleKeys {
                    form: self.form,
                    combined_radius_m: self.combined_radius_m,
                    step: self.step,
                    step_m: self.step_m,
                    largest_step_m: self.largest_step_m,
                    xi: self.xi,
                    eta: self.eta,
                    influence_distance_m: self.influence_distance_m,
                    minimum_force: self.minimum_force,
                    goal_capture_m: self.goal_capture_m,
                };
                $crate::field_descent::params::FieldSettings {
                    source: self.map,
                    grouping: self.group,
                    attraction: keys.attraction(),
                    repulsion: keys.repulsion(),
                    inflate: self.inflate,
                    goal_scaling_m: self.goal_scaling_m,
                    descent: $crate::field_descent::descent::DescentRules {
                        step: keys.step(),
                        minimum_force: self.minimum_force,
                        goal_tolerance_m: self.goal_tolerance_m,
                        goal_capture_m: keys.goal_capture_m(),
                        stall_window: self.stall_window,
                        stall_ratio: self.stall_ratio,
                        max_steps: self.max_steps,
                        minimum_clearance_m: self.minimum_clearance_m.unwrap_or(0.0),
                    },
                    minimum_clearance_m: self.minimum_clearance_m,
                    straighten: self.straighten,
                    smoothing_radius_m: self.smoothing_radius_m,
                }
            }
        }
    };
}
pub(crate) use field_params;
