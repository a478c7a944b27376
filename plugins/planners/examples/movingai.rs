//! Long check: both grid planners against the optimal lengths of the MovingAI benchmark (Sturtevant, 2012).
//!
//! `cargo run --release -p rumbo-planners --example movingai -- FOLDER`, where FOLDER holds `*.map.gz` files with their
//! `*.map.scen.gz` beside them, in any subfolders. Every problem is solved by `a_star` (its path is walked and measured)
//! and by `dp` with no cost for being near obstacles. Ends with an error when a length is off by more than 0.01.
#![allow(clippy::print_stdout)]

use flate2::read::GzDecoder;
use rayon::prelude::*;
use rumbo_kit::GridSize;
use rumbo_kit::cost_field::StepRule;
use rumbo_kit::proximity::CellKind;
use rumbo_planners::a_star::grid_a_star::GridAStar;
use rumbo_planners::dp::cost_map::Clearances;
use rumbo_planners::dp::grid_dp::{DpRules, GridDp, ends};
use std::error::Error;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Lengths are listed with as few as two decimals.
const TOLERANCE: f64 = 0.01;

type Fault = Box<dyn Error + Send + Sync>;

struct BenchMap {
    size: GridSize,
    kinds: Vec<CellKind>,
}

struct Problem {
    start: usize,
    goal: usize,
    optimum: f64,
}

/// What a set of problems showed.
#[derive(Clone, Copy, Default)]
struct Outcome {
    n_problems: usize,
    n_missed: usize,
    worst_a_star: f64,
    worst_dp: f64,
}

impl Outcome {
    fn of(problem: &Problem, a_star: Option<f64>, dp: Option<f64>) -> Self {
        let off =
            |length: Option<f64>| length.map_or(f64::INFINITY, |length| (length - problem.optimum).abs());
        let (worst_a_star, worst_dp) = (off(a_star), off(dp));
        let is_missed = worst_a_star.max(worst_dp) > TOLERANCE;
        Self { n_problems: 1, n_missed: usize::from(is_missed), worst_a_star, worst_dp }
    }

    fn and(self, other: Self) -> Self {
        Self {
            n_problems: self.n_problems + other.n_problems,
            n_missed: self.n_missed + other.n_missed,
            worst_a_star: self.worst_a_star.max(other.worst_a_star),
            worst_dp: self.worst_dp.max(other.worst_dp),
        }
    }

    fn print(&self, what: &str) {
        println!(
            "{what:28} {:7} problems  {:3} missed  worst deviation: a_star {:.6}  dp {:.6}",
            self.n_problems, self.n_missed, self.worst_a_star, self.worst_dp
        );
    }
}

fn read(path: &Path) -> Result<String, Fault> {
    let mut text = String::new();
    GzDecoder::new(File::open(path)?).read_to_string(&mut text)?;
    Ok(text)
}

/// A map: `.`, `G` and `S` are passable.
fn parse_map(text: &str) -> Result<BenchMap, Fault> {
    let mut lines = text.lines();
    let mut number = |key: &str| -> Result<usize, Fault> {
        let line = lines.find(|line| line.starts_with(key)).ok_or("the header is incomplete")?;
        Ok(line[key.len()..].trim().parse()?)
    };
    let size = {
        let height = number("height")?;
        GridSize::new(number("width")?, height)
    };
    let rows: Vec<&str> = text.lines().skip_while(|line| *line != "map").skip(1).take(size.height).collect();
    let kind = |letter: u8| if b".GS".contains(&letter) { CellKind::Free } else { CellKind::Obstacle };
    let kinds: Vec<CellKind> = rows.iter().flat_map(|row| row.bytes().map(kind)).collect();
    if kinds.len() != size.n_cells() {
        return Err(format!("{} cells instead of {}", kinds.len(), size.n_cells()).into());
    }
    Ok(BenchMap { size, kinds })
}

