//! Which pose of one trajectory belongs to which pose of another.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use rumbo_core::frames::Pose3;
use rumbo_core::time::{Span, Time};

use super::{StampedPose, Trajectory};

/// A pose of the truth and the pose of the estimate at the same time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PosePair {
    /// The stamp of the truth.
    pub stamp: Time,
    /// The true pose.
    pub truth: Pose3,
    /// The estimated one.
    pub estimate: Pose3,
}

/// Pairs of positions in `truth` and in `estimate` whose stamps are less than `max_gap` apart, in the order of time. Of
/// all possible pairs the nearest is taken first, then the nearest of what is left, and so on; every pose once (the
/// rule of the tools of Sturm et al. 2012).
///
/// What is nearest is always adjacent on the common time line, so that a queue of neighbors finds it: n log n, however
/// large the gap.
pub fn associate(truth: &Trajectory, estimate: &Trajectory, max_gap: Span) -> Vec<(usize, usize)> {
    let mut line = TimeLine::of(truth.poses(), estimate.poses(), max_gap);
    let mut pairs = Vec::new();
    while let Some(Reverse(nearest)) = line.queue.pop() {
        if line.take(&nearest) {
            pairs.push((nearest.truth, nearest.estimate));
        }
    }
    pairs.sort_unstable();
    pairs
}

/// The poses of both trajectories that belong together.
pub fn pose_pairs(truth: &Trajectory, estimate: &Trajectory, max_gap: Span) -> Vec<PosePair> {
    let pairs = associate(truth, estimate, max_gap).into_iter();
    let pair = |(truth_idx, estimate_idx)| {
        let (truth, estimate): (&StampedPose, &StampedPose) =
            (truth.poses().get(truth_idx)?, estimate.poses().get(estimate_idx)?);
        Some(PosePair {
            stamp: truth.stamp,
            truth: truth.world_from_body,
            estimate: estimate.world_from_body,
        })
    };
    pairs.filter_map(pair).collect()
}

/// A pair that could be taken; the nearest is the least.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Candidate {
    gap_ns: u64,
    truth: usize,
    estimate: usize,
    /// Places on the time line, the earlier first.
    places: [usize; 2],
}

/// A stamp of either trajectory, and the neighbors that are still there.
struct Mark {
    stamp: Time,
    is_truth: bool,
    idx: usize,
    before: Option<usize>,
    after: Option<usize>,
    is_taken: bool,
}

struct TimeLine {
    marks: Vec<Mark>,
    queue: BinaryHeap<Reverse<Candidate>>,
    max_gap: Span,
}

impl TimeLine {
    fn of(truth: &[StampedPose], estimate: &[StampedPose], max_gap: Span) -> TimeLine {
        let stamps = |poses: &[StampedPose], is_truth| -> Vec<(Time, bool, usize)> {
            poses.iter().enumerate().map(|(idx, pose)| (pose.stamp, is_truth, idx)).collect()
        };
        let mut order = stamps(truth, true);
        order.extend(stamps(estimate, false));
        order.sort_unstable();
        let n = order.len();
        let mark = |(place, (stamp, is_truth, idx)): (usize, (Time, bool, usize))| Mark {
            stamp,
            is_truth,
            idx,
            before: place.checked_sub(1),
            after: (place + 1 < n).then_some(place + 1),
            is_taken: false,
        };
        let marks = order.into_iter().enumerate().map(mark).collect();
        let mut line = TimeLine { marks, queue: BinaryHeap::new(), max_gap };
        for place in 1..n {
            line.offer(Some(place - 1), Some(place));
        }
        line
    }

    /// Queues two neighbors, where they are of different trajectories and near enough.
    fn offer(&mut self, early: Option<usize>, late: Option<usize>) {
        let (Some(early), Some(late)) = (early, late) else { return };
        let (Some(a), Some(b)) = (self.marks.get(early), self.marks.get(late)) else { return };
        let gap_ns = b.stamp.0.abs_diff(a.stamp.0);
        let is_near = i64::try_from(gap_ns).is_ok_and(|gap_ns| gap_ns < self.max_gap.0);
        if a.is_truth != b.is_truth && is_near {
            let (truth, estimate) = if a.is_truth { (a.idx, b.idx) } else { (b.idx, a.idx) };
            self.queue.push(Reverse(Candidate { gap_ns, truth, estimate, places: [early, late] }));
        }
    }

    /// Takes both off the line; false where one of them is gone already.
    fn take(&mut self, pair: &Candidate) -> bool {
        let [early, late] = pair.places;
        if pair.places.iter().any(|place| self.marks.get(*place).is_none_or(|mark| mark.is_taken)) {
            return false;
        }
        for place in pair.places {
            if let Some(mark) = self.marks.get_mut(place) {
                mark.is_taken = true;
            }
        }
        let before = self.marks.get(early).and_then(|mark| mark.before);
        let after = self.marks.get(late).and_then(|mark| mark.after);
        if let Some(mark) = before.and_then(|place| self.marks.get_mut(place)) {
            mark.after = after;
        }
        if let Some(mark) = after.and_then(|place| self.marks.get_mut(place)) {
            mark.before = before;
        }
        self.offer(before, after);
        true
    }
}
