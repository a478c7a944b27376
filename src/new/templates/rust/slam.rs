//! The SLAM plugin `{{name}}`: follows the odometer, corrects it by matching scans to the map, and maps what it sees.
//!
//! Replace what [`MatchAndMap::update`] does by your own algorithm; the rest can stay.

use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Point2, Pose2, flatten, pose2};
use rumbo_core::map::{Grid, GridHeader, Layer, Map};
use rumbo_core::messages::{Check, Estimate, LaserScan, Observation, ObservationKind, Prior, Seen};
use rumbo_core::nalgebra::{Matrix3, Vector3};
use rumbo_core::odometry_track::OdometryTrack;
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::stages::{BuildContext, BuildError, Cx, Slam, SlamError};
use rumbo_core::time::Time;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Odometry, corrected by matching scans to a grid that is free where nothing was seen.
// These comments are what `rumbo plugins describe` and editors show.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Parameters {
    /// Edge of the square around the map's origin that is mapped, meters.
    #[schemars(range(min = 1.0, max = 200.0))]
    pub size_m: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        Parameters { size_m: 30.0 }
    }
}

impl Params for Parameters {
    fn check(&self) -> Vec<BuildError> {
        let found = self.size_m;
        let fits = (1.0..=200.0).contains(&found);
        let fault = || BuildError::at("size_m", format!("is {found}, expected a number from 1 to 200"));
        (!fits).then(fault).into_iter().collect()
    }
}

impl Plugin<dyn Slam> for Parameters {
    fn manifest(&self) -> Manifest {
        Manifest {
            gives_layers: vec![Layer::Grid],
            consumes: vec![vec![ObservationKind::LaserScan], vec![ObservationKind::Odometry]],
            needs_start_pose: true,
            ..Manifest::default()
        }
    }

    fn build(&self, _: &BuildContext) -> Result<Box<dyn Slam>, BuildError> {
        let (track, state) = (OdometryTrack::new(), None);
        Ok(Box::new(MatchAndMap { parameters: self.clone(), track, state }))
    }
}

struct MatchAndMap {
    parameters: Parameters,
    /// Where the odometer said that the base was, so that a scan gets the pose of its own time.
    track: OdometryTrack,
    state: Option<State>,
}

#[derive(Clone, Copy)]
struct State {
    /// The correction of the odometer.
    map_from_odom: Pose2,
    /// What the odometer said at the start.
    odom_from_base: Pose2,
    variances: Vector3<f64>,
    newest_scan: Option<Time>,
}

const RESOLUTION_M: f64 = 0.05;
/// Log-odds of floor that nobody has seen: below `Grid::FREE_BELOW`.
const UNSEEN: f32 = -2.0;
/// What one hit adds, and what a beam that passes takes away.
const HIT: f32 = 1.5;
const PASS: f32 = -0.3;
/// Fewer hits on known walls than this are no match.
const FEWEST_MATCHED: usize = 20;
/// Variances that a match cannot go below: x, y, yaw.
const MATCHED: [f64; 3] = [0.02 * 0.02, 0.02 * 0.02, 0.01 * 0.01];

impl Slam for MatchAndMap {
    fn start(&mut self, prior: &Prior, map: &mut Map) -> Result<(), SlamError> {
        self.stand(prior)?;
        map.grid = Some(self.blank()?);
        map.touch();
        Ok(())
    }

    // The map stays. Clock and odometer may be others from now on.
    fn relocate(&mut self, prior: &Prior, _: &mut Map) -> Result<(), SlamError> {
        self.stand(prior)
    }

