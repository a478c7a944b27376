//! Plugins that do nothing, for pipelines that the shipped plugins cannot spell.

use rumbo_core::map::{Layer, Map};
use rumbo_core::messages::{Estimate, ObservationKind, Observations, Path, Prior, Seen};
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::stages::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

struct Idle;

impl Sensor for Idle {
    fn poll(&mut self, _: &mut Cx<'_>, _: &mut dyn World, _: &mut Observations) -> Result<(), SensorError> {
        Ok(())
    }
}

impl MapBuilder for Idle {
    fn start(&mut self, _: &mut Map) -> Result<(), MapError> {
        Ok(())
    }
    fn insert(&mut self, _: &mut Cx<'_>, _: &MapInput<'_>, _: &mut Map) -> Result<(), MapError> {
        Ok(())
    }
}

impl Localizer for Idle {
    fn start(&mut self, _: &Prior, _: &Map) -> Result<(), LocalizeError> {
        Ok(())
    }
    fn update(&mut self, cx: &mut Cx<'_>, _: Seen<'_>, _: &Map) -> Result<Estimate, LocalizeError> {
        Ok(Estimate::lost(cx.now))
    }
}

impl Slam for Idle {
    fn start(&mut self, _: &Prior, _: &mut Map) -> Result<(), SlamError> {
        Ok(())
    }
    fn update(&mut self, cx: &mut Cx<'_>, _: Seen<'_>, _: &mut Map) -> Result<Estimate, SlamError> {
        Ok(Estimate::lost(cx.now))
    }
}

impl Planner for Idle {
    fn plan(&mut self, _: &PlanRequest) -> Result<Path, PlanError> {
        Err(PlanError::GivenUp)
    }
}

macro_rules! double {
    ($register:ident, $seam:ident, $name:literal, $params:ident, $manifest:expr) => {
        /// A double.
        #[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
        #[serde(default, deny_unknown_fields)]
        struct $params {}
        impl Params for $params {}
        impl Plugin<dyn $seam> for $params {
            fn manifest(&self) -> Manifest {
                $manifest
            }
            fn build(&self, _: &BuildContext) -> Result<Box<dyn $seam>, BuildError> {
                Ok(Box::new(Idle))
            }
        }
        rumbo_core::$register!($params, $name, "a double");
    };
}

double!(
    register_sensor,
    Sensor,
    "test_smoother",
    SmootherParams,
    Manifest {
        consumes: vec![vec![ObservationKind::LaserScan]],
        produces: vec![ObservationKind::LaserScan],
        is_virtual: true,
        ..Manifest::default()
    }
);
double!(
    register_map_builder,
    MapBuilder,
    "test_overlay",
    OverlayParams,
    Manifest {
        needs_layers: vec![Layer::Grid],
        gives_layers: vec![Layer::Grid],
        overlays: true,
        ..Manifest::default()
    }
);
double!(register_localizer, Localizer, "test_idle", IdleParams, Manifest::default());
double!(
    register_localizer,
    Localizer,
    "test_lines",
    LinesParams,
    Manifest { needs_layers: vec![Layer::Lines], ..Manifest::default() }
);
double!(
    register_slam,
    Slam,
    "test_slam",
    SlamParams,
    Manifest { gives_layers: vec![Layer::Landmarks], ..Manifest::default() }
);
double!(register_planner, Planner, "test_planner", PlannerParams, Manifest::default());
