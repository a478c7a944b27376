//! Hall of 30 m x 20 m with six columns: 28 lines.

use rumbo_core::map::Line;

/// The walls.
#[derive(Debug, Clone)]
pub struct Hall {
    /// Each to the left of the way from its first end to its second.
    pub lines: Vec<Line>,
}

/// Width and height of the hall, and edge of a column, meters.
const SIZE: [f64; 2] = [30.0, 20.0];
const COLUMN: f64 = 0.8;
const CENTERS: [[f64; 2]; 6] =
    [[5.0, 4.0], [15.0, 2.5], [25.0, 4.0], [5.0, 16.0], [15.0, 17.5], [25.0, 16.0]];

/// The hall of the experiment.
pub fn hall() -> Hall {
    let mut corners = vec![vec![[0.0, 0.0], [0.0, SIZE[1]], SIZE, [SIZE[0], 0.0]]];
    for [x, y] in CENTERS {
        let h = COLUMN / 2.0;
        corners.push(vec![[x - h, y - h], [x + h, y - h], [x + h, y + h], [x - h, y + h]]);
    }
    let mut lines = Vec::new();
    for ring in corners {
        for (k, from) in ring.iter().enumerate() {
            lines.push(Line { from: *from, to: ring[(k + 1) % ring.len()], covariance: [0.0; 3] });
        }
    }
    Hall { lines }
}

impl Hall {
    /// Range to the first wall in a direction, meters.
    pub fn range_m(&self, [x, y]: [f64; 2], heading_rad: f64) -> f64 {
        let (sin, cos) = heading_rad.sin_cos();
        let range = |line: &Line| {
            let (ax, ay) = (line.from[0] - x, line.from[1] - y);
            let (dx, dy) = (line.to[0] - line.from[0], line.to[1] - line.from[1]);
            let cross = cos * dy - sin * dx;
            if cross == 0.0 {
                return f64::INFINITY;
            }
            let (range, share) = ((ax * dy - ay * dx) / cross, (ax * sin - ay * cos) / cross);
            if range > 0.0 && (0.0..=1.0).contains(&share) { range } else { f64::INFINITY }
        };
        self.lines.iter().map(range).fold(f64::INFINITY, f64::min)
    }
}
