//! Measurement models: how well a scan fits a place on the map. An open family by typetag.

mod beam;
mod field;

pub use beam::BeamModel;
pub use field::FieldModel;

use super::beams::ScanBeams;
use rumbo_kit::GridSize;
use rumbo_kit::grid_poses::GridPoses;
use std::fmt::Debug;

/// How probable readings are.
#[typetag::serde(tag = "model")]
pub trait MeasurementModel: Debug + Send + Sync {
    /// Prepares for a map.
    fn on_map(&self, obstacles: &Obstacles<'_>) -> Box<dyn ScanLikelihood>;
    /// What is wrong with the parameters: key and message.
    fn faults(&self) -> Vec<(&'static str, String)>;
    /// A copy.
    fn boxed_clone(&self) -> Box<dyn MeasurementModel>;
}

impl Clone for Box<dyn MeasurementModel> {
    fn clone(&self) -> Self {
        self.boxed_clone()
    }
}

/// What scans can hit.
#[derive(Debug, Clone, Copy)]
pub struct Obstacles<'a> {
    /// Size of the map.
    pub size: GridSize,
    /// Edge of a cell, meters.
    pub resolution_m: f64,
    /// One byte a cell, nonzero where occupied.
    pub occupied: &'a [u8],
}

/// A measurement model on one map. Poses are in the grid's own frame and in cells.
pub trait ScanLikelihood: Send {
    /// Adds, for each pose of the base, the sum of ln p over the beams that say something. Returns how many do.
    fn add_ln(&mut self, beams: &ScanBeams, poses: &GridPoses, ln_p: &mut [f64]) -> usize;

    /// The slow twin for one pose (x and y in cells, heading in radians): the formula in double precision.
    fn exact_ln(&self, beams: &ScanBeams, pose: [f64; 3]) -> f64;

    /// How many beams the map explains from this pose, and how many say something.
    fn explained(&self, beams: &ScanBeams, pose: [f64; 3]) -> [usize; 2];
}

/// Keys whose value is not a finite number above zero.
fn not_positive(values: &[(&'static str, f64)]) -> Vec<(&'static str, String)> {
    let bad = values.iter().filter(|(_, value)| !(value.is_finite() && *value > 0.0));
    bad.map(|(key, value)| (*key, format!("is {value}, expected a finite number above 0"))).collect()
}

/// Keys whose value is not a share.
fn no_share(values: &[(&'static str, f64)]) -> Vec<(&'static str, String)> {
    let bad = values.iter().filter(|(_, value)| !(0.0..=1.0).contains(value));
    bad.map(|(key, value)| (*key, format!("is {value}, expected a share from 0 to 1"))).collect()
}
