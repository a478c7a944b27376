//! Tracking by natural landmarks as a localizer.

use super::params::TriangulationParams;
use super::scan::SeenScan;
use super::tracker::{Anchor, Tracker};
use crate::particle_filter::scan_queue::{PendingScan, ScanQueue};
use nalgebra::Vector3;
use rumbo_core::frames::{Pose2, flatten};
use rumbo_core::map::{Layer, Map};
use rumbo_core::messages::{Check, Estimate, ObservationKind, Prior, Seen, SensorId};
use rumbo_core::registry::{Manifest, Plugin};
use rumbo_core::rng::Rng;
use rumbo_core::stages::{BuildContext, BuildError, Cx, LocalizeError, Localizer};
use rumbo_core::time::{Span, Time};
use rumbo_kit::landmarks::BeamFan;
use rumbo_kit::odometry_history::{OdometryHistory, Reading};

/// See [`TriangulationParams`].
struct Triangulation {
    params: TriangulationParams,
    max_speed_m_s: f64,
    max_turn_rad_s: f64,
    odometry: OdometryHistory,
    noise: [f64; 3],
    queue: ScanQueue,
    /// What the odometer said at the start, until it says something.
    start_odometry: Pose2,
    /// Whose scans are related to each other: the first scanner's.
    scanner: Option<SensorId>,
    state: State,
    /// As it was built: each start begins its stream anew.
    rng: Rng,
}

/// What it knows of the robot.
enum State {
    /// It was not started.
    Idle,
    /// Nobody said where the robot is, and it cannot search.
    Lost,
    /// It was told.
    Following(Box<Tracker>),
}

/// A scanner that leans more than this does not see walls where the map has them: cosine of 14 degrees.
const LEAST_UPRIGHT: f64 = 0.97;
/// Before the first reading the odometer may have moved unseen for this long, seconds.
const BEFORE_FIRST_S: f64 = 1.0;

impl Triangulation {
    fn take_odometry(&mut self, stamp: Time, odom_from_base: Pose2, noise: [f64; 3]) {
        let last = self.odometry.newest();
        if last.is_none_or(|(last, _)| stamp > last) {
            let elapsed_s = last.map_or(BEFORE_FIRST_S, |(last, _)| (stamp - last).as_secs());
            let old = last.map_or(self.start_odometry, |(_, pose)| pose);
            let way_m = (old.translation.vector - odom_from_base.translation.vector).norm();
            let reach = [self.max_speed_m_s * elapsed_s, self.max_turn_rad_s * elapsed_s];
            if way_m > self.params.jump_m + 2.0 * reach[0] {
                if let State::Following(tracker) = &mut self.state {
                    tracker.rebase(&old, &odom_from_base, self.noise, reach);
                }
                self.odometry.clear();
            }
        }
        if self.odometry.push(stamp, odom_from_base) == Reading::Newest {
            self.noise = noise;
        }
    }

    fn take_scan(&mut self, pending: &PendingScan, map: &Map) {
        let State::Following(tracker) = &mut self.state else { return };
        let scan = &pending.scan;
        // Half of the beams are older and half are newer than the middle one.
        let middle = pending.stamp + Span::from_secs(scan.sweep_s / 2.0);
        let odom_from_base = self.odometry.at(middle).or_else(|| self.odometry.at(pending.stamp));
        let up = (pending.base_from_sensor.rotation * Vector3::z()).z;
        let Some(odom_from_base) = odom_from_base.filter(|_| up.abs() >= LEAST_UPRIGHT) else { return };
        if !tracker.is_due(pending.stamp, &odom_from_base)
            || *self.scanner.get_or_insert(pending.sensor) != pending.sensor
        {
            return;
        }
        // Upside down it sweeps the other way.
        let side = up.signum();
        let fan = BeamFan {
            first_bearing_rad: side * scan.first_bearing_rad,
            bearing_step_rad: side * scan.bearing_step_rad,
            min_range_m: scan.min_range_m.into(),
            max_range_m: scan.max_range_m.into(),
        };
        let base_from_sensor = flatten(&pending.base_from_sensor);
        let seen = SeenScan { stamp: pending.stamp, fan, ranges_m: &scan.ranges_m, base_from_sensor };
        let grid = map.grid.as_ref().map(|grid| (map.version, grid));
        tracker.look(&seen, &odom_from_base, self.noise, grid);
    }

