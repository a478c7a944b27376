//! Lasting changes as a map builder of the framework.

use super::beams::BeamFan;
use super::conclusion::{Conclusion, conclude};
use super::evidence::Verdict;
use super::memory::Memory;
use super::memory_file::{memory_bytes, memory_of};
use super::params::LastingChangesParams;
use super::raster::Raster;
use super::visit::Visit;
use crate::scan_poses::ScanPoses;
use rumbo_core::frames::{Pose2, is_finite2};
use rumbo_core::map::{CellClass, Grid, Layer, Map};
use rumbo_core::messages::{Check, Estimate, LaserScan, Observation, ObservationKind, SensorId, Status};
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::stages::{BuildContext, BuildError, Cx, MapBuilder, MapError, MapInput};
use rumbo_core::time::Time;
use rumbo_kit::occupancy::UpdateGate;
use std::path::Path;

rumbo_core::register_map_builder!(
    LastingChangesParams,
    "lasting_changes",
    "corrects a map by what several visits have seen: moved furniture comes in, what is gone goes out"
);

/// See [`LastingChangesParams`].
pub struct LastingChanges {
    params: LastingChangesParams,
    /// What earlier visits left, and where it lay.
    given: Option<(String, Vec<u8>)>,
    poses: ScanPoses,
    sources: Vec<Source>,
    fan: BeamFan,
    began: Option<Time>,
    work: Option<Work>,
}

/// What is remembered of each scanner.
struct Source {
    sensor: SensorId,
    newest: Option<Time>,
    gate: UpdateGate,
}

/// A visit under way.
struct Work {
    raster: Raster,
    memory: Memory,
    visit: Visit,
    /// Cells of the grid that show what is not yet confirmed, with what stood there.
    shown: Vec<(usize, f32)>,
}

/// Why a scan does not count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Skipped {
    NotNewer,
    NoPose,
    Unsure,
    HardlyMoved,
    Unexplained,
}

impl Skipped {
    fn counter(self) -> &'static str {
        match self {
            Skipped::NotNewer => "scans not counted: not newer than the last",
            Skipped::NoPose => "scans not counted: no pose for their time",
            Skipped::Unsure => "scans not counted: the pose is not sure",
            Skipped::HardlyMoved => "scans not counted: the robot hardly moved",
            Skipped::Unexplained => "scans not counted: they do not fit the map",
        }
    }
}

impl Plugin<dyn MapBuilder> for LastingChangesParams {
    fn manifest(&self) -> Manifest {
        Manifest {
            needs_layers: vec![Layer::Grid],
            gives_layers: vec![Layer::Grid],
            overlays: true,
            consumes: vec![vec![ObservationKind::LaserScan]],
            ..Manifest::default()
        }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn MapBuilder>, BuildError> {
        if let Some(fault) = self.check().into_iter().next() {
            return Err(fault);
        }
        let read = |file: &Path| {
            let file = context.resolve(file);
            let bytes = std::fs::read(&file).map_err(|error| {
                let message = format!("cannot read {}: {error}", file.display());
                BuildError::at("memory", message).help("leave `memory` out at the first visit")
            });
            Ok((file.display().to_string(), bytes?))
        };
        Ok(Box::new(LastingChanges {
            given: self.memory.as_deref().map(read).transpose()?,
            poses: ScanPoses::new(self.max_pose_age_s),
            sources: Vec::new(),
            fan: BeamFan::default(),
            began: None,
            work: None,
            params: self.clone(),
        }))
    }
}

fn grid_of(map: &mut Map) -> Result<&mut Grid, MapError> {
    map.grid.as_mut().ok_or(MapError::MissingLayer { layer: "grid" })
}

impl MapBuilder for LastingChanges {
    fn start(&mut self, map: &mut Map) -> Result<(), MapError> {
        if !map.coarse_grids.is_empty() {
            let message =
                "the map has coarser grids, so it is made from scans already; correct one that is loaded";
            return Err(MapError::Other(message.to_owned()));
        }
        let grid = grid_of(map)?;
        let no_cell =
            || MapError::Other("the map has no known cell, so there is nothing to correct".to_owned());
        let raster = Raster::of(grid).ok_or_else(no_cell)?;
        let (memory, raster) = match &self.given {
            None => (Memory::blank(raster.size().n_cells()), raster),
            Some((path, bytes)) => memory_of(bytes, &raster)
                .map_err(|fault| MapError::File { path: path.clone(), reason: fault.to_string() })?,
        };
        write(grid, &raster, memory.learned());
        let mut shown = Vec::new();
        if self.params.shows_unconfirmed {
            let places = memory.unconfirmed().map(|(index, _)| raster.in_grid(index));
            shown.extend(places.filter_map(|place| Some((place, *grid.cells.get(place)?))));
            write(grid, &raster, memory.unconfirmed());
        }
        let visit = Visit::new(raster.size().n_cells(), self.params.visit_rules());
        self.work = Some(Work { raster, memory, visit, shown });
        self.sources.clear();
        self.began = None;
        map.touch();
        Ok(())
    }

    fn insert(&mut self, cx: &mut Cx<'_>, input: &MapInput<'_>, map: &mut Map) -> Result<(), MapError> {
        self.poses.take(input.seen);
        let grid = grid_of(map)?;
        for (observation, scan) in input.seen.laser_scans().filter(|(observation, _)| observation.valid) {
            match self.take(observation, scan, input.estimate, grid)? {
                None => cx.trace.count("scans counted", 1.0),
                Some(skipped) => cx.trace.count(skipped.counter(), 1.0),
            }
        }
        Ok(())
    }

