//! Slip: the floor gets a little more or less than the wheels roll. An open family: other crates add models.

use std::fmt::Debug;

use rand_distr::{Distribution, StandardNormal};
use rumbo_core::frames::Twist;
use rumbo_core::rng::Rng;
use serde::{Deserialize, Serialize};

/// How the motion over the floor differs from what the wheels roll, until the next draw.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlipDraw {
    /// Share of the wheels' speed that reaches the floor.
    pub speed: f64,
    /// Share of the wheels' turn that reaches the floor.
    pub turn: f64,
    /// Turn that the wheels do not know, radians per meter of way.
    pub drift_rad_per_m: f64,
}

impl SlipDraw {
    /// Wheels that grip.
    pub const NONE: Self = Self { speed: 1.0, turn: 1.0, drift_rad_per_m: 0.0 };

    /// The motion over the floor.
    pub fn apply(&self, wheels: Twist) -> Twist {
        Twist {
            forward_m_s: wheels.forward_m_s * self.speed,
            left_m_s: wheels.left_m_s * self.speed,
            turn_rad_s: wheels.turn_rad_s * self.turn + self.drift_rad_per_m * wheels.speed_m_s(),
        }
    }
}

/// A model of slip; the world draws from it 20 times a second.
#[typetag::serde(tag = "model")]
pub trait Slip: Debug + Send + Sync {
    /// The slip of the next 50 ms.
    fn draw(&self, rng: &mut Rng) -> SlipDraw;
    /// What is wrong with the parameters: key and message.
    fn faults(&self) -> Vec<(&'static str, String)>;
    /// A copy.
    fn boxed_clone(&self) -> Box<dyn Slip>;
}

impl Clone for Box<dyn Slip> {
    fn clone(&self) -> Self {
        self.boxed_clone()
    }
}

/// Every draw is independent and normal (`model = "gaussian"`).
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GaussianSlip {
    /// Standard deviation of the speed's share.
    pub speed: f64,
    /// Standard deviation of the turn's share.
    pub turn: f64,
    /// Standard deviation of unknown turning, degrees per meter.
    pub drift_deg_m: f64,
    /// Constant part of unknown turning (uneven wheels), degrees per meter.
    pub bias_deg_m: f64,
    /// Constant part of the speed's share: 0.05 when the floor gets 5 % more than the wheels roll.
    pub bias_speed: f64,
    /// Constant part of the turn's share.
    pub bias_turn: f64,
}

#[typetag::serde(name = "gaussian")]
impl Slip for GaussianSlip {
    fn draw(&self, rng: &mut Rng) -> SlipDraw {
        let mut normal = || -> f64 { StandardNormal.sample(rng) };
        SlipDraw {
            speed: 1.0 + self.bias_speed + self.speed * normal(),
            turn: 1.0 + self.bias_turn + self.turn * normal(),
            drift_rad_per_m: (self.drift_deg_m * normal() + self.bias_deg_m).to_radians(),
        }
    }

    fn faults(&self) -> Vec<(&'static str, String)> {
        let deviations = [("speed", self.speed), ("turn", self.turn), ("drift_deg_m", self.drift_deg_m)];
        let mut faults: Vec<_> = deviations
            .into_iter()
            .filter(|(_, value)| !(value.is_finite() && *value >= 0.0))
            .map(|(key, value)| (key, format!("is {value}, expected a finite number, 0 or more")))
            .collect();
        let biases =
            [("bias_deg_m", self.bias_deg_m), ("bias_speed", self.bias_speed), ("bias_turn", self.bias_turn)];
        let bad = biases.into_iter().filter(|(_, value)| !value.is_finite());
        faults.extend(bad.map(|(key, value)| (key, format!("is {value}, expected a finite number"))));
        faults
    }

    fn boxed_clone(&self) -> Box<dyn Slip> {
        Box::new(*self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_have_the_mean_and_deviation_asked_for() {
        let slip = GaussianSlip {
            speed: 0.05,
            turn: 0.1,
            drift_deg_m: 2.0,
            bias_deg_m: 0.5,
            bias_speed: 0.03,
            bias_turn: -0.02,
        };
        let mut rng = rumbo_core::rng::stream(3, "slip");
        let draws: Vec<SlipDraw> = (0..20_000).map(|_| slip.draw(&mut rng)).collect();
        let check = |pick: fn(&SlipDraw) -> f64, mean: f64, deviation: f64| {
            let n = draws.len() as f64;
            let found = draws.iter().map(pick).sum::<f64>() / n;
            let variance = draws.iter().map(|draw| (pick(draw) - found).powi(2)).sum::<f64>() / (n - 1.0);
            // Five standard errors.
            assert!((found - mean).abs() < 5.0 * deviation / n.sqrt(), "mean {found} not {mean}");
            assert!(
                (variance.sqrt() / deviation - 1.0).abs() < 5.0 / (2.0 * n).sqrt(),
                "deviation {}",
                variance.sqrt()
            );
        };
        check(|draw| draw.speed, 1.03, 0.05);
        check(|draw| draw.turn, 0.98, 0.1);
        check(|draw| draw.drift_rad_per_m.to_degrees(), 0.5, 2.0);
    }

    #[test]
    fn a_model_is_named_in_the_file_and_unknown_ones_are_refused() {
        let slip: Box<dyn Slip> = toml::from_str("model = 'gaussian'\nspeed = 0.02").unwrap();
        assert!(slip.faults().is_empty());
        assert!(toml::from_str::<Box<dyn Slip>>("model = 'ice'").is_err());
        let bad =
            GaussianSlip { speed: f64::NAN, turn: -1.0, bias_deg_m: f64::INFINITY, ..Default::default() };
        assert_eq!(bad.faults().len(), 3);
    }

    #[test]
    fn drift_turns_with_the_way_and_not_at_rest() {
        let draw = SlipDraw { drift_rad_per_m: 0.2, ..SlipDraw::NONE };
        assert_eq!(draw.apply(Twist::ZERO), Twist::ZERO);
        assert!((draw.apply(Twist::new(0.5, 0.1)).turn_rad_s - 0.2).abs() < 1e-12);
        assert!((draw.apply(Twist::new(-0.5, 0.1)).turn_rad_s - 0.2).abs() < 1e-12);
    }
}
