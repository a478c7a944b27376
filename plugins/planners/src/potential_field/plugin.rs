//! The planner in the framework.

use super::PotentialFieldParams;
use crate::field_descent::MapSource;
use crate::field_descent::planner::FieldPlanner;
use crate::hull_fit::fits_hull;
use rumbo_core::map::Layer;
use rumbo_core::messages::Path;
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::stages::{BuildContext, BuildError, PlanError, PlanRequest, Planner};

/// See [`PotentialFieldParams`].
pub struct PotentialField(FieldPlanner);

impl Planner for PotentialField {
    fn plan(&mut self, request: &PlanRequest) -> Result<Path, PlanError> {
        self.0.plan(request)
    }
}

impl Params for PotentialFieldParams {
    fn check(&self) -> Vec<BuildError> {
        self.faults()
    }
}

impl Plugin<dyn Planner> for PotentialFieldParams {
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
        let planner = FieldPlanner { settings: self.rules(), charges: None, rng: context.rng() };
        Ok(Box::new(PotentialField(planner)))
    }
}

rumbo_core::register_planner!(
    PotentialFieldParams,
    "potential_field",
    "down an artificial potential, until a local minimum (Khatib, 1986; Mora, Armesto and Tornero)",
);
