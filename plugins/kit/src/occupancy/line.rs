//! The cells of a straight line (Bresenham, 1965), clipped to a grid.

use crate::GridSize;

/// Calls `visit` with the index of every cell from `from` (inside the grid) to `to`, the end left out, until the line
/// leaves the grid.
pub fn line_cells(size: GridSize, from: [i32; 2], to: [i32; 2], mut visit: impl FnMut(usize)) {
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let (along_x, n) = (dx.abs() >= dy.abs(), dx.abs().max(dy.abs()));
    let (major, minor) = if along_x { (dx.signum(), dy.signum()) } else { (dy.signum(), dx.signum()) };
    let slope = if along_x { dy.abs() } else { dx.abs() };
    let (mut col, mut row, mut error) = (from[0], from[1], n / 2);
    let (width, height) = (size.width as i32, size.height as i32);
    for _ in 0..n {
        if col < 0 || row < 0 || col >= width || row >= height {
            return;
        }
        visit(size.index(col as usize, row as usize));
        error += slope;
        let aside = error >= n;
        if aside {
            error -= n;
        }
        let (step_major, step_minor) = (major, if aside { minor } else { 0 });
        if along_x {
            col += step_major;
            row += step_minor;
        } else {
            row += step_major;
            col += step_minor;
        }
    }
}
