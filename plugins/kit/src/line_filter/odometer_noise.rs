//! How unsure the mean speed and turn are that an odometer reads.

use super::wheels::Wheels;

/// Standard deviations of an odometer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OdometerNoise {
    /// Of the distance (m per root of a meter), the direction (rad per root of a meter) and the turn (rad per root of a
    /// radian); zero is what the odometer says.
    pub way: [f64; 3],
    /// Of place (m) and direction (rad) after a second, whatever the wheels do.
    pub standing: [f64; 2],
    /// Speed and turn of an odometer that says nothing: the noise of its wheels, m/s and rad/s.
    pub wheels: Option<[f64; 2]>,
}

impl Default for OdometerNoise {
    fn default() -> Self {
        OdometerNoise { way: [0.0; 3], standing: [1e-3, 5e-4], wheels: None }
    }
}

impl OdometerNoise {
    /// That of one reading, which says so much of itself.
    pub fn of(&self, told: [f64; 3], wheels: &Wheels) -> OdometerNoise {
        let known = self.way.iter().zip(told).map(|(known, told)| if *known > 0.0 { *known } else { told });
        let mut way = [0.0; 3];
        way.iter_mut().zip(known).for_each(|(way, known)| *way = known);
        let speed_m_s = wheels.speed_m_s / std::f64::consts::SQRT_2;
        let of_wheels = (way == [0.0; 3]).then_some([speed_m_s, speed_m_s / wheels.half_track_m]);
        OdometerNoise { way, wheels: of_wheels, ..*self }
    }

    /// Variances of a mean speed and a mean turn that hold for so many seconds.
    pub fn variances(&self, [speed_m_s, turn_rad_s]: [f64; 2], seconds: f64) -> [f64; 2] {
        if let Some(wheels) = self.wheels {
            return wheels.map(|sigma| sigma * sigma);
        }
        let [distance, direction, turn] = self.way.map(|sigma| sigma * sigma);
        let [place, heading] = self.standing.map(|sigma| sigma * sigma);
        let of_speed = distance * speed_m_s.abs() + place;
        let of_turn = direction * speed_m_s.abs() + turn * turn_rad_s.abs() + heading;
        [of_speed / seconds, of_turn / seconds]
    }
}
