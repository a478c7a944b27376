//! The three office maps: 200 random plans on each, compared with the reference simulation.

use crate::source_grid::{SourceGrid, toml};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rumbo_kit::cost_field::StepRule;
use rumbo_kit::generated_world::crc32;
use rumbo_kit::proximity::{CellKind, ProximityMap};
use rumbo_planners::dp::checkpoints::{Point, least_clearance, length};
use rumbo_planners::dp::cost_map::Clearances;
use rumbo_planners::dp::grid_dp::{DpFault, DpPlan, DpRules, GridDp, ends};

const CELL_M: f64 = 0.05;

fn load(map: &toml::Value) -> SourceGrid {
    let number = |key: &str| map[key].as_integer().unwrap() as usize;
    let mut grid = SourceGrid::free(number("lines"), number("columns"));
    for rectangle in map["rectangles"].as_array().unwrap() {
        let [line, column, height, width, value] =
            [0, 1, 2, 3, 4].map(|i| rectangle[i].as_integer().unwrap() as usize);
        for l in line..line + height {
            for c in column..column + width {
                grid.set(l, c, value == 1);
            }
        }
    }
    let bytes: Vec<u8> = (0..grid.size.height)
        .flat_map(|l| (0..grid.size.width).map(move |c| (l, c)))
        .map(|(l, c)| grid.kinds[grid.index(l, c)] as u8)
        .collect();
    assert_eq!(i64::from(crc32(&bytes)), map["crc32_row_major_bytes"].as_integer().unwrap());
    assert_eq!(bytes.iter().filter(|&&b| b == 0).count(), number("free_cells"));
    grid
}

fn rules(no_nearer_than_path: bool) -> DpRules {
    DpRules {
        clearances: Clearances { preferred: 0.45 / CELL_M, minimum: 0.30 / CELL_M, penalty_unit: 1.0 },
        steps: StepRule::default(),
        no_nearer_than_path,
        escape_radius: 8.0,
        escape_minimum: 0.22 / CELL_M,
        back_off: 2.0,
    }
}

fn turning_deg(points: &[Point]) -> f64 {
    let headings: Vec<f64> =
        points.windows(2).map(|w| (w[1][1] - w[0][1]).atan2(w[1][0] - w[0][0])).collect();
    let turn = |w: &[f64]| {
        let turn = (w[1] - w[0]).rem_euclid(std::f64::consts::TAU);
        turn.min(std::f64::consts::TAU - turn).to_degrees()
    };
    headings.windows(2).map(turn).sum()
}

/// Sums over plans: checkpoints, length in meters, turning in degrees.
#[derive(Default, Debug)]
struct Totals([f64; 3]);

impl Totals {
    fn add(&mut self, points: &[Point]) {
        let more = [points.len() as f64, length(points) * CELL_M, turning_deg(points)];
        self.0.iter_mut().zip(more).for_each(|(total, more)| *total += more);
    }

    fn mean(&self) -> [f64; 3] {
        self.0.map(|total| total / N_PLANS as f64)
    }
}

const N_PLANS: usize = 200;

/// Means of the reference simulation: checkpoints, length, turning; before, strict, with the fallback.
const REFERENCE: [(&str, [[f64; 3]; 3]); 3] = [
    ("5x5", [[12.6, 2.95, 479.0], [8.1, 2.90, 212.0], [5.9, 2.84, 124.0]]),
    ("10x10", [[19.5, 8.40, 790.0], [9.3, 8.25, 212.0], [8.4, 8.22, 186.0]]),
    ("20x20", [[24.7, 20.02, 1023.0], [10.9, 19.67, 251.0], [10.2, 19.63, 231.0]]),
];

#[test]
fn random_plans_keep_their_clearance_and_turn_as_little_as_the_reference() {
    let maps = toml("maps.toml");
    for (map, (name, reference)) in maps["map"].as_array().unwrap().iter().zip(REFERENCE) {
        assert_eq!(map["name"].as_str(), Some(name));
        let [before, strict, fallback] = plan_200(&load(map)).map(|t| t.mean());
        // Other random pairs than the reference's: the means scatter by a few percent.
        assert!((before[1] / reference[0][1] - 1.0).abs() < 0.15, "{name}: mean length {before:?}");
        assert!(fallback[0] <= strict[0] && strict[0] < before[0], "{name}");
        assert!(fallback[1] <= strict[1] + 1e-9 && strict[1] <= before[1] + 1e-9, "{name}");
        // Per meter of path, so that a longer draw of pairs does not count against the planner.
        let scale = before[1] / reference[0][1];
        assert!(fallback[0] <= reference[2][0] * scale.max(1.0) * 1.05, "{name}: {fallback:?}");
    }
}

fn plan_200(grid: &SourceGrid) -> [Totals; 3] {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(200);
    let mut totals = [Totals::default(), Totals::default(), Totals::default()];
    let map = ProximityMap::new(grid.size, &grid.kinds, std::f64::consts::SQRT_2);
    let allowed: Vec<usize> = (0..grid.kinds.len())
        .filter(|&c| map.distances()[c] >= 6.0 - 1e-9 && grid.kinds[c] == CellKind::Free)
        .collect();
    let mut planner = GridDp::default();
    let mut n_plans = 0;
    while n_plans < N_PLANS {
        let mut pick = || allowed[rng.random_range(0..allowed.len())];
        let request = ends(grid.size, pick(), pick());
        let mut plan =
            |fallback| planner.plan(grid.size, &grid.kinds, &rules(fallback), &request, &mut || false);
        let strict = match plan(false) {
            Ok(plan) => plan,
            Err(DpFault::Unreachable(_)) => continue,
            Err(fault) => panic!("{fault:?}"),
        };
        let fallback = plan(true).unwrap();
        check(&map, &fallback);
        totals[0].add(&strict.checkpoints);
        totals[1].add(&strict.refined);
        totals[2].add(&fallback.refined);
        n_plans += 1;
    }
    totals
}

fn check(map: &ProximityMap, plan: &DpPlan) {
    let (before, after) = (least_clearance(map, &plan.checkpoints), least_clearance(map, &plan.refined));
    assert!(after >= before.min(9.0) - 1e-9, "refinement went from {before} to {after} cells of clearance");
    assert!(after >= 6.0 - 1e-9);
    assert_eq!(plan.refined.first(), plan.checkpoints.first());
    assert_eq!(plan.refined.last(), plan.checkpoints.last());
}
