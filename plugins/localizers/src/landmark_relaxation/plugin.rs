//! Global localization by natural landmarks as a localizer.

use super::locator::{Hypothesis, Locator};
use super::model_seat::ModelSeat;
use super::params::LandmarkRelaxationParams;
use super::search::{Progress, Search};
use super::sighting::Sighting;
use crate::odometry::{DeadReckoning, OdometryParams};
use crate::particle_filter::scan_queue::{PendingScan, ScanQueue};
use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::{Pose2, lift};
use rumbo_core::map::{Grid, Layer, Map};
use rumbo_core::messages::{
    Candidate, Check, Estimate, ObservationKind, Prior, Seen, SensorId, Status, Wish,
};
use rumbo_core::registry::{Manifest, Plugin};
use rumbo_core::stages::{BuildContext, BuildError, Cx, LocalizeError, Localizer};
use rumbo_core::time::{Span, Time};
use rumbo_core::trace::Trace;
use rumbo_kit::odometry_history::OdometryHistory;

/// See [`LandmarkRelaxationParams`].
struct LandmarkRelaxation {
    params: LandmarkRelaxationParams,
    context: BuildContext,
    model: ModelSeat,
    odometry: OdometryHistory,
    queue: ScanQueue,
    /// Whose scans are used: the first scanner's.
    scanner: Option<SensorId>,
    state: State,
}

/// What it does.
enum State {
    NotStarted,
    /// Looks for the robot.
    Searching(Box<Search>),
    /// Knows where it is, and goes by the odometer from there.
    Carrying(Box<DeadReckoning>),
}

/// A robot at one of several places is as unsure of its place as this: meters, and radians.
const AMBIGUOUS_DEVIATION: [f64; 2] = [1e3, 3.0];

fn grid_of(map: &Map) -> Result<&Grid, LocalizeError> {
    map.grid.as_ref().ok_or(LocalizeError::MissingLayer { layer: "grid" })
}

impl LandmarkRelaxation {
    /// Takes in readings and scans; a scan is looked at once the odometry at its time is known.
    fn search(&mut self, cx: &Cx<'_>, seen: Seen<'_>, map: &Map) -> Result<Estimate, LocalizeError> {
        grid_of(map)?;
        self.model.go_on(cx.now).map_err(|error| LocalizeError::Other(error.to_string()))?;
        let mut readings = Ok(());
        for (observation, odometry) in seen.odometry().filter(|(observation, _)| observation.valid) {
            readings = readings.and(odometry.check());
            if odometry.check().is_ok() {
                self.take_odometry(cx, observation.stamp, odometry.odom_from_base);
            }
        }
        for (observation, scan) in seen.laser_scans().filter(|(observation, _)| observation.valid) {
            self.queue.push(observation, scan);
        }
        while let Some(pending) = self.queue.pop_ready(cx.now, &self.odometry) {
            self.take_scan(cx, &pending);
        }
        readings?;
        self.tell(cx.trace);
        self.estimate(cx, map)
    }

    fn take_odometry(&mut self, cx: &Cx<'_>, stamp: Time, odom_from_base: Pose2) {
        self.odometry.push(stamp, odom_from_base);
        if let (State::Searching(search), Some((_, newest))) = (&mut self.state, self.odometry.newest()) {
            search.follow(newest, cx.now);
        }
    }

    fn take_scan(&mut self, cx: &Cx<'_>, pending: &PendingScan) {
        let State::Searching(search) = &mut self.state else { return };
        let Some(known) = self.model.known() else { return };
        if *self.scanner.get_or_insert(pending.sensor) != pending.sensor || pending.scan.check().is_err() {
            return;
        }
        // Half of the beams are older and half are newer than the middle one.
        let middle = pending.stamp + Span::from_secs(pending.scan.sweep_s / 2.0);
        let odom_from_base = self.odometry.at(middle).or_else(|| self.odometry.at(pending.stamp));
        let Some(odom_from_base) = odom_from_base else { return };
        let reach_m = self.params.range_m;
        let sighting =
            Sighting::of(&pending.scan, pending.stamp, &pending.base_from_sensor, odom_from_base, reach_m);
        if let Some(sighting) = sighting {
            search.look(known, sighting, cx.now);
        }
    }

    fn tell(&self, trace: &Trace) {
        let State::Searching(search) = &self.state else { return };
        trace.count("model_progress", self.model.progress());
        if let Some(known) = self.model.known() {
            trace.count("model_cells", known.model.n_cells() as f64);
            trace.count("model_bytes", known.model.n_bytes() as f64);
            let file_use = self.model.file_use();
            trace.count("model_file_read", f64::from(file_use.was_read));
            trace.count("model_file_refused", f64::from(file_use.was_refused));
            trace.count("model_file_unwritable", f64::from(file_use.is_unwritable));
        }
        let report = search.report();
        trace.count("landmarks", report.n_landmarks as f64);
        trace.count("candidates", report.n_cells as f64);
        trace.count("matches", report.n_matches as f64);
        trace.count("squared_error_m2", report.squared_error_m2);
        trace.count("second_observations", f64::from(search.n_moves()));
    }

