//! How well a cell fits, and how the robot is turned there. S. Hernández Alamilla (2005), section 7.2.3, equations 7.1 to 7.4.
//!
//! Corrections of the source: the heading is that of the model minus the observed (equation 7.4 has the opposite sign), and
//! its mean is circular.

use super::relaxation::Assignment;
use rumbo_core::frames::wrap_angle;
use rumbo_kit::landmarks::Landmark;

/// Sum of the squares by which distances differ, m² (E, equation 7.1).
pub fn squared_error_m2(assignments: &[Assignment], observed: &[Landmark], model: &[Landmark]) -> f64 {
    let pairs = assignments.iter().filter_map(|pair| partners(pair, observed, model));
    pairs.map(|(seen, known)| (seen.distance_m - known.distance_m).powi(2)).sum()
}

/// The heading that the assignments give together: the circular mean of their differences, radians.
pub fn heading_rad(assignments: &[Assignment], observed: &[Landmark], model: &[Landmark]) -> f64 {
    mean_angle(differences(assignments, observed, model))
}

/// How far the headings of single assignments scatter around their mean: standard deviation, radians.
pub fn heading_scatter_rad(assignments: &[Assignment], observed: &[Landmark], model: &[Landmark]) -> f64 {
    let mean = heading_rad(assignments, observed, model);
    let squares = differences(assignments, observed, model).map(|angle| wrap_angle(angle - mean).powi(2));
    (squares.sum::<f64>() / assignments.len().max(1) as f64).sqrt()
}

/// Circular mean, radians.
pub fn mean_angle(angles: impl Iterator<Item = f64>) -> f64 {
    let (mut x, mut y) = (0.0, 0.0);
    for angle in angles {
        x += angle.cos();
        y += angle.sin();
    }
    y.atan2(x)
}

/// Assignments of one landmark differ in heading from the others by no more than this, radians (10 degrees).
const ONE_HEADING_RAD: f64 = 0.175;
/// Another heading counts when it has at least this share of the assignments of the best.
const OTHER_SHARE: f64 = 0.75;
/// So many headings at most: a square room has four.
const MOST_HEADINGS: usize = 4;

/// The headings that many supported assignments agree on, best first. In a room that looks the same after half a turn
/// there are two, and the mean of all would be neither.
pub fn headings_rad(allowed: &[Assignment], observed: &[Landmark], model: &[Landmark]) -> Vec<f64> {
    let supported: Vec<(usize, f64)> = allowed
        .iter()
        .filter(|pair| pair.support >= 1)
        .filter_map(|pair| {
            let (seen, known) = partners(pair, observed, model)?;
            Some((pair.observed, wrap_angle(known.bearing_rad - seen.bearing_rad)))
        })
        .collect();
    let mut votes: Vec<(usize, f64)> = supported
        .iter()
        .map(|(_, heading)| {
            let near = near(&supported, *heading);
            let n_observed = near.chunk_by(|a, b| a.0 == b.0).count();
            (n_observed, mean_angle(near.iter().map(|(_, angle)| *angle)))
        })
        .collect();
    votes.sort_by_key(|(n, _)| std::cmp::Reverse(*n));
    let most = votes.first().map_or(0, |vote| vote.0);
    let mut headings: Vec<f64> = Vec::new();
    for (n, heading) in votes {
        let is_new = headings.iter().all(|known| wrap_angle(known - heading).abs() > 2.0 * ONE_HEADING_RAD);
        if is_new && n >= 2 && n as f64 >= OTHER_SHARE * most as f64 && headings.len() < MOST_HEADINGS {
            headings.push(heading);
        }
    }
    headings
}

fn near(supported: &[(usize, f64)], heading_rad: f64) -> Vec<(usize, f64)> {
    let is_near = |(_, angle): &&(usize, f64)| wrap_angle(angle - heading_rad).abs() <= ONE_HEADING_RAD;
    supported.iter().filter(is_near).copied().collect()
}

fn differences<'a>(
    assignments: &'a [Assignment],
    observed: &'a [Landmark],
    model: &'a [Landmark],
) -> impl Iterator<Item = f64> + 'a {
    let pairs = assignments.iter().filter_map(|pair| partners(pair, observed, model));
    pairs.map(|(seen, known)| wrap_angle(known.bearing_rad - seen.bearing_rad))
}

fn partners<'a>(
    pair: &Assignment,
    observed: &'a [Landmark],
    model: &'a [Landmark],
) -> Option<(&'a Landmark, &'a Landmark)> {
    Some((observed.get(pair.observed)?, model.get(pair.model)?))
}
