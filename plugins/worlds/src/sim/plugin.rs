//! The simulation as a world of the framework.

use std::path::{Path, PathBuf};

use rumbo_core::frames::{Point2, Pose2, Pose3, is_finite3, pose2};
use rumbo_core::messages::{Command, Intrinsics, Marks};
use rumbo_core::registry::{Params, Plugin};
use rumbo_core::stages::{Advance, Answer, BuildContext, BuildError, Drove, Probe, Truth, World, WorldError};
use rumbo_core::time::Time;
use rumbo_kit::map_file::{MapImage, load_map};
use rumbo_kit::world_file::{Things, WorldScene, load_world};

use super::beams::{Fan, Ring};
use super::params::{SimParams, Start};
use super::place::{Extent, Place};
use super::simulation::{Hardships, Simulation};

rumbo_core::register_world!(
    SimParams,
    "sim",
    "a simulated place with walls, furniture, glass, doors and people"
);

/// A probe for more rays than this is a mistake in a sensor.
const MOST_RAYS: usize = 16_000_000;

/// The simulated world.
#[derive(Debug)]
pub struct SimWorld {
    simulation: Simulation,
    start: Pose2,
    map_file: Option<PathBuf>,
    contacts_rad: Vec<f64>,
    marks: Marks,
}

impl Plugin<dyn World> for SimParams {
    fn build(&self, context: &BuildContext) -> Result<Box<dyn World>, BuildError> {
        if let Some(fault) = self.check().into_iter().next() {
            return Err(fault);
        }
        let at_map = |error: &dyn std::fmt::Display| BuildError::at("map", error.to_string());
        let path = self.map.as_ref().map(|map| context.resolve(map));
        let mut scene = match &path {
            Some(path) => load_world(path).map_err(|error| at_map(&error))?,
            None => WorldScene::default(),
        };
        self.furnish(&mut scene)?;
        let image = scene
            .map
            .as_ref()
            .map(|map| load_map(map, self.max_cells).map_err(|error| at_map(&error)))
            .transpose()?;
        let area = Extent::of(&scene, image.as_ref()).area();
        if area > self.max_cells as f64 {
            let most = self.max_cells;
            let message = format!("the world spans {area:.0} cells of its map, expected at most {most}");
            let help = "move what lies far from the map, or raise max_cells";
            return Err(BuildError::at("map", message).help(help));
        }
        let mut place = Place::new(&scene, image.as_ref());
        place.companion = self.companion;
        let start = self.start.map_from_base();
        if let Some(image) = &image {
            check_on_map(image, start, "start")?;
        }
        if let (Some(image), Some(kidnap)) = (&image, &self.kidnap) {
            check_on_map(image, kidnap.to.map_from_base(), "kidnap.to")?;
        }
        let mut simulation = Simulation::new(place, &context.robot, start, self.hardships(), context.rng());
        check_is_free(simulation.truth().clearance_m, self.start, "start")?;
        if let Some(kidnap) = &self.kidnap {
            check_is_free(simulation.room_at_m(kidnap.to.map_from_base()), kidnap.to, "kidnap.to")?;
        }
        let (contacts_rad, marks) = (Vec::with_capacity(16), Marks::default());
        Ok(Box::new(SimWorld { simulation, start, map_file: path, contacts_rad, marks }))
    }
}

impl SimParams {
    fn hardships(&self) -> Hardships {
        Hardships {
            slip: self.slip.clone(),
            wheels: self.wheels,
            sway: self.sway,
            kidnap: self.kidnap,
            spins: self.spins.clone(),
        }
    }

    /// What the pipeline takes from the world file and adds to it.
    fn furnish(&self, scene: &mut WorldScene) -> Result<(), BuildError> {
        for (idx, name) in self.without.iter().enumerate() {
            if !scene.remove(name) {
                let message = format!(
                    "is \"{name}\", and the world has no box, ramp, step, door or person of this name"
                );
                return Err(BuildError::at(format!("without[{idx}]"), message));
            }
        }
        // Faults were told by `check`.
        if let Some(Ok(things)) = self.add.as_ref().map(Things::read) {
            scene.add(things);
        }
        Ok(())
    }
}

/// The robot must find room where it is put.
fn check_is_free(clearance_m: f64, place: Start, key: &str) -> Result<(), BuildError> {
    if clearance_m > 0.0 {
        return Ok(());
    }
    let Start { x_m, y_m, yaw_deg } = place;
    let message = format!(
        "the robot's hull overlaps something by {:.3} m at x_m = {x_m}, y_m = {y_m}, yaw_deg = {yaw_deg}",
        clearance_m.abs()
    );
    Err(BuildError::at(key, message).help("choose a start in free space"))
}

/// The robot must be put on the background map.
fn check_on_map(image: &MapImage, start: Pose2, key: &str) -> Result<(), BuildError> {
    let [x, y, yaw] = image.origin;
    let on_map = pose2(x, y, yaw).inverse() * Point2::from(start.translation.vector);
    let (width_m, height_m) =
        (image.width as f64 * image.resolution_m, image.height as f64 * image.resolution_m);
    if (0.0..width_m).contains(&on_map.x) && (0.0..height_m).contains(&on_map.y) {
        return Ok(());
    }
    let message = format!(
        "({}, {}) is outside the map, which covers {width_m:.2} m by {height_m:.2} m from its corner at ({x}, {y})",
        start.translation.x, start.translation.y
    );
    Err(BuildError::at(key, message).help("choose a place on the map"))
}

