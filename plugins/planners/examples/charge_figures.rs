//! Long check: random ways through the published warehouse, with and without charges, by `dp` and by `a_star`, against the
//! shortest ways that keep 0.3 m; and as many through the shipped office with its doors, against the ways of `a_star`.
//!
//! `cargo run --release -p rumbo-planners --example charge_figures [-- NUMBER]` ends with an error when charges lead fewer
//! than 99.5 % of the ways through the warehouse to their goals, a single walk fewer than 97 %, one that forgets charges
//! fewer than 99 %, or their ways are longer than 1.06 times the shortest ones on average; or when they lead fewer than 99 %
//! of the ways through the office.
#![allow(clippy::print_stdout, clippy::unwrap_used, clippy::panic)]

#[path = "../tests/charges/office.rs"]
mod office;
#[path = "../tests/charges/queries.rs"]
#[allow(dead_code)]
mod queries;
#[path = "../tests/charges/shortest.rs"]
mod shortest;
#[path = "../tests/charges/warehouse.rs"]
#[allow(dead_code)]
mod warehouse;

use office::Office;
use queries::{Tally, map, queries, request};
use rumbo_core::registry::Plugin;
use rumbo_core::stages::{BuildContext, Planner};
use rumbo_planners::a_star::AStarParams;
use rumbo_planners::dp::DpParams;
use rumbo_planners::fictitious_charges::FictitiousChargesParams;
use rumbo_planners::field_descent::{MapSource, StepKind};
use rumbo_planners::potential_field::PotentialFieldParams;
use shortest::ShortestWays;
use std::process::ExitCode;
use std::time::Instant;

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
    let published = FictitiousChargesParams { attempts: 1, ..charges.clone() };
    let planners: Vec<(&str, Box<dyn Planner>)> = vec![
        ("potential_field", built(&PotentialFieldParams { map: lines, ..PotentialFieldParams::default() })),
        ("fictitious_charges", built(&charges)),
        ("  one attempt", built(&published)),
        ("    walk only", built(&FictitiousChargesParams { straighten: false, ..published.clone() })),
        ("    forget", built(&FictitiousChargesParams { forget: true, ..published.clone() })),
        (
            "    adaptive steps",
            built(&FictitiousChargesParams { step: StepKind::Adaptive, ..published.clone() }),
        ),
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
            "fictitious_charges" => share(&tally) >= 0.995 && tally.mean() <= 1.06,
            "  one attempt" => share(&tally) >= 0.97 && tally.mean() <= 1.06,
            "    forget" => share(&tally) >= 0.99 && tally.mean() <= 1.06,
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
    is_as_before &= through_the_office(number);
    if is_as_before { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Ways through the office; false where too few arrive.
fn through_the_office(number: usize) -> bool {
    let office = Office::load();
    let mut shortest = built(&AStarParams { clearance_m: Some(0.3), ..AStarParams::default() });
    let asked = office.queries(number, SEED, &mut *shortest);
    println!("\n{number} ways through the office; length by that of a_star");
    println!("attempts   arrived    mean  longest  ms a plan");
    let mut share = 0.0;
    for attempts in [1, 2, 3, 6, 12, 24] {
        let mut planner = built(&FictitiousChargesParams { attempts, ..FictitiousChargesParams::default() });
        let began = Instant::now();
        let mut ratios = Vec::new();
        for [start, goal] in &asked {
            let request = request(&office.map, *start, *goal);
            match planner.plan(&request) {
                Ok(path) => ratios.push(path.length_m() / shortest.plan(&request).unwrap().length_m()),
                Err(failure) if attempts == 24 => println!("from {start} to {goal}: {failure}"),
                Err(_) => {}
            }
        }
        share = ratios.len() as f64 / number as f64;
        let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
        let longest = ratios.iter().copied().fold(0.0, f64::max);
        let plan_ms = began.elapsed().as_secs_f64() * 1e3 / number as f64;
        println!("{attempts:8} {:9} {mean:7.3} {longest:8.3} {plan_ms:10.1}", ratios.len());
    }
    share >= 0.99
}
