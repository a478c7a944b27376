//! Curves over time.

use crate::picture::{Anchor, Role, Sketch};

const WIDTH: f64 = 520.0;
const HEIGHT: f64 = 200.0;
const LEFT: f64 = 52.0;
const RIGHT: f64 = 10.0;
const TOP: f64 = 12.0;
const BOTTOM: f64 = 26.0;
const LETTERS: f64 = 12.0;

/// A curve, as pieces without gaps.
pub struct Curve {
    /// Its looks.
    pub role: Role,
    /// Time and value; a value that is not finite is a gap.
    pub points: Vec<[f64; 2]>,
}

/// Curves over the same axes; none where there is nothing to draw.
pub fn chart(curves: &[Curve], limit: Option<f64>, from_zero: bool) -> Option<Sketch> {
    let finite = || curves.iter().flat_map(|c| &c.points).filter(|[t, v]| t.is_finite() && v.is_finite());
    let last_s = finite().map(|[t, _]| *t).fold(f64::NEG_INFINITY, f64::max);
    let values = || finite().map(|[_, v]| *v).chain(limit);
    let mut low = values().fold(f64::INFINITY, f64::min);
    let mut high = values().fold(f64::NEG_INFINITY, f64::max);
    if finite().count() < 2 || last_s <= 0.0 {
        return None;
    }
    if from_zero {
        low = low.min(0.0);
    }
    if high - low < 1e-9 {
        high = low + 1e-3;
    }
    let (step, time_step) = (round_step((high - low) / 4.0), round_step(last_s / 5.0));
    let (low, high) = ((low / step).floor() * step, (high / step).ceil() * step);
    let at = |[t, v]: [f64; 2]| {
        let x = LEFT + t / last_s * (WIDTH - LEFT - RIGHT);
        [x, HEIGHT - BOTTOM - (v - low) / (high - low) * (HEIGHT - TOP - BOTTOM)]
    };
    let mut sketch = Sketch::sheet(WIDTH, HEIGHT);
    let digits = (-step.log10()).ceil().max(0.0) as usize;
    for k in 0..=((high - low) / step).round() as usize {
        let value = low + step * k as f64;
        let [x, y] = at([0.0, value]);
        sketch.chain(Role::Rule, vec![[x, y], at([last_s, value])]);
        sketch.text(Role::Note, [x - 6.0, y + 4.0], LETTERS, Anchor::End, format!("{value:.digits$}"));
    }
    for k in 0..=(last_s / time_step).floor() as usize {
        let time_s = time_step * k as f64;
        let [x, y] = at([time_s, low]);
        sketch.chain(Role::Rule, vec![[x, y], at([time_s, high])]);
        let anchor = if x > WIDTH - 40.0 { Anchor::End } else { Anchor::Middle };
        sketch.text(Role::Note, [x, y + 16.0], LETTERS, anchor, format!("{time_s} s"));
    }
    sketch.chain(Role::Frame, vec![at([0.0, high]), at([0.0, low]), at([last_s, low])]);
    for curve in curves {
        for piece in curve.points.split(|[t, v]| !(t.is_finite() && v.is_finite())) {
            sketch.chain(curve.role, thinned(piece).into_iter().map(at).collect());
        }
    }
    if let Some(limit) = limit {
        sketch.chain(Role::Limit, vec![at([0.0, limit]), at([last_s, limit])]);
    }
    Some(sketch)
}

/// 1, 2 or 5 times a power of ten, not below `raw`.
fn round_step(raw: f64) -> f64 {
    let power = 10f64.powf(raw.log10().floor());
    [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|m| m * power)
        .find(|step| *step >= raw * 0.999_999)
        .unwrap_or(power * 10.0)
}

/// Least and greatest value of each stretch of the curve, in order: peaks stay, the page stays small.
fn thinned(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    const MOST: usize = 400;
    if points.len() <= 2 * MOST {
        return points.to_vec();
    }
    let mut thin = Vec::with_capacity(2 * MOST);
    for stretch in points.chunks(points.len().div_ceil(MOST)) {
        let by_value = |a: &&[f64; 2], b: &&[f64; 2]| a[1].total_cmp(&b[1]);
        let (least, most) = (stretch.iter().min_by(by_value), stretch.iter().max_by(by_value));
        let mut pair: Vec<[f64; 2]> = least.into_iter().chain(most).copied().collect();
        pair.sort_by(|a, b| a[0].total_cmp(&b[0]));
        thin.extend(pair);
    }
    thin
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_of_axes_are_round() {
        for (raw, step) in [(0.031, 0.05), (1.0, 1.0), (1.1, 2.0), (7.0, 10.0), (0.2, 0.2)] {
            assert!((round_step(raw) - step).abs() < 1e-12, "{raw}");
        }
    }

    #[test]
    fn a_peak_survives_thinning() {
        let points: Vec<[f64; 2]> =
            (0..5000).map(|k| [f64::from(k), if k == 1234 { 9.0 } else { 0.0 }]).collect();
        let thin = thinned(&points);
        assert!(thin.len() <= 800 && thin.contains(&[1234.0, 9.0]));
        assert!(thin.windows(2).all(|w| w[0][0] <= w[1][0]));
    }

    #[test]
    fn nothing_to_draw_gives_no_chart() {
        let curve = Curve { role: Role::Curve, points: vec![[0.0, f64::NAN], [1.0, 2.0]] };
        assert!(chart(&[curve], None, true).is_none());
        let flat = Curve { role: Role::Curve, points: vec![[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]] };
        assert!(chart(&[flat], None, true).is_some());
    }
}
