//! Relative pose error.

use rumbo_core::frames::Pose3;
use rumbo_core::time::Span;

use super::{PosePair, Similarity};

/// How far apart the two poses of a relative error are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Step {
    /// So many pairs of poses; at least 1.
    Frames(usize),
    /// At least so long.
    Seconds(f64),
    /// At least so much way along the estimate.
    Meters(f64),
}

/// Which pairs of poses are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PairChoice {
    /// From the first pose one step on, from there another step, and so on.
    Consecutive,
    /// One step on from every pose: the steps overlap.
    #[default]
    EveryStart,
    /// Every pose with every later one, whatever the step.
    All,
}

/// The errors of all compared pairs.
#[doc(alias = "RPE")]
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RelativeErrors {
    /// Lengths of the translation parts, meters.
    pub translation_m: Vec<f64>,
    /// Angles of the rotation parts, radians.
    pub rotation_rad: Vec<f64>,
}

/// Positions of the first and the second pose of each comparison.
pub fn index_pairs(pairs: &[PosePair], step: Step, choice: PairChoice) -> Vec<(usize, usize)> {
    let n = pairs.len();
    match choice {
        PairChoice::All => (0..n).flat_map(|from| (from + 1..n).map(move |to| (from, to))).collect(),
        PairChoice::EveryStart => {
            let ruler = Ruler::of(pairs, step);
            (0..n).map_while(|from| Some((from, ruler.one_step_on(from)?))).collect()
        }
        PairChoice::Consecutive => {
            let ruler = Ruler::of(pairs, step);
            let ends = std::iter::successors(Some(0), |from| ruler.one_step_on(*from));
            let ends: Vec<usize> = ends.collect();
            ends.iter().copied().zip(ends.iter().copied().skip(1)).collect()
        }
    }
}

/// The errors of these comparisons: `(Qi⁻¹ Qj)⁻¹ (Pi⁻¹ Pj)` with the true poses Q and the aligned ones P (Sturm et al.
/// 2012, equation 1).
pub fn relative_errors(
    pairs: &[PosePair],
    alignment: &Similarity,
    compared: &[(usize, usize)],
) -> RelativeErrors {
    let mut errors = RelativeErrors::default();
    for (from, to) in compared {
        let (Some(from), Some(to)) = (pairs.get(*from), pairs.get(*to)) else { continue };
        let true_motion = from.truth.inverse() * to.truth;
        let motion = alignment.apply(&from.estimate).inverse() * alignment.apply(&to.estimate);
        let error: Pose3 = true_motion.inverse() * motion;
        errors.translation_m.push(error.translation.vector.norm());
        errors.rotation_rad.push(error.rotation.angle());
    }
    errors
}

/// How far along each pair is, in the unit of the step.
struct Ruler {
    marks: Vec<f64>,
    step: f64,
}

impl Ruler {
    fn of(pairs: &[PosePair], step: Step) -> Ruler {
        let start = pairs.first().map(|pair| pair.stamp).unwrap_or_default();
        let mut last = pairs.first().map(|pair| pair.estimate.translation.vector).unwrap_or_default();
        let mut way_m = 0.0;
        let mark = |(idx, pair): (usize, &PosePair)| match step {
            Step::Frames(_) => idx as f64,
            Step::Seconds(_) => (pair.stamp - start).as_secs(),
            Step::Meters(_) => {
                let place = pair.estimate.translation.vector;
                way_m += (place - last).norm();
                last = place;
                way_m
            }
        };
        let marks = pairs.iter().enumerate().map(mark).collect();
        let step = match step {
            Step::Frames(n) => n.max(1) as f64,
            // Stamps are whole nanoseconds; their differences as seconds are not.
            Step::Seconds(seconds) => seconds - Span(1).as_secs() / 2.0,
            Step::Meters(meters) => meters,
        };
        Ruler { marks, step }
    }

    /// The first pair at least one step behind another.
    fn one_step_on(&self, from: usize) -> Option<usize> {
        let end = self.marks.get(from)? + self.step;
        let rest = self.marks.get(from + 1..)?;
        let to = from + 1 + rest.partition_point(|mark| *mark < end);
        (to < self.marks.len()).then_some(to)
    }
}
