//! How far ahead a robot must see what it stops for.

use rumbo_core::robot::Robot;

/// What a stop needs: the guard's own distance.
#[derive(Debug, Clone, Copy)]
pub struct Braking {
    /// From the base to what a robot that stands just does not touch, meters.
    pub standing_m: f64,
    latency_s: f64,
    braking_m_s2: f64,
}

impl Braking {
    /// Beyond the guard's distance, so that the avoider stops first, meters.
    const TO_SPARE_M: f64 = 0.02;

    /// Of this robot.
    pub fn of(robot: &Robot) -> Braking {
        Braking {
            standing_m: robot.hull().outer_radius_m() + robot.guard.margin_m + Self::TO_SPARE_M,
            latency_s: robot.guard.latency_s,
            braking_m_s2: robot.braking_m_s2,
        }
    }

    /// From the base to what a stop at this speed just does not touch.
    pub fn distance_m(&self, speed_m_s: f64) -> f64 {
        self.standing_m + speed_m_s.powi(2) / (2.0 * self.braking_m_s2) + speed_m_s.abs() * self.latency_s
    }
}
