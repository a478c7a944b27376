//! Where the robot was followed to since the last step, as bytes.

use super::{State, put, put_count, put_pose, put_pose_if};
use crate::gyro::{Gyro, Heading};
use crate::rbpf_slam::motion::Step;
use crate::rbpf_slam::tracker::Tracker;
use nalgebra::Matrix3;
use rumbo_core::frames::Twist;

pub(super) fn put_tracker(bytes: &mut Vec<u8>, tracker: &Tracker) {
    put_count(bytes, usize::from(tracker.stamp.is_some()));
    bytes.extend(tracker.stamp.unwrap_or_default().0.to_le_bytes());
    bytes.extend(tracker.step_stamp.0.to_le_bytes());
    put_pose(bytes, &tracker.step_from_base);
    put_pose(bytes, &tracker.since_step.before_from_after);
    put(bytes, &tracker.since_step.stray);
    put_count(bytes, usize::from(tracker.since_step.measured_turn.is_some()));
    put(bytes, &[tracker.since_step.measured_turn.unwrap_or_default()]);
    put(bytes, tracker.covariance.as_slice());
    // What was not proven yet is not known.
    let at_least = if tracker.is_on_trial() { tracker.settings().lost_after_scans } else { 0 };
    put_count(bytes, tracker.n_unmatched.max(at_least) as usize);
    put(bytes, &[tracker.way_unmatched_m]);
    put_count(bytes, tracker.adrift_since.map_or(0, |since| since + 1));
    let odometer = &tracker.odometer;
    put_pose_if(bytes, odometer.at_scan);
    let (run, newest) = odometer.turns.gyro.newest();
    // A heading of another run tells nothing.
    let at_scan = odometer.turns.at_scan.filter(|heading| heading.run == run);
    put_pose_if(bytes, at_scan.map(|heading| heading.turn));
    let (stamp, turned) = newest.unzip();
    put_pose_if(bytes, turned);
    bytes.extend(stamp.unwrap_or_default().0.to_le_bytes());
    put(bytes, &odometer.stray);
    put(bytes, &[odometer.velocity.forward_m_s, odometer.velocity.left_m_s, odometer.velocity.turn_rad_s]);
}

impl State<'_> {
    pub(super) fn tracker(&mut self, tracker: &mut Tracker) -> Option<()> {
        let (has_stamp, stamp) = (self.count()? > 0, self.time()?);
        tracker.stamp = has_stamp.then_some(stamp);
        tracker.step_stamp = self.time()?;
        tracker.step_from_base = self.pose()?;
        let (before_from_after, stray) = (self.pose()?, self.numbers()?);
        let (is_measured, variance) = (self.count()? > 0, self.number()?);
        let measured_turn = is_measured.then_some(variance);
        tracker.since_step = Step { before_from_after, stray, measured_turn };
        tracker.covariance = Matrix3::from_column_slice(&self.numbers::<9>()?);
        tracker.n_unmatched = self.count()? as u32;
        tracker.way_unmatched_m = self.number()?;
        tracker.adrift_since = self.count()?.checked_sub(1);
        tracker.odometer.at_scan = self.pose_if()?;
        let at_scan = self.pose_if()?;
        let (turned, stamp) = (self.pose_if()?, self.time()?);
        tracker.odometer.turns.gyro = Gyro::go_on(0, turned.map(|turned| (stamp, turned)));
        tracker.odometer.turns.at_scan = at_scan.map(|turn| Heading { run: 0, turn });
        tracker.odometer.stray = self.numbers()?;
        let [forward_m_s, left_m_s, turn_rad_s] = self.numbers()?;
        tracker.odometer.velocity = Twist { forward_m_s, left_m_s, turn_rad_s };
        Some(())
    }
}
