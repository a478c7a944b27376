//! Does the filter know what it does not know? The running mean of normalized innovations, and the band that it should keep.

use crate::normal::upper_quantile;
use std::collections::VecDeque;

/// Readings that are looked back at.
const WINDOW: usize = 50;
/// Share of right filters that leave the band: 0.1 %, on both sides together.
const OUTSIDE: f64 = 0.001;

/// Normalized innovations squared (NIS) of one kind of sensor.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Consistency {
    /// Squared distance and degrees of freedom of the last readings.
    window: VecDeque<(f64, u32)>,
}

/// What the last readings say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NisBand {
    /// Mean NIS over its degrees of freedom; 1 is what is expected.
    pub mean: f64,
    /// The band that 99.9 % of right filters keep.
    pub band: [f64; 2],
}

impl NisBand {
    /// The filter is surer than it may be.
    pub fn is_overconfident(&self) -> bool {
        self.mean > self.band[1]
    }

    /// The filter is less sure than it could be.
    pub fn is_conservative(&self) -> bool {
        self.mean < self.band[0]
    }
}

impl Consistency {
    /// Takes in one reading.
    pub fn push(&mut self, distance2: f64, degrees: u32) {
        if self.window.len() == WINDOW {
            self.window.pop_front();
        }
        self.window.push_back((distance2, degrees));
    }

    /// The mean and its band; none before there are as many readings as are looked back at.
    pub fn band(&self) -> Option<NisBand> {
        if self.window.len() < WINDOW {
            return None;
        }
        let (sum, degrees) = self.window.iter().fold((0.0, 0), |(sum, n), (d2, k)| (sum + d2, n + k));
        let z = upper_quantile(OUTSIDE / 2.0)?;
        let degrees = f64::from(degrees);
        Some(NisBand { mean: sum / degrees, band: [-z, z].map(|z| chi_square(degrees, z) / degrees) })
    }
}

/// The number that chi square stays below with the probability that a normal number stays below `z` (Wilson and Hilferty
/// 1931).
fn chi_square(degrees: f64, z: f64) -> f64 {
    let spread = 2.0 / (9.0 * degrees);
    degrees * (1.0 - spread + z * spread.sqrt()).powi(3)
}