    fn update(&mut self, cx: &mut Cx<'_>, seen: Seen<'_>, map: &mut Map) -> Result<Estimate, SlamError> {
        let Some(mut state) = self.state else { return Err(SlamError::Other("it was not started".to_owned())) };
        for (observation, odometry) in seen.odometry().filter(|(observation, _)| observation.valid) {
            odometry.check()?;
            self.track.push(observation.stamp, odometry);
        }
        for (observation, scan) in seen.laser_scans().filter(|(observation, _)| observation.valid) {
            let is_new = state.newest_scan.is_none_or(|newest| observation.stamp > newest);
            if !is_new || scan.check().is_err() {
                continue;
            }
            let grid = map.grid.as_mut().ok_or_else(|| SlamError::Other("the grid is gone".to_owned()))?;
            let odom_from_base = self.track.stamp().map_or(state.odom_from_base, |_| self.track.at(observation.stamp));
            let points = points_in_base(observation, scan);
            let guess = state.map_from_odom * odom_from_base;
            let map_from_base = matched(grid, guess, &points);
            if map_from_base != guess {
                state.variances = Vector3::from(MATCHED);
            }
            state.map_from_odom = map_from_base * odom_from_base.inverse();
            state.newest_scan = Some(observation.stamp);
            paint(grid, &(map_from_base * flatten(&observation.base_from_sensor)), map_from_base, &points);
            map.touch();
        }
        self.state = Some(state);
        let stamp = self.track.stamp().unwrap_or(cx.now);
        let odom_from_base = self.track.stamp().map_or(state.odom_from_base, |_| self.track.now());
        let covariance = Matrix3::from_diagonal(&state.variances);
        Ok(Estimate::planar(stamp, state.map_from_odom * odom_from_base, odom_from_base, covariance))
    }
}

impl MatchAndMap {
    fn stand(&mut self, prior: &Prior) -> Result<(), SlamError> {
        prior.check()?;
        let needs = "a pose";
        let Prior::Pose { map_from_base, odom_from_base, covariance } = prior else {
            return Err(SlamError::Prior { prior: "no pose", needs });
        };
        self.track = OdometryTrack::new();
        self.state = Some(State {
            map_from_odom: map_from_base * odom_from_base.inverse(),
            odom_from_base: *odom_from_base,
            variances: covariance.diagonal().map(|variance| variance.max(0.0)),
            newest_scan: None,
        });
        Ok(())
    }

    fn blank(&self) -> Result<Grid, SlamError> {
        let n_cells = (self.parameters.size_m / RESOLUTION_M).ceil().max(1.0) as u32;
        let corner_m = -f64::from(n_cells) * RESOLUTION_M / 2.0;
        let header = GridHeader {
            width: n_cells,
            height: n_cells,
            resolution_m: RESOLUTION_M,
            origin: [corner_m, corner_m, 0.0],
            occupied_above: Grid::OCCUPIED_ABOVE,
            free_below: Grid::FREE_BELOW,
        };
        let cells = Buffer::filled(n_cells as usize * n_cells as usize, UNSEEN);
        Grid::new(header, cells).map_err(|fault| SlamError::Other(fault.to_string()))
    }
}

fn points_in_base(observation: &Observation, scan: &LaserScan) -> Vec<Point2> {
    let base_from_sensor = flatten(&observation.base_from_sensor);
    let point = |(bearing_rad, range_m): (f64, f64)| {
        base_from_sensor * Point2::new(range_m * bearing_rad.cos(), range_m * bearing_rad.sin())
    };
    scan.hits().map(point).collect()
}

/// The pose near the guess from which most hits lie on known walls: tries small steps, and smaller ones when none helps.
fn matched(grid: &Grid, guess: Pose2, points: &[Point2]) -> Pose2 {
    let n_on_walls = points.iter().filter(|point| evidence(grid, guess * *point) > 0.0).count();
    if n_on_walls < FEWEST_MATCHED {
        return guess;
    }
    let score = |pose: &Pose2| points.iter().map(|point| evidence(grid, pose * point)).sum::<f64>();
    let (mut best, mut best_score) = (guess, score(&guess));
    let (mut step_m, mut step_rad) = (0.02, 0.01);
    for _ in 0..12 {
        let (m, rad) = (step_m, step_rad);
        let steps = [(m, 0.0, 0.0), (-m, 0.0, 0.0), (0.0, m, 0.0), (0.0, -m, 0.0), (0.0, 0.0, rad), (0.0, 0.0, -rad)];
        let tried = steps.map(|(x, y, yaw)| best * pose2(x, y, yaw)).map(|pose| (score(&pose), pose));
        let better = tried.into_iter().filter(|(score, _)| *score > best_score + 1e-9);
        match better.max_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((score, pose)) => (best, best_score) = (pose, score),
            None => (step_m, step_rad) = (step_m / 2.0, step_rad / 2.0),
        }
    }
    best
}

