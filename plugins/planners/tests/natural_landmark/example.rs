//! The 15 x 15 example: figures 3.2 to 3.11.

use crate::source_grid::{SourceGrid, cells, table, toml};
use rumbo_kit::cost_field::{CostField, StepRule, Until};
use rumbo_kit::proximity::ProximityMap;
use rumbo_planners::dp::checkpoints::{ShortCut, length};
use rumbo_planners::dp::cost_map::Clearances;
use rumbo_planners::dp::grid_dp::{DpFault, DpPlan, DpRules, GridDp, ends};
use rumbo_planners::dp::obstruction::Obstruction;
use std::f64::consts::SQRT_2;

const CLEARANCES: Clearances = Clearances { preferred: 3.0, minimum: 1.5, penalty_unit: 1.0 };

fn rules(diagonal_step: f64, corner_cutting: bool, no_nearer_than_path: bool) -> DpRules {
    DpRules {
        clearances: CLEARANCES,
        steps: StepRule { diagonal_step, corner_cutting },
        no_nearer_than_path,
        escape_radius: 3.5,
        escape_minimum: 1.0,
        back_off: 1.0,
    }
}

fn grid() -> SourceGrid {
    SourceGrid::from_table(&table("fig3_2_map.csv"))
}

fn plan(grid: &SourceGrid, rules: &DpRules) -> Result<DpPlan, DpFault> {
    let request = ends(grid.size, grid.index(3, 3), grid.index(3, 11));
    GridDp::default().plan(grid.size, &grid.kinds, rules, &request, &mut || false)
}

/// Proximity of every cell, line by line.
fn proximity(diagonal_step: f64) -> Vec<Vec<f64>> {
    let grid = grid();
    let map = ProximityMap::new(grid.size, &grid.kinds, diagonal_step);
    lines(&grid, |cell| map.distances()[cell])
}

/// Cost of every cell, line by line; -1 for an obstacle, -2 for infinite, as printed.
fn costs(diagonal_step: f64) -> Vec<Vec<f64>> {
    let grid = grid();
    let map = ProximityMap::new(grid.size, &grid.kinds, diagonal_step);
    let mut entries = Vec::new();
    CLEARANCES.entry_costs(&map, None, &mut entries);
    let mut field = CostField::new();
    field.set_entry_costs(grid.size, &entries, StepRule { diagonal_step, corner_cutting: true });
    field.grow(grid.index(3, 11), Until::Everywhere, || false).unwrap();
    lines(&grid, |cell| match (map.distances()[cell], field.cost(cell)) {
        (0.0, _) => -1.0,
        (_, f64::INFINITY) => -2.0,
        (_, cost) => cost,
    })
}

fn lines(grid: &SourceGrid, value: impl Fn(usize) -> f64) -> Vec<Vec<f64>> {
    let line = |l| (0..grid.size.width).map(|c| value(grid.index(l, c))).collect();
    (0..grid.size.height).map(line).collect()
}

/// Cells where the two tables differ after `rounded` to one decimal.
fn mismatches(a: &[Vec<f64>], printed: &[Vec<f64>], rounded: impl Fn(f64) -> f64) -> Vec<(i64, i64)> {
    let mut found = Vec::new();
    for (line, (a, b)) in a.iter().zip(printed).enumerate() {
        for (column, (a, b)) in a.iter().zip(b).enumerate() {
            if (rounded(*a) - b).abs() > 1e-9 {
                found.push((line as i64, column as i64));
            }
        }
    }
    found
}

fn round(v: f64) -> f64 {
    (v * 10.0).round() / 10.0
}

fn truncate(v: f64) -> f64 {
    v.signum() * (v.abs() * 10.0 + 1e-6).floor() / 10.0
}

#[test]
fn proximity_and_cost_equal_the_computed_tables() {
    for (file, computed) in [
        ("fig3_6_proximity_sqrt2.csv", proximity(SQRT_2)),
        ("fig3_6_proximity_diag1_4.csv", proximity(1.4)),
        ("fig3_9_cost_sqrt2.csv", costs(SQRT_2)),
        ("fig3_9_cost_diag1_4.csv", costs(1.4)),
    ] {
        let expected = table(file);
        for (line, (a, b)) in computed.iter().zip(&expected).enumerate() {
            for (column, (a, b)) in a.iter().zip(b).enumerate() {
                // The files hold nine decimals.
                assert!((a - b).abs() < 1.1e-9, "{file}: ({line}, {column}) is {a} instead of {b}");
            }
        }
    }
}

