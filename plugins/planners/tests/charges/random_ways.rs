//! Random ways against the shortest ones, and the solver that knows these.

use super::queries::{Tally, map, queries};
use super::shortest::ShortestWays;
use super::warehouse::racks;
use rumbo_core::frames::Point2;
use rumbo_core::registry::Plugin;
use rumbo_core::stages::{BuildContext, Planner};
use rumbo_planners::fictitious_charges::FictitiousChargesParams;
use rumbo_planners::field_descent::MapSource;
use rumbo_planners::potential_field::PotentialFieldParams;

fn tally(params: impl Plugin<dyn Planner>, queries: &[[Point2; 2]]) -> Tally {
    let (map, shortest) = (map(), ShortestWays::new(racks(), 0.3));
    let mut planner = params.build(&BuildContext::bare("planner")).unwrap();
    Tally::of(queries, &map, &shortest, |request| planner.plan(request).map(|path| path.length_m()))
}

#[test]
fn random_ways_arrive_with_charges_and_are_nearly_as_short_as_can_be() {
    let queries = queries(150, 17);
    let lines = MapSource::Lines;
    let plain = tally(PotentialFieldParams { map: lines, ..PotentialFieldParams::default() }, &queries);
    let charged =
        tally(FictitiousChargesParams { map: lines, ..FictitiousChargesParams::default() }, &queries);
    let on_grid = tally(FictitiousChargesParams::default(), &queries);
    assert!(
        charged.n_arrived >= 147 && on_grid.n_arrived >= 147,
        "{} {}",
        charged.n_arrived,
        on_grid.n_arrived
    );
    assert!(plain.n_arrived < 135, "{}", plain.n_arrived);
    for tally in [&plain, &charged, &on_grid] {
        // No way is shorter than the shortest.
        assert!(tally.quantile(0.0) > 0.999, "{}", tally.quantile(0.0));
    }
    assert!(charged.mean() < 1.15, "{}", charged.mean());
}

#[test]
fn a_way_around_one_rack_is_its_taut_string() {
    let rack = [Point2::new(-1.0, -1.0), Point2::new(1.0, 1.0)];
    let ways = ShortestWays::new(vec![rack], 0.5);
    // Up along the side, a quarter of a circle, along the top, another quarter, and down again.
    let found = ways.length_m(Point2::new(-1.5, 0.0), Point2::new(1.5, 0.0));
    let quarter = 0.25 * std::f64::consts::TAU * 0.5;
    assert!((found - (1.0 + 2.0 + 1.0 + 2.0 * quarter)).abs() < 0.01, "{found}");
    assert_eq!(ways.length_m(Point2::new(-3.0, 2.0), Point2::new(3.0, 2.0)), 6.0);
}
