//! Depth pictures as scans, as a virtual sensor of the framework.

use crate::tilt::{without_yaw, world_from_base};
use std::collections::BTreeMap;
use std::ops::Range;

use nalgebra::{Translation3, UnitQuaternion};
use rumbo_core::frames::Pose3;
use rumbo_core::messages::{
    Data, DepthImage, Imu, Intrinsics, Observation, ObservationKind, Observations, Seen, SensorId,
};
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::stages::{BuildContext, BuildError, Cx, Sensor, SensorError, World};
use rumbo_core::time::Time;
use rumbo_kit::depth::{Depths, Rays, ScanLimits};

use super::DepthToScanParams;
use crate::blindness::Blindness;
use crate::virtual_scan::{ScanMaker, level};

rumbo_core::register_sensor!(
    DepthToScanParams,
    "depth_to_scan",
    "planar scans out of another sensor's depth pictures"
);

/// How much higher than the robot things may hang before they do not count, meters.
const HEADROOM_M: f64 = 0.10;

/// Makes scans of pictures.
#[derive(Debug)]
pub struct DepthToScan {
    sensor: SensorId,
    params: DepthToScanParams,
    highest_m: f64,
    blindness: Blindness,
    attitude: Option<Attitude>,
    /// When each camera gave its last picture.
    newest: BTreeMap<SensorId, Time>,
    n_late: u64,
    /// Scans of the camera that gave the last picture.
    maker: Option<(Intrinsics, ScanMaker)>,
}

/// How the base was tilted.
#[derive(Debug, Clone, Copy)]
struct Attitude {
    stamp: Time,
    stabilized_from_base: UnitQuaternion<f64>,
}

impl Plugin<dyn Sensor> for DepthToScanParams {
    fn manifest(&self) -> Manifest {
        Manifest {
            consumes: vec![vec![ObservationKind::DepthImage]],
            produces: vec![ObservationKind::LaserScan],
            is_virtual: true,
            ..Manifest::default()
        }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Sensor>, BuildError> {
        if let Some(fault) = self.check().into_iter().next() {
            return Err(fault);
        }
        let highest_m = self.max_height_m.unwrap_or(context.robot.height_m + HEADROOM_M);
        if highest_m <= self.min_height_m {
            let message = format!("is {}, expected less than {highest_m} m", self.min_height_m);
            return Err(BuildError::at("min_height_m", message));
        }
        let blindness = Blindness::after(self.blind_frames, self.min_valid_fraction);
        let (sensor, params) = (context.sensor, self.clone());
        Ok(Box::new(DepthToScan {
            sensor,
            params,
            highest_m,
            blindness,
            attitude: None,
            newest: BTreeMap::new(),
            n_late: 0,
            maker: None,
        }))
    }
}

impl Sensor for DepthToScan {
    fn poll(&mut self, _: &mut Cx<'_>, _: &mut dyn World, _: &mut Observations) -> Result<(), SensorError> {
        Err(SensorError::Other("this sensor derives scans from `inputs` and reads no world".to_owned()))
    }

    fn derive(
        &mut self,
        cx: &mut Cx<'_>,
        inputs: Seen<'_>,
        out: &mut Observations,
    ) -> Result<(), SensorError> {
        let mut failed = Ok(());
        for observation in inputs.iter() {
            match &observation.data {
                Data::Imu(imu) if observation.valid => self.turn(observation, imu),
                Data::DepthImage(image) if self.is_newer(observation) => {
                    failed = failed.and(self.scan(observation, image, out));
                }
                _ => {}
            }
        }
        cx.trace.count("depth pictures dropped: not newer than the last", self.n_late as f64);
        failed
    }
}

impl DepthToScan {
    /// A picture that comes twice, or late, is dropped.
    fn is_newer(&mut self, observation: &Observation) -> bool {
        let (sensor, stamp) = (observation.sensor, observation.stamp);
        let is_newer = self.newest.get(&sensor).is_none_or(|newest| *newest < stamp);
        if is_newer {
            self.newest.insert(sensor, stamp);
        } else {
            self.n_late += 1;
        }
        is_newer
    }

    /// Takes in how the base is tilted.
    fn turn(&mut self, observation: &Observation, imu: &Imu) {
        let Some(world_from_base) = world_from_base(&observation.base_from_sensor, imu) else { return };
        let stabilized_from_base = without_yaw(&world_from_base);
        self.attitude = Some(Attitude { stamp: observation.stamp, stabilized_from_base });
    }

    fn scan(
        &mut self,
        observation: &Observation,
        image: &DepthImage,
        out: &mut Observations,
    ) -> Result<(), SensorError> {
        let told = |error: &dyn std::fmt::Display| {
            SensorError::Other(format!("the depth picture cannot be read: {error}"))
        };
        let tilt = self.attitude.map_or(UnitQuaternion::identity(), |a| a.stabilized_from_base);
        let is_stale = self.attitude.is_some_and(|attitude| {
            (observation.stamp - attitude.stamp).as_secs().abs() > self.params.max_attitude_age_s
        });
        let stabilized_from_camera =
            Pose3::from_parts(Translation3::identity(), tilt) * observation.base_from_sensor;
        let (base_from_sensor, level_from_camera) = level(&stabilized_from_camera);
        let maker = match &mut self.maker {
            Some((camera, maker)) if *camera == image.intrinsics => maker,
            other => {
                let rays = Rays::pinhole(&image.intrinsics).map_err(|error| told(&error))?;
                let limits = limits(&self.params, self.highest_m, rays.n_rows());
                let maker = ScanMaker::new(rays, limits, self.params.beams.map(|n| n as usize));
                let maker = maker.map_err(|error| told(&error))?;
                &mut other.insert((image.intrinsics, maker)).1
            }
        };
        maker.face(&level_from_camera, base_from_sensor.translation.z);
        let depths = Depths::Counts { counts: &image.depth, unit_m: image.unit_m };
        let (scan, scanned) = maker.message(depths, out).map_err(|error| told(&error))?;
        let is_blind = self.blindness.is_blind(scanned.n_seen as f64 / scan.ranges_m.len() as f64);
        let valid = observation.valid && !is_blind && !is_stale;
        let (sensor, stamp, data) = (self.sensor, observation.stamp, Data::LaserScan(scan));
        out.push(Observation { sensor, stamp, base_from_sensor, valid, data });
        Ok(())
    }
}

fn limits(params: &DepthToScanParams, highest_m: f64, n_rows: usize) -> ScanLimits {
    ScanLimits {
        heights_m: [params.min_height_m, highest_m],
        ranges_m: [params.range_min_m, params.range_max_m],
        rows: params.rows.map(|rows| slice(rows as usize, params.row_center.map(|row| row as usize), n_rows)),
    }
}

/// `[center - rows / 2, center + rows / 2)`, as far as the picture has it; at least one row.
fn slice(rows: usize, center: Option<usize>, n_rows: usize) -> Range<usize> {
    let center = center.unwrap_or(n_rows / 2).min(n_rows.saturating_sub(1));
    let first = center.saturating_sub(rows / 2);
    first..(center + rows.div_ceil(2)).clamp(first + 1, n_rows.max(first + 1))
}

#[cfg(test)]
mod tests;
