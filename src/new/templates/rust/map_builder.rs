//! The map builder `{{name}}`: a grid in which unseen floor counts as free until a scan shows something there.
//!
//! Replace what [`Optimist::insert`] does by your own algorithm; the rest can stay.

use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Point2, flatten, is_finite2};
use rumbo_core::map::{Grid, GridHeader, Layer, Map};
use rumbo_core::messages::{Check, LaserScan, Observation, ObservationKind, Status};
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::stages::{BuildContext, BuildError, Cx, MapBuilder, MapError, MapInput};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A grid from laser scans, free where nothing was seen.
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

impl Plugin<dyn MapBuilder> for Parameters {
    fn manifest(&self) -> Manifest {
        Manifest {
            gives_layers: vec![Layer::Grid],
            consumes: vec![vec![ObservationKind::LaserScan]],
            ..Manifest::default()
        }
    }

    fn build(&self, _: &BuildContext) -> Result<Box<dyn MapBuilder>, BuildError> {
        Ok(Box::new(Optimist { parameters: self.clone() }))
    }
}

struct Optimist {
    parameters: Parameters,
}

/// Edge of a cell, meters.
const RESOLUTION_M: f64 = 0.05;
/// Log-odds of floor that nobody has seen: below `Grid::FREE_BELOW`.
const UNSEEN: f32 = -2.0;
/// What one hit adds, and what a beam that passes takes away.
const HIT: f32 = 1.5;
const PASS: f32 = -0.3;

impl MapBuilder for Optimist {
    fn start(&mut self, map: &mut Map) -> Result<(), MapError> {
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
        let n_cells = n_cells as usize;
        map.grid = Some(Grid::new(header, Buffer::filled(n_cells * n_cells, UNSEEN))?);
        map.touch();
        Ok(())
    }

    fn insert(&mut self, _: &mut Cx<'_>, input: &MapInput<'_>, map: &mut Map) -> Result<(), MapError> {
        if input.estimate.status != Status::Tracking || !is_finite2(&input.estimate.pose2()) {
            return Ok(());
        }
        let mut has_changed = false;
        for (observation, scan) in input.seen.laser_scans().filter(|(observation, _)| observation.valid) {
            let grid = map.grid.as_mut().ok_or(MapError::MissingLayer { layer: "grid" })?;
            if scan.check().is_ok() {
                paint(grid, input, observation, scan);
                has_changed = true;
            }
        }
        if has_changed {
            // Who computed something from the map learns that it is stale.
            map.touch();
        }
        Ok(())
    }
}

/// Puts one scan into the grid.
fn paint(grid: &mut Grid, input: &MapInput<'_>, observation: &Observation, scan: &LaserScan) {
    let map_from_sensor = input.estimate.pose2() * flatten(&observation.base_from_sensor);
    let sensor: Point2 = map_from_sensor.translation.vector.into();
    for (bearing_rad, range_m) in scan.hits() {
        let hit = map_from_sensor * Point2::new(range_m * bearing_rad.cos(), range_m * bearing_rad.sin());
        // Half a cell from one look to the next, and away from the hit itself.
        let n_steps = ((range_m / RESOLUTION_M * 2.0) as usize).min(10_000);
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

rumbo_core::register_map_builder!(Parameters, "{{name}}", "a grid from laser scans, free where nothing was seen");

// The line that makes a plugin library of this crate.
rumbo_core::export_plugins!();

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_core::frames::{Pose2, Pose3};
    use rumbo_core::map::CellClass;
    use rumbo_core::messages::{Data, Estimate, Seen, SensorId};
    use rumbo_core::time::Time;
    use rumbo_core::trace::Trace;

    #[test]
    fn two_hits_make_an_obstacle_and_the_way_there_stays_free() {
        let mut builder = Parameters { size_m: 10.0 }.build(&BuildContext::bare("map_builder")).unwrap();
        let mut map = Map::default();
        builder.start(&mut map).unwrap();
        let scan = LaserScan { max_range_m: 8.0, ranges_m: vec![2.0].into(), ..LaserScan::default() };
        let (base_from_sensor, data) = (Pose3::identity(), Data::LaserScan(scan));
        let seen =
            [Observation { sensor: SensorId(0), stamp: Time::ZERO, base_from_sensor, valid: true, data }];
        let covariance = Default::default();
        let estimate = Estimate::planar(Time::ZERO, Pose2::identity(), Pose2::identity(), covariance);
        let input = MapInput { seen: Seen::sorted(&seen), estimate: &estimate };
        for _ in 0..2 {
            let trace = Trace::unwatched();
            builder.insert(&mut Cx { now: Time::ZERO, trace: &trace }, &input, &mut map).unwrap();
        }
        let grid = map.grid.unwrap();
        let class = |x: f64| grid.class(grid.cell_at(Point2::new(x, 0.0)).unwrap());
        assert_eq!((class(2.0), class(1.0), class(3.0)), (CellClass::Occupied, CellClass::Free, CellClass::Free));
    }
}
