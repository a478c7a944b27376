//! Random ways through the shipped office of 29 m by 24 m: doors 1 m wide, goals as near as 0.5 m to walls.

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rumbo_core::frames::Point2;
use rumbo_core::map::{Grid, Map};
use rumbo_core::messages::Path;
use rumbo_core::stages::Planner;
use rumbo_kit::GridSize;
use rumbo_kit::distance_field::squared_distance_field;
use rumbo_kit::map_file::{DEFAULT_MAX_CELLS, MapImage, load_map};

/// Distance from obstacles at which ways begin and end, meters.
const STAND_M: f64 = 0.5;
/// Straight distance from the start to the goal, meters.
const WAY_M: [f64; 2] = [8.0, 30.0];

/// The office.
pub struct Office {
    image: MapImage,
    /// For plan requests.
    pub map: Map,
    size: GridSize,
    /// Cells in which a way may begin or end.
    stands: Vec<usize>,
}

impl Office {
    pub fn load() -> Office {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../pipelines/worlds");
        let file = std::path::Path::new(folder).join("natural_landmark_20x20.yaml");
        let image = load_map(&file, DEFAULT_MAX_CELLS).unwrap();
        let mut grid = Grid::unknown(image.width as u32, image.height as u32, image.resolution_m).unwrap();
        let marked: Vec<u8> = image.cells.iter().map(|percent| u8::from(*percent > 50)).collect();
        for (odds, is_marked) in grid.cells.make_mut().iter_mut().zip(&marked) {
            *odds = if *is_marked == 1 { Grid::CERTAIN } else { -Grid::CERTAIN };
        }
        let size = GridSize::new(image.width, image.height);
        // Half a cell more than from middle to middle.
        let least = (STAND_M / image.resolution_m + 0.5).powi(2);
        let field = squared_distance_field(size, &marked);
        let stands = (0..size.n_cells()).filter(|cell| f64::from(field[*cell]) >= least).collect();
        let map = Map { version: 1, grid: Some(grid), ..Map::default() };
        Office { image, map, size, stands }
    }

    /// Random starts and goals that a way joins: this planner finds one.
    pub fn queries(&self, n: usize, seed: u64, reaches: &mut dyn Planner) -> Vec<[Point2; 2]> {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let middle = |cell: usize| {
            let (col, row) = self.size.col_row(cell);
            Point2::new(col as f64 + 0.5, row as f64 + 0.5) * self.image.resolution_m
        };
        let mut queries = Vec::new();
        while queries.len() < n {
            let mut place = || middle(self.stands[rng.random_range(0..self.stands.len())]);
            let [start, goal] = [place(), place()];
            let is_long = (WAY_M[0]..WAY_M[1]).contains(&(goal - start).norm());
            if is_long && reaches.plan(&super::queries::request(&self.map, start, goal)).is_ok() {
                queries.push([start, goal]);
            }
        }
        queries
    }

    /// Smallest distance of a path to the square of any marked cell, all cells looked at, meters.
    #[allow(dead_code)]
    pub fn clearance_m(&self, path: &Path) -> f64 {
        let cell_m = self.image.resolution_m;
        let marked: Vec<Point2> = (0..self.size.n_cells())
            .filter(|cell| self.image.cells[*cell] > 50)
            .map(|cell| self.size.col_row(cell))
            .map(|(col, row)| Point2::new(col as f64, row as f64) * cell_m)
            .collect();
        let to_square = |at: Point2, low: &Point2| {
            let outside = |v: f64, low: f64| (low - v).max(v - low - cell_m).max(0.0);
            outside(at.x, low.x).hypot(outside(at.y, low.y))
        };
        let mut least_m = f64::INFINITY;
        for leg in path.points().windows(2) {
            let along = leg[1].position - leg[0].position;
            let n = (along.norm() / 0.1).ceil().max(1.0) as usize;
            for k in 0..=n {
                let at = leg[0].position + along * (k as f64 / n as f64);
                let nearest = marked.iter().map(|low| to_square(at, low));
                least_m = nearest.fold(least_m, f64::min);
            }
        }
        least_m
    }
}

#[cfg(test)]
mod tests {
    use super::Office;
    use crate::queries::request;
    use rumbo_core::registry::Plugin;
    use rumbo_core::stages::{BuildContext, PlanError};
    use rumbo_planners::a_star::AStarParams;
    use rumbo_planners::fictitious_charges::FictitiousChargesParams;

    #[test]
    fn an_office_with_doors_is_crossed_with_the_clearance_kept() {
        let office = Office::load();
        let context = BuildContext::bare("planner");
        let shortest = AStarParams { clearance_m: Some(0.3), ..AStarParams::default() };
        let queries = office.queries(40, 1986, &mut *shortest.build(&context).unwrap());
        let published = FictitiousChargesParams { attempts: 1, ..FictitiousChargesParams::default() };
        let mut published = published.build(&context).unwrap();
        let mut planner = FictitiousChargesParams::default().build(&context).unwrap();
        for [start, goal] in queries {
            let request = request(&office.map, start, goal);
            let path = planner.plan(&request).unwrap_or_else(|e| panic!("from {start} to {goal}: {e}"));
            assert_eq!((path.points()[0].position, path.end().position), (start, goal));
            assert!(office.clearance_m(&path) >= 0.3 - 1e-9, "from {start} to {goal}");
            // The lengths of a hall lead through none of these doors.
            let answer = published.plan(&request);
            let is_named = matches!(answer, Err(PlanError::Stuck { .. } | PlanError::GoalTooClose { .. }));
            assert!(is_named, "from {start} to {goal}: {answer:?}");
        }
    }
}
