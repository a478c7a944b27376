//! Parameters of `dp`.

use super::cost_map::Clearances;
use super::grid_dp::DpRules;
use rumbo_core::stages::BuildError;
use rumbo_kit::cost_field::StepRule;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Keeps away from obstacles, approaches the goal, turns little: in this order (Hernández Alamilla, 2005).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct DpParams {
    /// Distance to obstacles that the path keeps where there is room, meters (`D_pref`). Nearer cells cost
    /// exponentially more.
    pub preferred_clearance_m: f64,
    /// Distance to obstacles that the path always keeps, meters (`d_min`). Choose less than half of the narrowest
    /// passage that the robot must use, or doors close.
    pub minimum_clearance_m: f64,
    /// Distance over which the cost of being near an obstacle falls by a factor of e, meters. The same on maps of every
    /// resolution.
    pub penalty_unit_m: f64,
    /// Length of a diagonal step where a straight one is 1. The source's printed tables were made with 1.4.
    pub diagonal_step: f64,
    /// Diagonal steps may squeeze between closed cells.
    pub corner_cutting: bool,
    /// Cells of which nobody knows what they are count as obstacles. Otherwise no path enters them, but paths need not
    /// keep away from them.
    pub undetermined_is_obstacle: bool,
    /// In narrow places a straight piece may replace turns if it comes no nearer to obstacles than they did. Without
    /// it, all the turns in a door stay.
    pub straighten_narrow_places: bool,
    /// Distance at which the avoider stops the robot, meters (`M`). Around a robot that stands nearer to an obstacle
    /// than `minimum_clearance_m`, as it does after such a stop, a disc of the larger of the two plus 0.10 m is planned
    /// with the smallest clearance that the hull allows.
    pub stop_distance_m: f64,
    /// How far the robot backs off, once, when it is so near to an obstacle that no path begins where it stands,
    /// meters.
    pub back_off_m: f64,
    /// Plan as published: corners are cut and narrow places keep their turns, whatever the keys above say.
    pub thesis_mode: bool,
}

impl Default for DpParams {
    fn default() -> Self {
        Self {
            preferred_clearance_m: 0.45,
            minimum_clearance_m: 0.30,
            penalty_unit_m: 0.05,
            diagonal_step: std::f64::consts::SQRT_2,
            corner_cutting: false,
            undetermined_is_obstacle: true,
            straighten_narrow_places: true,
            stop_distance_m: 0.30,
            back_off_m: 0.10,
            thesis_mode: false,
        }
    }
}

/// Beyond the stop distance, planning around the robot is still in the forbidden band.
const ESCAPE_MARGIN_M: f64 = 0.10;
/// Between hull and obstacle while the robot leaves the forbidden band.
const HULL_MARGIN_M: f64 = 0.02;
/// Largest exponent of a penalty: the sums of a whole map must stay far from the largest number.
const LARGEST_EXPONENT: f64 = 400.0;

impl DpParams {
    /// Every impossible value.
    pub fn faults(&self) -> Vec<BuildError> {
        let mut faults = Vec::new();
        let lengths = [
            ("preferred_clearance_m", self.preferred_clearance_m),
            ("minimum_clearance_m", self.minimum_clearance_m),
            ("stop_distance_m", self.stop_distance_m),
            ("back_off_m", self.back_off_m),
        ];
        for (key, value) in lengths {
            if !(value.is_finite() && value >= 0.0) {
                faults.push(BuildError::at(
                    key,
                    format!("is {value}, expected a finite number of at least zero"),
                ));
            }
        }
        if self.minimum_clearance_m > self.preferred_clearance_m {
            let message = format!(
                "is {}, expected at most preferred_clearance_m, which is {}",
                self.minimum_clearance_m, self.preferred_clearance_m
            );
            faults.push(BuildError::at("minimum_clearance_m", message));
        }
        if !(1.0..=2.0).contains(&self.diagonal_step) {
            let message = format!("is {}, expected a number from 1 to 2", self.diagonal_step);
            faults.push(BuildError::at("diagonal_step", message));
        }
        let least_unit_m = self.preferred_clearance_m / LARGEST_EXPONENT;
        if !(self.penalty_unit_m.is_finite() && self.penalty_unit_m > 0.0) {
            let message = format!("is {}, expected a finite number above zero", self.penalty_unit_m);
            faults.push(BuildError::at("penalty_unit_m", message));
        } else if self.penalty_unit_m < least_unit_m {
            let message = format!("is {}, expected at least {least_unit_m}", self.penalty_unit_m);
            let help = "penalties grow by e per unit below preferred_clearance_m and would overflow";
            faults.push(BuildError::at("penalty_unit_m", message).help(help));
        }
        faults
    }

    /// The rules on a grid of this resolution for a robot of this radius.
    pub fn rules(&self, resolution_m: f64, robot_radius_m: f64) -> DpRules {
        let cells = |length_m: f64| length_m / resolution_m;
        DpRules {
            clearances: Clearances {
                preferred: cells(self.preferred_clearance_m),
                minimum: cells(self.minimum_clearance_m),
                penalty_unit: cells(self.penalty_unit_m),
            },
            steps: StepRule {
                diagonal_step: self.diagonal_step,
                corner_cutting: self.corner_cutting || self.thesis_mode,
            },
            no_nearer_than_path: self.straighten_narrow_places && !self.thesis_mode,
            escape_radius: cells(self.stop_distance_m.max(self.minimum_clearance_m) + ESCAPE_MARGIN_M),
            escape_minimum: cells(robot_radius_m + HULL_MARGIN_M),
            back_off: cells(self.back_off_m),
        }
    }
}
