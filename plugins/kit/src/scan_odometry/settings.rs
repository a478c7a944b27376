//! What can be set.

use super::degeneracy::DegeneracyRule;

/// Which line stands for the surface at a point of the key scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LineKind {
    /// The line through the point and its nearer neighbor by bearing: as published.
    Neighbor,
    /// The line that fits all neighbors within reach.
    #[default]
    Fitted,
}

/// All that can be set.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScanOdometrySettings {
    /// A scan becomes the key scan once the robot moved this far from the last one, meters.
    pub key_distance_m: f64,
    /// Or turned so far, radians.
    pub key_angle_rad: f64,
    /// Or fewer of its points than this share are matched.
    pub key_overlap: f64,
    /// Farthest match in the first steps, meters.
    pub max_match_m: f64,
    /// Farthest match in the last steps, meters.
    pub least_match_m: f64,
    /// Neighbors farther apart than this are not one surface, meters.
    pub max_line_gap_m: f64,
    /// Which line stands for the surface.
    pub lines: LineKind,
    /// Neighbors up to this distance on each side belong to a fitted line, meters.
    pub line_reach_m: f64,
    /// Noise of a range: no fitted line is surer of its direction than this allows, meters.
    pub range_noise_m: f64,
    /// Residuals beyond this count less (Huber), meters.
    pub huber_m: f64,
    /// Share of the worst residuals that is left out.
    pub trim: f64,
    /// Most steps.
    pub max_iterations: usize,
    /// Steps below this have arrived, meters and radians.
    pub converged: f64,
    /// Fewer matched points than this say nothing.
    pub min_points: usize,
    /// Less than this share of points matched is no match.
    pub min_overlap: f64,
    /// A larger root mean square of residuals is no match, meters.
    pub max_rms_m: f64,
    /// A match farther than this from the prior is none, meters.
    pub max_correction_m: f64,
    /// Nor is one that is turned by more, radians.
    pub max_correction_rad: f64,
    /// What counts as unobserved.
    pub degeneracy: DegeneracyRule,
    /// No match is surer than this of its place, meters.
    pub min_std_m: f64,
    /// No match is surer than this of its direction, radians.
    pub min_std_rad: f64,
    /// Where a smaller share of the points than this is matched at the smallest distance, other directions are tried, too.
    pub retry_support: f64,
    /// Other directions to begin from where a match fails: this far apart, radians.
    pub retry_step_rad: f64,
    /// So many of them to each side; none tries once.
    pub n_retries: usize,
    /// Where nothing is found near the prior, so many times as many are tried from where the base was; none does not look there.
    pub far_retries: usize,
    /// What is found there must see all directions: the prediction, which was wrong, would have to stand for the others.
    pub far_sees_all: bool,
    /// While matches may still be far, residuals count fully up to this share of that distance, and none is left out; zero
    /// treats them as at the end, as published.
    pub kernel_share: f64,
}

impl Default for ScanOdometrySettings {
    fn default() -> Self {
        ScanOdometrySettings {
            key_distance_m: 0.15,
            key_angle_rad: 0.1,
            key_overlap: 0.6,
            max_match_m: 0.3,
            least_match_m: 0.05,
            max_line_gap_m: 0.3,
            lines: LineKind::Fitted,
            line_reach_m: 0.2,
            range_noise_m: 0.01,
            huber_m: 0.02,
            trim: 0.1,
            max_iterations: 20,
            converged: 1e-5,
            min_points: 30,
            min_overlap: 0.3,
            max_rms_m: 0.05,
            max_correction_m: 0.5,
            max_correction_rad: 0.6,
            degeneracy: DegeneracyRule::default(),
            min_std_m: 0.005,
            min_std_rad: 0.002,
            retry_support: 0.6,
            retry_step_rad: 0.1,
            n_retries: 4,
            far_retries: 0,
            far_sees_all: false,
            kernel_share: 0.0,
        }
    }
}
