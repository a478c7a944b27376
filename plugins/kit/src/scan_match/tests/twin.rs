//! Matching as it is written in the specification, in double precision and without haste.

use super::super::*;
use super::scenes::Scene;
use nalgebra::Vector3;
use rumbo_core::frames::{Point2, Pose2};

pub struct Twin {
    pub width: usize,
    pub height: usize,
    pub resolution_m: f64,
    pub level_from_map: Pose2,
    pub p: Vec<f64>,
    pub is_touched: Vec<bool>,
}

impl Twin {
    pub fn of(scene: &Scene) -> Twin {
        Twin {
            width: scene.size.width,
            height: scene.size.height,
            resolution_m: scene.resolution_m,
            level_from_map: scene.map_from_level.inverse(),
            p: scene.cells.iter().map(|v| 1.0 / (1.0 + (-f64::from(*v)).exp())).collect(),
            is_touched: scene.cells.iter().map(|v| *v != 0.0).collect(),
        }
    }

    /// Value, gradient a meter in the map's axes, and whether a corner is touched.
    pub fn value(&self, point: Point2) -> Option<(f64, [f64; 2], bool)> {
        let at = self.level_from_map * point;
        let [u, v] = [at.x, at.y].map(|m| m / self.resolution_m - 0.5);
        // Within rounding of the border it is still on it.
        let slack = 1e-9;
        let inside = u >= -slack
            && v >= -slack
            && u <= self.width as f64 - 1.0 + slack
            && v <= self.height as f64 - 1.0 + slack;
        if !inside {
            return None;
        }
        let i = ((u + slack).floor() as usize).min(self.width - 2);
        let j = ((v + slack).floor() as usize).min(self.height - 2);
        let (fx, fy) = (u - i as f64, v - j as f64);
        let index = |i: usize, j: usize| j * self.width + i;
        let corners = [index(i, j), index(i + 1, j), index(i, j + 1), index(i + 1, j + 1)];
        let [p00, p10, p01, p11] = corners.map(|k| self.p[k]);
        let value = fy * (fx * p11 + (1.0 - fx) * p01) + (1.0 - fy) * (fx * p10 + (1.0 - fx) * p00);
        let dx = (fy * (p11 - p01) + (1.0 - fy) * (p10 - p00)) / self.resolution_m;
        let dy = (fx * (p11 - p10) + (1.0 - fx) * (p01 - p00)) / self.resolution_m;
        let gradient = self.level_from_map.rotation.inverse() * nalgebra::Vector2::new(dx, dy);
        Some((value, [gradient.x, gradient.y], corners.iter().any(|k| self.is_touched[*k])))
    }

    pub fn linearize(&self, points: &ScanPoints, pose: &Pose2) -> Linearized {
        let exact: Vec<[f64; 3]> = points.iter().map(|point| point.map(f64::from)).collect();
        self.linearize_exact(&exact, pose)
    }

    pub fn linearize_exact(&self, points: &[[f64; 3]], pose: &Pose2) -> Linearized {
        let mut sums = Linearized::default();
        let (sin, cos) = pose.rotation.angle().sin_cos();
        for [sx, sy, weight] in points {
            let Some((value, [gx, gy], is_known)) = self.value(pose * Point2::new(*sx, *sy)) else {
                continue;
            };
            let row = Vector3::new(gx, gy, gx * (-sin * sx - cos * sy) + gy * (cos * sx - sin * sy));
            sums.hessian += row * row.transpose() * *weight;
            sums.descent += row * (1.0 - value) * *weight;
            sums.cost += weight * (1.0 - value).powi(2);
            sums.shortfall += weight * (1.0 - value);
            sums.weight += weight;
            sums.n_used += 1;
            sums.n_known += usize::from(is_known);
        }
        sums
    }
}