    fn check_map(&self, map: &Map) -> Result<(), LocalizeError> {
        let is_missing = !self.params.thesis_mode && map.grid.is_none();
        if is_missing { Err(LocalizeError::MissingLayer { layer: "grid" }) } else { Ok(()) }
    }
}

impl Localizer for Triangulation {
    fn start(&mut self, prior: &Prior, map: &Map) -> Result<(), LocalizeError> {
        prior.check()?;
        self.check_map(map)?;
        let (state, odom_from_base) = match prior {
            Prior::Saved(_) => {
                return Err(LocalizeError::Prior { prior: "a saved state", needs: "a pose" });
            }
            Prior::Unknown => (State::Lost, Pose2::identity()),
            Prior::Pose { map_from_base, odom_from_base, covariance } => {
                let (map_from_base, odom_from_base) = (*map_from_base, *odom_from_base);
                let anchor = Anchor { map_from_base, covariance: *covariance, odom_from_base };
                let tracker = Tracker::new(self.params.settings(), anchor, self.rng.clone());
                (State::Following(Box::new(tracker)), odom_from_base)
            }
        };
        self.state = state;
        self.odometry.clear();
        self.queue.clear();
        (self.start_odometry, self.scanner, self.noise) = (odom_from_base, None, [0.0; 3]);
        Ok(())
    }

    fn update(&mut self, cx: &mut Cx<'_>, seen: Seen<'_>, map: &Map) -> Result<Estimate, LocalizeError> {
        self.check_map(map)?;
        match self.state {
            State::Idle => return Err(LocalizeError::NotStarted),
            State::Lost => return Ok(Estimate::lost(cx.now)),
            State::Following(_) => {}
        }
        for (observation, odometry) in seen.odometry().filter(|(observation, _)| observation.valid) {
            odometry.check()?;
            self.take_odometry(observation.stamp, odometry.odom_from_base, odometry.noise);
        }
        for (observation, scan) in seen.laser_scans().filter(|(observation, _)| observation.valid) {
            self.queue.push(observation, scan);
        }
        while let Some(pending) = self.queue.pop_ready(cx.now, &self.odometry) {
            self.take_scan(&pending, map);
        }
        let State::Following(tracker) = &self.state else { return Err(LocalizeError::NotStarted) };
        let report = tracker.report();
        cx.trace.count("landmarks", report.n_seen as f64);
        cx.trace.count("relations", report.n_related as f64);
        cx.trace.count("estimates", report.n_estimates as f64);
        cx.trace.count("starved", report.n_starved as f64);
        let (stamp, odom_from_base) = self.odometry.newest().unwrap_or((cx.now, self.start_odometry));
        let (map_from_base, covariance) = tracker.carried_to(&odom_from_base, self.noise);
        let covariance = (covariance + covariance.transpose()) / 2.0;
        let mut estimate = Estimate::planar(stamp, map_from_base, odom_from_base, covariance);
        estimate.status = tracker.status();
        Ok(estimate)
    }
}

impl Plugin<dyn Localizer> for TriangulationParams {
    fn manifest(&self) -> Manifest {
        Manifest {
            needs_layers: if self.thesis_mode { Vec::new() } else { vec![Layer::Grid] },
            consumes: vec![vec![ObservationKind::LaserScan], vec![ObservationKind::Odometry]],
            needs_start_pose: true,
            ..Manifest::default()
        }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Localizer>, BuildError> {
        Ok(Box::new(Triangulation {
            params: self.clone(),
            max_speed_m_s: context.robot.max_speed_m_s,
            max_turn_rad_s: context.robot.max_turn_rad_s(),
            odometry: OdometryHistory::default(),
            noise: [0.0; 3],
            queue: ScanQueue::default(),
            start_odometry: Pose2::identity(),
            scanner: None,
            state: State::Idle,
            rng: context.rng(),
        }))
    }
}

rumbo_core::register_localizer!(
    TriangulationParams,
    "triangulation",
    "follows a robot from a known start by corners, edges and walls that a laser sees"
);
