//! One plan in the published warehouse of 44 lines, from its first stuck start. Bar: 2 ms.
#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "../tests/charges/queries.rs"]
#[allow(dead_code)]
mod queries;
#[path = "../tests/charges/shortest.rs"]
#[allow(dead_code)]
mod shortest;
#[path = "../tests/charges/warehouse.rs"]
#[allow(dead_code)]
mod warehouse;

use rumbo_core::frames::Point2;
use rumbo_core::registry::Plugin;
use rumbo_core::stages::BuildContext;
use rumbo_planners::fictitious_charges::FictitiousChargesParams;
use rumbo_planners::field_descent::{MapSource, StepKind};

fn main() {
    divan::main();
}

/// The source of obstacles, whether the walk is straightened, and the steps.
#[divan::bench(args = ["lines", "lines, walk only", "lines, adaptive steps", "grid of 0.1 m"])]
fn plan(bencher: divan::Bencher, case: &str) {
    let params = FictitiousChargesParams {
        map: if case.starts_with("lines") { MapSource::Lines } else { MapSource::Grid },
        straighten: !case.ends_with("only"),
        step: if case.ends_with("steps") { StepKind::Adaptive } else { StepKind::Constant },
        ..FictitiousChargesParams::default()
    };
    let mut planner = params.build(&BuildContext::bare("planner")).unwrap();
    let request = queries::request(&queries::map(), Point2::new(20.0, 4.0), warehouse::goal());
    bencher.bench_local(|| planner.plan(&request).unwrap());
}
