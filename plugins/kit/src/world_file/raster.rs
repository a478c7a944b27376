//! A world without a background picture, as a map: what is `mapped` becomes occupied cells or lines.

use crate::map_file::MapImage;

use super::WorldScene;

/// Straight outlines of everything mapped, as `[from, to]` pairs; boxes give their four sides.
pub fn mapped_outlines(scene: &WorldScene) -> Vec<[[f64; 2]; 2]> {
    let walls = scene.walls.iter().filter(|wall| wall.mapped).map(|wall| [wall.from, wall.to]);
    let boxes = scene.boxes.iter().filter(|solid| solid.mapped).flat_map(|solid| {
        let corners = solid.corners();
        (0..4).map(move |idx| [corners[idx], corners[(idx + 1) % 4]])
    });
    walls.chain(boxes).collect()
}

/// Calls `visit(col, row)` for every cell of the unit lattice that the segment touches, widened by `margin` cells.
///
/// With a margin of 0 cells are half-open, so a segment on a cell edge belongs to the upper cell only.
pub fn segment_cells(from: [f64; 2], to: [f64; 2], margin: f64, mut visit: impl FnMut(i64, i64)) {
    let ([x0, y0], [x1, y1]) = if from[0] <= to[0] { (from, to) } else { (to, from) };
    let slope = if x1 > x0 { (y1 - y0) / (x1 - x0) } else { 0.0 };
    for col in (x0 - margin).floor() as i64..=(x1 + margin).floor() as i64 {
        let (low, high) = if x1 > x0 {
            let left = (col as f64 - margin).clamp(x0, x1);
            let right = ((col + 1) as f64 + margin).clamp(x0, x1);
            let (at_left, at_right) = (y0 + slope * (left - x0), y0 + slope * (right - x0));
            (at_left.min(at_right), at_left.max(at_right))
        } else {
            (y0.min(y1), y0.max(y1))
        };
        for row in (low - margin).floor() as i64..=(high + margin).floor() as i64 {
            visit(col, row);
        }
    }
}

/// A blank map that covers the bounds (or all outlines) and one cell around them, with everything mapped drawn in it.
/// `None` when that takes more than `max_cells` cells, or when there is nothing to cover.
pub fn raster_map(scene: &WorldScene, resolution_m: f64, max_cells: u64) -> Option<MapImage> {
    let mut bounds =
        scene.bounds.unwrap_or([f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY]);
    for [x, y] in mapped_outlines(scene).iter().flatten() {
        bounds = [bounds[0].min(*x), bounds[1].min(*y), bounds[2].max(*x), bounds[3].max(*y)];
    }
    if !bounds.iter().all(|bound| bound.is_finite()) {
        return None;
    }
    let n_cells = |length_m: f64| (length_m / resolution_m - 1e-9).ceil().max(0.0) + 3.0;
    let (width, height) = (n_cells(bounds[2] - bounds[0]), n_cells(bounds[3] - bounds[1]));
    if width * height > max_cells as f64 {
        return None;
    }
    let (width, height) = (width as usize, height as usize);
    let origin = [bounds[0] - resolution_m, bounds[1] - resolution_m, 0.0];
    let mut map = MapImage { width, height, resolution_m, origin, cells: vec![0; width * height] };
    draw_mapped(scene, &mut map);
    Some(map)
}

/// Draws everything mapped as occupied cells; what lies beside the map is left out.
pub fn draw_mapped(scene: &WorldScene, map: &mut MapImage) {
    let [origin_x, origin_y, yaw] = map.origin;
    let (sin, cos) = yaw.sin_cos();
    // The nudge keeps an edge that lies on a cell border, give or take rounding, in one row of cells.
    let to_cells = |[x, y]: [f64; 2]| {
        let (x, y) = (x - origin_x, y - origin_y);
        [cos * x + sin * y, cos * y - sin * x].map(|length_m| length_m / map.resolution_m + 1e-9)
    };
    let (width, height) = (map.width, map.height);
    let cells = &mut map.cells;
    let mut fill = |col: i64, row: i64| {
        if (0..width as i64).contains(&col) && (0..height as i64).contains(&row) {
            cells[row as usize * width + col as usize] = 100;
        }
    };
    for [from, to] in mapped_outlines(scene) {
        segment_cells(to_cells(from), to_cells(to), 0.0, &mut fill);
    }
    for solid in scene.boxes.iter().filter(|solid| solid.mapped) {
        let center = to_cells(solid.center);
        let half = solid.size.map(|edge| edge / 2.0 / map.resolution_m);
        let reach = half[0].hypot(half[1]);
        let range = |middle: f64, n: usize| {
            ((middle - reach).floor() as i64).max(0)..=((middle + reach).floor() as i64).min(n as i64 - 1)
        };
        let (sin, cos) = (solid.yaw_rad - yaw).sin_cos();
        for (row, col) in
            range(center[1], height).flat_map(|row| range(center[0], width).map(move |col| (row, col)))
        {
            let (x, y) = (col as f64 + 0.5 - center[0], row as f64 + 0.5 - center[1]);
            if (cos * x + sin * y).abs() <= half[0] && (cos * y - sin * x).abs() <= half[1] {
                fill(col, row);
            }
        }
    }
}
