//! Which points of a scan lie on something that is drawn already.

use super::level::MatchLevel;
use super::shape::ShapePoint;
use rumbo_core::frames::Pose2;

/// A cell of which more is said than this is drawn as something.
const DRAWN: f32 = 0.5;

/// Says of points of a scan laid here whether a cell with something lies within this distance and half a cell, on the coarsest of
/// the levels with a third of the distance as their cells, or the finest.
pub fn drawn_near<'a, L: MatchLevel>(
    levels: &'a [L],
    map_from_base: &Pose2,
    within_m: f64,
) -> impl Fn(&ShapePoint) -> bool + use<'a, L> {
    let is_near = near(levels, map_from_base, within_m);
    move |point| is_near(point.at)
}

/// A wall is looked for so many times farther along it, to both sides: a face that meets a wall is not on it.
const BESIDE_TIMES: f32 = 2.0;

/// The same, but of points on a line whether that goes on to both sides: proof that it is this line, which short ones do not give.
pub fn drawn_along<'a, L: MatchLevel>(
    levels: &'a [L],
    map_from_base: &Pose2,
    within_m: f64,
) -> impl Fn(&ShapePoint) -> bool + use<'a, L> {
    let is_near = near(levels, map_from_base, within_m);
    let aside_m = BESIDE_TIMES * within_m as f32;
    move |ShapePoint { at: [x, y], normal }| match normal {
        None => is_near([*x, *y]),
        Some([nx, ny]) => [aside_m, -aside_m].iter().all(|m| is_near([x - m * ny, y + m * nx])),
    }
}

fn near<'a, L: MatchLevel>(
    levels: &'a [L],
    map_from_base: &Pose2,
    within_m: f64,
) -> impl Fn([f32; 2]) -> bool + use<'a, L> {
    let can_tell = |level: &&L| 3.0 * level.resolution_m() <= within_m;
    let level = levels.iter().take_while(can_tell).last().or(levels.first());
    let placed = level.map(|level| (level, level.level_from_map() * map_from_base));
    move |[x, y]| {
        let at = nalgebra::Point2::new(f64::from(x), f64::from(y));
        placed.is_some_and(|(level, level_from_base)| is_drawn(level, &(level_from_base * at), within_m))
    }
}

fn is_drawn<L: MatchLevel>(level: &L, at: &nalgebra::Point2<f64>, within_m: f64) -> bool {
    let (size, cell_m) = (level.size(), level.resolution_m());
    if size.width < 2 || size.height < 2 {
        return false;
    }
    let reach = within_m / cell_m + 0.5;
    let [x, y] = [at.x, at.y].map(|m| m / cell_m - 0.5);
    // Nothing where the span is beside the level.
    let span = |middle: f64, n: usize| {
        let last = (middle + reach).min(n as f64 - 1.0);
        ((middle - reach).max(0.0).ceil() as usize..(last + 1.0).max(0.0) as usize).step_by(2)
    };
    span(y, size.height).any(|row| {
        span(x, size.width).any(|col| {
            let [col, row] = [col.min(size.width - 2), row.min(size.height - 2)];
            let is_near =
                |k: usize| (col as f64 + (k % 2) as f64 - x).hypot(row as f64 + (k / 2) as f64 - y) <= reach;
            (0..).zip(level.corners(col, row)).any(|(k, stored)| L::value(stored) > DRAWN && is_near(k))
        })
    })
}
