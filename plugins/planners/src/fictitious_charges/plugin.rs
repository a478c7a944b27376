//! The planner in the framework.

use super::FictitiousChargesParams;
use crate::field_descent::planner::FieldPlanner;
use crate::hull_fit::fits_hull;
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::stages::{BuildContext, BuildError, Planner};

impl Params for FictitiousChargesParams {
    fn check(&self) -> Vec<BuildError> {
        self.faults()
    }
}

impl Plugin<dyn Planner> for FictitiousChargesParams {
    fn manifest(&self) -> Manifest {
        Manifest { needs_layers: vec![self.map.layer()], ..Manifest::default() }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Planner>, BuildError> {
        if let Some(clearance_m) = self.minimum_clearance_m {
            fits_hull("minimum_clearance_m", clearance_m, &context.robot)?;
        }
        let (settings, charges) = self.rules();
        let planner =
            FieldPlanner { settings, charges: Some(charges), n_attempts: self.attempts, rng: context.rng() };
        Ok(Box::new(planner))
    }
}

rumbo_core::register_planner!(
    FictitiousChargesParams,
    "fictitious_charges",
    "down an artificial potential, out of local minima by charges that stand for nothing (Mora, Armesto and Tornero)",
);
