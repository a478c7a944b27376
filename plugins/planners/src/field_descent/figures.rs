//! What the search looked like: drawings and counters.

use super::descent::{ChargeRules, Walk};
use super::iso_lines::iso_lines;
use super::rounding::Rounded;
use super::straightening::{length_m, without_collinear};
use super::surroundings::around;
use rumbo_core::frames::Point2;
use rumbo_core::stages::PlanRequest;
use rumbo_core::trace::{Drawing, Trace};
use rumbo_kit::GridSize;
use rumbo_kit::potential::charge_map::{MapFrame, add_potential};
use rumbo_kit::potential::{Field, Obstacles};

/// Cells along the longer side of the map that the potential is drawn from.
const MOST_CELLS: f64 = 160.0;
/// Around the walk: at least so many meters, and this share of the longer side of the rectangle around it.
const MARGIN_M: f64 = 3.0;
const MARGIN_SHARE: f64 = 0.5;
/// Levels of the potential that are drawn.
const LEVELS: usize = 16;

/// The potential as iso-lines, the charges, and the walk itself; nothing where nobody looks.
pub(super) fn draw(request: &PlanRequest, field: &Field<'_>, charges: Option<&ChargeRules>, walk: &Walk) {
    if !request.trace.is_watched() {
        return;
    }
    let places: Vec<Point2> = walk.charges.iter().map(|charge| charge.at).collect();
    let frame = frame(field, walk);
    let mut potential: Vec<f32> =
        (0..frame.size.n_cells()).map(|cell| field.sample(frame.middle_of(cell)).potential as f32).collect();
    if let Some(rules) = charges {
        add_potential(&frame, &rules.law, &places, &mut potential);
    }
    let lowest = potential.iter().copied().fold(f32::INFINITY, f32::min);
    let ends = [walk.points.first(), walk.points.last()].into_iter().flatten();
    let highest =
        ends.map(|at| field.attraction.potential((field.goal - at).norm()) as f32).fold(1.0, f32::max);
    let step = (1.2 * highest - lowest).max(f32::MIN_POSITIVE) / LEVELS as f32;
    for level in 1..=LEVELS {
        for points in iso_lines(&frame, &potential, lowest + step * level as f32) {
            request.trace.draw(|| Drawing::Polyline { name: "level of the potential", points });
        }
    }
    request.trace.draw(|| Drawing::Points { name: "charges", points: places });
    let points = without_collinear(&walk.points);
    request.trace.draw(|| Drawing::Polyline { name: "walk before it is straightened", points });
}

fn frame(field: &Field<'_>, walk: &Walk) -> MapFrame {
    let mut points = vec![field.goal];
    points.extend(&walk.points);
    let (lower, upper) = around(&points, 0.0);
    let margin_m = MARGIN_M.max(MARGIN_SHARE * (upper.x - lower.x).max(upper.y - lower.y));
    let (mut lower, mut upper) = around(&points, margin_m);
    if let Some((map_lower, map_upper)) = field.obstacles.bounds() {
        lower = Point2::new(lower.x.max(map_lower.x), lower.y.max(map_lower.y));
        upper = Point2::new(upper.x.min(map_upper.x), upper.y.min(map_upper.y));
    }
    let (wide_m, high_m) = ((upper.x - lower.x).max(0.0), (upper.y - lower.y).max(0.0));
    let cell_m = (wide_m.max(high_m) / MOST_CELLS).max(1e-3);
    let n = |length_m: f64| (length_m / cell_m).ceil().min(MOST_CELLS) as usize + 1;
    MapFrame { size: GridSize::new(n(wide_m), n(high_m)), origin: lower, cell_m }
}

/// Counters of a walk and the path that it became.
pub(super) fn count(trace: &Trace, obstacles: &Obstacles, walk: &Walk, way: &Rounded) {
    if !trace.is_counting() {
        return;
    }
    trace.count("steps", walk.points.len() as f64 - 1.0);
    trace.count("charges", walk.charges.len() as f64);
    trace.count("length_before_straightening_m", walk.length_m);
    trace.count("length_m", length_m(&way.points));
    trace.count("points", way.points.len() as f64);
    let reach_m = obstacles.reach_m();
    trace.count("clearance_before_straightening_m", walk.clearance_m.min(reach_m));
    trace.count("clearance_m", least_clearance_m(obstacles, &way.points).min(reach_m));
    trace.count("tight_corners", way.n_tight_corners as f64);
}

/// Steps in which the clearance of a path is told, meters.
const LOOK_M: f64 = 0.02;

fn least_clearance_m(obstacles: &Obstacles, way: &[Point2]) -> f64 {
    let mut least_m = f64::INFINITY;
    for leg in way.windows(2) {
        let along = leg[1] - leg[0];
        let n = (along.norm() / LOOK_M).ceil().clamp(1.0, 1e6) as usize;
        for k in 0..=n {
            least_m = least_m.min(obstacles.clearance_m(leg[0] + along * (k as f64 / n as f64)));
        }
    }
    least_m
}
