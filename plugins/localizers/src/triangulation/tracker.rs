//! Follows a robot from scan to scan.

use super::between_scans::look_back;
use super::correspondence::Tolerances;
use super::dead_reckoning::sigmas;
use super::landmark_errors::LandmarkErrors;
use super::on_map::OnMap;
use super::quality::Weighting;
use super::scan::{Found, SeenScan};
use super::sureness::{Look, Sureness, SurenessRules};
use crate::deviations::deviations;
use crate::odometry::propagation::{ErrorGrowth, Uncertainty};
use nalgebra::Matrix3;
use rumbo_core::frames::Pose2;
use rumbo_core::map::Grid;
use rumbo_core::messages::Status;
use rumbo_core::rng::Rng;
use rumbo_core::time::{Span, Time};
use rumbo_kit::landmarks::{Extractor, Landmark, LandmarkNoise, LandmarkSettings};

/// How pairs of landmarks are put together, as the source does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairRules {
    /// How pairs are weighed.
    pub weighting: Weighting,
    /// Estimates farther than this from the median are dropped, and the heading is a median, too. Meters.
    pub within_m: Option<f64>,
}

/// How a robot is followed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackerSettings {
    /// What is a landmark.
    pub landmarks: LandmarkSettings,
    /// What may differ between two views.
    pub within: Tolerances,
    /// A pose is found by pairs of landmarks; else by all at once.
    pub pairs: Option<PairRules>,
    /// Scans are related to what the map lets expect, else to the scan before (by pairs only).
    pub by_map: bool,
    /// At least this long between scans that are looked at.
    pub period: Span,
    /// Errors of landmarks and of the map, but for its cells.
    pub errors: LandmarkErrors,
    /// Noise on what is seen, for experiments.
    pub noise: Option<LandmarkNoise>,
    /// A scan that agrees with the map on a smaller share of its beams is from elsewhere.
    pub least_explained: f64,
}

/// Where the robot was when something was last known of it.
#[derive(Debug, Clone, Copy)]
pub struct Anchor {
    /// The robot.
    pub map_from_base: Pose2,
    /// Covariance of x, y, yaw in the map's axes.
    pub covariance: Matrix3<f64>,
    /// What the odometer said.
    pub odom_from_base: Pose2,
}

/// What the scans gave.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Report {
    /// Landmarks of the last scan.
    pub n_seen: usize,
    /// Of these, related to known ones.
    pub n_related: usize,
    /// Estimates that the last pose was made from.
    pub n_estimates: usize,
    /// Scans ever with fewer than two related landmarks.
    pub n_starved: u64,
}

/// Follows a robot.
#[derive(Debug)]
pub struct Tracker {
    settings: TrackerSettings,
    anchor: Anchor,
    extractor: Extractor,
    on_map: OnMap,
    /// Landmarks of the last scan, where scans are related to each other, and when they were seen.
    known: Vec<Landmark>,
    last_scan: Option<Time>,
    rng: Rng,
    sureness: Sureness,
    report: Report,
}

/// A robot that moved less than this since the last scan has nothing new to see, meters and radians.
const LEAST_MOTION: [f64; 2] = [0.02, 0.01];

impl Tracker {
    /// Begins at a pose. `rng` feeds the noise of experiments.
    pub fn new(settings: TrackerSettings, anchor: Anchor, rng: Rng) -> Tracker {
        let rules = SurenessRules {
            deviation_m: settings.within.search_m,
            least_explained: settings.least_explained,
        };
        Tracker {
            settings,
            anchor,
            extractor: Extractor::new(settings.landmarks),
            on_map: OnMap::new(&settings, &anchor.map_from_base, &anchor.covariance),
            known: Vec::new(),
            last_scan: None,
            rng,
            sureness: Sureness::new(rules),
            report: Report::default(),
        }
    }

    /// What the scans gave.
    pub fn report(&self) -> Report {
        self.report
    }

