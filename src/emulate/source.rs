//! What is to be emulated: a pipeline's robot, or one in a world file.

use crate::exit::Failure;
use crate::load;
use crate::terminal::Terminal;
use rumbo_core::frames::Pose3;
use rumbo_core::pipeline::{Pipeline, SensorSpec};
use rumbo_core::stages::BuildContext;
use rumbo_kit::emulation::model;
use rumbo_kit::world_file::load_world;
use rumbo_worlds::robot::{EmulateParams, RobotParams};
use rumbo_worlds::sim::SimParams;
use std::path::Path;

/// A device at its place on the robot.
#[derive(Debug, Clone)]
pub struct Device {
    /// Name of the sensor.
    pub name: String,
    /// Name of the model.
    pub model: String,
    /// The mount.
    pub base_from_sensor: Pose3,
}

/// What is to be emulated.
pub struct Source {
    /// Place, start, rings, faults.
    pub emulate: EmulateParams,
    /// Robot, seed and folder.
    pub context: BuildContext,
    /// It comes from a pipeline that can drive it.
    pub is_robot: bool,
    sensors: Vec<Device>,
}

impl Source {
    /// The devices that sensors read, or else one of the model that is asked for.
    pub fn devices(&self, what: &str) -> Vec<Device> {
        let is_there = |device: &Device| device.model == what;
        if model(what).is_some() && !self.sensors.iter().any(is_there) {
            return vec![usual(what)];
        }
        self.sensors.clone()
    }
}

/// A device as high as most robots have it.
fn usual(model: &str) -> Device {
    const HEIGHT_M: f64 = 0.3;
    let base_from_sensor = Pose3::translation(0.0, 0.0, HEIGHT_M);
    Device { name: model.to_owned(), model: model.to_owned(), base_from_sensor }
}

/// Reads a pipeline, a world file or a map.
pub fn read(path: &Path, sets: &[String], json: bool, terminal: &Terminal) -> Result<Source, Failure> {
    if !path.is_file() {
        return Err(Failure::Usage(format!("{}: there is no such file", path.display())));
    }
    let is_map = path.extension().is_some_and(|ending| ending == "yaml" || ending == "yml");
    if is_map || (sets.is_empty() && load_world(path).is_ok()) {
        return of_world(path, sets);
    }
    let ready = load::checked(path, sets, json, terminal)?;
    of_pipeline(&ready.pipeline, path)
}

fn of_world(path: &Path, sets: &[String]) -> Result<Source, Failure> {
    if !sets.is_empty() {
        return Err(Failure::Usage(format!(
            "{} is no pipeline: --set changes nothing there",
            path.display()
        )));
    }
    let map = std::path::absolute(path);
    let map = map.map_err(|error| Failure::Usage(format!("{}: {error}", path.display())))?;
    Ok(Source {
        emulate: EmulateParams { map: Some(map), ..EmulateParams::default() },
        context: BuildContext::bare("world"),
        is_robot: false,
        sensors: vec![usual("lms200")],
    })
}

fn of_pipeline(pipeline: &Pipeline, path: &Path) -> Result<Source, Failure> {
    let (plugin, parameters) = (pipeline.world.entry.name.as_str(), pipeline.world.configured.parameters());
    let bug = |error: toml::de::Error| Failure::Internal(format!("the world's own parameters: {error}"));
    let emulate = match plugin {
        "robot" => parameters.try_into::<RobotParams>().map_err(bug)?.emulate,
        "sim" => {
            let SimParams { map, start, slip, .. } = parameters.try_into().map_err(bug)?;
            Some(EmulateParams { map, start, slip, ..EmulateParams::default() })
        }
        other => {
            return Err(Failure::Usage(format!(
                "{}: nothing emulates the world `{other}`, expected a pipeline with the world robot or sim",
                path.display()
            )));
        }
    };
    let emulate = emulate.ok_or_else(|| {
        Failure::Usage(format!(
            "{}: [world] has no table `emulate`, expected one that says where the robot stands, such as\n  emulate = \
             {{ map = \"worlds/office-20m.yaml\", start = {{ x_m = 3.0, y_m = 4.5 }}, enabled = false }}",
            path.display()
        ))
    })?;
    let context = BuildContext {
        robot: pipeline.robot.clone(),
        seed: pipeline.seed,
        folder: pipeline.folder.clone(),
        ..BuildContext::bare("world")
    };
    let sensors = pipeline.sensors.iter().filter_map(device_of).collect();
    Ok(Source { emulate, context, is_robot: plugin == "robot", sensors })
}

fn device_of(sensor: &SensorSpec) -> Option<Device> {
    let model = model(&sensor.stage.entry.name)?;
    Some(Device {
        name: sensor.stage.name.clone(),
        model: model.name.to_owned(),
        base_from_sensor: sensor.base_from_sensor,
    })
}
