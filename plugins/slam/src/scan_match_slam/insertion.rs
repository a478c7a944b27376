//! Which scans become part of the map, and how.

use super::settings::TrackerSettings;
use super::tracker::ScanTracker;
use rumbo_core::frames::{Point2, Pose2, pose2};
use rumbo_core::map::{Grid, GridFault, GridHeader, Map};
use rumbo_core::messages::{LaserScan, Observation};
use rumbo_kit::occupancy::{Inserted, UpdateGate};
use rumbo_kit::scan_match::MatchStatus;

/// Directions that a scan does not see must be known this well from before, meters (the specification's bound).
const MOST_BLIND_DEVIATION_M: f64 = 0.1;

/// Lays the levels with their axes along the robot's, and the robot on a corner of the coarsest cells: what is built does
/// not depend on how the map's frame happens to be turned.
pub(super) fn lay(settings: &TrackerSettings, map_from_base: &Pose2, map: &mut Map) -> Result<(), GridFault> {
    settings.mapper.pyramid.lay(map, settings.size_cells, Point2::origin(), [0.5, 0.5])?;
    for grid in map.grid.iter_mut().chain(&mut map.coarse_grids) {
        let [x, y, yaw] = grid.header().origin;
        let map_from_grid = map_from_base * pose2(x, y, yaw);
        let origin =
            [map_from_grid.translation.x, map_from_grid.translation.y, map_from_grid.rotation.angle()];
        *grid = Grid::new(GridHeader { origin, ..*grid.header() }, grid.cells.clone())?;
    }
    Ok(())
}

/// The scan with its ends a fiftieth of a cell farther: walls often lie on the edge between two cells, and rounding alone
/// must not say which of them is the wall.
fn pushed(scan: &LaserScan, resolution_m: f64) -> LaserScan {
    let mut pushed = scan.clone();
    let farther_m = (0.02 * resolution_m) as f32;
    for range_m in pushed.ranges_m.make_mut() {
        // What is out of reach stays so, and nothing else becomes so.
        if *range_m >= scan.min_range_m && *range_m <= scan.max_range_m {
            *range_m = (*range_m + farther_m).min(scan.max_range_m);
        }
    }
    pushed
}

impl ScanTracker {
    /// What did not match becomes part of the map only where the map ends: not far from where it matched last, or where
    /// a robot is that was looked for on the whole map in vain. What was not seen must be known from before.
    pub(super) fn may_insert(&self) -> bool {
        match self.status {
            MatchStatus::Ok => true,
            MatchStatus::Degenerate => self.blind_deviation_m <= MOST_BLIND_DEVIATION_M,
            MatchStatus::LowOverlap => {
                let is_on_new_ground = self.is_lost() && self.look.n_in_vain > 0 && !self.look.is_anywhere;
                self.way_without_match_m <= self.settings.explore_grace_m || is_on_new_ground
            }
            MatchStatus::TooFewPoints | MatchStatus::Diverged => false,
        }
    }

    pub(super) fn insert(
        &mut self,
        observation: &Observation,
        scan: &LaserScan,
        map_from_base: &Pose2,
        map: &mut Map,
    ) -> Result<bool, GridFault> {
        let field_of_view_rad = scan.bearing_step_rad.abs() * scan.ranges_m.len() as f64;
        let [way_m, turn_rad] = self.settings.insert_every;
        let known = self.gates.iter().position(|(sensor, _)| *sensor == observation.sensor);
        let idx = known.unwrap_or_else(|| {
            self.gates.push((observation.sensor, UpdateGate::new(way_m, turn_rad)));
            self.gates.len() - 1
        });
        let Some((_, gate)) = self.gates.get_mut(idx) else { return Ok(false) };
        if !gate.is_open(map_from_base, field_of_view_rad) {
            return Ok(false);
        }
        self.kept = Map::default();
        let inserted = self.mapper.insert(
            &pushed(scan, self.settings.mapper.pyramid.resolution_m),
            map_from_base,
            &observation.base_from_sensor,
            map,
        )?;
        if matches!(inserted, Inserted::Empty | Inserted::Beside) {
            return Ok(false);
        }
        gate.close(map_from_base);
        self.counters.inserted += 1;
        map.touch();
        Ok(true)
    }
}
