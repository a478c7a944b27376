//! The filter on what sensors really say: stamps that jitter, scans that come late, odometers in place of wheels.

use super::FilterSettings;
use super::clock::Clock;
use super::filter::{LineFilter, WallMap};
use super::odometer_noise::OdometerNoise;
use super::running::{LeftOut, Running};
use super::saved::{SavedFault, SavedFilter};
use crate::lines::{LineExtractor, LineSettings};
use nalgebra::{Matrix3, Matrix5, Vector5};
use rumbo_core::frames::{Pose2, pose2};
use rumbo_core::messages::{Check, Data, Estimate, MessageFault, Observation, Odometry, Prior, Seen};
use rumbo_core::robot::Drive;
use rumbo_core::time::Time;

/// All that a tracker needs to know.
#[derive(Debug, Clone)]
pub struct TrackerSettings {
    /// The filter.
    pub filter: FilterSettings,
    /// How lines are found in scans.
    pub lines: LineSettings,
    /// Which of the robot's wheels are the axle's.
    pub drive: Drive,
    /// Standard deviations of the speed (m/s) and the turn (rad/s) at the start, when the robot may be moving.
    pub start_motion: [f64; 2],
    /// When which reading is taken in.
    pub clock: Clock,
    /// A scan is taken in once the robot went (m) or turned (rad) so far since the last one that was.
    pub look_every: [f64; 2],
    /// How unsure an odometer is.
    pub odometer: OdometerNoise,
    /// So many scans in a row of which no line is a wall of the known map, and the robot is lost.
    pub lost_after_scans: u32,
}

