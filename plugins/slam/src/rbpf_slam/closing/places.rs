//! Which places of earlier visits may be here.

use crate::rbpf_slam::archive::Archive;
use rumbo_core::frames::Pose2;

/// Places to which there is a shorter way than this need no search, meters.
pub(super) const TRUSTED_WAY_M: f64 = 15.0;
/// Steps of a place lie at most this far from its middle, meters, and come at most so many before or after it.
const PLACE_REACH_M: f64 = 4.0;
const PLACE_STEPS: usize = 12;
/// Places that are this far apart are looked at separately, meters, and at most so many: the one that the robot is at may be
/// the farthest from where it believes to be.
const PLACES_APART_M: f64 = 4.0;
const MOST_PLACES: usize = 60;

/// How long the robot's way from each step to the last one was, meters.
pub(super) fn along(way: &[Pose2]) -> Vec<f64> {
    let mut total_m = 0.0;
    let mut ways_m: Vec<f64> = way
        .windows(2)
        .rev()
        .map(|pair| {
            if let [from, to] = pair {
                total_m += (from.translation.vector - to.translation.vector).norm();
            }
            total_m
        })
        .collect();
    ways_m.reverse();
    ways_m.push(0.0);
    ways_m
}

/// Steps in the middle of places that may be here, nearest first.
pub(super) fn places_of(
    archive: &Archive,
    way: &[Pose2],
    ways_m: &[f64],
    reach_of: &dyn Fn(usize) -> f64,
) -> Vec<usize> {
    let Some(here) = way.last() else { return Vec::new() };
    let off_m = |pose: &Pose2| (pose.translation.vector - here.translation.vector).norm();
    let mut near: Vec<(u64, usize)> = Vec::new();
    for (step, ((pose, way_m), taken)) in way.iter().zip(ways_m).zip(&archive.taken).enumerate() {
        if taken.is_drawn && *way_m > TRUSTED_WAY_M && off_m(pose) < reach_of(step) {
            near.push(((off_m(pose) * 1e6) as u64, step));
        }
    }
    near.sort_unstable();
    let mut middles: Vec<(usize, &Pose2)> = Vec::new();
    for (_, step) in near {
        let Some(pose) = way.get(step) else { continue };
        let apart_m = |other: &Pose2| (other.translation.vector - pose.translation.vector).norm();
        if middles.len() < MOST_PLACES && middles.iter().all(|(_, other)| apart_m(other) >= PLACES_APART_M) {
            middles.push((step, pose));
        }
    }
    middles.into_iter().map(|(step, _)| step).collect()
}

/// Steps of the same visit around a place.
pub(super) fn around<'a>(
    archive: &'a Archive,
    way: &'a [Pose2],
    place: usize,
) -> impl Iterator<Item = usize> + 'a {
    let middle = way.get(place).map_or_else(Default::default, |pose| pose.translation.vector);
    let end = (place + PLACE_STEPS + 1).min(archive.len());
    (place.saturating_sub(PLACE_STEPS)..end).filter(move |step| {
        way.get(*step).is_some_and(|pose| (pose.translation.vector - middle).norm() < PLACE_REACH_M)
    })
}
