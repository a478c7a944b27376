//! Scan by scan: where is the robot, as seen from the newest key frame?

use super::atlas::Atlas;
use super::nearest::NearestTable;
use super::registration::{Expected, Registered, register};
use super::surface::Surface;
use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::{Pose2, pose2};

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
    /// Where it would be if it had stayed, or moved as before, should the odometer be wrong; nobody knows after a gap.
    pub without_odometer: Option<[Pose2; 2]>,
    /// Standard deviations of place and turn since the scan before, meters and radians.
    pub deviation: [f64; 2],
    /// Since the scan before.
    pub seconds: f64,
    /// Pairs may be so far apart at the beginning, meters.
    pub first_gate_m: f64,
    /// It has come so far by the odometer alone that what was seen before is no help.
    pub is_far: bool,
    /// Nobody knows how it came here: for some time there was neither a scan nor an odometer.
    pub is_blind: bool,
}

impl Prediction {
    /// Near here, as a search has found.
    pub fn around(frame_from_base: Pose2) -> Prediction {
        Prediction {
            frame_from_base,
            without_odometer: None,
            deviation: [0.1, 0.05],
            seconds: 0.0,
            first_gate_m: 0.3,
            is_far: false,
            is_blind: false,
        }
    }
}

/// Deviations at which the odometer pulls with half its weight.
const HALF_AT: f64 = 1.0;
/// Scans that fit as well as this are where they were expected, whatever else they may fit.
pub(super) const SURE_FIT: f64 = 0.8;
/// Another heading must fit better by this.
const CLEARLY_BETTER: f64 = 0.1;
/// Headings that are tried, radians: neighbors run into the same minimum.
const HEADING_STEP_RAD: f64 = 6.0 * std::f64::consts::PI / 180.0;
const HEADINGS_EACH_SIDE: i32 = 4;
/// Pairs may be so far apart at the beginning, meters: what the table of nearest points knows.
const FAR_GATE_M: f64 = 0.5;

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
    pub fn place(&self, atlas: &Atlas, scan: &Surface, prediction: &Prediction) -> Option<Registered> {
        let settings = &atlas.settings;
        let found =
            self.turned_more(atlas, scan, prediction, self.turned_as_predicted(atlas, scan, prediction))?;
        let is_believed =
            found.overlap >= settings.least_overlap && found.agreement >= settings.least_agreement;
        is_believed.then_some(found)
    }

    fn turned_as_predicted(
        &self,
        atlas: &Atlas,
        scan: &Surface,
        prediction: &Prediction,
    ) -> Option<Registered> {
        let [off_m, off_rad] = prediction.deviation;
        let expected = Expected {
            reference_from_scan: prediction.frame_from_base,
            information: known(atlas, off_m, off_rad),
            half_at: HALF_AT.powi(2) / atlas.settings.believed_share,
            first_gate_m: prediction.first_gate_m,
            shape: scan.shape.as_ref(),
            least_pairs: 0.0,
        };
        register(&self.table, scan, &expected, &atlas.settings.registration)
    }

    /// The robot may have turned by more than its odometer says: a castor that swings around, a push. Where a scan fits
    /// badly, it is also tried from other headings; one of them is taken where it fits clearly better.
    fn turned_more(
        &self,
        atlas: &Atlas,
        scan: &Surface,
        prediction: &Prediction,
        predicted: Option<Registered>,
    ) -> Option<Registered> {
        let fit = |found: &Option<Registered>| found.as_ref().map_or(0.0, Registered::fit);
        if fit(&predicted) >= SURE_FIT {
            return predicted;
        }
        let off_m = prediction.deviation[0];
        let turned = (1..=HEADINGS_EACH_SIDE)
            .flat_map(|k| [k, -k])
            .map(|k| prediction.frame_from_base * pose2(0.0, 0.0, f64::from(k) * HEADING_STEP_RAD));
        let others =
            turned.chain(prediction.without_odometer.into_iter().flatten()).filter_map(|frame_from_base| {
                let expected = Expected {
                    reference_from_scan: scan.start(&prediction.frame_from_base, &frame_from_base),
                    information: known(atlas, off_m, HEADING_STEP_RAD),
                    half_at: HALF_AT.powi(2) / atlas.settings.believed_share,
                    first_gate_m: FAR_GATE_M,
                    shape: scan.shape.as_ref(),
                    least_pairs: 0.0,
                };
                register(&self.table, scan, &expected, &atlas.settings.registration)
            });
        let best = others.max_by(|a, b| a.fit().total_cmp(&b.fit()));
        if fit(&best) > fit(&predicted) + CLEARLY_BETTER { best } else { predicted }
    }
}

/// Information of what is known before looking, on the scale of that of all pairs.
fn known(atlas: &Atlas, off_m: f64, off_rad: f64) -> Matrix3<f64> {
    let diagonal = Vector3::new(off_m.powi(-2), off_m.powi(-2), off_rad.powi(-2));
    Matrix3::from_diagonal(&(diagonal / atlas.settings.believed_share))
}
