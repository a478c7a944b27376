//! `results.csv`, the same bytes for the same design, and `timing.csv`, which no two executions share.

use super::design::Design;
use super::figures::FIGURES;
use super::result::RunResult;
use super::summary::Results;
use rumbo_core::engine::Part;
use std::fmt::Write as _;

/// One row a run, sorted by alternative, world, seed and mission, without any wall time. Numbers have six digits behind
/// the point; what nobody knows is empty.
pub fn results(design: &Design, results: &Results) -> String {
    let mut head = key_names(design);
    head.extend(design.ranges.iter().map(|range| range.key.clone()));
    let fixed =
        "end,success,start_x_m,start_y_m,start_yaw_deg,goal_x_m,goal_y_m,straight_m,duration_s,driven_m";
    head.extend(fixed.split(',').map(str::to_owned));
    head.extend(FIGURES.iter().map(|figure| figure.key.to_owned()));
    let rest = "guard_interventions,stage_failures,steps,detail";
    head.extend(rest.split(',').map(str::to_owned));
    let mut text = line(head);
    for (run, result) in results {
        let mut row = keys(design, run);
        row.extend(design.ranges.iter().map(|range| number(Some(range.draw(run.seed)))));
        row.push(result.end.clone());
        row.push(u8::from(result.is_success()).to_string());
        row.extend((0..3).map(|k| number(result.start.and_then(|start| start.get(k).copied()))));
        row.extend((0..2).map(|k| number(result.goal.and_then(|goal| goal.get(k).copied()))));
        row.push(number(result.straight_m));
        row.extend(of_outcome(result));
        row.push(result.detail.clone().unwrap_or_default());
        text += &line(row);
    }
    text
}

fn of_outcome(result: &RunResult) -> Vec<String> {
    let outcome = result.outcome.as_ref();
    let mut cells = vec![number(outcome.map(|o| o.time_s)), number(outcome.map(|o| o.path_m))];
    cells.extend(FIGURES.iter().map(|figure| number(figure.of(result))));
    let whole = |value: Option<u64>| value.map_or(String::new(), |n| n.to_string());
    cells.push(whole(outcome.map(|o| o.guard_interventions.into())));
    cells.push(whole(outcome.map(|o| o.stage_failures.into())));
    cells.push(whole(outcome.map(|o| o.steps)));
    cells
}

/// Time of each run: on the wall, and used by each part of its steps, seconds.
pub fn timing(design: &Design, results: &Results) -> String {
    let mut head = key_names(design);
    head.push("wall_s".into());
    head.extend(Part::ALL.iter().map(|part| format!("cpu_{}_s", part.name())));
    let mut text = line(head);
    for (run, result) in results {
        let Some(outcome) = &result.outcome else { continue };
        let mut row = keys(design, run);
        row.push(number(wall_s(result)));
        row.extend(Part::ALL.iter().map(|part| number(Some(outcome.cpu_s(*part)))));
        text += &line(row);
    }
    text
}

/// Time of a run on the wall.
pub fn wall_s(result: &RunResult) -> Option<f64> {
    let outcome = result.outcome.as_ref()?;
    outcome.realtime_factor.filter(|factor| *factor > 0.0).map(|factor| outcome.time_s / factor)
}

fn key_names(design: &Design) -> Vec<String> {
    let first = design.alternatives.first();
    let named = first.into_iter().filter(|a| a.named.is_some()).map(|_| "alternative".to_owned());
    let sections = first.into_iter().flat_map(|a| a.choices.iter().map(|(section, _)| section.clone()));
    named.chain(sections).chain(["world", "seed", "mission"].map(str::to_owned)).collect()
}

fn keys(design: &Design, run: &super::design::Run) -> Vec<String> {
    let alternative = design.alternatives.get(run.alternative);
    let named = alternative.and_then(|a| a.named.as_ref()).map(|named| named.name.clone());
    let plugins = alternative.into_iter().flat_map(|a| a.choices.iter().map(|(_, plugin)| plugin.clone()));
    let rest = [design.place_name(run).to_owned(), run.seed.to_string(), run.mission.to_string()];
    named.into_iter().chain(plugins).chain(rest).collect()
}

fn number(value: Option<f64>) -> String {
    // Adding zero takes the sign from a negative one.
    value.filter(|value| value.is_finite()).map_or(String::new(), |value| format!("{:.6}", value + 0.0))
}

/// Quoted as RFC 4180 says.
fn line(cells: Vec<String>) -> String {
    let mut text = String::new();
    for (idx, cell) in cells.iter().enumerate() {
        let comma = if idx == 0 { "" } else { "," };
        let _ = match cell.contains([',', '"', '\n', '\r']) {
            true => write!(text, "{comma}\"{}\"", cell.replace('"', "\"\"")),
            false => write!(text, "{comma}{cell}"),
        };
    }
    text + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_with_commas_and_quotes_stay_one_cell() {
        let row = line(vec!["a".into(), "b, \"c\"".into(), String::new()]);
        assert_eq!(row, "a,\"b, \"\"c\"\"\",\n");
        assert_eq!(
            (number(Some(-0.0)), number(Some(f64::NAN)), number(None)),
            ("0.000000".into(), String::new(), String::new())
        );
    }
}
