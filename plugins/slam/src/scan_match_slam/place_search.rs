//! Where on the map is this scan? For starts far off, and for a robot that is lost.

use rumbo_core::frames::{Point2, Pose2};
use rumbo_core::map::{CellClass, Map};
use rumbo_kit::GridSize;
use rumbo_kit::correlative::{
    Apart, CorrelativeMatch, CorrelativeSearch, FitTable, SearchGaveUp, SearchWindow, turn_step_rad,
};
use rumbo_kit::scan_match::ScanPoints;

/// How to search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaceSearchSettings {
    /// A place fits from this mean value on.
    pub least_score: f64,
    /// The next best place must fit worse by this.
    pub least_lead: f64,
    /// Poses are looked at so many times at most.
    pub most_nodes: usize,
    /// Spread of a wall, meters.
    pub sigma_m: f64,
    /// Of all points, so many are looked at.
    pub most_points: usize,
}

/// A place that looks alike within this distance is the same.
const SAME_PLACE_M: f64 = 0.7;
/// And within this turn.
const SAME_PLACE_RAD: f64 = 0.35;
/// Levels of the table: squares up to 128 cells.
const N_LEVELS: usize = 8;

/// Searches a level of the map, and keeps what it made of it until the map changes.
#[derive(Debug, Clone)]
pub struct PlaceSearch {
    settings: PlaceSearchSettings,
    search: CorrelativeSearch,
    table: Option<(u64, FitTable)>,
    points: Vec<Point2>,
}

impl PlaceSearch {
    /// Nothing is prepared yet.
    pub fn new(settings: PlaceSearchSettings) -> PlaceSearch {
        PlaceSearch { settings, search: CorrelativeSearch::default(), table: None, points: Vec::new() }
    }

    /// The best pose around a guess, if it fits; it need not be the only one.
    pub fn near(&mut self, map: &Map, points: &ScanPoints, guess: &Pose2, reach: [f64; 2]) -> Option<Pose2> {
        let least_score = self.settings.least_score;
        let found = self.best(map, points, guess, reach, least_score, None).ok().flatten();
        found.map(|found| found.grid_from_base)
    }

    /// The one pose on the whole map that fits.
    pub fn anywhere(&mut self, map: &Map, points: &ScanPoints) -> Option<Pose2> {
        let grid = map.grid.as_ref()?;
        let (columns, rows) = grid.known_extent()?;
        let middle =
            |range: &std::ops::Range<u32>| 0.5 * f64::from(range.start + range.end) * grid.resolution_m();
        let reach_m = 0.5 * columns.len().max(rows.len()) as f64 * grid.resolution_m();
        let center = grid.map_from_grid() * Point2::new(middle(&columns), middle(&rows));
        let guess = rumbo_core::frames::pose2(center.x, center.y, 0.0);
        let reach = [reach_m, std::f64::consts::PI];
        let least_score = self.settings.least_score;
        let first = self.best(map, points, &guess, reach, least_score, None).ok().flatten()?;
        let apart = Apart {
            grid_from_base: map.grid.as_ref()?.grid_from_map() * first.grid_from_base,
            distance_m: SAME_PLACE_M,
            turn_rad: SAME_PLACE_RAD,
        };
        let rival_score = first.score - self.settings.least_lead;
        // Who gave up has not shown that there is no rival.
        let rival = self.best(map, points, &guess, reach, rival_score, Some(&apart)).ok()?;
        rival.is_none().then_some(first.grid_from_base)
    }

    /// With the pose in the map's frame.
    fn best(
        &mut self,
        map: &Map,
        points: &ScanPoints,
        guess: &Pose2,
        reach: [f64; 2],
        least_score: f64,
        apart: Option<&Apart>,
    ) -> Result<Option<CorrelativeMatch>, SearchGaveUp> {
        // Twice the edge of the finest cells: a quarter of the poses, and still well within reach of the matcher.
        let Some(grid) = map.coarse_grids.first().or(map.grid.as_ref()) else { return Ok(None) };
        if self.table.as_ref().is_none_or(|(version, _)| *version != map.version) {
            let size = GridSize::new(grid.width() as usize, grid.height() as usize);
            let is_wall = |v: &f32| u8::from(grid.class_of(*v) == CellClass::Occupied);
            let marks: Vec<u8> = grid.cells.iter().map(is_wall).collect();
            let sigma_m = self.settings.sigma_m.max(grid.resolution_m());
            let table = FitTable::around_marks(size, grid.resolution_m(), &marks, sigma_m, N_LEVELS);
            self.table = Some((map.version, table));
        }
        let Some((_, table)) = self.table.as_ref() else { return Ok(None) };
        let every = points.len().div_ceil(self.settings.most_points.max(1)).max(1);
        self.points.clear();
        self.points.extend(points.iter().step_by(every).map(|[x, y, _]| Point2::new(x.into(), y.into())));
        let window = SearchWindow {
            grid_from_base: grid.grid_from_map() * guess,
            reach_m: reach[0],
            reach_rad: reach[1],
            step_rad: turn_step_rad(&self.points, grid.resolution_m()),
            least_score,
            most_nodes: self.settings.most_nodes,
        };
        let mut found = self.search.best(table, &self.points, &window, apart)?;
        if let Some(found) = &mut found {
            found.grid_from_base = grid.map_from_grid() * found.grid_from_base;
        }
        Ok(found)
    }
}
