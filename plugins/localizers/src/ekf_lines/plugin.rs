//! Localization with lines as a stage of the framework.

use super::params::EkfLinesParams;
use rumbo_core::map::{Layer, Map};
use rumbo_core::messages::{Estimate, ObservationKind, Prior, Seen};
use rumbo_core::registry::{Manifest, Plugin};
use rumbo_core::robot::DriveKind;
use rumbo_core::stages::{BuildContext, BuildError, Cx, LocalizeError, Localizer};
use rumbo_kit::line_filter::{Growth, LineTracker, TrackFault, WallMap};

/// See [`EkfLinesParams`].
#[derive(Debug)]
pub struct EkfLines {
    tracker: LineTracker,
}

/// The covariance of the state is one matrix: more walls than this do not fit into memory together with everything else.
const MOST_WALLS: usize = 2000;

/// The tracker's faults in the words of the stage.
fn localize_error(fault: TrackFault) -> LocalizeError {
    match fault {
        TrackFault::Prior { prior, needs } => LocalizeError::Prior { prior, needs },
        TrackFault::NotStarted => LocalizeError::NotStarted,
        TrackFault::Message(fault) => LocalizeError::Message(fault),
        other => LocalizeError::Other(other.to_string()),
    }
}

impl EkfLines {
    fn show(&self, cx: &Cx<'_>) {
        let Some(filter) = self.tracker.filter() else { return };
        let left_out = self.tracker.left_out();
        cx.trace.count("slipping wheels", left_out.slipping as f64);
        cx.trace.count("late readings dropped", left_out.late as f64);
        cx.trace.count("readings refused", left_out.refused as f64);
        let names = ["innovation of wheels", "innovation of steering", "innovation of lines"];
        for (consistency, name) in filter.consistency().iter().zip(names) {
            if let Some(band) = consistency.band() {
                cx.trace.count(name, band.mean);
            }
        }
    }
}

impl Localizer for EkfLines {
    fn start(&mut self, prior: &Prior, map: &Map) -> Result<(), LocalizeError> {
        let lines = map.lines.as_ref().ok_or(LocalizeError::MissingLayer { layer: Layer::Lines.name() })?;
        let walls = WallMap::new(&lines.lines);
        if walls.is_empty() {
            return Err(LocalizeError::Other("the map has no wall to find the robot by".to_owned()));
        }
        if walls.len() > MOST_WALLS {
            let found = walls.len();
            let message =
                format!("the map has {found} walls, expected at most {MOST_WALLS}; leave out short ones");
            return Err(LocalizeError::Other(message));
        }
        self.tracker.follow(prior, &walls).map_err(localize_error)
    }

    fn update(&mut self, cx: &mut Cx<'_>, seen: Seen<'_>, _map: &Map) -> Result<Estimate, LocalizeError> {
        let estimate = self.tracker.update(cx.now, seen);
        if cx.trace.is_counting() {
            self.show(cx);
        }
        estimate.map_err(localize_error)
    }
}

impl Plugin<dyn Localizer> for EkfLinesParams {
    fn manifest(&self) -> Manifest {
        Manifest {
            needs_layers: vec![Layer::Lines],
            consumes: vec![
                vec![ObservationKind::LaserScan],
                vec![ObservationKind::Odometry, ObservationKind::WheelSpeeds],
            ],
            drives: vec![DriveKind::Differential, DriveKind::Tricycle],
            needs_start_pose: true,
            ..Manifest::default()
        }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Localizer>, BuildError> {
        let settings = self.shared().tracker_settings(&context.robot, Growth::default());
        Ok(Box::new(EkfLines { tracker: LineTracker::new(settings) }))
    }
}

rumbo_core::register_localizer!(
    EkfLinesParams,
    "ekf_lines",
    "a Kalman filter that follows a robot along the walls of a line map, from a known start"
);
