//! Mapping with a graph of key frames as a stage of the framework.

use super::params::GraphSlamParams;
use super::saved;
use super::sheet::{Sheet, SheetSettings};
use super::tracker::{BLIND_AFTER_S, Fit, Tracker, TrackerSettings};
use crate::unseen::is_unsure;
use nalgebra::Matrix3;
use rumbo_core::frames::{Point2, Pose2, is_finite3};
use rumbo_core::map::{Layer, Map};
use rumbo_core::messages::{Check, Data, Estimate, ObservationKind, Prior, Seen, StampedPose, Status};
use rumbo_core::registry::{Manifest, Plugin};
use rumbo_core::stages::{BuildContext, BuildError, Cx, Slam, SlamError};
use rumbo_core::time::Time;
use rumbo_core::trace::Drawing;

/// See [`GraphSlamParams`].
#[derive(Debug)]
pub struct GraphSlam {
    settings: TrackerSettings,
    sheet_settings: SheetSettings,
    tracker: Tracker,
    sheet: Sheet,
    /// Where the odometer was when it was last said where the robot is.
    odom_at_start: Option<Pose2>,
    refused: u32,
}

impl GraphSlam {
    fn begin(&mut self, pose: Pose2, odom_from_base: Pose2, covariance: Matrix3<f64>, map: &mut Map) {
        self.tracker = Tracker::new(self.settings, pose);
        self.tracker.covariance = covariance;
        self.sheet = Sheet::new(self.sheet_settings);
        self.odom_at_start = Some(odom_from_base);
        map.grid = self.sheet.empty(&pose);
        map.coarse_grids.clear();
        map.touch();
    }

    fn take(&mut self, seen: Seen<'_>) {
        // Odometer and gyroscope first: a scan may have come before the reading after it.
        for observation in seen.iter().filter(|observation| observation.valid) {
            match &observation.data {
                Data::Odometry(odometry) if odometry.check().is_ok() => {
                    self.tracker.odometry.push(observation.stamp, odometry.odom_from_base);
                }
                Data::Imu(imu) if imu.check().is_ok() && is_finite3(&observation.base_from_sensor) => {
                    let rate_rad_s = crate::turning::yaw_rate_rad_s(imu, &observation.base_from_sensor);
                    self.tracker.gyro.take(observation.stamp, rate_rad_s);
                }
                Data::Odometry(_) | Data::Imu(_) => self.refused += 1,
                _ => {}
            }
        }
        for (observation, scan) in seen.laser_scans().filter(|(observation, _)| observation.valid) {
            if scan.check().is_err() || !is_finite3(&observation.base_from_sensor) {
                self.refused += 1;
                continue;
            }
            self.tracker.take(observation.stamp, scan, &observation.base_from_sensor);
        }
    }

    fn estimate(&self, now: Time) -> Estimate {
        let tracker = &self.tracker;
        let Some(before) = tracker.before else {
            let odom = self.odom_at_start.unwrap_or_else(Pose2::identity);
            let moved = match tracker.odometry.newest() {
                Some((_, newest)) => odom.inverse() * newest,
                None => Pose2::identity(),
            };
            let pose = tracker.first_pose * moved;
            let stamp = tracker.odometry.newest().map_or(now, |(stamp, _)| stamp);
            let mut estimate = Estimate::planar(stamp, pose, odom * moved, tracker.covariance);
            estimate.status = Status::Converging;
            return estimate;
        };
        let at_scan = tracker.map_from_base();
        let turned = {
            let turn = nalgebra::Rotation3::from_axis_angle(
                &nalgebra::Vector3::z_axis(),
                at_scan.rotation.angle() - tracker.frame_from_base.rotation.angle(),
            );
            turn.matrix() * tracker.covariance * turn.matrix().transpose()
        };
        let mut covariance = (turned + turned.transpose()) * 0.5 + Matrix3::identity() * 1e-8;
        let newest = tracker.odometry.newest().filter(|(stamp, _)| *stamp > before.reckoned.stamp);
        let (stamp, pose, odom_from_base) = match (before.reckoned.odom_from_base, newest) {
            (Some(then), Some((stamp, odom))) => (stamp, at_scan * (then.inverse() * odom), odom),
            (Some(then), None) => (before.reckoned.stamp, at_scan, then),
            // Without an odometer the frame that it would count in stays where the base is.
            (None, _) => (before.reckoned.stamp, at_scan, Pose2::identity()),
        };
        let is_blind = (stamp.max(now) - before.reckoned.stamp).as_secs() > BLIND_AFTER_S;
        if is_blind {
            let [way, turn] = tracker.predict(now).deviation.map(|deviation| deviation * deviation);
            covariance += Matrix3::from_diagonal(&[way, way, turn].into());
        }
        // Without an odometer the robot is still thought to be there, ever less surely.
        let stamp = if is_blind && newest.is_none() { now } else { stamp };
        let mut estimate = Estimate::planar(stamp, pose, odom_from_base, covariance);
        estimate.status = match tracker.fit {
            Fit::Placed if !tracker.is_adrift && !is_blind && !is_unsure(&covariance) => Status::Tracking,
            Fit::Placed => Status::Converging,
            Fit::Guessed => Status::Converging,
            Fit::Lost => Status::Lost,
        };
        estimate
    }

