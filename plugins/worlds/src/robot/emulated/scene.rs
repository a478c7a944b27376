//! One simulated robot for all who emulate a part of it.

use std::sync::{Arc, Mutex, PoisonError};

use rumbo_core::stages::{Answer, Probe, World, WorldError};
use rumbo_core::time::Time;
use rumbo_kit::emulation::{Clock, Surroundings};

/// A simulated world that several threads look at, each as late as it is.
pub struct Scene {
    world: Mutex<Box<dyn World>>,
}

impl Scene {
    /// Takes a simulated world.
    pub fn new(world: Box<dyn World>) -> Self {
        Self { world: Mutex::new(world) }
    }

    /// The world as it is at `now`, or later, should somebody else have been there already.
    pub fn at<R>(&self, now: Time, see: impl FnOnce(&mut dyn World) -> R) -> R {
        // A simulation is not left half way when somebody panics beside it.
        let mut world = self.world.lock().unwrap_or_else(PoisonError::into_inner);
        if now > world.now() {
            // A simulated world has no reason to refuse what lies ahead.
            let _ = world.advance(now);
        }
        see(world.as_mut())
    }
}

/// The scene for a device, which looks at it when it has to.
pub struct SceneView {
    /// The scene.
    pub scene: Arc<Scene>,
    /// The time it is.
    pub clock: Clock,
}

impl Surroundings for SceneView {
    fn look(&mut self, probe: &Probe<'_>, take: &mut dyn FnMut(&Answer<'_>)) -> Result<(), WorldError> {
        self.scene.at((self.clock)(), |world| world.probe(probe).map(|answer| take(&answer)))
    }
}