    fn save(&self, map: &mut Map) -> Result<Option<Vec<u8>>, MapError> {
        let work = self.work.as_ref().ok_or_else(not_started)?;
        let grid = grid_of(map)?;
        if !work.raster.is_of(grid) {
            return Err(replaced());
        }
        let Conclusion { memory, .. } =
            conclude(&work.raster, &work.memory, &work.visit, &self.params.rules());
        let cells = grid.cells.make_mut();
        for (place, before) in &work.shown {
            if let Some(cell) = cells.get_mut(*place) {
                *cell = *before;
            }
        }
        write(grid, &work.raster, memory.learned());
        let bytes = memory_bytes(&memory, &work.raster);
        map.touch();
        Ok(Some(bytes))
    }
}

fn not_started() -> MapError {
    MapError::Other("it was not started".to_owned())
}

fn replaced() -> MapError {
    let message = "the map was replaced by one of another size or place during the visit; begin a new one";
    MapError::Other(message.to_owned())
}

fn write(grid: &mut Grid, raster: &Raster, cells: impl Iterator<Item = (usize, Verdict)>) {
    let buffer = grid.cells.make_mut();
    for (index, verdict) in cells {
        if let Some(cell) = buffer.get_mut(raster.in_grid(index)) {
            *cell = verdict.log_odds();
        }
    }
}

impl LastingChanges {
    fn take(
        &mut self,
        observation: &Observation,
        scan: &LaserScan,
        estimate: &Estimate,
        grid: &Grid,
    ) -> Result<Option<Skipped>, MapError> {
        let source = self.source(observation.sensor);
        let Some(work) = &mut self.work else { return Err(not_started()) };
        let Some(source) = self.sources.get_mut(source) else { return Err(not_started()) };
        if source.newest.is_some_and(|newest| observation.stamp <= newest) {
            return Ok(Some(Skipped::NotNewer));
        }
        source.newest = Some(observation.stamp);
        if !work.raster.is_of(grid) {
            return Err(replaced());
        }
        let is_sound = scan.check().is_ok() && estimate.check().is_ok();
        let pose = self.poses.at(observation.stamp, estimate).filter(|pose| is_sound && is_finite2(pose));
        let Some(map_from_base) = pose else { return Ok(Some(Skipped::NoPose)) };
        let Some(reach_m) = reach_m(estimate, self.params.max_end_std_m, self.params.max_range_m) else {
            return Ok(Some(Skipped::Unsure));
        };
        let field_of_view_rad = scan.bearing_step_rad.abs() * scan.ranges_m.len() as f64;
        if !source.gate.is_open(&map_from_base, field_of_view_rad) {
            return Ok(Some(Skipped::HardlyMoved));
        }
        let grid_from_base: Pose2 = grid.grid_from_map() * map_from_base;
        let (mount, raster) = (&observation.base_from_sensor, &work.raster);
        let to_raster = |cells| raster.from_grid_cells(cells);
        self.fan.place(scan, &grid_from_base, mount, raster.resolution_m(), reach_m, to_raster);
        if !fits(&self.fan, raster, self.params.min_explained) {
            return Ok(Some(Skipped::Unexplained));
        }
        source.gate.close(&map_from_base);
        let began = *self.began.get_or_insert(observation.stamp);
        work.visit.take(&self.fan.beams, raster, (observation.stamp - began).as_secs() as f32);
        Ok(None)
    }

    fn source(&mut self, sensor: SensorId) -> usize {
        self.sources.iter().position(|source| source.sensor == sensor).unwrap_or_else(|| {
            let (way_m, turn_rad) = (self.params.scan_distance_m, self.params.scan_angle_deg.to_radians());
            self.sources.push(Source { sensor, newest: None, gate: UpdateGate::new(way_m, turn_rad) });
            self.sources.len() - 1
        })
    }
}

/// How far from the robot a point that it sees has at most this standard deviation, by those of its place and heading; none
/// where the place alone has more, or where the robot is not followed.
fn reach_m(estimate: &Estimate, max_std_m: f64, most_m: f64) -> Option<f64> {
    let covariance = estimate.covariance2();
    let left_m2 = max_std_m.powi(2) - covariance[(0, 0)].max(covariance[(1, 1)]);
    if estimate.status != Status::Tracking || left_m2 <= 0.0 {
        return None;
    }
    let heading_rad2 = covariance[(2, 2)];
    Some(if heading_rad2 > 0.0 { (left_m2 / heading_rad2).sqrt().min(most_m) } else { most_m })
}

/// Enough of what the scan meets on the map stands on or beside a cell that the map has.
fn fits(fan: &BeamFan, raster: &Raster, least_share: f64) -> bool {
    let is_mapped = |index: usize| raster.class(index) == CellClass::Occupied;
    let (mut n_met, mut n_explained) = (0u32, 0u32);
    for beam in fan.beams.iter().filter(|beam| beam.is_hit) {
        let Some(cell) = raster.cell_at(beam.to) else { continue };
        n_met += 1;
        n_explained += u32::from(is_mapped(cell) || raster.around(cell).any(is_mapped));
    }
    f64::from(n_explained) >= least_share * f64::from(n_met)
}

#[cfg(test)]
mod tests;
