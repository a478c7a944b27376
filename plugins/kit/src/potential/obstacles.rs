//! Obstacles made of straight pieces, each obstacle with one nearest point.

use super::segment_index::SegmentIndex;
use nalgebra::{Point2, Vector2};

/// A straight piece of an obstacle; a point where both ends are the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// One end, meters.
    pub from: Point2<f64>,
    /// The other end.
    pub to: Point2<f64>,
    /// Half of its thickness, meters: a disc is a thick point.
    pub radius_m: f64,
}

impl Piece {
    /// A thin piece.
    pub fn between(from: Point2<f64>, to: Point2<f64>) -> Piece {
        Piece { from, to, radius_m: 0.0 }
    }
}

/// The pieces of one obstacle.
pub type Group = Vec<Piece>;

/// A piece with a number that is not finite, or a negative radius.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotFinite {
    /// Which obstacle.
    pub group: usize,
}

/// The point of an obstacle that is nearest to a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Which obstacle.
    pub group: u32,
    /// How far the place is from it, meters; negative inside a thick piece.
    pub distance_m: f64,
    /// From the obstacle to the place, of length one; zero on the line itself.
    pub away: Vector2<f64>,
}

/// Obstacles with an index for those within a reach.
#[derive(Clone, Debug)]
pub struct Obstacles {
    segments: Vec<Segment>,
    index: SegmentIndex,
    reach_m: f64,
}

#[derive(Clone, Copy, Debug)]
struct Segment {
    from: Point2<f64>,
    along: Vector2<f64>,
    /// Zero for a point.
    inverse_square: f64,
    radius_m: f64,
    group: u32,
}

impl Segment {
    fn new(piece: &Piece, group: u32) -> Segment {
        let along = piece.to - piece.from;
        let square = along.norm_squared();
        let inverse_square = if square > 0.0 { 1.0 / square } else { 0.0 };
        Segment { from: piece.from, along, inverse_square, radius_m: piece.radius_m, group }
    }

    /// From the nearest point of the piece's middle line.
    fn offset(&self, at: Point2<f64>) -> Vector2<f64> {
        let to_point = at - self.from;
        let t = (to_point.dot(&self.along) * self.inverse_square).clamp(0.0, 1.0);
        to_point - self.along * t
    }
}

impl Obstacles {
    /// Obstacles that are looked for within `reach_m`.
    ///
    /// # Errors
    /// The first obstacle with a number that is not finite.
    pub fn new(groups: &[Group], reach_m: f64) -> Result<Obstacles, NotFinite> {
        for (group, pieces) in groups.iter().enumerate() {
            let is_sound = |piece: &Piece| {
                let ends = piece.from.iter().chain(piece.to.iter());
                ends.chain([&piece.radius_m]).all(|v| v.abs() < 1e150) && piece.radius_m >= 0.0
            };
            if !pieces.iter().all(is_sound) {
                return Err(NotFinite { group });
            }
        }
        let numbered = (0_u32..).zip(groups);
        let segments: Vec<Segment> = numbered
            .flat_map(|(group, pieces)| pieces.iter().map(move |piece| Segment::new(piece, group)))
            .collect();
        let pieces: Vec<Piece> = groups.iter().flatten().copied().collect();
        Ok(Obstacles { index: SegmentIndex::new(&pieces, reach_m), segments, reach_m })
    }

    /// How far obstacles are looked for, meters.
    pub fn reach_m(&self) -> f64 {
        self.reach_m
    }

    /// Number of straight pieces.
    pub fn n_pieces(&self) -> usize {
        self.segments.len()
    }

    /// Entries of the index: its memory.
    pub fn n_index_entries(&self) -> usize {
        self.index.n_entries()
    }

    /// Lower and upper corner of the rectangle around all ends of pieces; none where there are none.
    pub fn bounds(&self) -> Option<(Point2<f64>, Point2<f64>)> {
        let ends = || self.segments.iter().flat_map(|segment| [segment.from, segment.from + segment.along]);
        let first = ends().next()?;
        let fold =
            |k: fn(f64, f64) -> f64| ends().fold(first, |all, p| Point2::new(k(all.x, p.x), k(all.y, p.y)));
        Some((fold(f64::min), fold(f64::max)))
    }

    /// Visits every obstacle within reach, in order, with its nearest point; among equals the first piece wins.
    #[inline]
    pub fn near(&self, at: Point2<f64>, mut visit: impl FnMut(Nearest)) {
        let mut best: Option<(u32, f64, Vector2<f64>)> = None;
        for &place in self.index.around(at) {
            let Some(segment) = self.segments.get(place as usize) else { continue };
            let offset = segment.offset(at);
            // Thin pieces need their root only when they win.
            let distance_m = offset.norm() - segment.radius_m;
            match &mut best {
                Some((group, least_m, nearest)) if *group == segment.group => {
                    if distance_m < *least_m {
                        (*least_m, *nearest) = (distance_m, offset);
                    }
                }
                _ => {
                    let done = best.replace((segment.group, distance_m, offset));
                    self.tell(done, &mut visit);
                }
            }
        }
        self.tell(best, &mut visit);
    }

    #[inline]
    fn tell(&self, found: Option<(u32, f64, Vector2<f64>)>, visit: &mut impl FnMut(Nearest)) {
        if let Some((group, distance_m, offset)) = found
            && distance_m <= self.reach_m
        {
            let norm = offset.norm();
            let away = if norm > 0.0 { offset / norm } else { Vector2::zeros() };
            visit(Nearest { group, distance_m, away });
        }
    }

    /// Visits every piece within a distance, which must not be above the reach, with how far it is and the direction from
    /// it: in a corner both walls count, also where they are one obstacle.
    pub fn pieces_within(&self, at: Point2<f64>, most_m: f64, mut visit: impl FnMut(f64, Vector2<f64>)) {
        for &place in self.index.around(at) {
            let Some(segment) = self.segments.get(place as usize) else { continue };
            let offset = segment.offset(at);
            let norm = offset.norm();
            if norm - segment.radius_m <= most_m && norm > 0.0 {
                visit(norm - segment.radius_m, offset / norm);
            }
        }
    }

    /// Distance to the nearest obstacle, meters; infinite where none is within reach.
    pub fn clearance_m(&self, at: Point2<f64>) -> f64 {
        let mut least_m = f64::INFINITY;
        self.near(at, |nearest| least_m = least_m.min(nearest.distance_m));
        least_m
    }

    /// Every point of the straight way between two places keeps this clearance, meters, which must be within reach.
    ///
    /// Marches in steps as long as the room that is left, at least 0.01 m, and asks for half of that more
    /// than the clearance, so that nothing between two steps is missed.
    pub fn is_clear(&self, from: Point2<f64>, to: Point2<f64>, clearance_m: f64) -> bool {
        let way = to - from;
        let length_m = way.norm();
        if !length_m.is_finite() {
            return false;
        }
        let needed_m = clearance_m + 0.5 * SHORTEST_MARCH_M;
        let mut done_m = 0.0;
        loop {
            let share = if length_m > 0.0 { (done_m / length_m).min(1.0) } else { 1.0 };
            let room_m = self.clearance_m(from + way * share).min(self.reach_m) - needed_m;
            if room_m < 0.0 {
                return false;
            }
            if share >= 1.0 {
                return true;
            }
            done_m += room_m.max(SHORTEST_MARCH_M);
        }
    }
}

/// Shortest step along a way whose clearance is looked at, meters.
const SHORTEST_MARCH_M: f64 = 0.01;