fn parse_problems(text: &str, size: GridSize) -> Result<Vec<Problem>, Fault> {
    let parse = |line: &str| -> Result<Problem, Fault> {
        let fields: Vec<&str> = line.split_ascii_whitespace().collect();
        let [.., start_x, start_y, goal_x, goal_y, optimum] = fields[..] else {
            return Err("a problem has too few fields".into());
        };
        let cell = |x: &str, y: &str| -> Result<usize, Fault> { Ok(size.index(x.parse()?, y.parse()?)) };
        Ok(Problem { start: cell(start_x, start_y)?, goal: cell(goal_x, goal_y)?, optimum: optimum.parse()? })
    };
    text.lines().filter(|line| !line.is_empty() && !line.starts_with("version")).map(parse).collect()
}

/// Length of a path, measured cell by cell; none when it leaves the map, jumps, or cuts a corner.
fn walked(map: &BenchMap, cells: &[usize]) -> Option<f64> {
    let mut length = 0.0;
    for pair in cells.windows(2) {
        let ((c0, r0), (c1, r1)) = (map.size.col_row(pair[0]), map.size.col_row(pair[1]));
        let beside = [map.size.index(c0, r1), map.size.index(c1, r0), pair[1]];
        let is_step = c0.abs_diff(c1).max(r0.abs_diff(r1)) == 1;
        if !is_step || beside.iter().any(|&cell| map.kinds[cell] != CellKind::Free) {
            return None;
        }
        length += (c0.abs_diff(c1) as f64).hypot(r0.abs_diff(r1) as f64);
    }
    Some(length)
}

fn solve(map: &BenchMap, problem: &Problem, planners: &mut (GridAStar, GridDp)) -> Outcome {
    let (a_star, dp) = planners;
    let path = a_star.plan(map.size, &map.kinds, 0.0, problem.start, problem.goal, || false).ok();
    let is_whole =
        |cells: &[usize]| (cells.first(), cells.last()) == (Some(&problem.start), Some(&problem.goal));
    let a_star_length = path.filter(|path| is_whole(&path.cells)).and_then(|path| walked(map, &path.cells));
    let rules = DpRules {
        clearances: Clearances { preferred: 0.0, minimum: 0.0, penalty_unit: 1.0 },
        steps: StepRule::default(),
        no_nearer_than_path: true,
        escape_radius: 0.0,
        escape_minimum: 0.0,
        back_off: 0.0,
    };
    let request = ends(map.size, problem.start, problem.goal);
    let dp_cost = dp.cost(map.size, &map.kinds, &rules, &request, &mut || false).ok();
    Outcome::of(problem, a_star_length, dp_cost)
}

fn check_map(path: &Path) -> Result<Outcome, Fault> {
    let map = parse_map(&read(path)?)?;
    let scenario = path.with_extension("").with_extension("map.scen.gz");
    let problems = parse_problems(&read(&scenario)?, map.size)?;
    let outcome = problems
        .par_iter()
        .map_init(Default::default, |planners, problem| solve(&map, problem, planners))
        .reduce(Outcome::default, Outcome::and);
    Ok(outcome)
}

/// All maps below a folder, in order.
fn maps_below(folder: &Path) -> Result<Vec<PathBuf>, Fault> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            found.extend(maps_below(&path)?);
        } else if path.to_string_lossy().ends_with(".map.gz") {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}

fn main() -> Result<(), Fault> {
    let folder = std::env::args().nth(1).ok_or("usage: movingai FOLDER")?;
    let mut all = Outcome::default();
    for path in maps_below(Path::new(&folder))? {
        let name = path.file_name().unwrap_or_default().to_string_lossy().replace(".map.gz", "");
        let outcome = check_map(&path).map_err(|fault| format!("{}: {fault}", path.display()))?;
        outcome.print(&name);
        all = all.and(outcome);
    }
    all.print("all");
    if all.n_missed > 0 || all.n_problems == 0 {
        return Err("not every problem was solved to the optimum".into());
    }
    Ok(())
}
