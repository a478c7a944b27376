//! Which points of a scan lie on something that is drawn already.

use super::level::MatchLevel;
use super::shape::ShapePoint;
use nalgebra::Point2;
use rumbo_core::frames::Pose2;

/// A cell of which more is said than this is drawn as something.
const DRAWN: f32 = 0.5;
/// A wall is looked for so many times farther along it: a face that meets a wall is not on it.
const BESIDE_TIMES: f32 = 2.0;
/// So many times farther than its last point a wall is over: the beam beside that may have passed it by a little only.
const BEYOND_TIMES: f32 = 3.0;
/// However far the robot may be off, an end is looked for no farther away than this, meters: where it is, the other wall of a
/// corridor would soon be taken for what comes after it.
const END_WITHIN_M: f64 = 0.1;

/// Says of points of a scan laid here whether a cell with something lies within this distance and half a cell, on the coarsest of
/// the levels with a third of the distance as their cells, or the finest; of the end of a wall whether one ends there.
pub fn drawn_near<'a, L: MatchLevel>(
    levels: &'a [L],
    map_from_base: &Pose2,
    within_m: f64,
) -> impl Fn(&ShapePoint) -> bool + use<'a, L> {
    let ground = Ground::of(levels, map_from_base, within_m);
    let at_ends = Ground::of(levels, map_from_base, within_m.min(END_WITHIN_M));
    move |point| match point.normal {
        Some(normal) if point.is_end => at_ends.ends(point.at, normal),
        _ => ground.is_drawn(point.at),
    }
}

/// The same, but of points on a line whether that goes on to both sides: proof that it is this line, which short ones do not give,
/// and ends never.
pub fn drawn_along<'a, L: MatchLevel>(
    levels: &'a [L],
    map_from_base: &Pose2,
    within_m: f64,
) -> impl Fn(&ShapePoint) -> bool + use<'a, L> {
    let ground = Ground::of(levels, map_from_base, within_m);
    move |point| match point.normal {
        None => ground.is_drawn(point.at),
        // Beams far apart draw walls as dots, and next to each of them nothing is.
        Some(_) if point.is_end => false,
        Some(normal) => ground.beside(point.at, normal, BESIDE_TIMES).iter().all(|at| ground.is_drawn(*at)),
    }
}

/// What is drawn, and where a scan is laid on it.
struct Ground<'a, L> {
    placed: Option<(&'a L, Pose2)>,
    within_m: f64,
}

impl<'a, L: MatchLevel> Ground<'a, L> {
    fn of(levels: &'a [L], map_from_base: &Pose2, within_m: f64) -> Ground<'a, L> {
        let can_tell = |level: &&L| 3.0 * level.resolution_m() <= within_m;
        let level = levels.iter().take_while(can_tell).last().or(levels.first());
        Ground { placed: level.map(|level| (level, level.level_from_map() * map_from_base)), within_m }
    }

    /// Along the line with this normal, to both sides.
    fn beside(&self, [x, y]: [f32; 2], [nx, ny]: [f32; 2], times: f32) -> [[f32; 2]; 2] {
        let aside_m = times * self.within_m as f32;
        [aside_m, -aside_m].map(|m| [x - m * ny, y + m * nx])
    }

    /// What is drawn here goes on to one side, and to the other it is known that nothing is.
    fn ends(&self, at: [f32; 2], normal: [f32; 2]) -> bool {
        let walls = self.beside(at, normal, BESIDE_TIMES);
        let mut beyond = self.beside(at, normal, BEYOND_TIMES);
        beyond.reverse();
        let is_between = |(wall, open): (&[f32; 2], &[f32; 2])| {
            self.is_drawn(*wall) && self.is_free(*open) && !self.is_drawn(*open)
        };
        self.is_drawn(at) && walls.iter().zip(&beyond).any(is_between)
    }

    fn is_free(&self, at: [f32; 2]) -> bool {
        self.placed.as_ref().is_some_and(|(level, level_from_base)| {
            let at = level_from_base * at_m(at) / level.resolution_m();
            let size = level.size();
            let last = [size.width, size.height].map(|n| n.saturating_sub(1) as f64);
            let is_inside = at.x >= 0.0 && at.y >= 0.0 && at.x < last[0] && at.y < last[1];
            if !is_inside {
                return false;
            }
            let [stored, ..] = level.corners(at.x as usize, at.y as usize);
            L::is_touched(stored) && L::value(stored) < DRAWN
        })
    }

    fn is_drawn(&self, at: [f32; 2]) -> bool {
        let Some((level, level_from_base)) = &self.placed else { return false };
        let (size, cell_m) = (level.size(), level.resolution_m());
        if size.width < 2 || size.height < 2 {
            return false;
        }
        let at = level_from_base * at_m(at);
        let reach = self.within_m / cell_m + 0.5;
        let [x, y] = [at.x, at.y].map(|m| m / cell_m - 0.5);
        // Nothing where the span is beside the level.
        let span = |middle: f64, n: usize| {
            let last = (middle + reach).min(n as f64 - 1.0);
            ((middle - reach).max(0.0).ceil() as usize..(last + 1.0).max(0.0) as usize).step_by(2)
        };
        span(y, size.height).any(|row| {
            span(x, size.width).any(|col| {
                let [col, row] = [col.min(size.width - 2), row.min(size.height - 2)];
                let is_near = |k: usize| {
                    (col as f64 + (k % 2) as f64 - x).hypot(row as f64 + (k / 2) as f64 - y) <= reach
                };
                (0..).zip(level.corners(col, row)).any(|(k, stored)| L::value(stored) > DRAWN && is_near(k))
            })
        })
    }
}

fn at_m([x, y]: [f32; 2]) -> Point2<f64> {
    Point2::new(f64::from(x), f64::from(y))
}
