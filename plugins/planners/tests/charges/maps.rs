//! The same warehouse from its grid, from lines in any order, from its published line file, and turned.

use super::queries::{CELL_M, map, request};
use super::warehouse::{goal, groups, runs};
use rumbo_core::frames::Point2;
use rumbo_core::map::{Grid, GridHeader, Line, Lines, Map};
use rumbo_core::messages::Path;
use rumbo_core::registry::Plugin;
use rumbo_core::stages::{BuildContext, PlanRequest};
use rumbo_kit::GridSize;
use rumbo_kit::potential::{Group, Obstacles, outlines_of_grid, outlines_of_lines};
use rumbo_planners::fictitious_charges::FictitiousChargesParams;
use rumbo_planners::field_descent::{Grouping, MapSource};

fn path(params: &FictitiousChargesParams, request: &PlanRequest) -> Path {
    params.build(&BuildContext::bare("planner")).unwrap().plan(request).unwrap()
}

pub fn on_lines(group: Grouping) -> FictitiousChargesParams {
    FictitiousChargesParams {
        map: MapSource::Lines,
        group,
        straighten: false,
        ..FictitiousChargesParams::default()
    }
}

/// Nearest distances of all obstacles near a place, sorted: what the repulsion is made of.
fn distances(obstacles: &Obstacles, at: Point2) -> Vec<f64> {
    let mut all = Vec::new();
    obstacles.near(at, |nearest| all.push(nearest.distance_m));
    all.sort_by(f64::total_cmp);
    all
}

/// Grid and lines without groups have the obstacles of the published file.
#[test]
fn grids_and_lines_are_grouped_as_published() {
    let published = Obstacles::new(&groups(), 2.0).unwrap();
    let ends: Vec<[Point2; 2]> = groups().iter().flatten().map(|piece| [piece.from, piece.to]).collect();
    let of_lines = outlines_of_lines(&ends, Point2::new(2.0, 2.0));
    assert_eq!(of_lines.len(), 14);
    let grid = map().grid.unwrap();
    let is_free: Vec<bool> = grid.cells.iter().map(|odds| *odds < 0.0).collect();
    let in_meters = |group: &Group| {
        let scaled = |p: Point2| p * CELL_M;
        group
            .iter()
            .map(|piece| rumbo_kit::potential::Piece::between(scaled(piece.from), scaled(piece.to)))
            .collect()
    };
    let of_grid: Vec<Group> =
        outlines_of_grid(GridSize::new(400, 300), &is_free).iter().map(in_meters).collect();
    assert_eq!(of_grid.len(), 14);
    let found = [Obstacles::new(&of_lines, 2.0).unwrap(), Obstacles::new(&of_grid, 2.0).unwrap()];
    for col in 0..80 {
        for row in 0..60 {
            let at = Point2::new(0.27 + 0.5 * f64::from(col), 0.23 + 0.5 * f64::from(row));
            for obstacles in &found {
                let (expected, found) = (distances(&published, at), distances(obstacles, at));
                assert_eq!(expected.len(), found.len(), "{at}");
                assert!(expected.iter().zip(&found).all(|(a, b)| (a - b).abs() < 1e-9), "{at}");
            }
        }
    }
}

#[test]
fn the_grid_gives_the_ways_of_the_lines() {
    let on_grid = FictitiousChargesParams { straighten: false, ..FictitiousChargesParams::default() };
    for run in runs() {
        let request = request(&map(), run.start, goal());
        let (a, b) = (path(&on_grid, &request), path(&on_lines(Grouping::Outline), &request));
        assert!((a.length_m() - run.length_m).abs() < 0.1, "{}: {}", run.start, a.length_m());
        assert!(
            (a.length_m() - b.length_m()).abs() < 0.05,
            "{}: {} {}",
            run.start,
            a.length_m(),
            b.length_m()
        );
    }
}

/// The published file of all lines by themselves: each is an obstacle, corners count twice.
#[test]
fn lines_without_groups_are_accepted_as_they_are() {
    let text = include_str!("../data/potential/fc_warehouse_lines.csv");
    let line = |row: &str| {
        let v: Vec<f64> = row.split(',').skip(1).map(|word| word.trim().parse().unwrap()).collect();
        Line { from: [v[0], v[1]], to: [v[2], v[3]], ..Line::default() }
    };
    let lines: Vec<Line> = text.lines().skip(1).map(line).collect();
    assert_eq!(lines.len(), 44);
    let map = Map { lines: Some(Lines { lines: lines.into() }), ..Map::default() };
    for run in runs() {
        let one = path(&on_lines(Grouping::Outline), &request(&map, run.start, goal()));
        assert!((one.length_m() - run.length_m).abs() < 0.1, "{}: {}", run.start, one.length_m());
        path(&on_lines(Grouping::Segment), &request(&map, run.start, goal()));
    }
}

/// Hall and columns of the published log with their true lines, each off by a few centimeters and with ends that do not
/// meet, as SLAM leaves them.
#[test]
fn a_hall_of_lines_with_errors_is_planned_through() {
    let mut lines = Vec::new();
    let mut rectangle = |x0: f64, y0: f64, x1: f64, y1: f64| {
        let corners = [[x0, y0], [x1, y0], [x1, y1], [x0, y1]];
        for k in 0..4 {
            // Ends that do not meet, and lines off by centimeters.
            let off = 0.01 * (lines.len() % 7) as f64 - 0.03;
            let (from, to) = (corners[k], corners[(k + 1) % 4]);
            let shrunk = |a: f64, b: f64| a + 0.05 * (b - a) + off;
            let from_end = [shrunk(from[0], to[0]), shrunk(from[1], to[1])];
            let to_end = [shrunk(to[0], from[0]), shrunk(to[1], from[1])];
            lines.push(Line { from: from_end, to: to_end, ..Line::default() });
        }
    };
    rectangle(0.0, 0.0, 30.0, 20.0);
    for [x, y] in [[5.0, 4.0], [15.0, 2.5], [25.0, 4.0], [5.0, 16.0], [15.0, 17.5], [25.0, 16.0]] {
        rectangle(x - 0.4, y - 0.4, x + 0.4, y + 0.4);
    }
    assert_eq!(lines.len(), 28);
    let map = Map { lines: Some(Lines { lines: lines.into() }), ..Map::default() };
    let request = request(&map, Point2::new(19.5, 10.0), Point2::new(5.0, 10.0));
    for group in [Grouping::Outline, Grouping::Segment] {
        let path = path(&on_lines(group), &request);
        assert!(path.length_m() < 15.5, "{}", path.length_m());
    }
}

#[test]
fn a_turned_grid_gives_a_turned_way() {
    let straight = request(&map(), Point2::new(18.0, 6.0), goal());
    let old = straight.grid.clone().unwrap();
    let header = GridHeader { origin: [10.0, -5.0, 2.0], ..*old.header() };
    let grid = Grid::new(header, old.cells).unwrap();
    let there = |at: Point2| grid.map_from_grid() * at;
    let turned_map = Map { grid: Some(grid.clone()), ..Map::default() };
    let turned = request(&turned_map, there(Point2::new(18.0, 6.0)), there(goal()));
    let params = FictitiousChargesParams::default();
    let (a, b) = (path(&params, &straight), path(&params, &turned));
    assert!((a.length_m() - b.length_m()).abs() < 0.05, "{} {}", a.length_m(), b.length_m());
}
