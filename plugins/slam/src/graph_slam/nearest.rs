//! Which point of a surface is nearest? A table of small squares that each know the answer.

use super::surface::SurfacePoint;

/// Points of a surface, and for each square of a table the one nearest to its middle.
#[derive(Debug, Clone, Default)]
pub(crate) struct NearestTable {
    points: Vec<SurfacePoint>,
    corner: [f32; 2],
    width: usize,
    height: usize,
    owners: Vec<u32>,
    squares: Vec<f32>,
}

const NOBODY: u32 = u32::MAX;
/// Edge of a square, meters: along a wall its nearest point may be half as far off, across it that makes no difference.
const SQUARE_M: f32 = 0.1;
/// Squares farther from a point than this do not know it, meters.
const REACH_M: f32 = 0.5;
/// Farther from the first point than this there are no squares, meters.
const FARTHEST_M: f32 = 60.0;

impl NearestTable {
    /// Replaces the points.
    pub fn fill(&mut self, points: impl Iterator<Item = SurfacePoint>) {
        self.points.clear();
        self.points.extend(points);
        let (mut low, mut high) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
        let near = |point: &&SurfacePoint| point.at.iter().all(|v| v.abs() < FARTHEST_M);
        for point in self.points.iter().filter(near) {
            for axis in 0..2 {
                low[axis] = low[axis].min(point.at[axis]);
                high[axis] = high[axis].max(point.at[axis]);
            }
        }
        if low[0] > high[0] {
            (self.width, self.height) = (0, 0);
            return;
        }
        self.corner = low.map(|v| v - REACH_M);
        let n_squares = |axis: usize| ((high[axis] - low[axis] + 2.0 * REACH_M) / SQUARE_M) as usize + 1;
        (self.width, self.height) = (n_squares(0), n_squares(1));
        self.owners.clear();
        self.owners.resize(self.width * self.height, NOBODY);
        self.squares.clear();
        self.squares.resize(self.width * self.height, REACH_M * REACH_M);
        for idx in 0..self.points.len() {
            self.spread(idx);
        }
    }

    fn spread(&mut self, idx: usize) {
        let Some(point) = self.points.get(idx) else { return };
        let place = [0, 1].map(|axis| (point.at[axis] - self.corner[axis]) / SQUARE_M - 0.5);
        let reach = REACH_M / SQUARE_M;
        let span = |axis: usize, n: usize| {
            let first = (place[axis] - reach).ceil().clamp(0.0, n as f32) as usize;
            let end = ((place[axis] + reach).floor() + 1.0).clamp(0.0, n as f32) as usize;
            first..end
        };
        for row in span(1, self.height) {
            let dy = (row as f32 - place[1]) * SQUARE_M;
            for col in span(0, self.width) {
                let dx = (col as f32 - place[0]) * SQUARE_M;
                let (square, at) = (dx * dx + dy * dy, row * self.width + col);
                if let (Some(least), Some(owner)) = (self.squares.get_mut(at), self.owners.get_mut(at))
                    && square < *least
                {
                    *least = square;
                    *owner = idx as u32;
                }
            }
        }
    }

    /// The point nearest to a place, or one that is hardly farther.
    pub fn at(&self, place: [f32; 2]) -> Option<&SurfacePoint> {
        let [x, y] = [0, 1].map(|axis| (place[axis] - self.corner[axis]) / SQUARE_M);
        let is_inside = x >= 0.0 && y >= 0.0 && x < self.width as f32 && y < self.height as f32;
        let owner = self.owners.get(is_inside.then(|| y as usize * self.width + x as usize)?)?;
        self.points.get(*owner as usize)
    }

    /// All points.
    #[cfg(test)]
    pub fn points(&self) -> &[SurfacePoint] {
        &self.points
    }
}
