//! Where the robot was at every scan, also at those that the filter did not take in.

use rumbo_core::frames::{Pose2, interpolate2, lift};
use rumbo_core::messages::StampedPose;
use rumbo_core::time::Time;

/// One scan: seen from where the robot was at the filter's step before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entry {
    /// When.
    pub stamp: Time,
    /// Which step of the filter was the last before, or this one.
    pub step: u32,
    /// Where the robot was then, seen from that step.
    pub step_from_base: Pose2,
}

/// All scans, oldest first.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Diary {
    pub(super) entries: Vec<Entry>,
    /// When each step was, and where the next one is as the robot was followed up to it: the filter draws another pose.
    pub(super) steps: Vec<(Time, Pose2)>,
}

impl Diary {
    /// A step of the filter; the robot was followed to here from the step before.
    pub fn step(&mut self, stamp: Time, step_from_base: &Pose2) {
        if let Some((_, step_from_next)) = self.steps.last_mut() {
            *step_from_next = *step_from_base;
        }
        self.steps.push((stamp, Pose2::identity()));
        self.note(stamp, &Pose2::identity());
    }

    /// A scan that the filter does not take in.
    pub fn note(&mut self, stamp: Time, step_from_base: &Pose2) {
        let is_newer = self.entries.last().is_none_or(|last| stamp > last.stamp);
        if let (Some(step), true) = (self.steps.len().checked_sub(1), is_newer) {
            self.entries.push(Entry { stamp, step: step as u32, step_from_base: *step_from_base });
        }
    }

    /// What comes is of another clock. Scans so far are forgotten, since their stamps cannot be ordered among those to come;
    /// steps are not, since ways of particles count them.
    pub fn begin_clock_anew(&mut self) {
        self.entries.clear();
    }

    /// The poses at all scans, from where one particle was at the steps. What the filter drew differently from how the robot
    /// was followed is spread over the time between the two steps.
    pub fn trajectory(&self, way: &[Pose2]) -> Vec<StampedPose> {
        let pose = |entry: &Entry| {
            let step = entry.step as usize;
            let map_from_step = way.get(step)?;
            let mut map_from_base = map_from_step * entry.step_from_base;
            if let (Some((begin, step_from_next)), Some((end, _)), Some(map_from_next)) =
                (self.steps.get(step), self.steps.get(step + 1), way.get(step + 1))
            {
                let drawn_from_followed = step_from_next.inverse() * map_from_step.inverse() * map_from_next;
                let whole_s = (*end - *begin).as_secs();
                let share = if whole_s > 0.0 { (entry.stamp - *begin).as_secs() / whole_s } else { 0.0 };
                map_from_base *=
                    interpolate2(&Pose2::identity(), &drawn_from_followed, share.clamp(0.0, 1.0));
            }
            Some(StampedPose { stamp: entry.stamp, map_from_base: lift(&map_from_base) })
        };
        self.entries.iter().filter_map(pose).collect()
    }
}