    fn estimate(&mut self, cx: &Cx<'_>, map: &Map) -> Result<Estimate, LocalizeError> {
        let State::Searching(search) = &self.state else { return Err(LocalizeError::NotStarted) };
        let (stamp, odom_from_base) = self.odometry.newest().unwrap_or((cx.now, Pose2::identity()));
        let stamp = stamp.min(cx.now);
        let unsure = |status: Status, wish: Option<Wish>| {
            // Nothing is known of the place, but the odometer's frame stays what it is.
            let mut estimate = Estimate { status, wish, ..Estimate::lost(stamp) };
            estimate.map_from_odom = lift(&odom_from_base.inverse());
            estimate
        };
        match search.progress() {
            Progress::Looking(wish) => Ok(unsure(Status::Converging, Some(wish))),
            Progress::Lost(wish) => Ok(unsure(Status::Lost, wish)),
            Progress::Ambiguous(places, wish) => {
                let best = places.first().map_or_else(Pose2::identity, |place| place.map_from_base);
                let [place_m, heading_rad] = AMBIGUOUS_DEVIATION;
                let deviations = Vector3::new(place_m, place_m, heading_rad);
                let covariance = Matrix3::from_diagonal(&deviations.component_mul(&deviations));
                let estimate = Estimate::planar(stamp, best, odom_from_base, covariance);
                let candidates = candidates_of(&places);
                Ok(Estimate { status: Status::Ambiguous, candidates, wish, ..estimate })
            }
            Progress::Found(place, sighting) => {
                let prior = Prior::Pose {
                    map_from_base: place.map_from_base,
                    odom_from_base: sighting.odom_from_base,
                    covariance: place.covariance,
                };
                self.carry(&prior, map)?;
                let moved = sighting.odom_from_base.inverse() * odom_from_base;
                let map_from_base = place.map_from_base * moved;
                Ok(Estimate::planar(stamp, map_from_base, odom_from_base, place.covariance))
            }
        }
    }

    /// From a pose that is known, the odometer tells the rest.
    fn carry(&mut self, prior: &Prior, map: &Map) -> Result<(), LocalizeError> {
        let robot = &self.context.robot;
        let mut reckoning =
            DeadReckoning::new(OdometryParams::default(), robot.max_speed_m_s, robot.max_turn_rad_s());
        reckoning.start(prior, map)?;
        self.state = State::Carrying(Box::new(reckoning));
        Ok(())
    }
}

/// Places with scores that add up to one.
fn candidates_of(places: &[Hypothesis]) -> Vec<Candidate> {
    let all: f64 = places.iter().map(|place| place.score).sum();
    let share = |score: f64| if all > 0.0 { score / all } else { 1.0 / places.len() as f64 };
    let candidate =
        |place: &Hypothesis| Candidate { map_from_base: place.map_from_base, score: share(place.score) };
    places.iter().map(candidate).collect()
}

impl Localizer for LandmarkRelaxation {
    fn start(&mut self, prior: &Prior, map: &Map) -> Result<(), LocalizeError> {
        prior.check()?;
        let grid = grid_of(map)?;
        self.odometry.clear();
        self.queue.clear();
        self.scanner = None;
        match prior {
            Prior::Pose { .. } => self.carry(prior, map),
            Prior::Saved(_) => {
                Err(LocalizeError::Prior { prior: "a saved state", needs: "a pose, or none at all" })
            }
            Prior::Unknown => {
                self.model.want(grid);
                let locator = Locator::new(self.params.locator(), self.context.rng());
                let settings = self.params.search(self.context.robot.hull().outer_radius_m());
                self.state = State::Searching(Box::new(Search::new(settings, locator)));
                Ok(())
            }
        }
    }

    fn update(&mut self, cx: &mut Cx<'_>, seen: Seen<'_>, map: &Map) -> Result<Estimate, LocalizeError> {
        match &mut self.state {
            State::NotStarted => Err(LocalizeError::NotStarted),
            State::Searching(_) => self.search(cx, seen, map),
            State::Carrying(reckoning) => reckoning.update(cx, seen, map),
        }
    }
}

impl Plugin<dyn Localizer> for LandmarkRelaxationParams {
    fn manifest(&self) -> Manifest {
        Manifest {
            needs_layers: vec![Layer::Grid],
            consumes: vec![vec![ObservationKind::LaserScan], vec![ObservationKind::Odometry]],
            wishes_motion: self.moves,
            ..Manifest::default()
        }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Localizer>, BuildError> {
        let model = ModelSeat::new(self.model(), self.model_file(context), context.background.clone());
        Ok(Box::new(LandmarkRelaxation {
            params: self.clone(),
            context: context.clone(),
            model,
            odometry: OdometryHistory::default(),
            queue: ScanQueue::default(),
            scanner: None,
            state: State::NotStarted,
        }))
    }
}

rumbo_core::register_localizer!(
    LandmarkRelaxationParams,
    "landmark_relaxation",
    "finds a robot that may be anywhere on a grid map by edges and walls that a laser sees all around"
);
