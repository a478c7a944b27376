//! Monte-Carlo localization over time: which scans are weighed when, and what is known in between.

mod odometer;

use super::anchor::Anchor;
use super::beams::ScanBeams;
use super::continuity::Continuity;
use super::filter::{Fit, ParticleFilter, Weighed};
use super::measurement::MeasurementModel;
use super::scan_queue::{PendingScan, ScanQueue};
use super::silence::Silence;
use super::sureness::{Sureness, is_tight};
use super::terrain::Terrain;
use super::tracker_settings::{Counters, TrackerSettings};
use super::unmapped::without_unmapped;
use super::wishes::wish;
use nalgebra::Matrix3;
use rumbo_core::frames::{Pose2, lift};
use rumbo_core::map::{Grid, Map};
use rumbo_core::messages::{Check, Estimate, Prior, Seen, Status};
use rumbo_core::stages::LocalizeError;
use rumbo_core::time::{Span, Time};
use rumbo_kit::odometry_history::OdometryHistory;

/// A filter that follows a robot.
pub struct MonteCarlo {
    settings: TrackerSettings,
    model: Box<dyn MeasurementModel>,
    filter: ParticleFilter,
    terrain: Option<Terrain>,
    odometry: OdometryHistory,
    last_noise: [f64; 3],
    queue: ScanQueue,
    /// The newest scan of each sensor that came too soon after the last update.
    too_soon: Vec<PendingScan>,
    anchor: Option<Anchor>,
    sureness: Sureness,
    continuity: Continuity,
    /// The next scan is weighed even if the robot did not move.
    is_first: bool,
    silence: Silence,
    counters: Counters,
}

impl MonteCarlo {
    /// Scans of different sensors within this belong to the same moment, seconds.
    const MOMENT_S: f64 = 0.02;

    /// Not started yet.
    pub fn new(
        settings: TrackerSettings,
        model: Box<dyn MeasurementModel>,
        filter: ParticleFilter,
    ) -> MonteCarlo {
        let sureness = Sureness::new(settings.rules, false);
        MonteCarlo {
            settings,
            model,
            filter,
            terrain: None,
            odometry: OdometryHistory::default(),
            last_noise: [0.0; 3],
            queue: ScanQueue::default(),
            too_soon: Vec::new(),
            anchor: None,
            sureness,
            continuity: Continuity::default(),
            is_first: true,
            silence: Silence::default(),
            counters: Counters::default(),
        }
    }

    /// The filter as it is.
    pub fn filter(&self) -> &ParticleFilter {
        &self.filter
    }

    /// What was received, used and dropped.
    pub fn counters(&self) -> Counters {
        self.counters
    }

    /// Share of the beams of the last update that the map explains from where the robot is taken to be.
    pub fn explained(&self) -> Option<f64> {
        self.anchor.as_ref()?.explained
    }

    /// Scans that were dropped.
    pub fn scans_dropped(&self) -> u64 {
        self.queue.n_dropped()
    }

    /// Begins anew around a pose, or anywhere.
    ///
    /// # Errors
    /// For a saved state, for numbers that are none, and for a map without a grid or without a free cell.
    pub fn start(&mut self, prior: &Prior, map: &Map) -> Result<(), LocalizeError> {
        prior.check()?;
        let grid = self.prepare(map)?;
        let Some(terrain) = &self.terrain else { return Err(LocalizeError::NotStarted) };
        if terrain.free.is_empty() {
            return Err(LocalizeError::Other("the map has no free cell where the robot could be".into()));
        }
        let odom_from_base = match prior {
            Prior::Unknown => {
                self.filter.start_anywhere(terrain, grid);
                self.odometry.newest().map_or_else(Pose2::identity, |(_, pose)| pose)
            }
            Prior::Pose { map_from_base, odom_from_base, covariance } => {
                self.filter.start_around(map_from_base, covariance);
                *odom_from_base
            }
            Prior::Saved(_) => {
                let needs = "a pose or an unknown place";
                return Err(LocalizeError::Prior { prior: "a saved state", needs });
            }
        };
        self.queue.clear();
        self.too_soon.clear();
        self.odometry.clear();
        self.sureness = Sureness::new(self.settings.rules, *prior != Prior::Unknown);
        self.continuity = Continuity::default();
        (self.is_first, self.silence, self.last_noise) = (true, Silence::default(), [0.0; 3]);
        self.anchor = None;
        self.set_anchor(odom_from_base, None, Vec::new());
        Ok(())
    }

    /// Takes in what was seen and says where the robot is at the newest reading of the odometer.
    ///
    /// # Errors
    /// Before the start, and for a map without a grid.
    pub fn update(&mut self, now: Time, seen: Seen<'_>, map: &Map) -> Result<Estimate, LocalizeError> {
        if self.anchor.is_none() {
            return Err(LocalizeError::NotStarted);
        }
        for (observation, odometry) in seen.odometry().filter(|(observation, _)| observation.valid) {
            self.take_odometry(observation.stamp, odometry);
        }
        for (observation, scan) in seen.laser_scans().filter(|(observation, _)| observation.valid) {
            self.queue.push(observation, scan);
        }
        while let Some(scan) = self.queue.pop_ready(now, &self.odometry) {
            self.consider(scan, map)?;
        }
        self.estimate(now)
    }

