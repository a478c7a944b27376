//! What the map explains: readings that an occupied cell of the grid accounts for.

use nalgebra::Vector2;
use rumbo_core::frames::{Point2, wrap_angle};
use rumbo_core::map::{Cell, CellClass, Grid};

/// An occupied cell lies within `within_m` of the point, measured to the nearest point of the cell.
pub fn is_near_occupied(grid: &Grid, point: Point2, within_m: f64) -> bool {
    let mut cells = occupied_cells(grid, point, within_m);
    cells.any(|cell| (nearest_of_cell(grid, cell, point) - grid.grid_from_map() * point).norm() <= within_m)
}

/// An occupied cell lies in the cone, not farther than `reach_m` from its tip: the nearest echo that a ray traced in the
/// map would give there is not longer.
pub fn is_occupied_in_cone(
    grid: &Grid,
    tip: Point2,
    axis_rad: f64,
    half_opening_rad: f64,
    reach_m: f64,
) -> bool {
    let tip_in_grid = grid.grid_from_map() * tip;
    let axis_in_grid_rad = axis_rad + grid.grid_from_map().rotation.angle();
    let edges = [-half_opening_rad, half_opening_rad].map(|off_rad| {
        let (sin, cos) = (axis_in_grid_rad + off_rad).sin_cos();
        Vector2::new(cos, sin)
    });
    occupied_cells(grid, tip, reach_m).any(|cell| {
        // The nearest point of cell and cone together is the cell's own, or lies on an edge of the cone.
        let to_nearest = nearest_of_cell(grid, cell, tip) - tip_in_grid;
        let off_rad = wrap_angle(to_nearest.y.atan2(to_nearest.x) - axis_in_grid_rad);
        let inside = off_rad.abs() <= half_opening_rad || to_nearest.norm() <= 0.0;
        (inside && to_nearest.norm() <= reach_m)
            || edges.iter().any(|edge| meets_cell(grid, cell, tip_in_grid, *edge, reach_m))
    })
}

/// A ray of the grid's frame meets a cell within `reach_m` (slab method: Kay and Kajiya 1986).
fn meets_cell(grid: &Grid, cell: Cell, from: Point2, direction: Vector2<f64>, reach_m: f64) -> bool {
    let edge_m = grid.resolution_m();
    let (mut enters_m, mut leaves_m) = (0.0f64, reach_m);
    for (at, step, count) in [(from.x, direction.x, cell.col), (from.y, direction.y, cell.row)] {
        let low_m = f64::from(count) * edge_m - at;
        let (one, other) = (low_m / step, (low_m + edge_m) / step);
        // A ray along the slab gives infinities, or not-a-number on its border, which `max` and `min` ignore.
        enters_m = enters_m.max(one.min(other));
        leaves_m = leaves_m.min(one.max(other));
    }
    enters_m <= leaves_m
}

/// Occupied cells whose bounding box reaches within `reach_m` of a point of the map.
fn occupied_cells(grid: &Grid, point: Point2, reach_m: f64) -> impl Iterator<Item = Cell> {
    let in_grid = grid.grid_from_map() * point / grid.resolution_m();
    let reach = reach_m / grid.resolution_m();
    // Casts saturate: a box beside the grid is empty.
    let cols = (in_grid.x - reach).floor() as u32..((in_grid.x + reach).floor() + 1.0) as u32;
    let rows = (in_grid.y - reach).floor() as u32..((in_grid.y + reach).floor() + 1.0) as u32;
    let (width, height) = (grid.width(), grid.height());
    (rows.start..rows.end.min(height))
        .flat_map(move |row| (cols.start..cols.end.min(width)).map(move |col| Cell { col, row }))
        .filter(|cell| grid.class(*cell) == CellClass::Occupied)
}