    /// How sure the pose is.
    pub fn status(&self) -> Status {
        self.sureness.status()
    }

    /// Where the robot is when the odometer says this, and how surely; `noise` is what the odometer claims of itself.
    pub fn carried_to(&self, odom_from_base: &Pose2, noise: [f64; 3]) -> (Pose2, Matrix3<f64>) {
        let way = self.anchor.odom_from_base.inverse() * odom_from_base;
        if self.settings.by_map {
            return self.on_map.carried(&way, noise);
        }
        let mut unsure = Uncertainty::new(self.anchor.covariance);
        grow(&mut unsure, &self.anchor.map_from_base, &way, noise);
        (self.anchor.map_from_base * way, unsure.covariance())
    }

    /// The odometer was set anew: the robot is where it was, and may have come this far.
    pub fn rebase(&mut self, old: &Pose2, new: &Pose2, noise: [f64; 3], reach: [f64; 2]) {
        let (map_from_base, covariance) = self.carried_to(old, noise);
        let mut unsure = Uncertainty::new(covariance);
        unsure.widen(reach[0], reach[1]);
        self.on_map.carry(&(self.anchor.odom_from_base.inverse() * old), noise);
        self.on_map.widen(reach);
        self.anchor = Anchor { map_from_base, covariance: unsure.covariance(), odom_from_base: *new };
        self.known.clear();
    }

    /// Whether a scan of this time is to be looked at.
    pub fn is_due(&self, stamp: Time, odom_from_base: &Pose2) -> bool {
        let Some(last) = self.last_scan else { return true };
        let way = self.anchor.odom_from_base.inverse() * odom_from_base;
        let has_moved =
            way.translation.vector.norm() >= LEAST_MOTION[0] || way.rotation.angle().abs() >= LEAST_MOTION[1];
        has_moved && stamp - last >= self.settings.period
    }

    /// Looks at a scan that was made where the odometer said `odom_from_base`. `map` is the grid and its version.
    pub fn look(
        &mut self,
        scan: &SeenScan<'_>,
        odom_from_base: &Pose2,
        noise: [f64; 3],
        map: Option<(u64, &Grid)>,
    ) {
        let is_first = self.last_scan.replace(scan.stamp).is_none();
        let ranges = scan.ranges_m.iter().map(|range| f64::from(*range));
        let mut seen = self.extractor.extract(&scan.fan, ranges).to_vec();
        if let Some(on_landmarks) = &self.settings.noise {
            on_landmarks.disturb(&mut seen, &mut self.rng);
        }
        let way = self.anchor.odom_from_base.inverse() * odom_from_base;
        let found = match (&self.settings.pairs, map) {
            (Some(rules), _) if !self.settings.by_map => {
                let odometry = (&self.anchor, odom_from_base, noise);
                look_back(scan, (&self.known, &seen), odometry, (&self.settings, rules))
            }
            (_, Some(map)) => self.on_map.look(scan, &seen, (&way, noise), map),
            (_, None) => self.on_map.look_without_map(&way, noise),
        };
        let Found { map_from_base, covariance, n_related, n_estimates, explained } = found;
        self.anchor = Anchor { map_from_base, covariance, odom_from_base: *odom_from_base };
        let [deviation_m, _] = deviations(&covariance);
        // The first scan has none before it that it could be related to.
        if self.settings.by_map || !is_first {
            self.sureness.judge(&Look { n_related, explained, deviation_m });
        }
        let n_starved = self.sureness.n_starved_ever();
        self.report = Report { n_seen: seen.len(), n_related, n_estimates, n_starved };
        self.known = seen;
    }
}

/// The odometer's errors on a way from a pose.
pub fn grow(unsure: &mut Uncertainty, map_from_base: &Pose2, way: &Pose2, noise: [f64; 3]) {
    let along = map_from_base.rotation * way.translation.vector;
    unsure.advance(along, way.rotation.angle(), sigmas(noise), ErrorGrowth::Constant);
}
