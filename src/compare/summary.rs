//! From runs to alternatives: intervals, paired differences, and the Pareto set.

use super::by_world::{Line, lines};
use super::design::{Design, Run};
use super::figures::FIGURES;
use super::pareto::{OBJECTIVES, mark};
use super::result::RunResult;
use super::statistics::{Interval, bootstrap_mean, mean, paired_change, wilson};
use rumbo_core::engine::Part;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// Results by run.
pub type Results = BTreeMap<Run, RunResult>;

/// What the sweep says.
#[derive(Debug, Serialize)]
pub struct Summary {
    /// In the order of the swaps.
    pub alternatives: Vec<Standing>,
    /// The second minus the first, run by run in the same world, mission and seed.
    pub differences: Vec<Difference>,
    /// What a study shows of each world by itself.
    pub by_world: BTreeMap<String, Vec<Line>>,
    /// What the Pareto set is meant for.
    pub objectives: Vec<&'static str>,
}

/// One alternative.
#[derive(Debug, Serialize)]
pub struct Standing {
    /// `planner=dp localizer=odometry`.
    pub name: String,
    /// Runs.
    pub n: usize,
    /// Runs that succeeded.
    pub n_successes: usize,
    /// Their share, with Wilson's interval.
    pub success: Option<Interval>,
    /// The same for each world by itself.
    pub success_by_world: BTreeMap<String, Interval>,
    /// Runs with contact; absent where no run knows.
    pub n_with_contact: Option<usize>,
    /// How often the runs ended for which reason.
    pub ends: BTreeMap<String, usize>,
    /// What the first run said that did not even drive.
    pub trouble: Option<String>,
    /// Mean of each figure, with its bootstrap interval and the number of runs that have it.
    pub figures: BTreeMap<&'static str, Estimate>,
    /// Mean time to the goal in the settings that every alternative with any success completed, seconds: who fails the long
    /// missions is not quicker for it.
    pub common_time_s: Option<f64>,
    /// Mean time used by each part of the steps, seconds of one run; of runs that drove.
    pub cpu_s: BTreeMap<&'static str, Estimate>,
    /// No other alternative is better in one objective without being worse in another.
    pub is_pareto: bool,
}

/// A mean and what it was made of.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Estimate {
    /// How many values.
    pub n: usize,
    /// The mean with its interval.
    #[serde(flatten)]
    pub interval: Interval,
}

/// Two alternatives.
#[derive(Debug, Serialize)]
pub struct Difference {
    /// The first.
    pub from: String,
    /// The second.
    pub to: String,
    /// Change of the success rate, with Newcombe's interval for pairs.
    pub success: Option<Estimate>,
    /// Change of each figure, over the pairs in which both have it.
    pub figures: BTreeMap<&'static str, Estimate>,
}

/// Sums the results up.
pub fn summarize(design: &Design, results: &Results) -> Summary {
    let of = |alternative: usize| -> Vec<(&Run, &RunResult)> {
        results.iter().filter(|(run, _)| run.alternative == alternative).collect()
    };
    let groups: Vec<_> = (0..design.alternatives.len()).map(of).collect();
    let mut alternatives: Vec<Standing> =
        design.alternatives.iter().zip(&groups).map(|(a, runs)| standing(design, a.name(), runs)).collect();
    let common = common_settings(&groups);
    for (standing, runs) in alternatives.iter_mut().zip(&groups) {
        let times: Vec<f64> = runs
            .iter()
            .filter(|(run, result)| result.is_success() && common.contains(&run.setting()))
            .filter_map(|(_, result)| Some(result.outcome.as_ref()?.time_s))
            .collect();
        standing.common_time_s = mean(&times);
    }
    mark(&mut alternatives);
    let mut differences = Vec::new();
    for (idx, from) in groups.iter().enumerate() {
        for (jdx, to) in groups.iter().enumerate().skip(idx + 1) {
            let name = |k: usize| design.alternatives.get(k).map(|a| a.name()).unwrap_or_default();
            differences.push(difference((name(idx), name(jdx)), from, to));
        }
    }
    let shown = design.places.iter().enumerate().filter(|_| !design.show.is_empty());
    let by_world = shown.map(|(idx, place)| (place.name.clone(), lines(&design.show, idx, &groups)));
    let by_world = by_world.collect();
    Summary { alternatives, differences, by_world, objectives: OBJECTIVES.to_vec() }
}

/// Settings that every alternative completed, but for those that completed none.
fn common_settings(groups: &[Vec<(&Run, &RunResult)>]) -> BTreeSet<(usize, u64, u32)> {
    let completed = |runs: &Vec<(&Run, &RunResult)>| -> BTreeSet<_> {
        runs.iter().filter(|(_, result)| result.is_success()).map(|(run, _)| run.setting()).collect()
    };
    let able = groups.iter().map(completed).filter(|settings| !settings.is_empty());
    able.reduce(|common, settings| &common & &settings).unwrap_or_default()
}

