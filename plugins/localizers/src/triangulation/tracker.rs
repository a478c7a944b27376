//! Follows a robot from scan to scan.

use super::all_pairs::by_pairs;
use super::correspondence::{Relation, Tolerances, relate};
use super::covariance::{in_axes_of, moved_by};
use super::expected_scan::ExpectedScan;
use super::least_squares::{LandmarkErrors, Solution, solve};
use super::quality::Weighting;
use crate::odometry::propagation::{ErrorGrowth, Uncertainty};
use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::Pose2;
use rumbo_core::map::Grid;
use rumbo_core::time::{Span, Time};
use rumbo_kit::landmarks::{BeamFan, Extractor, Landmark, LandmarkSettings};

/// How a pose is found from related landmarks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Method {
    /// All landmarks at once, each weighed by its errors.
    LeastSquares,
    /// Pairs of landmarks, as the source does.
    Pairs {
        /// How pairs are weighed.
        weighting: Weighting,
        /// Estimates farther than this from the median are dropped, and the heading is a median, too.
        within_m: Option<f64>,
    },
}

/// How a robot is followed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackerSettings {
    /// What is a landmark.
    pub landmarks: LandmarkSettings,
    /// What may differ between two views.
    pub within: Tolerances,
    /// How a pose is found.
    pub method: Method,
    /// Scans are related to what the map lets expect, else to the scan before.
    pub by_map: bool,
    /// At least this long between scans that are looked at.
    pub period: Span,
    /// Standard deviations of walls of the map: distance in meters, direction in radians.
    pub map_deviation: [f64; 2],
}

/// One scan in the frame of a sensor whose axis is upright.
#[derive(Debug)]
pub struct SeenScan<'a> {
    /// When.
    pub stamp: Time,
    /// Its beams.
    pub fan: BeamFan,
    /// Its ranges, meters.
    pub ranges_m: &'a [f32],
    /// Where the sensor sits.
    pub base_from_sensor: Pose2,
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

/// What the last scan gave.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Report {
    /// Landmarks seen.
    pub n_seen: usize,
    /// Of these, related to known ones.
    pub n_related: usize,
    /// Scans in a row with fewer than two related landmarks.
    pub n_starved: usize,
}

/// Follows a robot.
#[derive(Debug)]
pub struct Tracker {
    settings: TrackerSettings,
    anchor: Anchor,
    extractor: Extractor,
    expected: ExpectedScan,
    /// Landmarks of the last scan, where scans are related to each other, and when they were seen.
    known: Vec<Landmark>,
    last_scan: Option<Time>,
    report: Report,
}

/// The odometer is never better than this, whatever it claims: m/m, rad/m, rad/rad.
const LEAST_NOISE: [f64; 3] = [0.005, 0.002, 0.005];
/// Unsureness that nothing takes away, as standard deviations of x, y (meters) and yaw (radians).
const LEAST_DEVIATION: [f64; 3] = [5e-4, 5e-4, 2e-4];
/// A robot that moved less than this since the last scan has nothing new to see, meters and radians: the same errors of
/// the map would be taken for new knowledge again and again.
const LEAST_MOTION: [f64; 2] = [0.02, 0.01];

impl Tracker {
    /// Begins at a pose.
    pub fn new(settings: TrackerSettings, anchor: Anchor) -> Tracker {
        Tracker {
            settings,
            anchor,
            extractor: Extractor::new(settings.landmarks),
            expected: ExpectedScan::default(),
            known: Vec::new(),
            last_scan: None,
            report: Report::default(),
        }
    }

    /// What the last scan gave.
    pub fn report(&self) -> Report {
        self.report
    }

    /// Where the robot is when the odometer says this, and how surely; `noise` is what the odometer claims of itself.
    pub fn carried_to(&self, odom_from_base: &Pose2, noise: [f64; 3]) -> (Pose2, Matrix3<f64>) {
        let way = self.anchor.odom_from_base.inverse() * odom_from_base;
        let mut unsure = Uncertainty::new(self.anchor.covariance);
        grow(&mut unsure, &self.anchor.map_from_base, &way, noise);
        (self.anchor.map_from_base * way, unsure.covariance())
    }

