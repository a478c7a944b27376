//! Numbers of the control, and the speeds and offsets that follow from them.

use super::speed_profile::SpeedProfile;
use super::straight::Straight;

/// Numbers of the control, radians and meters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tuning {
    /// Speeds along a straight piece.
    pub straight: SpeedProfile,
    /// Speeds of a turn.
    pub turn: SpeedProfile,
    /// Time from one command to the next, seconds.
    pub period_s: f64,
    /// Deceleration of the straight speed that the robot surely follows, m/s².
    pub slowing_m_s2: f64,
    /// Deceleration of the turn that the robot surely follows, rad/s².
    pub slowing_rad_s2: f64,
    /// A checkpoint nearer than this is reached, meters.
    pub checkpoint_radius_m: f64,
    /// A heading nearer than this is reached, radians.
    pub heading_tolerance_rad: f64,
    /// Heading errors beyond this stop the robot for another turn, radians.
    pub max_heading_error_rad: f64,
    /// Distances from the straight piece beyond this stop the robot for another turn, meters.
    pub max_lateral_error_m: f64,
    /// Heading correction while driving, rad/s per radian of error; zero for none.
    pub heading_gain_per_s: f64,
}

impl Tuning {
    /// The correction while driving aims this far ahead on the straight piece, meters.
    const AIM_M: f64 = 0.5;
    /// The most that a robot gives way, as a part of the lateral error that would stop it.
    const MOST_ASIDE: f64 = 0.8;

    /// Speed of a straight piece of which `left_m` are left.
    pub(super) fn speed(&self, left_m: f64, length_m: f64) -> f64 {
        ending_speed(&self.straight, left_m, length_m, self.slowing_m_s2, self.period_s)
    }

    /// Rate of a turn of which `left_rad` are left.
    pub(super) fn turn_rate(&self, left_rad: f64, length_rad: f64) -> f64 {
        ending_speed(&self.turn, left_rad, length_rad, self.slowing_rad_s2, self.period_s)
    }

    /// The offset that the lane asks for, within what is no lateral error yet.
    pub(super) fn wanted_aside_m(&self, straight: &Straight) -> f64 {
        let most_m = Self::MOST_ASIDE * self.max_lateral_error_m;
        straight.lane.aside_m(straight.lateral_m).clamp(-most_m, most_m)
    }

    /// How far ahead on the straight piece the robot should look: at the checkpoint itself, or nearer for a correction
    /// that neither swings (damping of at least 0.8 with the gain) nor lags.
    pub(super) fn aim_m(&self, speed_m_s: f64, left_m: f64) -> f64 {
        let gain = self.heading_gain_per_s;
        let nearest_m = self.checkpoint_radius_m.max(1e-3);
        let aim_m = if gain > 0.0 { Self::AIM_M.max(4.0 * speed_m_s / gain).min(left_m) } else { left_m };
        aim_m.max(nearest_m)
    }
}

/// The profile's speed, but not more than still stops in time, and in the last period just enough to end exactly.
fn ending_speed(profile: &SpeedProfile, left: f64, length: f64, slowing: f64, period_s: f64) -> f64 {
    let stops_in_time = (2.0 * slowing * left).sqrt();
    profile.speed(length - left, length).min(stops_in_time).min(left / period_s)
}