/// Why there is no estimate.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TrackFault {
    /// It cannot start from this prior.
    #[error("cannot start from {prior}; it needs {needs}")]
    Prior {
        /// What it was given.
        prior: &'static str,
        /// What it needs.
        needs: &'static str,
    },
    /// The saved state is none.
    #[error("the saved state cannot be used: {0}")]
    Saved(#[from] SavedFault),
    /// Nobody started it.
    #[error("it was not started")]
    NotStarted,
    /// A number that must not go on.
    #[error(transparent)]
    Message(#[from] MessageFault),
    /// Too long without a reading: where the robot was driven to, nobody knows.
    #[error("no reading for {gap_s:.1} s; the pose is kept, the speed is forgotten")]
    Gap {
        /// How long, seconds.
        gap_s: f64,
    },
    /// The numbers of the state are not finite.
    #[error("the state is not finite any more")]
    Diverged,
}

/// The filter at work.
#[derive(Debug)]
pub struct LineTracker {
    settings: TrackerSettings,
    extractor: LineExtractor,
    running: Option<Running>,
}

/// A pose that is surer than this makes walls that depend on it too exactly for the numbers, m² and rad².
const LEAST_VARIANCE: f64 = 1e-12;

impl LineTracker {
    /// A tracker that waits for its start.
    pub fn new(settings: TrackerSettings) -> LineTracker {
        let extractor = LineExtractor::new(settings.lines);
        LineTracker { settings, extractor, running: None }
    }

    /// Begins to build a map, at a pose or where a saved state was.
    ///
    /// # Errors
    /// Why that is no start.
    pub fn build_map(&mut self, prior: &Prior) -> Result<(), TrackFault> {
        prior.check()?;
        let running = match prior {
            Prior::Saved(bytes) => self.resumed(bytes)?,
            Prior::Pose { map_from_base, odom_from_base, covariance } => {
                let (robot, spread) = self.robot_at(map_from_base, covariance)?;
                let filter = LineFilter::building(self.settings.filter.clone(), robot, &spread);
                Running::new(filter, &self.settings, *odom_from_base)
            }
            Prior::Unknown => {
                let needs = "a pose, which defines the map's frame, or a state that it saved";
                return Err(TrackFault::Prior { prior: "an unknown pose", needs });
            }
        };
        self.running = Some(running);
        Ok(())
    }

    /// Somebody says where the robot is in the map that it has built; the map stays.
    ///
    /// # Errors
    /// Why that cannot be; everything is as it was then.
    pub fn relocate(&mut self, prior: &Prior) -> Result<(), TrackFault> {
        prior.check()?;
        let needs = "a pose";
        let Prior::Pose { map_from_base, odom_from_base, covariance } = prior else {
            return Err(TrackFault::Prior { prior: "an unknown pose", needs });
        };
        let (robot, spread) = self.robot_at(map_from_base, covariance)?;
        let running = self.running.as_mut().ok_or(TrackFault::NotStarted)?;
        running.filter.place(robot, &spread);
        running.place(&self.settings, *odom_from_base);
        Ok(())
    }

    /// Begins to follow the robot on a map.
    ///
    /// # Errors
    /// Why that is no start.
    pub fn follow(&mut self, prior: &Prior, map: &WallMap) -> Result<(), TrackFault> {
        prior.check()?;
        let needs = "a pose";
        let Prior::Pose { map_from_base, odom_from_base, covariance } = prior else {
            let is_saved = matches!(prior, Prior::Saved(_));
            let prior = if is_saved { "a saved state" } else { "an unknown pose" };
            return Err(TrackFault::Prior { prior, needs });
        };
        let (robot, spread) = self.robot_at(map_from_base, covariance)?;
        let filter = LineFilter::on_map(self.settings.filter.clone(), robot, &spread, map);
        self.running = Some(Running::new(filter, &self.settings, *odom_from_base));
        Ok(())
    }

    fn robot_at(
        &self,
        map_from_base: &Pose2,
        covariance: &Matrix3<f64>,
    ) -> Result<(Vector5<f64>, Matrix5<f64>), TrackFault> {
        let symmetric = (covariance + covariance.transpose()) * 0.5;
        let least = symmetric.symmetric_eigenvalues().min();
        if least < -1e-9 * symmetric.amax().max(LEAST_VARIANCE) {
            let (message, field) = ("prior", "covariance");
            let (found, expected) = (format!("an eigenvalue of {least}"), "no negative eigenvalue");
            return Err(MessageFault { message, field, found, expected }.into());
        }
        let place = map_from_base.translation.vector;
        let robot = Vector5::new(place.x, place.y, map_from_base.rotation.angle(), 0.0, 0.0);
        let mut spread = Matrix5::zeros();
        let floor = Matrix3::identity() * (LEAST_VARIANCE - least.min(0.0));
        spread.fixed_view_mut::<3, 3>(0, 0).copy_from(&(symmetric + floor));
        for (k, deviation) in (3..).zip(self.settings.start_motion) {
            spread[(k, k)] = deviation * deviation;
        }
        Ok((robot, spread))
    }

    fn resumed(&self, bytes: &[u8]) -> Result<Running, TrackFault> {
        let saved = SavedFilter::from_bytes(bytes, self.settings.filter.clone())?;
        let [x, y, yaw] = saved.odom_from_base;
        let mut running = Running::new(saved.filter, &self.settings, pose2(x, y, yaw));
        running.clock.resume(saved.start, saved.now);
        running.odometer.stamp = saved.odometry_stamp;
        if let Some(stamp) = saved.odometry_stamp {
            let odom_from_base = running.odometer.odom_from_base;
            running.track.push(stamp, &Odometry { odom_from_base, ..Odometry::default() });
        }
        Ok(running)
    }

    /// The whole state as bytes; none before the start.
    pub fn save(&self) -> Option<Vec<u8>> {
        let Running { filter, clock, odometer, .. } = self.running.as_ref()?;
        let place = odometer.odom_from_base.translation.vector;
        let saved = SavedFilter {
            start: clock.start(),
            now: clock.now(),
            odom_from_base: [place.x, place.y, odometer.odom_from_base.rotation.angle()],
            odometry_stamp: odometer.stamp,
            filter: filter.clone(),
        };
        Some(saved.to_bytes())
    }

    /// The filter; none before the start.
    pub fn filter(&self) -> Option<&LineFilter> {
        self.running.as_ref().map(|running| &running.filter)
    }

    /// What was left out since the start.
    pub fn left_out(&self) -> LeftOut {
        self.running.as_ref().map_or_else(LeftOut::default, |running| running.left_out)
    }

    /// Scans that were taken in since the start.
    pub fn n_scans(&self) -> u64 {
        self.running.as_ref().map_or(0, |running| running.n_scans)
    }

    /// Takes in what was seen. A fault of one reading is told after all others were taken in.
    ///
    /// # Errors
    /// Why there is no estimate.
    pub fn update(&mut self, now: Time, seen: Seen<'_>) -> Result<Estimate, TrackFault> {
        let running = self.running.as_mut().ok_or(TrackFault::NotStarted)?;
        let mut outcome = Ok(());
        let mut seen: Vec<&Observation> = seen.iter().filter(|observation| observation.valid).collect();
        // Where the robot went comes before what it saw there.
        seen.sort_by_key(|observation| (observation.stamp, matches!(observation.data, Data::LaserScan(_))));
        for observation in seen {
            let taken = running.take(observation, &self.settings, &mut self.extractor);
            outcome = outcome.and(taken);
        }
        outcome?;
        if !running.filter.state().robot.iter().all(|v| v.is_finite()) {
            return Err(TrackFault::Diverged);
        }
        Ok(running.estimate(now, self.settings.lost_after_scans))
    }
}
