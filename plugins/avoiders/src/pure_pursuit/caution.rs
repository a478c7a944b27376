//! How near things slow the robot.

/// See the module.
#[derive(Debug, Clone, Copy)]
pub struct Caution {
    /// What is always left of the speed, m/s.
    pub least_m_s: f64,
    /// Nearer than this to the hull things slow it, meters.
    pub slow_within_m: f64,
    /// This near, only the least is left, meters.
    pub clearance_m: f64,
}

impl Caution {
    /// How much of the speed is left beside something this near.
    pub fn beside_m_s(&self, beside_m: f64, wanted_m_s: f64) -> f64 {
        let room_m = (beside_m - self.clearance_m).max(0.0);
        let most_m = (self.slow_within_m - self.clearance_m).max(1e-9);
        (wanted_m_s * (room_m / most_m)).max(self.least_m_s)
    }
}