impl World for SimWorld {
    fn now(&self) -> Time {
        self.simulation.now
    }

    fn advance(&mut self, to: Time) -> Result<Advance, WorldError> {
        let now = self.simulation.now;
        if to < now {
            return Err(WorldError::Backwards { now, to });
        }
        if to > now {
            self.simulation.advance(to);
        }
        Ok(Advance::Reached(to))
    }

    fn drive(&mut self, command: &Command) -> Result<Drove, WorldError> {
        if !command.twist.is_finite() {
            return Err(WorldError::NotFinite);
        }
        self.simulation.drive.want(command.twist);
        Ok(Drove::Drove)
    }

    fn probe<'w>(&'w mut self, probe: &Probe<'_>) -> Result<Answer<'w>, WorldError> {
        check_probe(probe)?;
        let simulation = &mut self.simulation;
        match *probe {
            Probe::Beams { base_from_sensor, first_bearing_rad, bearing_step_rad, n_beams, max_range_m } => {
                let mount = simulation.map_from_sensor(base_from_sensor);
                let fan = Fan { first_bearing_rad, bearing_step_rad, n_beams };
                Ok(Answer::Ranges(simulation.eyes.beams(&mut simulation.place, &mount, fan, max_range_m)))
            }
            Probe::Cones { base_from_sensor, bearings_rad, cone_rad, ring_radius_m, max_range_m } => {
                let mount = simulation.map_from_sensor(base_from_sensor);
                let ring = Ring { bearings_rad, cone_rad, ring_radius_m };
                Ok(Answer::Ranges(simulation.eyes.cones(&mut simulation.place, &mount, ring, max_range_m)))
            }
            Probe::Depth { base_from_sensor, intrinsics, max_range_m } => {
                let mount = simulation.map_from_sensor(base_from_sensor);
                Ok(Answer::Ranges(simulation.eyes.depths(
                    &mut simulation.place,
                    &mount,
                    intrinsics,
                    max_range_m,
                )))
            }
            Probe::Wheels => Ok(Answer::Wheels(simulation.drive.wheels)),
            Probe::Attitude => Ok(Answer::Attitude(simulation.attitude())),
            Probe::Position => {
                Ok(Answer::Position(simulation.truth().map_from_base.translation.vector.into()))
            }
            Probe::Person { name } => {
                let place = simulation.place.person(name).map(|at| [at.x, at.y, 0.0]);
                place.map(Answer::Position).ok_or(WorldError::Unsupported { probe: probe.name() })
            }
            Probe::Contacts => {
                simulation.body.contacts(&mut simulation.place, &mut self.contacts_rad);
                Ok(Answer::Contacts(&self.contacts_rad))
            }
            Probe::Marks { base_from_sensor, field_of_view_rad, max_range_m } => {
                let mount = simulation.map_from_sensor(base_from_sensor);
                simulation.marks_in_view(&mount, field_of_view_rad, max_range_m, &mut self.marks);
                Ok(Answer::Marks(&self.marks))
            }
            _ => Err(WorldError::Unsupported { probe: probe.name() }),
        }
    }

    fn truth(&self) -> Option<&Truth> {
        Some(self.simulation.truth())
    }

    fn start(&self) -> Option<Pose2> {
        Some(self.start)
    }

    fn map_file(&self) -> Option<&Path> {
        self.map_file.as_deref()
    }
}

/// A sensor may ask nonsense; the answer must not be an endless loop or all of the memory.
fn check_probe(probe: &Probe<'_>) -> Result<(), WorldError> {
    let (mount, numbers, max_range_m, n_rays): (Option<&Pose3>, [f64; 3], f64, usize) = match *probe {
        Probe::Beams { base_from_sensor, first_bearing_rad, bearing_step_rad, n_beams, max_range_m } => {
            (Some(base_from_sensor), [first_bearing_rad, bearing_step_rad, 0.0], max_range_m, n_beams)
        }
        Probe::Cones { base_from_sensor, bearings_rad, cone_rad, ring_radius_m, max_range_m } => {
            let bearings = bearings_rad.iter().sum();
            (Some(base_from_sensor), [bearings, cone_rad, ring_radius_m], max_range_m, bearings_rad.len())
        }
        Probe::Depth { base_from_sensor, intrinsics, max_range_m } => {
            let Intrinsics { width, height, focal_px: [fx, fy], center_px: [cx, cy] } = *intrinsics;
            let n_rays = width as usize * height as usize;
            (Some(base_from_sensor), [1.0 / fx, 1.0 / fy, cx + cy], max_range_m, n_rays)
        }
        Probe::Marks { base_from_sensor, field_of_view_rad, max_range_m } => {
            (Some(base_from_sensor), [field_of_view_rad, 0.0, 0.0], max_range_m, 0)
        }
        _ => return Ok(()),
    };
    let sane =
        mount.is_none_or(is_finite3) && numbers.iter().all(|number| number.is_finite()) && max_range_m >= 0.0;
    if sane && n_rays <= MOST_RAYS {
        return Ok(());
    }
    Err(WorldError::Other(format!(
        "the probe for {} asks for {n_rays} rays with {numbers:?} up to {max_range_m} m; expected finite numbers, a \
         range of 0 or more and at most {MOST_RAYS} rays",
        probe.name()
    )))
}

#[cfg(test)]
mod tests;
