//! Normal equations of points near lines.

use nalgebra::{Matrix3, Vector3};

/// A line `normal . p = distance`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Its unit normal.
    pub normal: [f64; 2],
    /// Its distance from the origin along the normal, meters.
    pub distance_m: f64,
    /// Variance of the normal's direction, rad².
    pub normal_rad2: f64,
}

impl Line {
    /// Signed distance of a point, meters.
    #[inline(always)]
    pub fn residual_m(&self, [x, y]: [f64; 2]) -> f64 {
        self.normal[0] * x + self.normal[1] * y - self.distance_m
    }
}

/// Sums over points: `J^T W J`, `J^T W r`, and what noise adds to the first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Equations {
    /// `J^T W J` for (x, y, yaw).
    pub information: Matrix3<f64>,
    /// `J^T W r`.
    pub gradient: Vector3<f64>,
    /// The part of `information` that wrong directions of the lines pretend.
    pub pretended: Matrix3<f64>,
    /// Weighted sum of squared residuals, m².
    pub cost_m2: f64,
    /// Sum of squared distances of the points from the base, m².
    pub spread_m2: f64,
    /// How many points.
    pub n: usize,
}

impl Default for Equations {
    fn default() -> Self {
        Equations {
            information: Matrix3::zeros(),
            gradient: Vector3::zeros(),
            pretended: Matrix3::zeros(),
            cost_m2: 0.0,
            spread_m2: 0.0,
            n: 0,
        }
    }
}

impl Equations {
    /// How the residual changes with (x, y, yaw): the normal, and the point's arm (the point turned into the line's frame,
    /// without the shift) crossed with it.
    pub fn jacobian([nx, ny]: [f64; 2], [arm_x, arm_y]: [f64; 2]) -> Vector3<f64> {
        Vector3::new(nx, ny, ny * arm_x - nx * arm_y)
    }

    /// Adds a point that is `residual_m` from its line.
    #[inline]
    pub fn add(&mut self, line: &Line, arm: [f64; 2], residual_m: f64, weight: f64) {
        let [nx, ny] = line.normal;
        let row = Self::jacobian(line.normal, arm);
        let weighted = row * weight;
        self.information += weighted * row.transpose();
        self.gradient += weighted * residual_m;
        // A normal that is off by a small angle has so much of the tangent in it.
        let tangent = Self::jacobian([-ny, nx], arm);
        self.pretended += tangent * (weight * line.normal_rad2) * tangent.transpose();
        self.cost_m2 += weight * residual_m * residual_m;
        self.spread_m2 += arm[0] * arm[0] + arm[1] * arm[1];
        self.n += 1;
    }
}
