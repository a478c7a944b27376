//! Pictures of a comparison: one row an alternative.

use super::figures::Figure;
use super::statistics::{Interval, quantile};
use crate::picture::{Anchor, Role, Sketch};

const WIDTH: f64 = 520.0;
const LEFT: f64 = 34.0;
const RIGHT: f64 = 16.0;
const TOP: f64 = 8.0;
const ROW: f64 = 34.0;
const AXIS: f64 = 24.0;
const LETTERS: f64 = 12.0;

/// One row: the values of the runs, and their mean.
pub struct Row {
    /// `A`.
    pub letter: String,
    /// One for each run that has the figure.
    pub values: Vec<f64>,
    /// Mean of the values with its interval.
    pub mean: Option<Interval>,
}

/// A dot for each run, a box from the first to the third quartile with the median, and the mean with its interval.
pub fn dots(figure: &Figure, rows: &[Row]) -> Option<Sketch> {
    let values = || rows.iter().flat_map(|row| &row.values).map(|value| value * figure.scale);
    let (low, high) = values().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    if !(low.is_finite() && high.is_finite()) {
        return None;
    }
    let axis = Axis::over(low, high);
    let mut sketch = axis.sheet(rows.len());
    for (idx, row) in rows.iter().enumerate() {
        let y = middle(idx);
        label(&mut sketch, row, y);
        let mut sorted: Vec<f64> = row.values.iter().map(|value| value * figure.scale).collect();
        for (at, value) in sorted.iter().enumerate() {
            // Spread by the run's place in the list, so that equal values can be counted.
            let offset = f64::from((at * 7 % 11) as u32) / 10.0 - 0.5;
            sketch.circle(Role::Dot, [axis.x(*value), y + offset * ROW * 0.5], 2.2);
        }
        sorted.sort_by(f64::total_cmp);
        let quartiles = [0.25, 0.5, 0.75].map(|p| quantile(&sorted, p).map(|value| axis.x(value)));
        if let [Some(first), Some(median), Some(third)] = quartiles {
            sketch.rectangle(Role::Box, [first, y - ROW * 0.3], [third, y + ROW * 0.3]);
            sketch.chain(Role::Curve, vec![[median, y - ROW * 0.3], [median, y + ROW * 0.3]]);
        }
        if let Some(mean) = row.mean {
            let x = |value: f64| axis.x(value * figure.scale);
            whisker(&mut sketch, [x(mean.low), x(mean.value), x(mean.high)], y);
        }
    }
    Some(sketch)
}

/// A bar for each share, with its interval.
pub fn bars(rows: &[(String, Option<Interval>)]) -> Sketch {
    let axis = Axis::over(0.0, 100.0);
    let mut sketch = axis.sheet(rows.len());
    for (idx, (letter, share)) in rows.iter().enumerate() {
        let y = middle(idx);
        let row = Row { letter: letter.clone(), values: vec![0.0], mean: None };
        label(&mut sketch, &row, y);
        let Some(share) = share else { continue };
        let x = |value: f64| axis.x(value * 100.0);
        sketch.rectangle(Role::Box, [axis.x(0.0), y - ROW * 0.28], [x(share.value), y + ROW * 0.28]);
        whisker(&mut sketch, [x(share.low), x(share.value), x(share.high)], y);
    }
    sketch
}

fn middle(idx: usize) -> f64 {
    TOP + ROW * (idx as f64 + 0.5)
}

fn label(sketch: &mut Sketch, row: &Row, y: f64) {
    sketch.text(Role::Text, [8.0, y + 4.0], LETTERS, Anchor::Start, row.letter.clone());
    if row.values.is_empty() {
        sketch.text(Role::Note, [LEFT + 8.0, y + 4.0], LETTERS, Anchor::Start, "no run has it");
    }
}

fn whisker(sketch: &mut Sketch, [low, value, high]: [f64; 3], y: f64) {
    sketch.chain(Role::Mean, vec![[low, y], [high, y]]);
    for end in [low, high] {
        sketch.chain(Role::Mean, vec![[end, y - 4.0], [end, y + 4.0]]);
    }
    sketch.circle(Role::Mean, [value, y], 3.2);
}

/// A scale from left to right.
struct Axis {
    low: f64,
    high: f64,
    step: f64,
}

impl Axis {
    fn over(low: f64, high: f64) -> Axis {
        let span = (high - low).max(high.abs().max(1e-3) * 1e-3);
        let raw = span / 5.0;
        let power = 10f64.powf(raw.log10().floor());
        let step = [1.0, 2.0, 5.0].into_iter().map(|m| m * power).find(|s| *s >= raw * 0.999_999);
        let step = step.unwrap_or(power * 10.0);
        let (low, high) = ((low / step + 1e-9).floor() * step, (high / step - 1e-9).ceil() * step);
        Axis { low, high: high.max(low + step), step }
    }

    fn x(&self, value: f64) -> f64 {
        LEFT + (value - self.low) / (self.high - self.low) * (WIDTH - LEFT - RIGHT)
    }

    fn sheet(&self, n_rows: usize) -> Sketch {
        let bottom = TOP + ROW * n_rows as f64;
        let mut sketch = Sketch::sheet(WIDTH, bottom + AXIS);
        let digits = (-self.step.log10()).ceil().max(0.0) as usize;
        for k in 0..=((self.high - self.low) / self.step).round() as usize {
            let value = self.low + self.step * k as f64;
            let x = self.x(value);
            sketch.chain(Role::Rule, vec![[x, TOP], [x, bottom]]);
            let text = format!("{:.digits$}", value + 0.0);
            sketch.text(Role::Note, [x, bottom + 16.0], LETTERS, Anchor::Middle, text);
        }
        sketch.chain(Role::Frame, vec![[LEFT, TOP], [LEFT, bottom], [WIDTH - RIGHT, bottom]]);
        sketch
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_holds_its_values_on_round_steps() {
        for (low, high) in [(0.0, 100.0), (5.0, 5.0), (-3.2, 0.01), (0.0, 0.0), (333.1, 351.9)] {
            let axis = Axis::over(low, high);
            assert!(axis.low <= low + 1e-9 && axis.high >= high - 1e-9 && axis.high > axis.low);
            assert!((axis.high - axis.low) / axis.step < 8.0, "{low} {high}");
        }
    }
}
