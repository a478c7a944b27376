//! Which observed landmark is which of a cell: discrete relaxation. S. Hernández Alamilla (2005), section 7.2.2, Algorithm 7.1.
//!
//! Corrections of the source: the element that is increased is that of the observed and the model landmark at hand, and the
//! separation of two landmarks is signed, which tells a place from its mirror image.

use rumbo_core::frames::wrap_angle;
use rumbo_kit::landmark_model::{Look, Similarity};
use rumbo_kit::landmarks::Landmark;

/// When a pair of observed landmarks lies to each other as a pair of the model does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelationTolerance {
    /// Of their distance from each other, meters (mu_s).
    pub distance_m: f64,
    /// Of the angle between them, radians.
    pub angle_rad: f64,
    /// Left is told from right.
    pub is_signed: bool,
}

/// An observed landmark that may be this one of the model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Assignment {
    /// Index among the observed.
    pub observed: usize,
    /// Index in the model.
    pub model: usize,
    /// How many other observed landmarks say so (an element of A in the source).
    pub support: u32,
}

/// How landmarks of one set lie to each other.
#[derive(Debug, Clone, Default)]
pub struct Relations {
    n: usize,
    /// Distance and angle from each to each.
    relations: Vec<[f64; 2]>,
}

impl Relations {
    /// The relations of all pairs.
    pub fn of(landmarks: &[Landmark]) -> Relations {
        let mut relations = Vec::with_capacity(landmarks.len() * landmarks.len());
        for from in landmarks {
            let [x, y] = from.position();
            relations.extend(landmarks.iter().map(|to| {
                let [to_x, to_y] = to.position();
                [(to_x - x).hypot(to_y - y), wrap_angle(to.bearing_rad - from.bearing_rad)]
            }));
        }
        Relations { n: landmarks.len(), relations }
    }

    fn between(&self, from: usize, to: usize) -> [f64; 2] {
        self.relations.get(from * self.n + to).copied().unwrap_or([f64::NAN; 2])
    }
}

/// Rounding must not decide.
const ROUNDING: f64 = 1e-9;

impl RelationTolerance {
    fn holds(&self, [a_m, a_rad]: [f64; 2], [b_m, b_rad]: [f64; 2]) -> bool {
        let apart_rad =
            if self.is_signed { wrap_angle(a_rad - b_rad).abs() } else { (a_rad.abs() - b_rad.abs()).abs() };
        (a_m - b_m).abs() <= self.distance_m + ROUNDING && apart_rad <= self.angle_rad + ROUNDING
    }
}

/// All allowed assignments (landmarks that look alike) with their support, in the order of the observed ones.
pub fn relax(
    observed: (&[Landmark], &Relations),
    model: (&[Landmark], &Relations),
    alike: &Similarity,
    within: &RelationTolerance,
) -> Vec<Assignment> {
    let mut allowed = allowed(observed.0, model.0, alike);
    let support = |this: &Assignment| {
        let agrees = |other: &Assignment| {
            other.model != this.model
                && within.holds(
                    model.1.between(this.model, other.model),
                    observed.1.between(this.observed, other.observed),
                )
        };
        // However many landmarks of the model fit, another observed one counts once.
        let groups = allowed.chunk_by(|a, b| a.observed == b.observed);
        let others = groups.filter(|group| group.first().is_some_and(|o| o.observed != this.observed));
        others.filter(|group| group.iter().any(agrees)).count() as u32
    };
    let supports: Vec<u32> = allowed.iter().map(support).collect();
    for (assignment, support) in allowed.iter_mut().zip(supports) {
        assignment.support = support;
    }
    allowed
}

fn allowed(observed: &[Landmark], model: &[Landmark], alike: &Similarity) -> Vec<Assignment> {
    let looks: Vec<Option<Look>> = model.iter().map(Look::of).collect();
    let mut allowed = Vec::new();
    for (observed, landmark) in observed.iter().enumerate() {
        let Some(seen) = Look::of(landmark) else { continue };
        let fits = |look: &Option<Look>| look.is_some_and(|look| alike.holds(&seen, &look));
        let similar = looks.iter().enumerate().filter(|(_, look)| fits(look));
        allowed.extend(similar.map(|(model, _)| Assignment { observed, model, support: 0 }));
    }
    allowed
}

/// The best supported assignment of each observed landmark, ties by the smaller difference of distances; those that nothing
/// supports are left out. Their number is n in the source.
pub fn best(allowed: &[Assignment], observed: &[Landmark], model: &[Landmark]) -> Vec<Assignment> {
    let off_m = |assignment: &Assignment| {
        let distances = [observed.get(assignment.observed), model.get(assignment.model)];
        let [Some(seen), Some(known)] = distances else { return f64::INFINITY };
        (seen.distance_m - known.distance_m).abs()
    };
    let best_of = |group: &[Assignment]| {
        let better =
            |a: &&Assignment, b: &&Assignment| a.support.cmp(&b.support).then(off_m(b).total_cmp(&off_m(a)));
        group.iter().max_by(better).filter(|assignment| assignment.support >= 1).copied()
    };
    allowed.chunk_by(|a, b| a.observed == b.observed).filter_map(best_of).collect()
}