    /// The grid of the map, and everything computed from it if it changed.
    fn prepare<'m>(&mut self, map: &'m Map) -> Result<&'m Grid, LocalizeError> {
        let grid = map.grid.as_ref().ok_or(LocalizeError::MissingLayer { layer: "grid" })?;
        if self.terrain.as_ref().is_none_or(|terrain| terrain.version != map.version) {
            let TrackerSettings { init_clearance_m, unmapped_beyond_m, penalties, .. } = self.settings;
            let model = self.model.as_ref();
            self.terrain =
                Some(Terrain::new(map.version, grid, model, init_clearance_m, unmapped_beyond_m, penalties));
        }
        Ok(grid)
    }

    /// Weighs a scan if the robot moved enough since the last, together with what other sensors saw meanwhile.
    fn consider(&mut self, scan: PendingScan, map: &Map) -> Result<(), LocalizeError> {
        let (Some(anchor), Some(odom_from_base)) = (&self.anchor, self.odometry.at(scan.stamp)) else {
            return Ok(());
        };
        let way = anchor.odom_from_base.inverse() * odom_from_base;
        let has_moved = way.translation.vector.norm() >= self.settings.update_min_d_m
            || way.rotation.angle().abs() >= self.settings.update_min_a_rad
            || self.silence.is_long();
        let sensor = scan.sensor;
        if !(has_moved || self.is_first) {
            self.too_soon.retain(|other| other.sensor != sensor);
            self.too_soon.push(scan);
            return Ok(());
        }
        let within = Span::from_secs(Self::MOMENT_S);
        let mut scans = self.queue.pop_companions(&scan, within, &self.odometry);
        let has_newer =
            |old: &PendingScan| old.sensor == sensor || scans.iter().any(|s| s.sensor == old.sensor);
        let old: Vec<PendingScan> = self.too_soon.drain(..).filter(|old| !has_newer(old)).collect();
        scans.extend(old);
        let stamp = scan.stamp;
        scans.push(scan);
        self.step(stamp, odom_from_base, &scans, map)
    }

    /// One cycle of the filter at a time.
    fn step(
        &mut self,
        stamp: Time,
        odom_from_base: Pose2,
        scans: &[PendingScan],
        map: &Map,
    ) -> Result<(), LocalizeError> {
        let Some(odom_from_before) = self.anchor.as_ref().map(|anchor| anchor.odom_from_base) else {
            return Ok(());
        };
        let grid = self.prepare(map)?;
        self.filter.advance(&odom_from_before, &odom_from_base);
        if self.silence.is_long() {
            let [deviation_m, deviation_rad] = self.silence.end(self.settings.max_speed);
            self.filter.widen(deviation_m, deviation_rad);
        }
        let beams: Vec<ScanBeams> = scans.iter().map(|scan| self.beams_of(scan, &odom_from_base)).collect();
        let Some(terrain) = &mut self.terrain else { return Ok(()) };
        let expected = self.anchor.as_ref().filter(|_| self.filter.fit() == Fit::Good);
        let weighed = match expected.map(|anchor| anchor.expected_at(&odom_from_base)) {
            Some((expected, _)) => self.filter.weigh(&without_unmapped(&beams, terrain, &expected), terrain),
            None => self.filter.weigh(&beams, terrain),
        };
        self.counters.count(weighed);
        self.is_first &= weighed == Weighed::Nothing;
        self.set_anchor(odom_from_base, Some(stamp), beams);
        let Some(terrain) = &self.terrain else { return Ok(()) };
        let status = self.sureness.status();
        let fit = self.anchor.as_ref().map(|anchor| self.settings.fit(anchor, terrain, status));
        self.filter.set_fit(fit.unwrap_or_default());
        if weighed != Weighed::Nothing && self.filter.needs_resampling() {
            self.filter.resample(terrain, grid);
        }
        Ok(())
    }

    /// A scan as seen from where the base is at the time of the update.
    fn beams_of(&self, scan: &PendingScan, odom_from_base: &Pose2) -> ScanBeams {
        let odom_from_then = self.odometry.at(scan.stamp).unwrap_or(*odom_from_base);
        let base_from_then = odom_from_base.inverse() * odom_from_then;
        ScanBeams::of(&scan.scan, &(lift(&base_from_then) * scan.base_from_sensor), self.settings.max_beams)
    }

    /// Takes the filter's word for where the robot is now.
    fn set_anchor(&mut self, odom_from_base: Pose2, stamp: Option<Time>, scans: Vec<ScanBeams>) {
        let mut clusters = self.filter.clusters();
        let last = self.anchor.as_ref().filter(|_| self.sureness.has_tracked());
        self.continuity.choose(&mut clusters, last.map(|last| last.expected_at(&odom_from_base)));
        let best = clusters.first().map(|cluster| (cluster.map_from_base, cluster.covariance));
        let (map_from_base, covariance) = best.unwrap_or((Pose2::identity(), Matrix3::identity() * 1e6));
        // The middle of a wide cluster is nowhere in particular, and its fit says nothing.
        let is_place = clusters.first().is_some_and(is_tight);
        let terrain = self.terrain.as_ref().filter(|terrain| is_place && terrain.has_obstacles);
        let explained = terrain.and_then(|terrain| terrain.explained(&scans, &map_from_base));
        self.sureness.judge(&clusters, explained);
        self.anchor =
            Some(Anchor { map_from_base, covariance, odom_from_base, stamp, scans, clusters, explained });
    }

    /// The last word of the filter, carried on by the odometer.
    fn estimate(&self, now: Time) -> Result<Estimate, LocalizeError> {
        let Some(anchor) = &self.anchor else { return Err(LocalizeError::NotStarted) };
        let newest = self.odometry.newest().unwrap_or((now, anchor.odom_from_base));
        let status = self.sureness.status();
        let mut estimate = anchor.carried_to(newest, self.last_noise, status);
        if self.settings.may_wish && status != Status::Tracking {
            estimate.wish = Some(wish(&anchor.scans, self.settings.radius_m));
        }
        Ok(estimate)
    }
}