/// How much the map says for a wall at a point, between the middles of cells in proportion.
fn evidence(grid: &Grid, point: Point2) -> f64 {
    let in_cells = grid.grid_from_map() * point / grid.resolution_m();
    let (x, y) = (in_cells.x - 0.5, in_cells.y - 0.5);
    let (col, row) = (x.floor(), y.floor());
    let at = |col: f64, row: f64| {
        let is_inside = col >= 0.0 && row >= 0.0 && col < grid.width().into() && row < grid.height().into();
        let idx = row as usize * grid.width() as usize + col as usize;
        let log_odds = if is_inside { grid.cells.get(idx).copied().unwrap_or(UNSEEN) } else { UNSEEN };
        f64::from(log_odds.max(0.0))
    };
    let (dx, dy) = (x - col, y - row);
    let lower = at(col, row) * (1.0 - dx) + at(col + 1.0, row) * dx;
    let upper = at(col, row + 1.0) * (1.0 - dx) + at(col + 1.0, row + 1.0) * dx;
    lower * (1.0 - dy) + upper * dy
}

/// Puts one scan into the grid.
fn paint(grid: &mut Grid, map_from_sensor: &Pose2, map_from_base: Pose2, points: &[Point2]) {
    let sensor: Point2 = map_from_sensor.translation.vector.into();
    for point in points {
        let hit = map_from_base * point;
        // Half a cell from one look to the next, and away from the hit itself.
        let n_steps = (((hit - sensor).norm() / RESOLUTION_M * 2.0) as usize).min(10_000);
        let mut last = None;
        for step in 0..n_steps.saturating_sub(3) {
            let cell = grid.cell_at(sensor + (hit - sensor) * (step as f64 / n_steps as f64));
            if cell != last {
                change(grid, cell, PASS);
                last = cell;
            }
        }
        change(grid, grid.cell_at(hit), HIT);
    }
}

fn change(grid: &mut Grid, cell: Option<rumbo_core::map::Cell>, by: f32) {
    let Some(idx) = cell.map(|cell| grid.index_of(cell)) else { return };
    if let Some(log_odds) = grid.cells.make_mut().get_mut(idx) {
        *log_odds = (*log_odds + by).clamp(UNSEEN, Grid::CERTAIN);
    }
}

rumbo_core::register_slam!(Parameters, "{{name}}", "odometry corrected by matching scans, and a grid of what was seen");

// The line that makes a plugin library of this crate.
rumbo_core::export_plugins!();

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scan_is_moved_back_onto_the_wall_that_it_shows() {
        let slam = MatchAndMap { parameters: Parameters { size_m: 10.0 }, track: OdometryTrack::new(), state: None };
        let mut grid = slam.blank().unwrap();
        // Two walls in the form of an L, seen twice.
        let mut points: Vec<Point2> = (0..60).map(|k| Point2::new(2.025, 0.05 * f64::from(k) - 1.475)).collect();
        points.extend((0..60).map(|k| Point2::new(0.05 * f64::from(k) - 0.975, 1.525)));
        for _ in 0..3 {
            paint(&mut grid, &Pose2::identity(), Pose2::identity(), &points);
        }
        let found = matched(&grid, pose2(0.02, -0.02, 0.0), &points);
        assert!(found.translation.vector.norm() < 0.01, "{found}");
    }
}