/// The point of a closed cell that is nearest to a point of the map, in the grid's own frame.
fn nearest_of_cell(grid: &Grid, cell: Cell, point: Point2) -> Point2 {
    let (in_grid, edge_m) = (grid.grid_from_map() * point, grid.resolution_m());
    let (left, bottom) = (f64::from(cell.col) * edge_m, f64::from(cell.row) * edge_m);
    Point2::new(in_grid.x.clamp(left, left + edge_m), in_grid.y.clamp(bottom, bottom + edge_m))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_core::boundary::Buffer;
    use rumbo_core::map::GridHeader;

    /// 20 x 20 cells of 5 cm, turned by 0.5 rad, with cell (10, 8) occupied.
    fn one_cell() -> (Grid, Cell) {
        let header =
            GridHeader { origin: [1.0, -2.0, 0.5], ..*Grid::unknown(20, 20, 0.05).unwrap().header() };
        let cell = Cell { col: 10, row: 8 };
        let mut grid = Grid::new(header, Buffer::filled(400, -Grid::CERTAIN)).unwrap();
        let index = grid.index_of(cell);
        grid.cells.make_mut()[index] = Grid::CERTAIN;
        (grid, cell)
    }

    #[test]
    fn nearness_is_measured_to_the_edge_of_the_cell_on_every_side() {
        let (grid, cell) = one_cell();
        let middle_in_grid = grid.grid_from_map() * grid.center_of(cell);
        for (x, y) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
            let at = |off_m: f64| {
                let shifted = Point2::new(middle_in_grid.x + x * off_m, middle_in_grid.y + y * off_m);
                is_near_occupied(&grid, grid.map_from_grid() * shifted, 0.10)
            };
            assert!(at(0.1249) && !at(0.1251), "{x} {y}");
        }
        let corner = Point2::new(middle_in_grid.x + 0.025 + 0.08, middle_in_grid.y + 0.025 + 0.08);
        assert!(!is_near_occupied(&grid, grid.map_from_grid() * corner, 0.10), "0.113 m from the corner");
        assert!(!is_near_occupied(&grid, Point2::new(1e9, -1e9), 0.10));
    }

    #[test]
    fn a_cone_finds_a_cell_exactly_when_a_finely_traced_ray_does() {
        let (grid, cell) = one_cell();
        let target = grid.center_of(cell);
        let mut n_found = 0;
        for (step, distance_m) in (0..72).flat_map(|s| [0.04, 0.12, 0.3, 0.45].map(|d| (s, d))) {
            let angle = f64::from(step) * 5f64.to_radians();
            let tip = target - Vector2::new(angle.cos(), angle.sin()) * distance_m;
            for (off, reach) in [(0.0, 0.2), (0.15, 0.35), (-0.25, 0.5), (0.6, 0.5), (2.0, 0.5)] {
                let traced = traces(&grid, tip, angle + off, reach);
                let found = is_occupied_in_cone(&grid, tip, angle + off, 0.218, reach);
                // The slow twin misses what lies between its rays and steps.
                assert!(found || !traced, "{step} {distance_m} {off} {reach}");
                assert!(!found || traces_with(&grid, tip, angle + off, 0.222, reach + 0.003), "{step} {off}");
                n_found += u32::from(found);
            }
        }
        assert!(n_found > 300, "{n_found}");
    }

    fn traces(grid: &Grid, tip: Point2, axis: f64, reach: f64) -> bool {
        traces_with(grid, tip, axis, 0.216, reach - 0.002)
    }

    fn traces_with(grid: &Grid, tip: Point2, axis: f64, half: f64, reach: f64) -> bool {
        (-60..=60).any(|ray| {
            let angle = axis + half * f64::from(ray) / 60.0;
            (0..=500).any(|k| {
                let along = Vector2::new(angle.cos(), angle.sin()) * (reach * f64::from(k) / 500.0);
                grid.cell_at(tip + along).is_some_and(|cell| grid.class(cell) == CellClass::Occupied)
            })
        })
    }
}
