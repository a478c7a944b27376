//! The filter: predictions, readings, and the map that grows from them.

use super::association::{Match, associate, rows_of};
use super::clock::Steps;
use super::consistency::Consistency;
use super::odometer_errors::shift;
use super::sighting::{Mount, Viewpoint};
use super::state::State;
use super::tentative::Tentative;
use super::update::{NotPositiveDefinite, Update};
use super::wall::{Wall, from_layer, to_layer};
use super::{FilterSettings, MotionModel};
use crate::lines::SensedLine;
use nalgebra::{Matrix5, Vector5};
use rumbo_core::map::Line;

/// Where the map comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MapUse {
    /// The filter builds it.
    Build,
    /// It is given and does not change.
    Known,
}

/// What became of a reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reading {
    /// Taken in; its squared Mahalanobis distance.
    Fused(f64),
    /// A wheel slips: left out.
    Slipping(f64),
    /// The robot is too slow for it to say anything: left out.
    TooSlow,
    /// Its covariance is none, or a number is not finite: left out.
    Refused,
}

/// What became of a scan.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ScanReport {
    /// Lines that are walls of the map.
    pub matches: Vec<Match>,
    /// New walls.
    pub n_added: usize,
    /// Walls that became one with another.
    pub n_merged: usize,
    /// The measurement of all lines together was refused: nothing was changed.
    pub is_refused: bool,
}

/// A map that is given.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct WallMap {
    lines: Vec<Line>,
}

impl WallMap {
    /// Walls of the map layer; each is to the left of the way from its first end to its second. Lines without a length and
    /// those that are not finite are left out.
    pub fn new(lines: &[Line]) -> WallMap {
        WallMap { lines: lines.iter().filter(|line| from_layer(line).is_some()).copied().collect() }
    }

    /// Walls.
    pub fn len(&self) -> usize {
        self.lines.len()
    }

    /// There is none.
    pub fn is_empty(&self) -> bool {
        self.lines.is_empty()
    }
}

/// The filter.
#[derive(Debug, Clone)]
pub struct LineFilter {
    pub(super) settings: FilterSettings,
    pub(super) map_use: MapUse,
    pub(super) state: State,
    pub(super) walls: Vec<Wall>,
    pub(super) tentative: Tentative,
    pub(super) n_scans: u64,
    consistency: [Consistency; 3],
    /// Since when the wheels have disagreed without a break, seconds; none while they agree.
    /// Time since lines that are no walls were looked at, seconds.
    pub(super) untested_s: f64,
    slipping_s: Option<f64>,
}

impl LineFilter {
    /// A filter that builds its map, from a robot that is known so well.
    pub fn building(settings: FilterSettings, robot: Vector5<f64>, covariance: &Matrix5<f64>) -> LineFilter {
        let mut state = State::new(robot, covariance);
        settings.odometer.begin(&mut state);
        LineFilter {
            settings,
            map_use: MapUse::Build,
            state,
            walls: Vec::new(),
            tentative: Tentative::default(),
            n_scans: 0,
            consistency: Default::default(),
            untested_s: 0.0,
            slipping_s: None,
        }
    }

    /// A filter on a map that is known. Its errors (the covariance of its lines) stay what they are: they are considered,
    /// not corrected.
    pub fn on_map(
        settings: FilterSettings,
        robot: Vector5<f64>,
        covariance: &Matrix5<f64>,
        map: &WallMap,
    ) -> LineFilter {
        let mut filter = LineFilter::building(settings, robot, covariance);
        filter.map_use = MapUse::Known;
        for (line, wall, covariance) in map.lines.iter().filter_map(from_layer) {
            filter.state.add_known(line, &covariance);
            filter.walls.push(wall);
        }
        filter
    }

    /// Somebody says where the robot is: the walls stay, and lines that are no walls yet are forgotten, since they were seen
    /// from elsewhere.
    pub fn place(&mut self, robot: Vector5<f64>, spread: &Matrix5<f64>) {
        self.state.place(robot, spread);
        self.tentative = Tentative::default();
        self.slipping_s = None;
    }

    /// Robot and walls.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Ends of the walls, in the order of the state.
    pub fn walls(&self) -> &[Wall] {
        &self.walls
    }

    /// The walls as a layer of the map.
    pub fn layer(&self) -> Vec<Line> {
        to_layer(&self.state, &self.walls)
    }

    /// Its map is given.
    pub fn is_on_map(&self) -> bool {
        self.map_use == MapUse::Known
    }

    /// Nothing is known any more of the speed and the turn but these deviations, m/s and rad/s.
    pub fn forget_motion(&mut self, deviations: [f64; 2]) {
        self.state.forget_motion(deviations);
        self.slipping_s = None;
    }

