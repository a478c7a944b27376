//! What keeps the robot off an obstacle: equation (6), with the range that the print lacks.

/// Nearer than this to a line, a point lies on it, meters.
pub const ON_A_LINE_M: f64 = 1e-6;

/// The repulsion of one obstacle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Repulsion {
    /// `η`.
    pub strength: f64,
    /// `d_obs`: farther away the obstacle has no effect, meters.
    pub influence_m: f64,
    /// Subtracted from every distance: the radius of the robot where obstacles are inflated, meters.
    pub inflation_m: f64,
}

impl Repulsion {
    /// Obstacles farther than this from the robot's middle have no effect, meters.
    pub fn reach_m(&self) -> f64 {
        self.influence_m + self.inflation_m
    }

    /// The potential at a distance; nearly infinite on the obstacle.
    pub fn potential(&self, distance_m: f64) -> f64 {
        0.5 * self.strength * self.excess(self.rho(distance_m)).powi(2)
    }

    /// Size of the force away from the obstacle: minus the derivative of the potential.
    pub fn push(&self, distance_m: f64) -> f64 {
        let rho = self.rho(distance_m);
        self.strength * self.excess(rho) / (rho * rho)
    }

    /// The distance at which the push is as strong as this, meters: it falls steadily with the distance.
    pub fn distance_of_push_m(&self, push: f64) -> f64 {
        let (mut near, mut far) = (ON_A_LINE_M, self.influence_m);
        // 60 halvings of meters end far below the smallest length that matters.
        for _ in 0..60 {
            let middle = 0.5 * (near + far);
            if self.push(middle + self.inflation_m) > push {
                near = middle;
            } else {
                far = middle;
            }
        }
        far + self.inflation_m
    }

    fn rho(&self, distance_m: f64) -> f64 {
        (distance_m - self.inflation_m).max(ON_A_LINE_M)
    }

    fn excess(&self, rho: f64) -> f64 {
        (1.0 / rho - 1.0 / self.influence_m).max(0.0)
    }
}
