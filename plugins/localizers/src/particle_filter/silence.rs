//! Times without odometry: the robot may have moved meanwhile, by how much nobody knows.

/// How long the odometer was silent since the last update of the filter.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Silence {
    seconds: f64,
}

impl Silence {
    /// Silence up to this is normal, seconds.
    const NORMAL_S: f64 = 1.0;
    /// Beyond it the robot may stray by this share of what it can do.
    const STRAY_SHARE: f64 = 0.1;
    /// Standard deviations that silence leads to at most, meters and radians.
    const MOST_STRAY: [f64; 2] = [1.0, 0.5];

    /// Two readings of the odometer are this far apart.
    pub fn add(&mut self, elapsed_s: f64) {
        self.seconds += (elapsed_s - Self::NORMAL_S).max(0.0);
    }

    /// The odometer was silent for longer than is normal.
    pub fn is_long(self) -> bool {
        self.seconds > 0.0
    }

    /// Standard deviations of place and heading that a robot of these greatest speeds (m/s, rad/s) may have strayed by,
    /// meters and radians; the silence is over.
    pub fn end(&mut self, max_speed: [f64; 2]) -> [f64; 2] {
        let seconds = std::mem::take(&mut self.seconds);
        [0, 1].map(|k| (seconds * Self::STRAY_SHARE * max_speed[k]).min(Self::MOST_STRAY[k]))
    }
}
