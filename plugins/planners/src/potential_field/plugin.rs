//! The planner in the framework.

use super::PotentialFieldParams;
use crate::field_descent::planner::FieldPlanner;
use crate::hull_fit::fits_hull;
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::stages::{BuildContext, BuildError, Planner};

impl Params for PotentialFieldParams {
    fn check(&self) -> Vec<BuildError> {
        self.faults()
    }
}

impl Plugin<dyn Planner> for PotentialFieldParams {
    fn manifest(&self) -> Manifest {
        Manifest { needs_layers: vec![self.map.layer()], ..Manifest::default() }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Planner>, BuildError> {
        if let Some(clearance_m) = self.minimum_clearance_m {
            fits_hull("minimum_clearance_m", clearance_m, &context.robot)?;
        }
        let planner =
            FieldPlanner { settings: self.rules(), charges: None, n_attempts: 1, rng: context.rng() };
        Ok(Box::new(planner))
    }
}

rumbo_core::register_planner!(
    PotentialFieldParams,
    "potential_field",
    "down an artificial potential, until a local minimum (Khatib, 1986; Mora, Armesto and Tornero)",
);
