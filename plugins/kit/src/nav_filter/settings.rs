//! How the filter works.

use rumbo_core::time::Span;

/// Settings of the filter; names as in the specification of the disaster robot, section 10.
#[derive(Debug, Clone, PartialEq)]
pub struct NavSettings {
    /// Standard deviation of each turning rate, rad/s.
    pub gyro_noise_rad_s: f64,
    /// Standard deviation of each specific force, m/s².
    pub accel_noise_m_s2: f64,
    /// How the bias of the rates walks, rad/s per root of a second.
    pub gyro_bias_walk: f64,
    /// How the bias of the forces walks, m/s² per root of a second.
    pub accel_bias_walk: f64,
    /// Standard deviation of the rates' bias at the start, rad/s.
    pub gyro_bias_rad_s: f64,
    /// Standard deviation of the forces' bias at the start, m/s².
    pub accel_bias_m_s2: f64,
    /// The body is leveled by forces whose length is this near to gravity, m/s².
    pub gravity_gate_m_s2: f64,
    /// At rates beyond this a leveling counts less, rad/s.
    pub leveling_rate_rad_s: f64,
    /// Standard deviation of roll and pitch by leveling, radians.
    pub leveling_std_rad: f64,
    /// Where gravity has said for so long that roll and pitch are wrong, they are what it says; at once where the robot stands.
    pub level_anew_after: Span,
    /// Standard deviation of the body's sideways velocity of a robot that cannot drive sideways, m/s; none for one that can.
    pub body_lateral_m_s: Option<f64>,
    /// Standard deviation of the body's vertical velocity, m/s.
    pub body_vertical_m_s: f64,
    /// Standard deviation of the velocity of a robot that stands, m/s.
    pub standing_m_s: f64,
    /// Standard deviation of its turning rates beside the device's own noise, rad/s.
    pub standing_rad_s: f64,
    /// Each aid is used at most once in this time.
    pub aid_period: Span,
    /// So many refused updates in a row, and the covariance is multiplied by 4.
    pub max_rejects: u32,
    /// States of the last moments are kept for measurements that come late.
    pub history: Span,
    /// There is no integration over longer gaps.
    pub max_gap: Span,
    /// The robot's greatest acceleration, for what a gap may have changed, m/s².
    pub max_acceleration_m_s2: f64,
    /// Longer specific forces are no readings, m/s².
    pub accel_limit_m_s2: f64,
    /// Higher rates are no readings, rad/s.
    pub rate_limit_rad_s: f64,
    /// Without a sample for this long the filter is stale.
    pub stale_after: Span,
    /// How much less sure roll and pitch of a stale filter get, rad/s.
    pub stale_rad_s: f64,
    /// Weight of a planar pose in covariance intersection.
    pub omega: Omega,
    /// What covariance intersection applies to.
    pub intersected: Intersected,
}

/// Weight of a measurement in covariance intersection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Omega {
    /// Always the same, from 0 up to but not including 1.
    Fixed(f64),
    /// The one that makes the trace of the pose's covariance least.
    Best,
}

/// What covariance intersection applies to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Intersected {
    /// The planar pose; other states follow by what they have in common with it.
    Pose,
    /// All states, as published.
    Everything,
}

/// A setting that cannot be.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("{name} is {value}, expected {expected}")]
pub struct NavFault {
    /// Which.
    pub name: &'static str,
    /// What it is.
    pub value: f64,
    /// What it may be.
    pub expected: &'static str,
}

impl Default for NavSettings {
    fn default() -> Self {
        NavSettings {
            gyro_noise_rad_s: 0.01,
            accel_noise_m_s2: 0.2,
            gyro_bias_walk: 1e-4,
            accel_bias_walk: 1e-3,
            gyro_bias_rad_s: 0.02,
            accel_bias_m_s2: 0.1,
            gravity_gate_m_s2: 0.5,
            leveling_rate_rad_s: 0.3,
            leveling_std_rad: 0.05,
            level_anew_after: Span(1_000_000_000),
            body_lateral_m_s: Some(0.1),
            body_vertical_m_s: 0.1,
            standing_m_s: 0.01,
            standing_rad_s: 0.001,
            aid_period: Span(50_000_000),
            max_rejects: 10,
            history: Span(1_000_000_000),
            max_gap: Span(200_000_000),
            max_acceleration_m_s2: 3.0,
            accel_limit_m_s2: 160.0,
            rate_limit_rad_s: 35.0,
            stale_after: Span(1_000_000_000),
            stale_rad_s: 0.05,
            omega: Omega::Best,
            intersected: Intersected::Pose,
        }
    }
}

impl NavSettings {
    /// Everything that cannot be.
    pub fn faults(&self) -> Vec<NavFault> {
        let above_0 = [
            ("gyro_noise", self.gyro_noise_rad_s),
            ("accel_noise", self.accel_noise_m_s2),
            ("gravity_gate", self.gravity_gate_m_s2),
            ("leveling_rate", self.leveling_rate_rad_s),
            ("leveling_std", self.leveling_std_rad),
            ("body_lateral", self.body_lateral_m_s.unwrap_or(1.0)),
            ("body_vertical", self.body_vertical_m_s),
            ("standing_m_s", self.standing_m_s),
            ("standing_rad_s", self.standing_rad_s),
            ("max_gap", self.max_gap.as_secs()),
            ("max_acceleration", self.max_acceleration_m_s2),
            ("accel_limit", self.accel_limit_m_s2),
            ("rate_limit", self.rate_limit_rad_s),
            ("stale_after", self.stale_after.as_secs()),
            ("level_anew_after", self.level_anew_after.as_secs()),
            ("max_rejects", f64::from(self.max_rejects)),
        ];
        let at_least_0 = [
            ("gyro_bias_walk", self.gyro_bias_walk),
            ("accel_bias_walk", self.accel_bias_walk),
            ("gyro_bias", self.gyro_bias_rad_s),
            ("accel_bias", self.accel_bias_m_s2),
            ("aid_period", self.aid_period.as_secs()),
            ("history", self.history.as_secs()),
            ("stale_rad_s", self.stale_rad_s),
        ];
        let fault = |fine: bool, name, value, expected| (!fine).then_some(NavFault { name, value, expected });
        let above_0 = above_0
            .into_iter()
            .filter_map(|(name, v)| fault(v > 0.0 && v.is_finite(), name, v, "a number above 0"));
        let at_least_0 = at_least_0
            .into_iter()
            .filter_map(|(name, v)| fault(v >= 0.0 && v.is_finite(), name, v, "a number of at least 0"));
        let omega = match self.omega {
            Omega::Fixed(omega) => {
                fault((0.0..1.0).contains(&omega), "omega", omega, "a weight from 0 to less than 1")
            }
            Omega::Best => None,
        };
        above_0.chain(at_least_0).chain(omega).collect()
    }
}
