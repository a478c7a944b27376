//! The planner in the framework.

use super::FictitiousChargesParams;
use crate::field_descent::MapSource;
use crate::field_descent::planner::FieldPlanner;
use crate::hull_fit::fits_hull;
use rumbo_core::map::Layer;
use rumbo_core::messages::Path;
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::stages::{BuildContext, BuildError, PlanError, PlanRequest, Planner};

/// See [`FictitiousChargesParams`].
pub struct FictitiousCharges(FieldPlanner);

impl Planner for FictitiousCharges {
    fn plan(&mut self, request: &PlanRequest) -> Result<Path, PlanError> {
        self.0.plan(request)
    }
}

impl Params for FictitiousChargesParams {
    fn check(&self) -> Vec<BuildError> {
        self.faults()
    }
}

impl Plugin<dyn Planner> for FictitiousChargesParams {
    fn manifest(&self) -> Manifest {
        let layer = match self.map {
            MapSource::Grid => Layer::Grid,
            MapSource::Lines => Layer::Lines,
        };
        Manifest { needs_layers: vec![layer], ..Manifest::default() }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Planner>, BuildError> {
        if let Some(clearance_m) = self.minimum_clearance_m {
            fits_hull("minimum_clearance_m", clearance_m, &context.robot)?;
        }
        let (settings, charges) = self.rules();
        let planner = FieldPlanner { settings, charges: Some(charges), rng: context.rng() };
        Ok(Box::new(FictitiousCharges(planner)))
    }
}

rumbo_core::register_planner!(
    FictitiousChargesParams,
    "fictitious_charges",
    "down an artificial potential, out of local minima by charges that stand for nothing (Mora, Armesto and Tornero)",
);
