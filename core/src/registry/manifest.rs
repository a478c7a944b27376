//! What a plugin declares, so that a pipeline can be proved to fit together before it runs.

use crate::map::Layer;
use crate::messages::ObservationKind;
use crate::robot::DriveKind;
use serde::Serialize;

/// Needs and gifts of a configured plugin.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Manifest {
    /// Map layers that it reads.
    pub needs_layers: Vec<Layer>,
    /// Map layers that it writes.
    pub gives_layers: Vec<Layer>,
    /// It writes on top of layers that another builder gives.
    pub overlays: bool,
    /// Observations that it cannot do without: of each group, at least one kind.
    pub consumes: Vec<Vec<ObservationKind>>,
    /// Observations that it takes where some sensor makes them, and does without where none does.
    pub uses: Vec<ObservationKind>,
    /// Observations that it makes.
    pub produces: Vec<ObservationKind>,
    /// It derives its observations from other sensors' (`inputs` is required).
    pub is_virtual: bool,
    /// Drives that it can steer or plan for.
    pub drives: Vec<DriveKind>,
    /// How often it runs when the pipeline does not say, times a second.
    pub default_rate_hz: Option<f64>,
    /// The fastest that the device can do, times a second.
    pub max_rate_hz: Option<f64>,
    /// How wide a range sensor sees to its sides, radians in all; none of what has no such view, or does not say.
    pub field_of_view_rad: Option<f64>,
    /// It follows a robot from a pose that somebody must name: it cannot find one.
    pub needs_start_pose: bool,
    /// It asks for motion while it looks for the robot.
    pub wishes_motion: bool,
}

impl Default for Manifest {
    /// Needs nothing, gives nothing, steers every drive.
    fn default() -> Self {
        Manifest {
            needs_layers: Vec::new(),
            gives_layers: Vec::new(),
            overlays: false,
            consumes: Vec::new(),
            uses: Vec::new(),
            produces: Vec::new(),
            is_virtual: false,
            drives: DriveKind::ALL.to_vec(),
            default_rate_hz: None,
            max_rate_hz: None,
            field_of_view_rad: None,
            needs_start_pose: false,
            wishes_motion: false,
        }
    }
}

impl Manifest {
    /// The guard stops the robot when this source grows old: it sees obstacles, or says how the robot moves.
    pub fn is_watched(&self, has_odometer: bool) -> bool {
        self.produces.iter().any(|kind| match kind {
            ObservationKind::LaserScan | ObservationKind::RangeRing | ObservationKind::PointCloud => true,
            ObservationKind::Odometry => !has_odometer,
            _ => false,
        })
    }
}

/// What a plugin can know of the rest of its pipeline before anything is built.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Surroundings {
    /// View of the range sensor that sees least far to its sides, radians in all; none where no sensor tells its view.
    pub narrowest_view_rad: Option<f64>,
}