fn standing(design: &Design, name: String, runs: &[(&Run, &RunResult)]) -> Standing {
    let n_successes = runs.iter().filter(|(_, result)| result.is_success()).count();
    let mut ends = BTreeMap::new();
    for (_, result) in runs {
        *ends.entry(result.end.clone()).or_insert(0) += 1;
    }
    let outcomes = || runs.iter().filter_map(|(_, result)| result.outcome.as_ref());
    let contacts: Vec<u32> = outcomes().filter_map(|outcome| outcome.contacts).collect();
    let figures = FIGURES.iter().filter_map(|figure| {
        let sample: Vec<f64> = runs.iter().filter_map(|(_, result)| figure.of(result)).collect();
        Some((figure.key, estimate(&sample, figure.key)?))
    });
    let cpu = Part::ALL.iter().filter_map(|part| {
        let sample: Vec<f64> = outcomes().map(|outcome| outcome.cpu_s(*part)).collect();
        Some((part.name(), estimate(&sample, part.name())?))
    });
    let share = |place: usize| {
        let here = || runs.iter().filter(|(run, _)| run.place == place);
        wilson(here().filter(|(_, result)| result.is_success()).count(), here().count())
    };
    let by_world = design.places.iter().enumerate();
    let by_world = by_world.filter_map(|(idx, place)| Some((place.name.clone(), share(idx)?)));
    Standing {
        name,
        n: runs.len(),
        n_successes,
        success: wilson(n_successes, runs.len()),
        success_by_world: by_world.collect(),
        n_with_contact: (!contacts.is_empty()).then(|| contacts.iter().filter(|n| **n > 0).count()),
        ends,
        trouble: runs.iter().find(|(_, result)| result.outcome.is_none()).and_then(|(_, r)| r.detail.clone()),
        figures: figures.collect(),
        common_time_s: None,
        cpu_s: cpu.collect(),
        is_pareto: false,
    }
}

fn estimate(sample: &[f64], name: &str) -> Option<Estimate> {
    Some(Estimate { n: sample.len(), interval: bootstrap_mean(sample, name)? })
}

fn difference(
    (from, to): (String, String),
    first: &[(&Run, &RunResult)],
    second: &[(&Run, &RunResult)],
) -> Difference {
    let by_setting: BTreeMap<_, &RunResult> =
        second.iter().map(|(run, result)| (run.setting(), *result)).collect();
    let pairs: Vec<(&RunResult, &RunResult)> =
        first.iter().filter_map(|(run, result)| Some((*result, *by_setting.get(&run.setting())?))).collect();
    let successes: Vec<(bool, bool)> = pairs.iter().map(|(a, b)| (a.is_success(), b.is_success())).collect();
    let success = paired_change(&successes).map(|interval| Estimate { n: successes.len(), interval });
    let figures = FIGURES.iter().filter_map(|figure| {
        let changes: Vec<f64> =
            pairs.iter().filter_map(|(a, b)| Some(figure.of(b)? - figure.of(a)?)).collect();
        Some((figure.key, estimate(&changes, figure.key)?))
    });
    Difference { from, to, success, figures: figures.collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::{swap, worlds::Place};
    use crate::outcome::Outcome;
    use crate::record::test_record;
    use rumbo_core::engine::EndReason;

    fn result(time_s: f64, arrived: bool) -> RunResult {
        let reason = if arrived { EndReason::Arrived } else { EndReason::Stuck };
        let outcome = Outcome { time_s, arrived, reason, ..test_record().outcome.unwrap() };
        RunResult {
            end: reason.to_string(),
            detail: None,
            start: None,
            goal: None,
            straight_m: Some(2.0),
            outcome: Some(outcome),
            drawn: Vec::new(),
            as_expected: None,
        }
    }

    #[test]
    fn differences_are_paired_and_leave_out_pairs_that_only_one_has() {
        let design = Design {
            title: String::new(),
            base: "p.toml".into(),
            sets: Vec::new(),
            ranges: Vec::new(),
            alternatives: swap::alternatives(&[swap::parse("planner=dp,a_star").unwrap()], &[]),
            places: vec![Place::own()],
            seeds: vec![1, 2, 3, 4],
            show: Vec::new(),
        };
        let times =
            [[(10.0, true), (12.0, true)], [(100.0, true), (104.0, true)], [(1.0, false), (9.0, true)]];
        let mut results = Results::new();
        for (seed, pair) in (1..).zip(times) {
            for (alternative, (time_s, arrived)) in pair.into_iter().enumerate() {
                results.insert(Run { alternative, place: 0, seed, mission: 0 }, result(time_s, arrived));
            }
        }
        // Seed 4 has no partner.
        results.insert(Run { alternative: 0, place: 0, seed: 4, mission: 0 }, result(50.0, true));
        let summary = summarize(&design, &results);
        let change = &summary.differences[0];
        assert_eq!((change.from.as_str(), change.to.as_str()), ("planner=dp", "planner=a_star"));
        let time = change.figures["time_s"];
        // By hand: (12 - 10 + 104 - 100) / 2, between the two differences.
        assert_eq!((time.n, time.interval.value, time.interval.low, time.interval.high), (2, 3.0, 2.0, 4.0));
        assert!((change.success.unwrap().interval.value - 1.0 / 3.0).abs() < 1e-12);
        // Settings 1 and 2 are those that both completed.
        let common: Vec<_> = summary.alternatives.iter().map(|standing| standing.common_time_s).collect();
        assert_eq!(common, [Some(55.0), Some(58.0)]);
        let first = &summary.alternatives[0];
        assert_eq!((first.n, first.n_successes, first.ends["stuck"]), (4, 3, 1));
        assert!((first.figures["time_s"].interval.value - 160.0 / 3.0).abs() < 1e-9);
    }
}