    fn show(&self, cx: &Cx<'_>) {
        let tracker = &self.tracker;
        let graph = &tracker.atlas.graph;
        for (name, value) in [
            ("key frames", graph.n_nodes()),
            ("ties", graph.constraints().len()),
            ("loops", tracker.n_loops),
            ("late scans dropped", tracker.left_out.late as usize),
            ("scans with too few points", tracker.left_out.too_few_points as usize),
            ("scans that fit nowhere", tracker.left_out.unplaced as usize),
            ("readings refused", self.refused as usize),
        ] {
            cx.trace.count(name, value as f64);
        }
        cx.trace.draw(|| {
            let points = graph.poses().iter().map(|pose| Point2::new(pose.x, pose.y)).collect();
            Drawing::Points { name: "key frames", points }
        });
    }
}

impl Slam for GraphSlam {
    fn start(&mut self, prior: &Prior, map: &mut Map) -> Result<(), SlamError> {
        prior.check()?;
        match prior {
            Prior::Pose { map_from_base, odom_from_base, covariance } => {
                self.begin(*map_from_base, *odom_from_base, *covariance, map);
            }
            Prior::Unknown => {
                self.begin(Pose2::identity(), Pose2::identity(), Matrix3::identity() * 1e-6, map);
            }
            Prior::Saved(bytes) => {
                let tracker = saved::read(bytes, self.settings).map_err(SlamError::Other)?;
                self.begin(Pose2::identity(), Pose2::identity(), Matrix3::identity() * 1e-6, map);
                self.tracker = tracker;
                map.grid = None;
                self.sheet.keep_up(&self.tracker.atlas, self.tracker.n_moves, &mut map.grid);
                map.touch();
            }
        }
        Ok(())
    }

    fn update(&mut self, cx: &mut Cx<'_>, seen: Seen<'_>, map: &mut Map) -> Result<Estimate, SlamError> {
        self.take(seen);
        if self.sheet.keep_up(&self.tracker.atlas, self.tracker.n_moves, &mut map.grid) {
            map.touch();
        }
        if cx.trace.is_counting() {
            self.show(cx);
        }
        Ok(self.estimate(cx.now))
    }

    fn relocate(&mut self, prior: &Prior, _map: &mut Map) -> Result<(), SlamError> {
        prior.check()?;
        match prior {
            Prior::Pose { map_from_base, covariance, .. } => {
                self.tracker.carry_to(map_from_base, covariance);
                Ok(())
            }
            Prior::Unknown => {
                self.tracker.lose();
                Ok(())
            }
            Prior::Saved(_) => Err(SlamError::Prior { prior: "a saved state", needs: "a pose or none" }),
        }
    }

    fn trajectory(&self) -> Result<Vec<StampedPose>, SlamError> {
        Ok(self.tracker.trajectory())
    }

    fn keep_no_trajectory(&mut self) {
        self.settings.keeps_tracks = false;
        self.tracker.settings.keeps_tracks = false;
    }

    fn save_map(&self, map: &mut Map) -> Result<(), SlamError> {
        let atlas = self.tracker.settled();
        if !atlas.frames.is_empty() {
            map.grid = None;
            Sheet::new(self.sheet_settings).keep_up(atlas, 0, &mut map.grid);
            map.touch();
        }
        Ok(())
    }

    fn save(&self) -> Result<Vec<u8>, SlamError> {
        Ok(saved::write(&self.tracker))
    }
}

impl Plugin<dyn Slam> for GraphSlamParams {
    fn manifest(&self) -> Manifest {
        Manifest {
            gives_layers: vec![Layer::Grid],
            consumes: vec![vec![ObservationKind::LaserScan]],
            uses: vec![ObservationKind::Odometry, ObservationKind::Imu],
            ..Manifest::default()
        }
    }

    fn build(&self, _context: &BuildContext) -> Result<Box<dyn Slam>, BuildError> {
        let settings = self.tracker();
        let Some(sheet_settings) = self.sheet() else {
            return Err(BuildError::at("update_factor_free", "makes no evidence"));
        };
        Ok(Box::new(GraphSlam {
            settings,
            sheet_settings,
            tracker: Tracker::new(settings, Pose2::identity()),
            sheet: Sheet::new(sheet_settings),
            odom_at_start: None,
            refused: 0,
        }))
    }
}

rumbo_core::register_slam!(
    GraphSlamParams,
    "graph_slam",
    "key frames in a pose graph: scans registered on each other, loops closed, the map drawn from where all agree best"
);
