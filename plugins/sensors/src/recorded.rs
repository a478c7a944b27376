//! What every sensor does alike: in a world that plays a recording it passes on what was recorded under its name, in one
//! that is real it looks for its device.

use rumbo_core::frames::Pose3;
use rumbo_core::messages::{Observation, Observations, SensorId};
use rumbo_core::stages::{Answer, BuildContext, OwnDevice, Probe, SensorError, World, WorldError};

/// Who a sensor is and where it sits.
#[derive(Debug, Clone)]
pub(crate) struct Seat {
    pub name: String,
    pub sensor: SensorId,
    pub base_from_sensor: Pose3,
}

impl Seat {
    pub fn of(context: &BuildContext) -> Self {
        Self {
            name: context.name.clone(),
            sensor: context.sensor,
            base_from_sensor: context.base_from_sensor,
        }
    }

    /// Passes on what was recorded, with its own stamps, as seen by this sensor.
    pub fn pass_on(&self, recorded: &[Observation], out: &mut Observations) {
        for observation in recorded {
            let (sensor, base_from_sensor) = (self.sensor, self.base_from_sensor);
            out.push(Observation { sensor, base_from_sensor, ..observation.clone() });
        }
    }

    /// Asks the world, and takes from its answer what the sensor needs; nothing where the world gave a recording, which is
    /// passed on. `take` gives nothing for an answer that is not what was `expected`.
    pub fn ask<T>(
        &self,
        world: &mut dyn World,
        probe: &Probe<'_>,
        expected: &'static str,
        out: &mut Observations,
        take: impl FnOnce(&Answer<'_>) -> Option<T>,
    ) -> Result<Option<T>, SensorError> {
        match world.probe(probe) {
            Ok(Answer::Recorded(recorded)) => {
                self.pass_on(recorded, out);
                Ok(None)
            }
            Ok(answer) => {
                take(&answer).map(Some).ok_or(SensorError::WrongAnswer { expected, found: answer.name() })
            }
            Err(unanswered @ WorldError::Unsupported { .. }) => {
                self.ask_recording(world, unanswered, out).map(|()| None)
            }
            Err(error) => Err(error.into()),
        }
    }

    /// After a world had no answer to the sensor's own probe: asks for the recorded channel of its name.
    pub fn ask_recording(
        &self,
        world: &mut dyn World,
        unanswered: WorldError,
        out: &mut Observations,
    ) -> Result<(), SensorError> {
        match world.probe(&Probe::Channel { name: &self.name }) {
            Ok(Answer::Recorded(recorded)) => {
                self.pass_on(recorded, out);
                Ok(())
            }
            // The first refusal says what this sensor needs; the second only that there is no recording either.
            _ => Err(SensorError::World(unanswered)),
        }
    }

    /// In a world that is real: where the device is. A world that emulates devices says it, else `port`.
    pub fn device_address(
        &self,
        model: &str,
        port: Option<&str>,
        world: &mut dyn World,
    ) -> Result<String, SensorError> {
        let device = OwnDevice { model, name: &self.name, base_from_sensor: &self.base_from_sensor };
        let emulated = world.emulated_device(&device)?;
        emulated.or_else(|| port.map(str::to_owned)).ok_or_else(|| SensorError::Device {
            device: self.name.clone(),
            reason: "the world is real, and `port` does not say where the device is".to_owned(),
        })
    }
}
