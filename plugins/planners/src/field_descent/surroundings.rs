//! The obstacles of a request: from its grid, or from its lines.

use super::{Grouping, MapSource};
use crate::plan_grid::{PlanGrid, finite_numbers};
use nalgebra::Vector2;
use rumbo_core::frames::Point2;
use rumbo_core::stages::{PlanError, PlanRequest};
use rumbo_kit::potential::{
    Group, ON_A_LINE_M, Obstacles, Piece, each_line, outlines_of_grid, outlines_of_lines,
};
use rumbo_kit::proximity::CellKind;

/// The checked obstacles of a request, with an index for those within `reach_m`.
pub(super) fn obstacles(
    request: &PlanRequest,
    source: MapSource,
    grouping: Grouping,
    reach_m: f64,
) -> Result<Obstacles, PlanError> {
    match source {
        MapSource::Grid => of_grid(request, reach_m),
        MapSource::Lines => of_lines(request, grouping, reach_m),
    }
}

fn of_grid(request: &PlanRequest, reach_m: f64) -> Result<Obstacles, PlanError> {
    let grid = PlanGrid::new(request)?;
    let mut kinds = Vec::new();
    grid.kinds(true, &mut kinds);
    let is_free: Vec<bool> = kinds.iter().map(|kind| *kind == CellKind::Free).collect();
    let in_map = |at: Point2| grid.in_map([at.x, at.y]);
    let groups: Vec<Group> = outlines_of_grid(grid.size, &is_free)
        .into_iter()
        .map(|group| group.iter().map(|piece| Piece::between(in_map(piece.from), in_map(piece.to))).collect())
        .collect();
    Obstacles::new(&groups, reach_m).map_err(|_| PlanError::NotFinite { what: "the grid's origin" })
}

fn of_lines(request: &PlanRequest, grouping: Grouping, reach_m: f64) -> Result<Obstacles, PlanError> {
    finite_numbers(request)?;
    let lines = request.map.lines.as_ref().ok_or(PlanError::MissingLayer { layer: "lines" })?;
    let (start, goal) = (Point2::from(request.start.translation.vector), request.goal.position);
    let ends: Vec<[Point2; 2]> =
        lines.lines.iter().map(|line| [line.from, line.to].map(Point2::from)).collect();
    let mut groups = match grouping {
        Grouping::Outline => outlines_of_lines(&ends, start),
        Grouping::Segment => each_line(&ends),
    };
    let n_on_map = groups.len();
    groups.extend(
        request
            .obstacles
            .iter()
            .map(|found| vec![Piece { from: found.position, to: found.position, radius_m: found.radius_m }]),
    );
    let obstacles = Obstacles::new(&groups, reach_m).map_err(|fault| {
        let is_on_map = fault.group < n_on_map;
        PlanError::NotFinite {
            what: if is_on_map { "a line of the map" } else { "an obstacle found on the way" },
        }
    })?;
    if obstacles.clearance_m(goal) < ON_A_LINE_M {
        return Err(PlanError::GoalOccupied { goal, found: "on an obstacle" });
    }
    if obstacles.clearance_m(start) < ON_A_LINE_M {
        return Err(PlanError::StartOccupied { start, found: "on an obstacle" });
    }
    Ok(obstacles)
}

/// A rectangle around the obstacles' way from `a` to `b`, for drawings: lower and upper corner.
pub(super) fn around(points: &[Point2], margin_m: f64) -> (Point2, Point2) {
    let grown = |from: Point2, k: fn(f64, f64) -> f64| {
        points.iter().fold(from, |all, p| Point2::new(k(all.x, p.x), k(all.y, p.y)))
    };
    let first = points.first().copied().unwrap_or_else(Point2::origin);
    let margin = Vector2::repeat(margin_m);
    (grown(first, f64::min) - margin, grown(first, f64::max) + margin)
}
