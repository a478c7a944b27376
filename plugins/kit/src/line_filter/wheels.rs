//! Speeds of the two wheels of the fixed axle (equation 1 of the source).

use super::state::State;
use super::update::Row;

/// The axle with the encoders.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wheels {
    /// Half of the distance between the wheels, meters (l).
    pub half_track_m: f64,
    /// Standard deviation of each wheel's speed, m/s (sigma_1, sigma_2).
    pub speed_m_s: f64,
    /// Readings whose squared Mahalanobis distance is above this come from a wheel that slips; 13.8 is 99.9 % of two
    /// degrees of freedom. Not in the source.
    pub slip_gate: f64,
    /// Wheels that disagree for longer than this do not slip: the prediction errs, and they are believed again, seconds.
    pub longest_slip_s: f64,
}

impl Default for Wheels {
    fn default() -> Self {
        Wheels { half_track_m: 0.45, speed_m_s: 0.02, slip_gate: 13.8, longest_slip_s: 0.6 }
    }
}

impl Wheels {
    /// Speed and turn may be off by as much as the wheels say.
    pub(super) fn doubt_motion(&self, state: &mut State, rows: &[Row; 2]) {
        let [left, right] = rows.each_ref().map(|row| row.innovation);
        let off = [(left + right) / 2.0, (right - left) / (2.0 * self.half_track_m)];
        let mut covariance = state.covariance.view_mut();
        for (column, off) in (3..).zip(off) {
            covariance[(column, column)] += off * off;
        }
    }
}
