//! The particle filter as a stage of the framework.

use super::params::RbpfSlamParams;
use super::saved;
use super::tracker::Tracker;
use nalgebra::Matrix3;
use rumbo_core::frames::{Point2, Pose2};
use rumbo_core::map::{Layer, Map};
use rumbo_core::messages::{Check, Estimate, MessageFault, ObservationKind, Prior, Seen, StampedPose};
use rumbo_core::registry::{Manifest, Plugin};
use rumbo_core::stages::{BuildContext, BuildError, Cx, Slam, SlamError};
use rumbo_core::time::Time;
use rumbo_core::trace::Drawing;
use rumbo_kit::streams::Streams;
use rumbo_kit::tile_map::GridExport;

/// See [`RbpfSlamParams`].
#[derive(Debug)]
pub struct RbpfSlam {
    tracker: Tracker,
    export: GridExport,
    written: Option<Time>,
}

/// Where a prior puts the robot.
fn beginning(prior: &Prior) -> Result<(Pose2, Matrix3<f64>), SlamError> {
    prior.check()?;
    match prior {
        Prior::Pose { map_from_base, covariance, .. } => {
            if let Some(negative) = covariance.diagonal().iter().find(|v| **v < 0.0) {
                let (message, field) = ("prior", "covariance diagonal");
                let (found, expected) = (negative.to_string(), "numbers of at least zero");
                return Err(MessageFault { message, field, found, expected }.into());
            }
            Ok((*map_from_base, *covariance))
        }
        // The map's frame is where the robot begins.
        _ => Ok((Pose2::identity(), Matrix3::zeros())),
    }
}

impl RbpfSlam {
    /// The best particle's map becomes the layer.
    fn write(&mut self, map: &mut Map) -> Result<(), SlamError> {
        let Some(best) = self.tracker.filter().best() else { return Ok(()) };
        let max_cells = self.tracker.settings().max_cells;
        let map_from_tiles = self.tracker.map_from_start();
        let written = self.export.write(&best.map, map_from_tiles, &mut map.grid, max_cells);
        written.map_err(|fault| SlamError::Other(fault.to_string()))?;
        map.touch();
        Ok(())
    }

    fn show(&self, cx: &Cx<'_>) {
        let (filter, counters) = (self.tracker.filter(), self.tracker.counters());
        cx.trace.count("particles that say something", filter.effective());
        for (name, value) in [
            ("updates", counters.updates),
            ("scans unmatched", counters.unmatched),
            ("scans degenerate", counters.degenerate),
            ("scans dropped", counters.scans_dropped),
            ("particles drawn anew", counters.resampled),
            ("updates without weight", counters.without_weight),
            ("loops closed by bending", counters.loops),
            ("odometry dropped", counters.odometry_dropped),
            ("imu dropped", counters.imu_dropped),
            ("odometry jumps", counters.odometry_jumps),
        ] {
            cx.trace.count(name, value as f64);
        }
        cx.trace.draw(|| {
            let map_from_start = self.tracker.map_from_start();
            let at = |pose: &Pose2| map_from_start * Point2::from(pose.translation.vector);
            let points = filter.particles().iter().map(|particle| at(&particle.map_from_base)).collect();
            Drawing::Points { name: "particles", points }
        });
    }
}

impl Slam for RbpfSlam {
    fn start(&mut self, prior: &Prior, map: &mut Map) -> Result<(), SlamError> {
        if let Prior::Saved(bytes) = prior {
            saved::restore(&mut self.tracker, bytes.as_slice())?;
        } else {
            let (map_from_base, covariance) = beginning(prior)?;
            self.tracker.start(&map_from_base, &covariance);
        }
        (self.export, self.written, map.grid) = (GridExport::default(), None, None);
        map.coarse_grids.clear();
        self.write(map)
    }

    fn update(&mut self, cx: &mut Cx<'_>, seen: Seen<'_>, map: &mut Map) -> Result<Estimate, SlamError> {
        if !self.tracker.is_started() {
            return Err(SlamError::Other("has not been started".into()));
        }
        let is_new = self.tracker.update(cx.now, seen);
        let period_s = self.tracker.settings().publish_period_s;
        if is_new && self.written.is_none_or(|last| (cx.now - last).as_secs() >= period_s) {
            self.written = Some(cx.now);
            self.write(map)?;
        }
        if cx.trace.is_counting() {
            self.show(cx);
        }
        let estimate = self.tracker.estimate(cx.now);
        estimate.check()?;
        Ok(estimate)
    }

    fn relocate(&mut self, prior: &Prior, _map: &mut Map) -> Result<(), SlamError> {
        match prior {
            Prior::Pose { .. } if self.tracker.is_started() => {
                let (map_from_base, covariance) = beginning(prior)?;
                self.tracker.relocate(&map_from_base, &covariance);
                Ok(())
            }
            Prior::Pose { .. } => Err(SlamError::Other("has not been started".into())),
            _ => Err(SlamError::Prior { prior: "no pose", needs: "a pose" }),
        }
    }

    fn trajectory(&self) -> Result<Vec<StampedPose>, SlamError> {
        Ok(self.tracker.trajectory())
    }

    fn save(&self) -> Result<Vec<u8>, SlamError> {
        if !self.tracker.is_started() {
            return Err(SlamError::Other("has not been started".into()));
        }
        Ok(saved::save(&self.tracker))
    }
}

impl Plugin<dyn Slam> for RbpfSlamParams {
    fn manifest(&self) -> Manifest {
        Manifest {
            gives_layers: vec![Layer::Grid],
            consumes: vec![vec![ObservationKind::LaserScan]],
            uses: vec![ObservationKind::Odometry, ObservationKind::Imu],
            ..Manifest::default()
        }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Slam>, BuildError> {
        let tracker = Tracker::new(self.settings()?, Streams::new(context.rng()));
        Ok(Box::new(RbpfSlam { tracker, export: GridExport::default(), written: None }))
    }
}

rumbo_core::register_slam!(
    RbpfSlamParams,
    "rbpf_slam",
    "a particle filter whose particles each have a map: many guesses of the robot's way, and the one that closes loops stays"
);
