//! Scan by scan: where is the robot, as seen from the newest key frame?

use super::atlas::Atlas;
use super::nearest::NearestTable;
use super::registration::{Expected, Registered, register};
use super::surface::SurfacePoint;
use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::Pose2;

/// The surfaces around the robot, seen from its key frame.
#[derive(Debug, Clone, Default)]
pub(super) struct FrontEnd {
    table: NearestTable,
    frames: Vec<usize>,
    /// The key frame.
    pub frame: usize,
}

/// Where the odometer says the robot is, and how surely.
#[derive(Debug, Clone, Copy)]
pub(super) struct Prediction {
    /// As seen from the key frame.
    pub frame_from_base: Pose2,
    /// Standard deviations of place and turn since the scan before, meters and radians.
    pub deviation: [f64; 2],
    /// Pairs may be so far apart at the beginning, meters.
    pub first_gate_m: f64,
}

impl FrontEnd {
    /// Takes the surfaces of these frames.
    pub fn look_from(&mut self, atlas: &Atlas, frame: usize, frames: &[usize]) {
        self.frame = frame;
        self.frames = frames.to_vec();
        self.table.fill(atlas.surfaces(frames.iter().copied(), frame));
    }

    /// The frames whose surfaces it has.
    pub fn frames(&self) -> &[usize] {
        &self.frames
    }

    /// Registers a scan; nothing where it cannot be believed.
    pub fn place(&self, atlas: &Atlas, scan: &[SurfacePoint], prediction: &Prediction) -> Option<Registered> {
        let settings = &atlas.settings;
        let [off_m, off_rad] = prediction.deviation;
        let diagonal =
            Vector3::new(off_m.powi(-2), off_m.powi(-2), off_rad.powi(-2)) / settings.believed_share;
        let expected = Expected {
            reference_from_scan: prediction.frame_from_base,
            information: Matrix3::from_diagonal(&diagonal),
            first_gate_m: prediction.first_gate_m,
        };
        let found = register(&self.table, scan, &expected, &settings.registration)?;
        let is_believed =
            found.overlap >= settings.least_overlap && found.agreement >= settings.least_agreement;
        is_believed.then_some(found)
    }
}
