//! Depth cameras as sensors of the framework.

use rumbo_core::messages::{Data, DepthImage, Intrinsics, Observation, Observations};
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::rng::Rng;
use rumbo_core::stages::{
    Answer, BuildContext, BuildError, Cx, Probe, Sensor, SensorError, World, WorldError,
};
use rumbo_kit::depth::DepthDevice;

use super::eye::{Eye, EyeError, EyeSettings};
use super::params::{Given, KinectParams};
use crate::blindness::Blindness;
use crate::recorded::Seat;

rumbo_core::register_sensor!(
    KinectParams,
    "kinect",
    "a depth camera (Kinect v1, v2 or any other) as scan, points and pictures"
);

/// How much higher than the robot things may hang before they do not count, meters.
const HEADROOM_M: f64 = 0.10;
/// Pictures a second of both devices.
const DEVICE_HZ: f64 = 30.0;

/// A depth camera.
#[derive(Debug)]
pub struct Kinect {
    seat: Seat,
    camera: Intrinsics,
    device: DepthDevice,
    gives: Vec<Given>,
    eye: Eye,
    rng: Rng,
}

impl Plugin<dyn Sensor> for KinectParams {
    fn manifest(&self) -> Manifest {
        Manifest {
            produces: self.gives.iter().map(|given| given.kind()).collect(),
            default_rate_hz: Some(10.0),
            max_rate_hz: Some(DEVICE_HZ),
            field_of_view_rad: Some(self.field_of_view_rad()),
            ..Manifest::default()
        }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Sensor>, BuildError> {
        if let Some(fault) = self.check().into_iter().next() {
            return Err(fault);
        }
        let (seat, device, camera) = (Seat::of(context), self.device(), self.camera());
        let highest_m = self.max_height_m.unwrap_or(context.robot.height_m + HEADROOM_M);
        if highest_m <= self.min_height_m {
            let message = format!("is {}, expected less than {highest_m} m", self.min_height_m);
            return Err(BuildError::at("min_height_m", message));
        }
        let settings = EyeSettings {
            sensor: seat.sensor,
            base_from_camera: seat.base_from_sensor,
            projection: self.projection,
            near_plane_m: self.near_plane_m,
            max_range_m: device.max_m,
            heights_m: [self.min_height_m, highest_m],
            n_beams: self.beams.map(|n| n as usize),
            slice_rows: self.slice_rows.map(|n| n as usize),
            has_median: self.median,
            near_m: self.near_is_occupied.then(|| self.least_m().max(self.near_plane_m) + self.near_margin_m),
            closing_m_s: self.near_closing_m_s,
            gives_scan: self.gives.contains(&Given::LaserScan),
            gives_points: self.gives.contains(&Given::PointCloud),
            gives_picture: self.gives.contains(&Given::DepthImage),
        };
        let blindness = Blindness::after(self.blind_frames, self.min_valid_fraction);
        let eye =
            Eye::new(settings, &camera, blindness).map_err(|error| BuildError::at("", error.to_string()))?;
        Ok(Box::new(Kinect { seat, camera, device, gives: self.gives.clone(), eye, rng: context.rng() }))
    }
}

impl Sensor for Kinect {
    fn poll(
        &mut self,
        cx: &mut Cx<'_>,
        world: &mut dyn World,
        out: &mut Observations,
    ) -> Result<(), SensorError> {
        let probe = Probe::Depth {
            base_from_sensor: &self.seat.base_from_sensor,
            intrinsics: &self.camera,
            max_range_m: self.device.max_m,
        };
        let answer = match world.probe(&probe) {
            Err(unanswered @ WorldError::Unsupported { .. }) => {
                match world.probe(&Probe::Channel { name: &self.seat.name }) {
                    Ok(Answer::Recorded(recorded)) => return self.play(recorded, out),
                    // The first refusal says what this sensor needs.
                    _ => return Err(SensorError::World(unanswered)),
                }
            }
            answer => answer?,
        };
        let n_pixels = self.camera.width as usize * self.camera.height as usize;
        match answer {
            Answer::Recorded(recorded) => self.play(recorded, out),
            Answer::Ranges(exact_m) if exact_m.len() == n_pixels => {
                let mut depth = out.depth_buffer(n_pixels);
                let read =
                    self.device.read(exact_m, self.camera.width as usize, depth.make_mut(), &mut self.rng);
                read.map_err(|error| SensorError::Other(error.to_string()))?;
                let image =
                    DepthImage { intrinsics: self.camera, unit_m: self.device.unit_m as f32, depth };
                let seen = self.eye.see(cx.now, &image, out);
                if !self.gives.contains(&Given::DepthImage) {
                    // Nobody else has the picture: its memory serves the next one.
                    let Seat { sensor, base_from_sensor, .. } = self.seat;
                    let data = Data::DepthImage(image);
                    out.recycle(Observation { sensor, stamp: cx.now, base_from_sensor, valid: true, data });
                }
                seen.map_err(told)
            }
            Answer::Live => Err(SensorError::Device {
                device: self.seat.name.clone(),
                reason: "`kinect` has no driver of its own for a real camera; a plugin library with one gives depth \
                         pictures, from which `depth_to_scan` makes scans"
                    .to_owned(),
            }),
            other => Err(SensorError::WrongAnswer { expected: "a depth picture", found: other.name() }),
        }
    }
}

impl Kinect {
    /// Passes on what was recorded, and makes of recorded pictures what the recording does not have itself.
    fn play(&mut self, recorded: &[Observation], out: &mut Observations) -> Result<(), SensorError> {
        let mut failed = Ok(());
        for observation in recorded {
            match &observation.data {
                Data::DepthImage(image) if observation.valid => {
                    let has = |given: &Given| recorded.iter().any(|other| other.data.kind() == given.kind());
                    let derived = self.gives.iter().any(|given| *given != Given::DepthImage && !has(given));
                    if derived {
                        failed = failed.and(self.eye.see(observation.stamp, image, out).map_err(told));
                    } else {
                        self.pass_on(observation, out);
                    }
                }
                _ => self.pass_on(observation, out),
            }
        }
        failed
    }

    /// Scans lie level at the camera's place.
    fn pass_on(&self, observation: &Observation, out: &mut Observations) {
        let base_from_sensor = match observation.data {
            Data::LaserScan(_) => self.eye.base_from_scan(),
            _ => self.seat.base_from_sensor,
        };
        out.push(Observation { sensor: self.seat.sensor, base_from_sensor, ..observation.clone() });
    }
}

fn told(error: EyeError) -> SensorError {
    SensorError::Other(format!("the depth picture cannot be read: {error}"))
}

#[cfg(test)]
mod tests;
