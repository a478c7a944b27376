//! FC-A11: the walls that the line filter built from the published log (encoders, steering and the lines of the scans; no
//! pose but the first), as the filter gives them.

use super::maps::on_lines;
use super::queries::request;
use nalgebra::{Matrix5, Vector5};
use rumbo_core::frames::Point2;
use rumbo_core::map::{Lines, Map};
use rumbo_core::registry::Plugin;
use rumbo_core::stages::BuildContext;
use rumbo_kit::line_filter::{FilterSettings, LineFilter, Mount};
use rumbo_kit::lines::SensedLine;
use rumbo_planners::field_descent::Grouping;
use std::collections::BTreeMap;

fn rows(text: &str) -> impl Iterator<Item = Vec<f64>> + '_ {
    text.lines().skip(1).map(|line| line.split(',').map(|word| word.trim().parse().unwrap()).collect())
}

/// The lines of each scan, by the step at which it was taken.
fn scans() -> BTreeMap<usize, Vec<SensedLine>> {
    let mut scans: BTreeMap<usize, Vec<SensedLine>> = BTreeMap::new();
    for v in rows(include_str!("../data/potential/ekf_log_lines.csv")) {
        scans.entry(v[0] as usize).or_default().push(SensedLine {
            distance_m: v[1],
            normal_rad: v[2],
            covariance: [v[3], v[4], v[5]],
            ends_m: [[v[6], v[7]], [v[8], v[9]]],
            n_points: v[10] as usize,
            rms_m: 0.03,
        });
    }
    scans
}

/// The filter after the whole drive: a step every 50 ms, a scan every 500 ms.
fn driven() -> LineFilter {
    let scans = scans();
    let truth = rows(include_str!("../data/potential/ekf_log_truth.csv")).next().unwrap();
    let robot = Vector5::new(truth[2], truth[3], truth[4], 0.0, 0.0);
    let covariance = Matrix5::from_diagonal(&Vector5::new(1e-6, 1e-6, 1e-6, 1e-4, 1e-4));
    let mut filter = LineFilter::building(FilterSettings::default(), robot, &covariance);
    for v in rows(include_str!("../data/potential/ekf_log_encoders.csv")) {
        let k = v[0] as usize;
        if k > 0 {
            filter.predict(0.05);
        }
        filter.read_wheels([v[2], v[3]]);
        filter.read_steering(v[4]);
        if k.is_multiple_of(10) {
            filter.read_lines(scans.get(&k).map(Vec::as_slice).unwrap_or_default(), &Mount::default());
        }
    }
    filter
}

#[test]
fn the_walls_that_the_filter_built_are_planned_through_unchanged() {
    let filter = driven();
    // The recorded drive ends here, and the reference filter has 20 walls of the 28.
    let last = rows(include_str!("../data/potential/ekf_log_truth.csv")).last().unwrap();
    let robot = filter.state().robot;
    assert!((robot[0] - last[2]).hypot(robot[1] - last[3]) < 0.02, "{robot}");
    let walls = filter.layer();
    assert_eq!(walls.len(), 20);
    let map = Map { lines: Some(Lines { lines: walls.into() }), ..Map::default() };
    let request = request(&map, Point2::new(19.5, 10.0), Point2::new(5.0, 10.0));
    for group in [Grouping::Outline, Grouping::Segment] {
        let mut planner = on_lines(group).build(&BuildContext::bare("planner")).unwrap();
        let path = planner.plan(&request).unwrap();
        assert!((14.5..15.5).contains(&path.length_m()), "{}", path.length_m());
        assert_eq!(path.end().position, Point2::new(5.0, 10.0));
    }
}
