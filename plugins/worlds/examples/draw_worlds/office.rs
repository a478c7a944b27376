//! An office floor of 29 m by 24 m: two corridors of 2 m, joined by two passages, and eleven rooms around them.
//!
//! ```text
//! 24 ┌────────┬────────┬───────┬────────┐
//!    │ R1     │ R2     │ R3    │ R4     │
//! 17 ├──  ────┴─  ─────┴──  ───┴──  ────┤
//!    │              upper corridor      │
//! 15 ├───────┬──┬────  ──┬──┬───────────┤
//!    │ M1       │   M2   │     M3       │
//!  9 ├──  ───┴──┴─  ─────┴──┴───  ──────┤
//!    │              lower corridor      │
//!  7 ├──  ──┬─  ──┬──  ──┬──  ─┬──  ────┤
//!    │ S1   │ S2  │ S3   │ S4  │ S5     │
//!  0 └──────┴─────┴──────┴─────┴────────┘
//! ```

use rumbo_kit::map_file::MapImage;

const WIDTH_M: f64 = 29.0;
const HEIGHT_M: f64 = 24.0;
const CELL_M: f64 = 0.05;
const DOOR_M: f64 = 1.0;

struct Floor(MapImage);

impl Floor {
    /// Fills a rectangle given by two corners.
    fn fill(&mut self, [x0, y0, x1, y1]: [f64; 4], percent: i8) {
        let cell = |length_m: f64| (length_m / CELL_M).round() as usize;
        for row in cell(y0)..cell(y1).min(self.0.height) {
            for col in cell(x0)..cell(x1).min(self.0.width) {
                self.0.cells[row * self.0.width + col] = percent;
            }
        }
    }

    fn wall(&mut self, corners: [f64; 4]) {
        self.fill(corners, 100);
    }

    /// Opens a door in a wall that runs along x, between `y0` and `y1`, beginning at `x`.
    fn door(&mut self, x: f64, y0: f64, y1: f64) {
        self.fill([x, y0, x + DOOR_M, y1], 0);
    }

    /// Something that stands around, by its lower left corner and size.
    fn furniture(&mut self, things: &[[f64; 4]]) {
        for &[x, y, length_m, width_m] in things {
            self.wall([x, y, x + length_m, y + width_m]);
        }
    }
}

/// Draws the floor.
pub fn draw() -> MapImage {
    let (width, height) = ((WIDTH_M / CELL_M).round() as usize, (HEIGHT_M / CELL_M).round() as usize);
    let cells = vec![0; width * height];
    let mut floor = Floor(MapImage { width, height, resolution_m: CELL_M, origin: [0.0; 3], cells });
    outer_walls(&mut floor);
    south_rooms(&mut floor);
    middle_rooms(&mut floor);
    north_rooms(&mut floor);
    corridors(&mut floor);
    floor.0
}

fn outer_walls(floor: &mut Floor) {
    floor.wall([0.0, 0.0, WIDTH_M, 0.2]);
    floor.wall([0.0, HEIGHT_M - 0.2, WIDTH_M, HEIGHT_M]);
    floor.wall([0.0, 0.0, 0.2, HEIGHT_M]);
    floor.wall([WIDTH_M - 0.2, 0.0, WIDTH_M, HEIGHT_M]);
}

fn south_rooms(floor: &mut Floor) {
    floor.wall([0.0, 6.9, WIDTH_M, 7.0]);
    for x in [5.8, 10.9, 17.4, 23.1] {
        floor.wall([x, 0.0, x + 0.1, 7.0]);
    }
    for x in [2.6, 7.1, 15.2, 19.0, 26.3] {
        floor.door(x, 6.9, 7.0);
    }
    floor.furniture(&[
        // S1: a desk under the window, a cabinet, a low shelf.
        [3.6, 0.2, 1.4, 0.7],
        [0.2, 5.2, 0.4, 1.2],
        [5.0, 4.0, 0.8, 0.4],
        // S2: two desks face to face, a cabinet.
        [7.2, 2.0, 1.4, 1.4],
        [5.9, 5.6, 0.5, 1.0],
        [10.3, 0.2, 0.6, 1.6],
        // S3: a meeting table.
        [12.8, 2.6, 2.8, 1.2],
        [11.0, 0.2, 0.4, 2.0],
        [16.9, 5.0, 0.5, 1.2],
        // S4: a desk, a copier.
        [20.4, 0.2, 1.4, 0.7],
        [17.5, 3.2, 0.7, 0.9],
        [22.4, 4.6, 0.7, 1.4],
        // S5: two desks and a round table, as a square.
        [24.6, 0.2, 1.6, 0.8],
        [28.0, 2.4, 0.8, 1.6],
        [25.4, 3.4, 0.9, 0.9],
    ]);
}

fn middle_rooms(floor: &mut Floor) {
    for [x0, x1] in [[0.0, 9.0], [11.0, 19.0], [21.0, WIDTH_M]] {
        floor.wall([x0, 9.0, x1, 9.1]);
        floor.wall([x0, 14.9, x1, 15.0]);
    }
    for x in [8.9, 11.0, 18.9, 21.0] {
        floor.wall([x, 9.0, x + 0.1, 15.0]);
    }
    // M1 opens to the lower corridor, M2 to both, M3 to the lower one.
    floor.door(3.4, 9.0, 9.1);
    floor.door(13.2, 9.0, 9.1);
    floor.door(16.8, 14.9, 15.0);
    floor.door(25.4, 9.0, 9.1);
    floor.furniture(&[
        [0.2, 11.6, 0.7, 1.4],
        [5.2, 13.4, 1.4, 0.7],
        [6.4, 10.4, 1.2, 0.8],
        [11.1, 12.4, 0.6, 1.8],
        [17.4, 10.0, 1.2, 0.8],
        [13.0, 14.3, 1.6, 0.6],
        [22.4, 13.0, 1.4, 0.7],
        [27.2, 10.6, 1.6, 0.6],
        [23.8, 10.2, 0.6, 0.6],
    ]);
}

fn north_rooms(floor: &mut Floor) {
    floor.wall([0.0, 17.0, WIDTH_M, 17.1]);
    for x in [7.6, 14.4, 21.9] {
        floor.wall([x, 17.0, x + 0.1, HEIGHT_M]);
    }
    for x in [4.8, 9.2, 18.6, 24.0] {
        floor.door(x, 17.0, 17.1);
    }
    floor.furniture(&[
        // R1: a long table.
        [1.6, 20.2, 3.2, 1.2],
        [7.0, 18.4, 0.6, 1.4],
        // R2: desks along the wall.
        [8.6, 23.1, 1.4, 0.7],
        [11.6, 23.1, 1.4, 0.7],
        [12.8, 18.0, 0.8, 1.6],
        // R3: four desks as a block, a cabinet.
        [16.6, 20.6, 2.8, 1.4],
        [14.5, 18.2, 0.4, 1.6],
        // R4: a kitchen counter and a table.
        [22.8, 23.2, 4.0, 0.6],
        [26.0, 19.4, 1.2, 1.2],
    ]);
}

fn corridors(floor: &mut Floor) {
    floor.furniture(&[
        // A plant, a bench, a printer, a cabinet: each leaves more than a meter beside it.
        [0.2, 8.6, 0.4, 0.4],
        [21.6, 8.6, 1.6, 0.4],
        [6.4, 15.0, 0.6, 0.5],
        [27.6, 16.5, 1.2, 0.5],
    ]);
}
