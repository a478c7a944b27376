//! Scan by scan: where is the robot, as seen from the newest key frame?

use super::atlas::Atlas;
use super::loops::{RESOLUTION_M, points_of, table_of, thinned};
use super::nearest::NearestTable;
use super::registration::{Expected, Registered, register};
use super::surface::SurfacePoint;
use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::Pose2;
use rumbo_kit::correlative::{CorrelativeSearch, FitTable, SearchWindow, turn_step_rad};

/// The surfaces around the robot, seen from its key frame.
#[derive(Debug, Clone, Default)]
pub(super) struct FrontEnd {
    table: NearestTable,
    frames: Vec<usize>,
    /// For scans that are far from where they were expected; made when the first of them comes.
    wide: Option<(FitTable, Pose2)>,
    search: CorrelativeSearch,
    /// The key frame.
    pub frame: usize,
}

/// A registration with this product of overlap and agreement needs no second look.
const GOOD: f64 = 0.45;
/// Nor is it believed without one when it is this far from where it was expected, meters and radians.
const SURPRISE: [f64; 2] = [0.35, 0.15];
/// How far around the expected place a scan is looked for then, meters and radians.
const WIDE: [f64; 2] = [1.0, 0.7];
const LEAST_SCORE: f64 = 0.5;
const MOST_NODES: usize = 50_000;

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
        self.wide = None;
    }

    /// The frames whose surfaces it has.
    pub fn frames(&self) -> &[usize] {
        &self.frames
    }

    /// Registers a scan; nothing where it cannot be believed.
    pub fn place(
        &mut self,
        atlas: &Atlas,
        scan: &[SurfacePoint],
        prediction: &Prediction,
    ) -> Option<Registered> {
        let settings = &atlas.settings;
        let [off_m, off_rad] = prediction.deviation;
        let diagonal =
            Vector3::new(off_m.powi(-2), off_m.powi(-2), off_rad.powi(-2)) / settings.believed_share;
        let expected = Expected {
            reference_from_scan: prediction.frame_from_base,
            information: Matrix3::from_diagonal(&diagonal),
            first_gate_m: prediction.first_gate_m,
        };
        let found = register(&self.table, scan, &expected, &settings.registration);
        let quality = |found: &Registered| found.overlap * found.agreement;
        let is_surprise = |found: &Registered| {
            let off = prediction.frame_from_base.inverse() * found.reference_from_scan;
            off.translation.vector.norm() > SURPRISE[0] || off.rotation.angle().abs() > SURPRISE[1]
        };
        let best = match found {
            Some(found) if quality(&found) >= GOOD && !is_surprise(&found) => Some(found),
            // The odometer may have slipped: elsewhere it may fit better.
            _ => self
                .place_widely(atlas, scan, prediction)
                .into_iter()
                .chain(found)
                .max_by(|a, b| quality(a).total_cmp(&quality(b))),
        };
        best.filter(|found| {
            found.overlap >= settings.least_overlap && found.agreement >= settings.least_agreement
        })
    }

    /// Looks for a scan around the place where it was expected.
    fn place_widely(
        &mut self,
        atlas: &Atlas,
        scan: &[SurfacePoint],
        prediction: &Prediction,
    ) -> Option<Registered> {
        if self.wide.is_none() {
            self.wide = table_of(self.table.points());
        }
        let (table, grid_from_frame) = self.wide.as_ref()?;
        let points = points_of(&thinned(scan.iter().copied()));
        let window = SearchWindow {
            grid_from_base: grid_from_frame * prediction.frame_from_base,
            reach_m: WIDE[0],
            reach_rad: WIDE[1],
            step_rad: turn_step_rad(&points, RESOLUTION_M).max(0.008),
            least_score: LEAST_SCORE,
            most_nodes: MOST_NODES,
        };
        // A search that gives up has seen many places that fit alike: then the odometer knows best.
        let best = self.search.best(table, &points, &window, None).ok()??;
        let expected = Expected {
            reference_from_scan: grid_from_frame.inverse() * best.grid_from_base,
            information: Matrix3::zeros(),
            first_gate_m: 0.3,
        };
        register(&self.table, scan, &expected, &atlas.settings.registration)
    }
}
