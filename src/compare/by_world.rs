//! What a study shows of each world by itself: mean, median, 95 % and worst of its runs.

use super::design::Run;
use super::figures::FIGURES;
use super::result::RunResult;
use super::statistics::{Interval, bootstrap_mean, quantile};
use serde::Serialize;

/// One line of a world's table.
#[derive(Debug, Clone, Serialize)]
pub struct Line {
    /// As the study names it.
    pub key: String,
    /// For people, with the unit.
    pub title: String,
    /// One for each alternative; none where no run has it.
    pub cells: Vec<Option<Spread>>,
}

/// How the runs of one alternative spread.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spread {
    /// How many have it.
    pub n: usize,
    /// Mean with its interval.
    pub mean: Interval,
    /// Half of the runs are at or below this.
    pub median: f64,
    /// 95 % of them are.
    pub p95: f64,
    /// The greatest.
    pub worst: f64,
    /// Digits behind the point for people.
    #[serde(skip)]
    digits: usize,
}

impl Spread {
    fn of(values: &[f64], key: &str, digits: usize) -> Option<Spread> {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let at = |share| quantile(&sorted, share);
        let (median, p95, worst) = (at(0.5)?, at(0.95)?, at(1.0)?);
        Some(Spread { n: values.len(), mean: bootstrap_mean(values, key)?, median, p95, worst, digits })
    }

    /// Mean with its interval.
    pub fn mean_in_words(&self) -> String {
        let Interval { value, low, high } = self.mean;
        let digits = self.digits;
        format!("{value:.digits$} [{low:.digits$}, {high:.digits$}]")
    }

    /// Median, 95 % and worst.
    pub fn spread_in_words(&self) -> String {
        let digits = self.digits;
        format!("{:.digits$} / {:.digits$} / {:.digits$}", self.median, self.p95, self.worst)
    }
}

/// What `keys` name, of one world and all alternatives.
pub fn lines(keys: &[String], place: usize, groups: &[Vec<(&Run, &RunResult)>]) -> Vec<Line> {
    let line = |key: &String| {
        let figure = FIGURES.iter().find(|figure| figure.key == key);
        let (scale, digits) = figure.map_or((1.0, 2), |figure| (figure.scale, figure.digits));
        let value = |result: &RunResult| match figure {
            Some(figure) => figure.of(result).map(|value| value * scale),
            None => counted(result, key),
        };
        let cell = |runs: &Vec<(&Run, &RunResult)>| {
            let here = runs.iter().filter(|(run, _)| run.place == place);
            let values: Vec<f64> = here.filter_map(|(_, result)| value(result)).collect();
            Spread::of(&values, key, digits)
        };
        let title =
            figure.map_or_else(|| key.clone(), |figure| super::table::titled(figure.name, figure.unit));
        Line { key: key.clone(), title, cells: groups.iter().map(cell).collect() }
    };
    keys.iter().map(line).collect()
}

/// A counter's mean in a run; of `NAME:last` its last value.
fn counted(result: &RunResult, key: &str) -> Option<f64> {
    let counters = &result.outcome.as_ref()?.counters;
    match key.strip_suffix(":last") {
        Some(name) => counters.get(name).map(|counted| counted.last),
        None => counters.get(key).map(|counted| counted.mean),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spread_has_the_median_and_the_worst() {
        let spread = Spread::of(&[3.0, 1.0, 2.0, 10.0], "key", 1).unwrap();
        assert_eq!((spread.n, spread.mean.value, spread.median, spread.worst), (4, 4.0, 2.5, 10.0));
        assert_eq!(spread.spread_in_words(), "2.5 / 8.9 / 10.0");
        assert_eq!(Spread::of(&[], "key", 1), None);
    }
}
