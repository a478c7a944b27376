//! From a scan to its lines, in memory that is kept.

use super::fit::{LineFit, fit, fit_weighted};
use super::points::Points;
use super::split::split;
use super::{FitWeights, LineSettings, SensedLine};
use crate::landmarks::BeamFan;
use std::ops::Range;

/// Finds lines in scans. O(n log n) in the beams where the splits halve, O(n²) at worst.
#[derive(Debug, Clone)]
pub struct LineExtractor {
    settings: LineSettings,
    points: Points,
    stack: Vec<Range<usize>>,
    pieces: Vec<Range<usize>>,
    /// Of the points of one line.
    weights: Vec<f64>,
    lines: Vec<SensedLine>,
}

impl LineExtractor {
    /// An extractor with these thresholds.
    pub fn new(settings: LineSettings) -> LineExtractor {
        LineExtractor {
            settings,
            points: Points::default(),
            stack: Vec::new(),
            pieces: Vec::new(),
            weights: Vec::new(),
            lines: Vec::new(),
        }
    }

    /// The lines of a scan in beam order.
    pub fn extract(&mut self, fan: &BeamFan, ranges_m: impl ExactSizeIterator<Item = f64>) -> &[SensedLine] {
        self.lines.clear();
        self.pieces.clear();
        self.points.place(fan, ranges_m, &self.settings);
        let Self { settings, points, stack, pieces, weights, lines } = self;
        for run in points.runs() {
            split(points, run, settings.split_m, settings.min_points, stack, |piece| {
                let joined = pieces.last().and_then(|last| joined(points, last, &piece, settings));
                match (joined, pieces.last_mut()) {
                    (Some(joined), Some(last)) => *last = joined,
                    _ => pieces.push(piece),
                }
            });
        }
        lines.extend(pieces.iter().filter_map(|piece| line_of(points, piece.clone(), settings, weights)));
        &self.lines
    }

    /// The points of the last scan.
    pub fn points(&self) -> &Points {
        &self.points
    }
}

/// Two pieces as one, if at most one point lies between them and all are near one line.
fn joined(
    points: &Points,
    one: &Range<usize>,
    next: &Range<usize>,
    settings: &LineSettings,
) -> Option<Range<usize>> {
    if next.start > one.end + 1 {
        return None;
    }
    let both = one.start..next.end;
    let line = fit(points, both.clone())?;
    let is_one = line.rms_m < settings.merge_rms_m && line.worst_m(points, both.clone()) < settings.split_m;
    is_one.then_some(both)
}

/// The line of a straight piece without its end points, which a corner may have mixed with something else.
fn line_of(
    points: &Points,
    piece: Range<usize>,
    settings: &LineSettings,
    weights: &mut Vec<f64>,
) -> Option<SensedLine> {
    let inner = piece.start + 1..piece.end.checked_sub(1)?;
    if inner.len() < settings.min_points.max(2) {
        return None;
    }
    let (line, mut covariance) = weighted(points, inner.clone(), settings, weights)?;
    let [first_m, last_m] = line.extent_m(points, inner.clone());
    if line.rms_m > settings.max_rms_m || last_m - first_m < settings.min_length_m {
        return None;
    }
    covariance[0] += settings.floor_distance_m * settings.floor_distance_m;
    covariance[2] += settings.floor_normal_rad * settings.floor_normal_rad;
    covariance.iter().all(|v| v.is_finite()).then(|| SensedLine {
        distance_m: line.distance_m,
        normal_rad: line.normal_rad,
        covariance,
        ends_m: [line.at(first_m), line.at(last_m)],
        n_points: inner.len(),
        rms_m: line.rms_m,
    })
}

/// The fit that is asked for, and its covariance.
fn weighted(
    points: &Points,
    piece: Range<usize>,
    settings: &LineSettings,
    weights: &mut Vec<f64>,
) -> Option<(LineFit, [f64; 3])> {
    let line = fit(points, piece.clone())?;
    let by_noise = settings.weights == FitWeights::Noise;
    if by_noise && line.weights(points, piece.clone(), &settings.noise, weights) {
        let line = fit_weighted(points, piece.clone(), weights)?;
        let covariance = line.weighted_covariance(points, piece, weights, &settings.noise);
        return Some((line, covariance));
    }
    Some((line, line.covariance(points, piece, &settings.noise)))
}
