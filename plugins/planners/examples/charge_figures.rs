//! Long check: random ways through the published warehouse, with and without charges, by `dp` and by `a_star`, against the
//! shortest ways that keep 0.3 m.
//!
//! `cargo run --release -p rumbo-planners --example charge_figures [-- NUMBER]` ends with an error when charges lead fewer
//! than 97 % of the ways to their goals, forgotten charges fewer than 99 %, or their ways are longer than 1.06 times the
//! shortest ones on average.
#![allow(clippy::print_stdout, clippy::unwrap_used, clippy::panic)]

#[path = "../tests/charges/queries.rs"]
#[allow(dead_code)]
mod queries;
#[path = "../tests/charges/shortest.rs"]
mod shortest;
#[path = "../tests/charges/warehouse.rs"]
#[allow(dead_code)]
mod warehouse;

use queries::{Tally, map, queries};
use rumbo_core::registry::Plugin;
use rumbo_core::stages::{BuildContext, Planner};
use rumbo_planners::a_star::AStarParams;
use rumbo_planners::dp::DpParams;
use rumbo_planners::fictitious_charges::FictitiousChargesParams;
use rumbo_planners::field_descent::{MapSource, StepKind};
use rumbo_planners::potential_field::PotentialFieldParams;
use shortest::ShortestWays;
use std::process::ExitCode;

/// Where the random ways begin.
const SEED: u64 = 1986;

fn built(params: &impl Plugin<dyn Planner>) -> Box<dyn Planner> {
    params.build(&BuildContext::bare("planner")).unwrap()
}

fn main() -> ExitCode {
    let mut is_as_before = true;
    let number = std::env::args().nth(1).and_then(|word| word.parse().ok()).unwrap_or(1000);
    let (asked, map) = (queries(number, SEED), map());
    let shortest = ShortestWays::new(warehouse::racks(), 0.3);
    let lines = MapSource::Lines;
    let charges = FictitiousChargesParams { map: lines, ..FictitiousChargesParams::default() };
    let planners: Vec<(&str, Box<dyn Planner>)> = vec![
        ("potential_field", built(&PotentialFieldParams { map: lines, ..PotentialFieldParams::default() })),
        ("fictitious_charges", built(&charges)),
        ("  walk only", built(&FictitiousChargesParams { straighten: false, ..charges.clone() })),
        ("  forget", built(&FictitiousChargesParams { forget: true, ..charges.clone() })),
        ("  adaptive steps", built(&FictitiousChargesParams { step: StepKind::Adaptive, ..charges.clone() })),
        ("  on the grid", built(&FictitiousChargesParams::default())),
        ("dp", built(&DpParams::default())),
        ("a_star", built(&AStarParams { clearance_m: Some(0.3), ..AStarParams::default() })),
    ];
    let share = |tally: &Tally| tally.n_arrived as f64 / number as f64;
    println!("{number} ways; length by that of the shortest way");
    println!("planner               arrived   stuck  refused    mean  median    95 %  longest");
    for (name, mut planner) in planners {
        let tally =
            Tally::of(&asked, &map, &shortest, |request| planner.plan(request).map(|path| path.length_m()));
        is_as_before &= match name {
            "fictitious_charges" => share(&tally) >= 0.97 && tally.mean() <= 1.06,
            "  forget" => share(&tally) >= 0.99 && tally.mean() <= 1.06,
            _ => true,
        };
        let of = |share: f64| tally.quantile(share);
        println!(
            "{name:20} {:8} {:7} {:8} {:7.3} {:7.3} {:7.3} {:8.3}",
            tally.n_arrived,
            tally.n_stuck,
            tally.n_goals_refused,
            tally.mean(),
            of(0.5),
            of(0.95),
            of(1.0)
        );
    }
    if is_as_before { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