#[test]
fn the_printed_tables_are_reproduced_in_as_many_cells_as_the_source_says() {
    let expected = &toml("grid_example.toml")["reproduction"];
    let count = |key: &str| expected[key].as_integer().unwrap() as usize;
    let printed = table("fig3_6_proximity_printed.csv");
    for (step, key) in [(SQRT_2, "proximity_sqrt2"), (1.4, "proximity_diag1_4")] {
        let found = mismatches(&proximity(step), &printed, round);
        assert_eq!(found.len(), count(&format!("{key}_rounded_mismatches")));
    }
    let printed = table("fig3_9_cost_printed.csv");
    assert_eq!(mismatches(&costs(1.4), &printed, round).len(), count("cost_diag1_4_rounded_mismatches"));
    assert_eq!(mismatches(&costs(1.4), &printed, truncate).len(), count("cost_diag1_4_truncated_mismatches"));
    assert_eq!(mismatches(&costs(SQRT_2), &printed, round).len(), count("cost_sqrt2_rounded_mismatches"));
    let truncated = mismatches(&costs(SQRT_2), &printed, truncate);
    assert_eq!(truncated.len(), count("cost_sqrt2_truncated_mismatches"));
    assert_eq!(truncated, cells(&expected["cost_sqrt2_truncated_mismatch_cells"]));
}

#[test]
fn the_printed_path_and_its_checkpoints_are_found_with_either_diagonal_step() {
    let grid = grid();
    let expected = &toml("grid_example.toml")["initial_path"];
    for (step, key) in [(SQRT_2, "start_cost_sqrt2"), (1.4, "start_cost_diag1_4")] {
        for corner_cutting in [false, true] {
            let plan = plan(&grid, &rules(step, corner_cutting, false)).unwrap();
            let path: Vec<_> = plan.cells.iter().map(|&c| grid.line_column(c)).collect();
            assert_eq!(path, cells(&expected["cells"]));
            let checkpoints: Vec<_> = plan.checkpoints.iter().map(|&p| grid.line_column_of(p)).collect();
            assert_eq!(checkpoints, cells(&expected["checkpoints"]));
            assert!((length(&plan.checkpoints) - expected["length_cells"].as_float().unwrap()).abs() < 1e-9);
            assert!((plan.cost - expected[key].as_float().unwrap()).abs() < 1e-8, "{}", plan.cost);
        }
    }
}

#[test]
fn the_refined_paths_are_those_of_the_reference() {
    let grid = grid();
    let expected = &toml("grid_example.toml")["refined_path"];
    let check = |points: &[[f64; 2]], cells_key: &str, length_key: &str| {
        let found: Vec<_> = points.iter().map(|&p| grid.line_column_of(p)).collect();
        assert_eq!(found, cells(&expected[cells_key]));
        assert!((length(points) - expected[length_key].as_float().unwrap()).abs() < 1e-9);
    };
    let strict = plan(&grid, &rules(SQRT_2, true, false)).unwrap();
    check(&strict.refined, "strict_d_pref", "strict_length_cells");
    let fallback = plan(&grid, &rules(SQRT_2, true, true)).unwrap();
    check(&fallback.refined, "with_clearance_fallback", "fallback_length_cells");
    let relaxed = ShortCut { preferred: 1.5, minimum: 1.5, no_nearer_than_path: false, corner_cutting: true };
    let map = ProximityMap::new(grid.size, &grid.kinds, SQRT_2);
    let refined = relaxed.refine(&map, &strict.checkpoints, || false).unwrap();
    check(&refined, "relaxed_d_min", "relaxed_length_cells");
}