    /// The odometer was set anew: the robot is where it was, and may have come this far.
    pub fn rebase(&mut self, old: &Pose2, new: &Pose2, noise: [f64; 3], reach: [f64; 2]) {
        let (map_from_base, covariance) = self.carried_to(old, noise);
        let mut unsure = Uncertainty::new(covariance);
        unsure.widen(reach[0], reach[1]);
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
        let (predicted, covariance) = self.carried_to(odom_from_base, noise);
        let is_first = self.last_scan.is_none();
        self.last_scan = Some(scan.stamp);
        let seen = self.extractor.extract(&scan.fan, scan.ranges_m.iter().map(|range| f64::from(*range)));
        let seen = seen.to_vec();
        self.report.n_seen = seen.len();
        let by_map = self.settings.by_map;
        let base = scan.base_from_sensor;
        // The earlier place A, its covariance, and what the odometry says of the way from there; all of the sensor.
        let (map_from_a, known_covariance, odometry) = if by_map {
            let map_from_sensor = predicted * base;
            if let Some(map) = map {
                let ranges = self.expected.trace(map, &map_from_sensor, &scan.fan, scan.ranges_m.len());
                self.known.clear();
                self.known.extend_from_slice(self.extractor.extract(&scan.fan, ranges.iter().copied()));
            }
            let local = in_axes_of(
                &map_from_sensor,
                &moved_by(&covariance, &(predicted.rotation * base.translation.vector)),
            );
            let odometry = Solution { a_from_b: Pose2::identity(), covariance: local };
            (map_from_sensor, Matrix3::zeros(), odometry)
        } else {
            let way = self.anchor.odom_from_base.inverse() * odom_from_base;
            let mut unsure = Uncertainty::new(Matrix3::from_diagonal(&Vector3::repeat(1e-10)));
            grow(&mut unsure, &Pose2::identity(), &way, noise);
            let a_from_b = base.inverse() * way * base;
            let turned = in_axes_of(&base, &unsure.covariance());
            let odometry = Solution { a_from_b, covariance: turned };
            (self.anchor.map_from_base * base, self.anchor.covariance, odometry)
        };
        let relations = relate(&self.known, &seen, &odometry.a_from_b, &self.settings.within);
        self.report.n_related = relations.len();
        let is_starved = relations.len() < 2 && (by_map || !is_first);
        self.report.n_starved = if is_starved { self.report.n_starved + 1 } else { 0 };
        let solution = self.solution(&relations, &odometry).unwrap_or(odometry);
        let map_from_sensor = map_from_a * solution.a_from_b;
        let map_from_base = map_from_sensor * base.inverse();
        let way = map_from_sensor.translation.vector - map_from_a.translation.vector;
        let step = in_axes_of(&map_from_a.inverse(), &solution.covariance);
        let back = map_from_base.translation.vector - map_from_sensor.translation.vector;
        let mut covariance = moved_by(&(moved_by(&known_covariance, &way) + step), &back);
        let floor = Vector3::from(LEAST_DEVIATION).map(|deviation| deviation * deviation);
        covariance += Matrix3::from_diagonal(&floor);
        self.anchor = Anchor { map_from_base, covariance, odom_from_base: *odom_from_base };
        if !by_map {
            self.known = seen;
        }
    }

    fn solution(&self, relations: &[Relation], odometry: &Solution) -> Option<Solution> {
        match self.settings.method {
            Method::LeastSquares => {
                let errors = LandmarkErrors {
                    range_m: self.settings.landmarks.range_deviation_m,
                    known_is_seen: !self.settings.by_map,
                    map_m: self.settings.map_deviation[0],
                    map_rad: self.settings.map_deviation[1],
                };
                solve(relations, odometry, &errors)
            }
            Method::Pairs { weighting, within_m } => by_pairs(relations, odometry, weighting, within_m),
        }
    }
}

/// The odometer's errors on a way from a pose.
fn grow(unsure: &mut Uncertainty, map_from_base: &Pose2, way: &Pose2, noise: [f64; 3]) {
    let noise = [0, 1, 2].map(|k| noise[k].abs().max(LEAST_NOISE[k]));
    let along = map_from_base.rotation * way.translation.vector;
    unsure.advance(along, way.rotation.angle(), noise, ErrorGrowth::Constant);
}
