//! Parts of a graph that nothing connects: each needs a pose that stays where it is.

use super::graph::PoseGraph;

/// For each pose whether it is held: those that are fixed, and the first of every part that nothing else holds.
pub(super) fn held_poses(graph: &PoseGraph) -> Vec<bool> {
    let n = graph.n_nodes();
    // Each pose points toward the first of its part.
    let mut toward: Vec<usize> = (0..n).collect();
    let mut is_held_by_prior = vec![false; n];
    for constraint in graph.constraints() {
        match constraint.from {
            Some(from) => {
                let (a, b) = (first_of(&mut toward, from), first_of(&mut toward, constraint.to));
                toward[a.max(b)] = a.min(b);
            }
            None => is_held_by_prior[constraint.to] = true,
        }
    }
    let mut part_is_held = vec![false; n];
    for (node, (by_prior, is_fixed)) in is_held_by_prior.iter().zip(graph.fixed()).enumerate() {
        if *by_prior || *is_fixed {
            let first = first_of(&mut toward, node);
            part_is_held[first] = true;
        }
    }
    (0..n)
        .map(|node| graph.fixed()[node] || (first_of(&mut toward, node) == node && !part_is_held[node]))
        .collect()
}

fn first_of(toward: &mut [usize], node: usize) -> usize {
    let mut first = node;
    while toward[first] != first {
        // Halves the way for the next one.
        toward[first] = toward[toward[first]];
        first = toward[first];
    }
    first
}