    /// What it is set to.
    pub fn settings(&self) -> &FilterSettings {
        &self.settings
    }

    /// Normalized innovations of wheels, steering and lines.
    pub fn consistency(&self) -> &[Consistency; 3] {
        &self.consistency
    }

    /// Goes on by so many seconds.
    pub fn predict(&mut self, seconds: f64) {
        self.settings.motion.predict(&mut self.state, seconds);
        self.settings.odometer.wander(&mut self.state, seconds);
        self.slipping_s = self.slipping_s.map(|since_s| since_s + seconds);
        self.untested_s += seconds;
    }

    /// Takes in the speeds of the left and the right wheel, m/s.
    pub fn read_wheels(&mut self, speeds_m_s: [f64; 2]) -> Reading {
        let wheels = self.settings.wheels;
        let rows = self.settings.odometer.rows(&wheels, &self.state, speeds_m_s);
        let Ok(mut update) = Update::new(&self.state, &rows) else { return Reading::Refused };
        let distance2 = update.distance2();
        if distance2.is_nan() || distance2 > wheels.slip_gate {
            if *self.slipping_s.get_or_insert(0.0) <= wheels.longest_slip_s || !distance2.is_finite() {
                return Reading::Slipping(distance2);
            }
            wheels.doubt_motion(&mut self.state, &rows);
            let Ok(again) = Update::new(&self.state, &rows) else { return Reading::Refused };
            update = again;
        }
        self.slipping_s = None;
        update.fuse(&mut self.state, &rows, self.map_use == MapUse::Known);
        self.consistency[0].push(distance2, 2);
        Reading::Fused(distance2)
    }

    /// Goes on by some steps, in which an odometer read this mean speed (m/s) and turn (rad/s) with these variances. What it
    /// read is the motion: it says where the robot went to the millimeter, however its stamps jitter.
    pub fn roll(&mut self, read: [f64; 2], variances: [f64; 2], steps: Steps) -> Reading {
        let model = self.settings.odometer;
        let rows = model.odometer_rows(&self.state, read, variances);
        let Ok(update) = Update::new(&self.state, &rows) else { return Reading::Refused };
        let distance2 = update.distance2();
        if !distance2.is_finite() {
            return Reading::Refused;
        }
        model.move_as_read(&mut self.state, read, variances);
        let motion =
            MotionModel { acceleration_m_s2: 0.0, turn_acceleration_rad_s2: 0.0, ..self.settings.motion };
        for _ in 0..steps.n {
            motion.predict(&mut self.state, steps.seconds);
            model.wander(&mut self.state, steps.seconds);
        }
        self.untested_s += steps.all_s();
        self.slipping_s = None;
        self.consistency[0].push(distance2, 2);
        Reading::Fused(distance2)
    }

    /// Takes in the angle of the steered wheel, radians.
    pub fn read_steering(&mut self, angle_rad: f64) -> Reading {
        let Some(row) = self.settings.steering.row(&self.state.robot, angle_rad) else {
            return Reading::TooSlow;
        };
        let Ok(update) = Update::new(&self.state, &[row]) else { return Reading::Refused };
        let distance2 = update.distance2();
        update.fuse(&mut self.state, &[row], self.map_use == MapUse::Known);
        self.consistency[1].push(distance2, 1);
        Reading::Fused(distance2)
    }

    /// Takes in the lines of one scan.
    pub fn read_lines(&mut self, seen: &[SensedLine], mount: &Mount) -> ScanReport {
        let (model, motion) = (self.settings.odometer, self.settings.motion);
        shift(&model, &motion, &mut self.state, -1.0);
        let report = self.look(seen, mount);
        shift(&model, &motion, &mut self.state, 1.0);
        report
    }

    fn look(&mut self, seen: &[SensedLine], mount: &Mount) -> ScanReport {
        let view = Viewpoint::new(&self.state.robot, mount);
        let matches = associate(&self.state, &self.walls, &view, seen, &self.settings.gates);
        let mut report = ScanReport::default();
        if !matches.is_empty() {
            if self.fuse(&view, seen, &matches).is_err() {
                return ScanReport { is_refused: true, ..report };
            }
            matches.iter().for_each(|found| self.consistency[2].push(found.distance2, 2));
        }
        if self.map_use == MapUse::Build {
            self.grow(seen, mount, &matches, &mut report);
        }
        report.matches = matches;
        report
    }

    /// One stacked update of all matches.
    fn fuse(
        &mut self,
        view: &Viewpoint,
        seen: &[SensedLine],
        matches: &[Match],
    ) -> Result<(), NotPositiveDefinite> {
        let rows = rows_of(&self.state, view, seen, matches);
        let update = Update::new(&self.state, &rows)?;
        update.fuse(&mut self.state, &rows, self.map_use == MapUse::Known);
        Ok(())
    }
}