#[test]
fn added_obstacles_change_proximity_path_and_cost_as_in_the_reference() {
    let example = toml("grid_example.toml");
    for case in example["added_obstacle"].as_array().unwrap() {
        let mut grid = grid();
        let mut planner = GridDp::default();
        let request = ends(grid.size, grid.index(3, 3), grid.index(3, 11));
        let rules = rules(SQRT_2, true, false);
        planner.plan(grid.size, &grid.kinds, &rules, &request, &mut || false).unwrap();
        let before = planner.proximity().clone();
        let added = cells(&case["new_obstacle_cells"]);
        added.iter().for_each(|&(line, column)| grid.set(line as usize, column as usize, true));
        let answer = planner.plan(grid.size, &grid.kinds, &rules, &request, &mut || false);
        assert_eq!(*planner.proximity(), ProximityMap::new(grid.size, &grid.kinds, SQRT_2));
        match &case["start_cost"] {
            toml::Value::Float(cost) => assert!((answer.as_ref().unwrap().cost - cost).abs() < 1e-8),
            _ => assert!(matches!(answer, Err(DpFault::Unreachable(Some(_)))), "{case}: {answer:?}"),
        }
        if let Some(path) = case.get("path") {
            let found: Vec<_> = answer.as_ref().unwrap().cells.iter().map(|&c| grid.line_column(c)).collect();
            assert_eq!(found, cells(path));
        }
        if let Some(checkpoints) = case.get("checkpoints") {
            let points = &answer.as_ref().unwrap().checkpoints;
            let found: Vec<_> = points.iter().map(|&p| grid.line_column_of(p)).collect();
            assert_eq!(found, cells(checkpoints));
        }
        if let Some(gap) = case.get("clearance_in_gap") {
            let column = (6..12).map(|line| planner.proximity().distances()[grid.index(line, 7)]);
            assert_eq!(column.fold(0.0, f64::max), gap.as_float().unwrap());
        }
        check_changed_proximity(case, &grid, &before, planner.proximity());
    }
}

fn check_changed_proximity(
    case: &toml::Value,
    grid: &SourceGrid,
    before: &ProximityMap,
    after: &ProximityMap,
) {
    let Some(changed) = case.get("changed_proximity") else { return };
    let changed = changed.as_array().unwrap();
    let number = |v: &toml::Value| v.as_float().or(v.as_integer().map(|i| i as f64)).unwrap();
    for row in changed {
        let cell = grid.index(row[0].as_integer().unwrap() as usize, row[1].as_integer().unwrap() as usize);
        assert!((before.distances()[cell] - number(&row[2])).abs() < 1e-9);
        assert!((after.distances()[cell] - number(&row[3])).abs() < 1e-9);
    }
    let n_changed = before.distances().iter().zip(after.distances()).filter(|(a, b)| a != b).count();
    assert_eq!(n_changed, changed.len());
}

#[test]
fn an_unreachable_goal_comes_with_what_is_in_the_way() {
    let mut closed = grid();
    (6..12).for_each(|line| closed.set(line, 7, true));
    let Err(DpFault::Unreachable(Some(Obstruction::Closed { cells }))) =
        plan(&closed, &rules(SQRT_2, false, true))
    else {
        panic!("the opening is closed")
    };
    assert_eq!(cells.len(), 1);
    let mut narrow = grid();
    [6, 7, 10, 11].into_iter().for_each(|line| narrow.set(line, 7, true));
    let Err(DpFault::Unreachable(Some(Obstruction::Narrow { cell, distance }))) =
        plan(&narrow, &rules(SQRT_2, false, true))
    else {
        panic!("the opening is too narrow")
    };
    assert_eq!((narrow.line_column(cell).1, distance), (7, 1.0));
}

#[test]
fn a_goal_too_close_or_not_free_is_named() {
    let grid = grid();
    let goal_at = |line, column| {
        let request = ends(grid.size, grid.index(3, 3), grid.index(line, column));
        GridDp::default().plan(grid.size, &grid.kinds, &rules(SQRT_2, false, true), &request, &mut || false)
    };
    let map = table("fig3_2_map.csv");
    let near = table("fig3_6_proximity_sqrt2.csv");
    for line in 0..15 {
        for column in 0..15 {
            match goal_at(line, column) {
                Err(DpFault::GoalNotFree) => assert_eq!(map[line][column], 1.0),
                Err(DpFault::GoalTooClose(d)) => {
                    assert!(d < 1.5 && (d - near[line][column]).abs() < 1e-9);
                }
                Ok(plan) => assert!(near[line][column] >= 1.5 && plan.cost.is_finite()),
                other => panic!("({line}, {column}): {other:?}"),
            }
        }
    }
}
