//! A planner of your own: one struct of parameters, one trait, one line of registration, and any pipeline can name it.
//!
//! `cargo run --release --example own_planner`
#![allow(clippy::print_stdout)]

use rumbo_core::engine::{Engine, Metrics};
use rumbo_core::frames::Point2;
use rumbo_core::map::Layer;
use rumbo_core::messages::Path;
use rumbo_core::pipeline::Loaded;
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::stages::{BuildContext, BuildError, PlanError, PlanRequest, Planner};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::atomic::AtomicBool;

/// Goes along x first and along y afterwards, and never looks where it goes.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
struct ManhattanParams {
    /// Go along y first.
    y_first: bool,
}

struct Manhattan(ManhattanParams);

impl Params for ManhattanParams {}

impl Plugin<dyn Planner> for ManhattanParams {
    fn manifest(&self) -> Manifest {
        Manifest { needs_layers: vec![Layer::Grid], ..Manifest::default() }
    }

    fn build(&self, _: &BuildContext) -> Result<Box<dyn Planner>, BuildError> {
        Ok(Box::new(Manhattan(self.clone())))
    }
}

impl Planner for Manhattan {
    fn plan(&mut self, request: &PlanRequest) -> Result<Path, PlanError> {
        let start = Point2::from(request.start.translation.vector);
        let goal = request.goal.position;
        let corner = if self.0.y_first { Point2::new(start.x, goal.y) } else { Point2::new(goal.x, start.y) };
        Path::through([start, corner, goal], 0.0).ok_or(PlanError::Other("no points".into()))
    }
}

rumbo_core::register_planner!(ManhattanParams, "manhattan", "goes along x, then along y");

const PIPELINE: &str = r#"
world = { plugin = "sim", map = "worlds/office-20m.yaml", start = { x_m = 3.0, y_m = 4.5, yaw_deg = 90.0 } }
sensor = [{ name = "laser", plugin = "lms200" }, { name = "wheels", plugin = "wheel_encoders" }]
map_builder = { plugin = "static_map" }
localizer = { plugin = "odometry" }
planner = { plugin = "manhattan" }
avoider = { plugin = "stop_and_replan" }
mission = { waypoints = [{ x_m = 3.1, y_m = 8.0 }] }
"#;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let registry = rumbo::registry()?;
    let loaded = Loaded::from_text("pipelines/own_planner.toml".as_ref(), PIPELINE, &[], &registry);
    let pipeline = loaded.sound().ok_or_else(|| loaded.lines().join("\n"))?;
    let mut metrics = Metrics::new();
    let end = Engine::build(pipeline)?.run(&mut [&mut metrics], &AtomicBool::new(false));
    let summary = metrics.summary(end.reason, end.detail);
    println!("{} after {:.2} m and {:.1} s", summary.reason, summary.path_m, summary.time_s);
    Ok(())
}
