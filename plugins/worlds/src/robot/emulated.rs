//! The robot that is not there: one simulated robot, its base and its devices behind real lines, in real time.

mod base;
mod scene;

use std::sync::Arc;

use rumbo_core::rng::{self, RngExt as _};
use rumbo_core::robot::Robot;
use rumbo_core::stages::{BuildContext, OwnDevice, Truth, World, WorldError};
use rumbo_kit::emulation::{Clock, EmulatedDevice, LineFaults, Mounted, Outlet, Served, model, models};
use rumbo_kit::wall_clock::WallClock;

use super::params::EmulateParams;
pub use base::EmulatedBase;
pub use scene::{Scene, SceneView};

/// A simulated robot in real time.
pub struct EmulatedRobot {
    /// Threads that use the scene end before it does.
    served: Vec<Served>,
    scene: Arc<Scene>,
    clock: Clock,
    robot: Arc<Robot>,
    params: EmulateParams,
    seed: u64,
}

impl std::fmt::Debug for EmulatedRobot {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("EmulatedRobot").field("served", &self.served).finish_non_exhaustive()
    }
}

impl EmulatedRobot {
    /// Puts the robot into a simulated place, which [`EmulateParams::place`] gives. Nothing can be reached yet.
    pub fn new(place: Box<dyn World>, params: &EmulateParams, context: &BuildContext) -> Self {
        let clock = WallClock::start();
        Self {
            served: Vec::new(),
            scene: Arc::new(Scene::new(place)),
            clock: Arc::new(move || clock.now()),
            robot: Arc::clone(&context.robot),
            params: params.clone(),
            seed: context.seed,
        }
    }

    /// Lets the base live at an outlet; the address that a host opens.
    pub fn serve_base(&mut self, outlet: Outlet) -> std::io::Result<String> {
        let base = EmulatedBase::new(&self.params, &self.robot, Arc::clone(&self.scene));
        self.serve("base", Box::new(base), outlet)
    }

    /// Switches a device on and lets it live at an outlet; the address that a host opens.
    pub fn serve_device(&mut self, device: &OwnDevice<'_>, outlet: Outlet) -> Result<String, WorldError> {
        let Some(model) = model(device.model) else {
            let known: Vec<&str> = models().map(|model| model.name).collect();
            return Err(WorldError::Other(format!(
                "there is no emulated {}, expected one of {}",
                device.model,
                known.join(", ")
            )));
        };
        let view = SceneView { scene: Arc::clone(&self.scene), clock: Arc::clone(&self.clock) };
        let mounted = Mounted {
            base_from_sensor: *device.base_from_sensor,
            surroundings: Box::new(view),
            now: (self.clock)(),
            // Two devices of one model err each in its own way.
            seed: rng::stream(self.seed, device.name).random(),
        };
        let served = self.serve(device.name, (model.switch_on)(mounted), outlet);
        served.map_err(|error| WorldError::Other(format!("{}: {error}", device.name)))
    }

    /// Where the robot really is.
    pub fn truth(&self) -> Option<Truth> {
        self.scene.at((self.clock)(), |world| world.truth().copied())
    }

    /// Everything that was served still lives.
    pub fn is_alive(&self) -> bool {
        self.served.iter().all(Served::is_alive)
    }

    fn serve(
        &mut self,
        name: &str,
        device: Box<dyn EmulatedDevice>,
        outlet: Outlet,
    ) -> std::io::Result<String> {
        let faults = LineFaults::new(self.params.faults, self.seed, name);
        let served = Served::start(outlet, device, faults, Arc::clone(&self.clock))?;
        let address = served.address().to_owned();
        self.served.push(served);
        Ok(address)
    }
}
