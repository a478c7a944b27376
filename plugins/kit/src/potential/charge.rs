//! Charges that stand for nothing: equations (9) and (10).

use nalgebra::{Point2, Vector2};

/// A charge nearer than this counts as this near, meters: it has no direction at its own place.
pub const NEAREST_CHARGE_M: f64 = 1e-3;

/// Which force a charge has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChargeForce {
    /// Minus the gradient of the potential (9): `(m K / 2) / d^(m + 1)`.
    Consistent,
    /// As equation (10) is printed: `K / d^(m - 1)`. It is no gradient, and falls so slowly that goals are not reached.
    Printed,
}

/// What all charges have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChargeLaw {
    /// `K_c`.
    pub strength: f64,
    /// `m_c`.
    pub exponent: f64,
    /// Which force.
    pub force: ChargeForce,
    /// A charge farther than this has no effect, meters; may be infinite.
    pub range_m: f64,
}

impl ChargeLaw {
    /// `(K_c / 2) (1 / d)^m_c`, without the range.
    pub fn potential(&self, distance_m: f64) -> f64 {
        0.5 * self.strength / power(distance_m.max(NEAREST_CHARGE_M), self.exponent)
    }

    /// Size of the force away from the charge.
    pub fn push(&self, distance_m: f64) -> f64 {
        let d = distance_m.max(NEAREST_CHARGE_M);
        match self.force {
            ChargeForce::Consistent => 0.5 * self.exponent * self.strength / power(d, self.exponent + 1.0),
            ChargeForce::Printed => self.strength / power(d, self.exponent - 1.0),
        }
    }

    /// Potential of all charges at a place.
    pub fn potential_at(&self, at: Point2<f64>, charges: &[Point2<f64>]) -> f64 {
        let distances = charges.iter().map(|charge| (at - charge).norm());
        distances.filter(|d| *d <= self.range_m).map(|d| self.potential(d)).sum()
    }

    /// Force of all charges at a place.
    pub fn force_at(&self, at: Point2<f64>, charges: &[Point2<f64>]) -> Vector2<f64> {
        let mut force = Vector2::zeros();
        for charge in charges {
            let away = at - charge;
            let distance_m = away.norm();
            if distance_m <= self.range_m && distance_m > 0.0 {
                force += away * (self.push(distance_m) / distance_m);
            }
        }
        force
    }
}

/// Whole exponents, the usual ones, cost a few products.
fn power(base: f64, exponent: f64) -> f64 {
    if exponent.fract() == 0.0 && exponent.abs() <= 64.0 {
        base.powi(exponent as i32)
    } else {
        base.powf(exponent)
    }
}
