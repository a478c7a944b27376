//! The way of a guess, given that it came back to a place: the mean of all its steps under what the loop says.
//!
//! A filter draws only its newest step anew; where a loop is found open that is too late. Drawing a block of past steps
//! together with it is block sampling (Doucet, Briers, Sénécal, "Efficient block sampling strategies for sequential Monte
//! Carlo methods", 2006; for maps: Beevers, Huang, "Fixed-lag sampling strategies for particle filtering SLAM", 2007). Here
//! the block is the whole loop, and what is drawn is its mean: each step is a Gaussian around where the guess took it, so
//! that least squares give it.

use super::archive::{Archive, Link, turned_into};
use nalgebra::Matrix3;
use rumbo_core::frames::Pose2;
use rumbo_kit::pose_graph::{Constraint, GraphOptimizer, OptimizeSettings, PoseGraph, RobustKernel};

/// A loop that all that is known makes less probable than one this many deviations away is a false one, squared.
const MOST_SURPRISE: f64 = 25.0;
/// A loop that moves two steps in a row so far against each other is a false one, meters and radians.
const MOST_TORN: [f64; 2] = [0.5, 0.35];

/// The way, bent so that the link holds; none where that is too improbable, or would tear it.
pub fn bent(archive: &Archive, way: &[Pose2], link: &Link, earlier_from_later: &Pose2) -> Option<Vec<Pose2>> {
    let mut graph = PoseGraph::default();
    for pose in way {
        graph.add_pose(pose).ok()?;
    }
    graph.fix(0).ok()?;
    let seen = |from: usize, to: usize| Some(way.get(from)?.inverse() * way.get(to)?);
    // What was known before agrees with the way as it is.
    for (to, taken) in archive.taken.iter().enumerate().take(way.len()).skip(1) {
        let from_to = seen(to - 1, to)?;
        let information = taken.covariance.try_inverse().unwrap_or_else(Matrix3::identity);
        let information = turned_into(&from_to, &information);
        let from = Some(to - 1);
        graph.add(Constraint { from, to, from_to, information, kernel: RobustKernel::Quadratic }).ok()?;
    }
    for old in &archive.links {
        let from_to = seen(old.earlier, old.later)?;
        graph.add(constraint(old, from_to)).ok()?;
    }
    graph.add(constraint(link, *earlier_from_later)).ok()?;
    let settings = OptimizeSettings { least_decrease: 1e-4, ..OptimizeSettings::default() };
    GraphOptimizer::default().optimize(&mut graph, &settings);
    // Nothing but the loop disagrees with the way as it was, so that what is left is how improbable the loop is.
    if graph.cost() > MOST_SURPRISE {
        return None;
    }
    let bent: Vec<Pose2> = (0..way.len()).filter_map(|step| graph.pose(step)).collect();
    let is_torn = way.windows(2).zip(bent.windows(2)).any(|(before, after)| {
        let (&[a, b], &[c, d]) = (before, after) else { return false };
        let off = (a.inverse() * b).inverse() * (c.inverse() * d);
        off.translation.vector.norm() > MOST_TORN[0] || off.rotation.angle().abs() > MOST_TORN[1]
    });
    (!is_torn).then_some(bent)
}

fn constraint(link: &Link, from_to: Pose2) -> Constraint {
    let (from, to, information) = (Some(link.earlier), link.later, link.information);
    Constraint { from, to, from_to, information, kernel: RobustKernel::Quadratic }
}
