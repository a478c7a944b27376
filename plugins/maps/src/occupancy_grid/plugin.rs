//! The occupancy grid as a map builder of the framework.

use rumbo_core::frames::{Point2, Pose2};
use rumbo_core::map::{Layer, Map};
use rumbo_core::messages::{LaserScan, Observation, ObservationKind, SensorId, Status};
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::stages::{BuildContext, BuildError, Cx, MapBuilder, MapError, MapInput};
use rumbo_core::time::Time;
use rumbo_kit::occupancy::{Inserted, ScanMapper, UpdateGate};

use super::params::OccupancyGridParams;
use crate::scan_poses::ScanPoses;

rumbo_core::register_map_builder!(
    OccupancyGridParams,
    "occupancy_grid",
    "a grid built from laser scans and the localizer's poses"
);

/// See [`OccupancyGridParams`].
#[derive(Debug)]
pub struct OccupancyGrid {
    params: OccupancyGridParams,
    mapper: ScanMapper,
    sources: Vec<Source>,
    is_blank: bool,
    poses: ScanPoses,
    has_told_full: bool,
}

/// Farther away from the map's origin cells can no longer be counted in 32 bits.
const FARTHEST_CELLS: f64 = 1e9;

/// What is remembered of each scanner: two that look to different sides do not wait for each other.
#[derive(Debug)]
struct Source {
    sensor: SensorId,
    newest: Option<Time>,
    gate: UpdateGate,
}

/// Why a scan did not become part of the map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Skipped {
    NotNewer,
    NoHits,
    NoPose,
    Unsure,
    HardlyMoved,
    BesideTheMap,
}

impl Skipped {
    fn counter(self) -> &'static str {
        match self {
            Skipped::NotNewer => "scans skipped: not newer than the last",
            Skipped::NoHits => "scans skipped: no readings",
            Skipped::NoPose => "scans skipped: no pose for their time",
            Skipped::Unsure => "scans skipped: the pose is not sure",
            Skipped::HardlyMoved => "scans skipped: the robot hardly moved",
            Skipped::BesideTheMap => "scans skipped: the robot is beside the map",
        }
    }
}

impl Plugin<dyn MapBuilder> for OccupancyGridParams {
    fn manifest(&self) -> Manifest {
        Manifest {
            gives_layers: vec![Layer::Grid],
            consumes: vec![vec![ObservationKind::LaserScan]],
            ..Manifest::default()
        }
    }

    fn build(&self, _: &BuildContext) -> Result<Box<dyn MapBuilder>, BuildError> {
        if let Some(fault) = self.check().into_iter().next() {
            return Err(fault);
        }
        let evidence = self.evidence().map_err(|_| BuildError::at("", "impossible evidence"))?;
        Ok(Box::new(OccupancyGrid {
            mapper: ScanMapper::new(self.mapper(evidence)),
            sources: Vec::new(),
            is_blank: true,
            poses: ScanPoses::new(self.max_pose_age_s),
            has_told_full: false,
            params: self.clone(),
        }))
    }
}

impl MapBuilder for OccupancyGrid {
    fn start(&mut self, map: &mut Map) -> Result<(), MapError> {
        self.lay(map, Point2::origin())
    }

    fn insert(&mut self, cx: &mut Cx<'_>, input: &MapInput<'_>, map: &mut Map) -> Result<(), MapError> {
        self.poses.take(input.seen);
        for (observation, scan) in input.seen.laser_scans().filter(|(observation, _)| observation.valid) {
            let skipped = self.insert_scan(observation, scan, input, map)?;
            // Only now: what failed is handed in once more.
            let source = self.source(observation.sensor);
            let newest = self.sources[source].newest.max(Some(observation.stamp));
            self.sources[source].newest = newest;
            match skipped {
                None => cx.trace.count("scans inserted", 1.0),
                Some(skipped) => cx.trace.count(skipped.counter(), 1.0),
            }
        }
        Ok(())
    }
}

impl OccupancyGrid {
    fn lay(&mut self, map: &mut Map, around: Point2) -> Result<(), MapError> {
        let share = [self.params.start_x, self.params.start_y];
        self.mapper.pyramid().lay(map, self.params.size_cells, around, share)?;
        self.sources.clear();
        self.is_blank = true;
        map.touch();
        Ok(())
    }

    fn insert_scan(
        &mut self,
        observation: &Observation,
        scan: &LaserScan,
        input: &MapInput<'_>,
        map: &mut Map,
    ) -> Result<Option<Skipped>, MapError> {
        let source = self.source(observation.sensor);
        if self.sources[source].newest.is_some_and(|newest| observation.stamp <= newest) {
            return Ok(Some(Skipped::NotNewer));
        }
        let Some(map_from_base) = self.poses.at(observation.stamp, input.estimate) else {
            return Ok(Some(Skipped::NoPose));
        };
        let farthest_cells = map_from_base.translation.vector.amax() / self.params.resolution_m;
        if !rumbo_core::frames::is_finite2(&map_from_base) || farthest_cells > FARTHEST_CELLS {
            let Pose2 { translation: at, .. } = map_from_base;
            let message = format!(
                "the pose of a scan is ({}, {}) m, expected finite numbers, at most {FARTHEST_CELLS} cells from the \
                 map's origin",
                at.x, at.y
            );
            return Err(MapError::Other(message));
        }
        let deviations = input.estimate.covariance2().diagonal().map(f64::sqrt);
        let is_sure = deviations.x.max(deviations.y) <= self.params.max_pose_std_m;
        if input.estimate.status != Status::Tracking || !is_sure {
            return Ok(Some(Skipped::Unsure));
        }
        let field_of_view_rad = scan.bearing_step_rad.abs() * scan.ranges_m.len() as f64;
        if !(self.params.map_with_known_poses
            || self.sources[source].gate.is_open(&map_from_base, field_of_view_rad))
        {
            return Ok(Some(Skipped::HardlyMoved));
        }
        if self.is_blank || !self.mapper.pyramid().fits(map) {
            self.lay(map, map_from_base.translation.vector.into())?;
        }
        // Laying a new grid forgets the scanners.
        let source = self.source(observation.sensor);
        let inserted = self.mapper.insert(scan, &map_from_base, &observation.base_from_sensor, map)?;
        match inserted {
            Inserted::Empty => return Ok(Some(Skipped::NoHits)),
            Inserted::Cut if !self.has_told_full => return Err(self.full()),
            Inserted::Beside => return Ok(Some(Skipped::BesideTheMap)),
            Inserted::Whole | Inserted::Cut => {}
        }
        self.is_blank = false;
        self.sources[source].gate.close(&map_from_base);
        map.touch();
        Ok(None)
    }

    fn source(&mut self, sensor: SensorId) -> usize {
        self.sources.iter().position(|source| source.sensor == sensor).unwrap_or_else(|| {
            let (distance_m, angle_deg) =
                (self.params.map_update_distance_m, self.params.map_update_angle_deg);
            let gate = UpdateGate::new(distance_m, angle_deg.to_radians());
            self.sources.push(Source { sensor, newest: None, gate });
            self.sources.len() - 1
        })
    }

    /// Said once.
    fn full(&mut self) -> MapError {
        self.has_told_full = true;
        let most = self.params.max_cells;
        MapError::Other(format!(
            "the grid cannot grow beyond max_cells = {most}, and what lies beside it is left out; raise max_cells \
             or resolution_m"
        ))
    }
}

#[cfg(test)]
mod tests;
