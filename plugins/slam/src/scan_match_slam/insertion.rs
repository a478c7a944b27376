//! Which scans become part of the map, and how.

use super::settings::TrackerSettings;
use super::tracker::ScanTracker;
use rumbo_core::frames::{Point2, Pose2, pose2};
use rumbo_core::map::{Grid, GridFault, GridHeader, Map};
use rumbo_core::messages::{LaserScan, Observation};
use rumbo_kit::occupancy::{Inserted, UpdateGate};
use rumbo_kit::scan_match::{MatchStatus, SurfaceMap};

/// Directions that a scan does not see must be known this well from before, meters (the specification's bound).
const MOST_BLIND_DEVIATION_M: f64 = 0.1;
/// And this well where something that is seen for the first time shows them, unless nobody knows them anyway, meters.
const MOST_UNSHOWN_M: f64 = 0.5;

/// How the levels are turned against the robot that begins. Walls are mostly along or across its heading, and one along a
/// row of cells does not tell where in the row it lies: matches would be off by half a cell.
const AXES_RAD: f64 = -std::f64::consts::FRAC_PI_4;
/// The robot begins so far from a corner of cells along both axes: nothing that is round in meters lies on an edge.
const CORNER_CELLS: f64 = -0.29;

/// Lays the levels by the robot's pose: matches do not depend on how the map's frame happens to be turned, and in a mirror
/// they are the same in the mirror.
fn lay_levels(settings: &TrackerSettings, map_from_base: &Pose2, levels: &mut Map) -> Result<(), GridFault> {
    let pyramid = settings.mapper.pyramid;
    pyramid.lay(levels, settings.size_cells, Point2::origin(), [0.5, 0.5])?;
    let aside_m = CORNER_CELLS * pyramid.resolution_m;
    for grid in levels.grid.iter_mut().chain(&mut levels.coarse_grids) {
        let [x, y, yaw] = grid.header().origin;
        let base_from_grid = pose2(0.0, 0.0, AXES_RAD) * pose2(x + aside_m, y + aside_m, yaw);
        let map_from_grid = map_from_base * base_from_grid;
        let origin =
            [map_from_grid.translation.x, map_from_grid.translation.y, map_from_grid.rotation.angle()];
        *grid = Grid::new(GridHeader { origin, ..*grid.header() }, grid.cells.clone())?;
    }
    levels.touch();
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
    /// Empty levels, and an empty map with the axes of its frame, around the robot.
    pub(super) fn lay(&mut self, map_from_base: &Pose2, map: &mut Map) -> Result<(), GridFault> {
        lay_levels(&self.settings, map_from_base, &mut self.levels)?;
        let finest = self.levels.grid.as_ref().filter(|_| self.settings.polish.is_some());
        self.surfaces = finest.map(|grid| SurfaceMap::new(grid.resolution_m(), grid.grid_from_map()));
        let around = Point2::from(map_from_base.translation.vector);
        self.drawer.pyramid().lay(map, self.settings.size_cells, around, [0.5, 0.5])
    }

    /// What did not match becomes part of the map only where the map ends: not far from where it matched last, or where
    /// a robot is that was looked for on the whole map in vain. What was not seen must be known from before.
    pub(super) fn may_insert(&self) -> bool {
        match self.status {
            MatchStatus::Ok => true,
            MatchStatus::Degenerate => {
                // What is seen for the first time shows the way from now on.
                let shows_new = self.points.blind().is_some() && self.shows_all();
                let may_be_far = self.sure_levels.is_some() || self.blind_deviation_m <= MOST_UNSHOWN_M;
                self.blind_deviation_m <= MOST_BLIND_DEVIATION_M || shows_new && may_be_far
            }
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
        let pushed = pushed(scan, self.settings.mapper.pyramid.resolution_m);
        let inserted =
            self.mapper.insert(&pushed, map_from_base, &observation.base_from_sensor, &mut self.levels)?;
        if matches!(inserted, Inserted::Empty | Inserted::Beside) {
            return Ok(false);
        }
        gate.close(map_from_base);
        if let Some(surfaces) = &mut self.surfaces {
            surfaces.insert(&self.points, map_from_base);
        }
        self.levels.touch();
        // Nobody else holds the cells while they are written, so that they are not copied.
        self.drawn = None;
        self.drawer.insert(scan, map_from_base, &observation.base_from_sensor, map)?;
        self.counters.inserted += 1;
        map.touch();
        Ok(true)
    }
}
