//! A world for tests: one straight wall, wheels that say what they are told, or a recording.

use rumbo_core::messages::{Command, Marks, Observation, Observations};
use rumbo_core::stages::{Advance, Answer, Drove, Probe, WheelMotion, World, WorldError};
use rumbo_core::time::Time;

/// What a sensor gave, oldest first.
pub(crate) fn given(out: &Observations) -> Vec<Observation> {
    out.iter().cloned().collect()
}

/// The wall stands at x = `wall_x_m` of the sensor's frame.
pub(crate) struct TestWorld {
    pub wall_x_m: f64,
    pub wheels: WheelMotion,
    pub recorded: Option<Vec<Observation>>,
    pub contacts_rad: Vec<f64>,
    pub marks: Marks,
    /// Sensors shall read their own devices.
    pub is_live: bool,
    ranges_m: Vec<f32>,
}

impl TestWorld {
    pub fn with_wall(wall_x_m: f64) -> Self {
        Self {
            wall_x_m,
            wheels: WheelMotion::default(),
            recorded: None,
            contacts_rad: Vec::new(),
            marks: Marks::default(),
            is_live: false,
            ranges_m: Vec::new(),
        }
    }

    pub fn recorded(recorded: Vec<Observation>) -> Self {
        Self { recorded: Some(recorded), ..Self::with_wall(1.0) }
    }
}

impl World for TestWorld {
    fn now(&self) -> Time {
        Time::ZERO
    }

    fn advance(&mut self, to: Time) -> Result<Advance, WorldError> {
        Ok(Advance::Reached(to))
    }

    fn drive(&mut self, _: &Command) -> Result<Drove, WorldError> {
        Ok(Drove::NotActuated)
    }

    fn probe<'w>(&'w mut self, probe: &Probe<'_>) -> Result<Answer<'w>, WorldError> {
        if self.is_live {
            return Ok(Answer::Live);
        }
        match (probe, &self.recorded) {
            (Probe::Channel { name: "sensor" }, Some(recorded)) => Ok(Answer::Recorded(recorded)),
            (_, Some(_)) => Err(WorldError::Unsupported { probe: probe.name() }),
            (Probe::Wheels, None) => Ok(Answer::Wheels(self.wheels)),
            (Probe::Beams { first_bearing_rad, bearing_step_rad, n_beams, max_range_m, .. }, None) => {
                let range_m = |idx: usize| {
                    let range_m = self.wall_x_m / (first_bearing_rad + bearing_step_rad * idx as f64).cos();
                    if range_m > 0.0 && range_m <= *max_range_m { range_m as f32 } else { f32::INFINITY }
                };
                self.ranges_m = (0..*n_beams).map(range_m).collect();
                Ok(Answer::Ranges(&self.ranges_m))
            }
            (Probe::Cones { bearings_rad, ring_radius_m, max_range_m, .. }, None) => {
                let range_m = |bearing_rad: &f64| {
                    let range_m = self.wall_x_m / bearing_rad.cos() - ring_radius_m;
                    if range_m > 0.0 && range_m <= *max_range_m { range_m as f32 } else { f32::INFINITY }
                };
                self.ranges_m = bearings_rad.iter().map(range_m).collect();
                Ok(Answer::Ranges(&self.ranges_m))
            }
            (Probe::Depth { base_from_sensor, intrinsics, .. }, None) => {
                self.ranges_m = (0..intrinsics.width * intrinsics.height)
                    .map(|pixel| {
                        let (row, column) = (pixel / intrinsics.width, pixel % intrinsics.width);
                        let left = (intrinsics.center_px[0] - f64::from(column)) / intrinsics.focal_px[0];
                        let up = (intrinsics.center_px[1] - f64::from(row)) / intrinsics.focal_px[1];
                        let ray = base_from_sensor.rotation * nalgebra::Vector3::new(1.0, left, up);
                        let floor_m = -base_from_sensor.translation.z / ray.z;
                        let wall_m = self.wall_x_m / ray.x;
                        [floor_m, wall_m].into_iter().filter(|m| *m > 0.0).fold(f64::INFINITY, f64::min)
                            as f32
                    })
                    .collect();
                Ok(Answer::Ranges(&self.ranges_m))
            }
            (Probe::Marks { .. }, None) => Ok(Answer::Marks(&self.marks)),
            (Probe::Contacts, None) => Ok(Answer::Contacts(&self.contacts_rad)),
            _ => Err(WorldError::Unsupported { probe: probe.name() }),
        }
    }
}
