//! Mapping with lines as a stage of the framework.

use super::params::EkfLineSlamParams;
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::Point2;
use rumbo_core::map::{Layer, Lines, Map};
use rumbo_core::messages::{Estimate, ObservationKind, Prior, Seen};
use rumbo_core::registry::{Manifest, Plugin};
use rumbo_core::robot::DriveKind;
use rumbo_core::stages::{BuildContext, BuildError, Cx, Slam, SlamError};
use rumbo_core::trace::Drawing;
use rumbo_kit::line_filter::{LineTracker, OdometerError, TrackFault};

/// See [`EkfLineSlamParams`].
#[derive(Debug)]
pub struct EkfLineSlam {
    tracker: LineTracker,
}

/// The tracker's faults in the words of the stage.
fn slam_error(fault: TrackFault) -> SlamError {
    match fault {
        TrackFault::Prior { prior, needs } => SlamError::Prior { prior, needs },
        TrackFault::Message(fault) => SlamError::Message(fault),
        other => SlamError::Other(other.to_string()),
    }
}

impl EkfLineSlam {
    fn write(&self, map: &mut Map) {
        let lines = self.tracker.filter().map(|filter| filter.layer()).unwrap_or_default();
        map.lines = Some(Lines { lines: Buffer::from(lines) });
        map.touch();
    }

    fn show(&self, cx: &Cx<'_>) {
        let Some(filter) = self.tracker.filter() else { return };
        let left_out = self.tracker.left_out();
        cx.trace.count("walls", filter.walls().len() as f64);
        let odometer = &filter.settings().odometer;
        let errors = OdometerError::ALL.iter().zip(odometer.errors(filter.state()));
        for (error, value) in errors.filter(|(error, _)| odometer.estimated().any(|other| other == **error)) {
            cx.trace.count(error.name(), value);
        }
        cx.trace.count("slipping wheels", left_out.slipping as f64);
        cx.trace.count("late readings dropped", left_out.late as f64);
        cx.trace.count("readings refused", left_out.refused as f64);
        let names = ["innovation of wheels", "innovation of steering", "innovation of lines"];
        let alarms = ["wheels overconfident", "steering overconfident", "lines overconfident"];
        for ((consistency, name), alarm) in filter.consistency().iter().zip(names).zip(alarms) {
            if let Some(band) = consistency.band() {
                cx.trace.count(name, band.mean);
                cx.trace.count(alarm, f64::from(u8::from(band.is_overconfident())));
            }
        }
        cx.trace.draw(|| {
            let ends = filter.walls().iter().flat_map(|wall| wall.ends_m);
            let points = ends.map(|[x, y]| Point2::new(x, y)).collect();
            Drawing::Points { name: "ends of walls", points }
        });
    }
}

impl Slam for EkfLineSlam {
    fn start(&mut self, prior: &Prior, map: &mut Map) -> Result<(), SlamError> {
        self.tracker.build_map(prior).map_err(slam_error)?;
        self.write(map);
        Ok(())
    }

    fn update(&mut self, cx: &mut Cx<'_>, seen: Seen<'_>, map: &mut Map) -> Result<Estimate, SlamError> {
        let before = self.tracker.n_scans();
        let estimate = self.tracker.update(cx.now, seen);
        // Also after a fault: other readings of the same update may have changed the walls.
        if self.tracker.n_scans() != before {
            self.write(map);
        }
        if cx.trace.is_counting() {
            self.show(cx);
        }
        estimate.map_err(slam_error)
    }

    fn relocate(&mut self, prior: &Prior, _: &mut Map) -> Result<(), SlamError> {
        self.tracker.relocate(prior).map_err(slam_error)
    }

    fn save(&self) -> Result<Vec<u8>, SlamError> {
        self.tracker.save().ok_or_else(|| slam_error(TrackFault::NotStarted))
    }
}

impl Plugin<dyn Slam> for EkfLineSlamParams {
    fn manifest(&self) -> Manifest {
        Manifest {
            gives_layers: vec![Layer::Lines],
            consumes: vec![
                vec![ObservationKind::LaserScan],
                vec![ObservationKind::Odometry, ObservationKind::WheelSpeeds],
            ],
            drives: vec![DriveKind::Differential, DriveKind::Tricycle],
            needs_start_pose: true,
            ..Manifest::default()
        }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Slam>, BuildError> {
        let settings = self.shared().tracker_settings(&context.robot, self.growth());
        Ok(Box::new(EkfLineSlam { tracker: LineTracker::new(settings) }))
    }
}

rumbo_core::register_slam!(
    EkfLineSlamParams,
    "ekf_line_slam",
    "a Kalman filter for the robot and the walls around it: wheels, steering and lines of scans at their own rates"
);
