//! Beam model of a range finder as a table: how probable is this reading where that range is expected?
//!
//! Thrun, Burgard, Fox, *Probabilistic Robotics* (2005), table 6.1: a reading hits what the map shows, or something
//! nearer that it does not show, or nothing, or it is anything. The table holds the logarithm for every pair of expected
//! and measured range in steps of `bin_m`, as distance from its maximum in 65,535 steps, so that beams add up as
//! integers. [`BeamShape::likelihood`] is the slow twin.

use crate::normal::cumulative;
use std::f64::consts::TAU;

/// How probable a reading is by the range that the map lets expect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeamShape {
    /// Share of readings that hit what the map shows.
    pub z_hit: f64,
    /// Share of those that hit something nearer.
    pub z_short: f64,
    /// Share of those that hit nothing.
    pub z_max: f64,
    /// Share of those that can be anything.
    pub z_rand: f64,
    /// Standard deviation of hits, meters.
    pub sigma_hit_m: f64,
    /// How fast things that the map does not show become rarer with the range, 1/m.
    pub lambda_short_per_m: f64,
    /// Reach of the device, meters.
    pub z_max_range_m: f64,
}

/// The four parts of the mixture, before their shares.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeamParts {
    /// Normal, cut off at 0 and at the reach.
    pub hit: f64,
    /// Exponential, cut off at 0 and at the expected range.
    pub short: f64,
    /// All of it at the reach.
    pub max: f64,
    /// Uniform below the reach.
    pub rand: f64,
}

impl BeamShape {
    /// The densities at a reading, 1/m, and the mass at the reach.
    pub fn parts(&self, measured_m: f64, expected_m: f64) -> BeamParts {
        let reach_m = self.z_max_range_m;
        if measured_m >= reach_m {
            return BeamParts { hit: 0.0, short: 0.0, max: 1.0, rand: 0.0 };
        }
        let off = |range_m: f64| (range_m - expected_m) / self.sigma_hit_m;
        let density = (-0.5 * off(measured_m).powi(2)).exp() / (self.sigma_hit_m * TAU.sqrt());
        let kept = cumulative(off(reach_m)) - cumulative(off(0.0));
        let lambda = self.lambda_short_per_m;
        // The mass that is kept of an exponential over a short way.
        let before = -(-lambda * expected_m).exp_m1();
        let is_short = measured_m <= expected_m && before > 0.0;
        BeamParts {
            hit: if kept > 0.0 { density / kept } else { 0.0 },
            short: if is_short { lambda * (-lambda * measured_m).exp() / before } else { 0.0 },
            max: 0.0,
            rand: 1.0 / reach_m,
        }
    }

    /// Probability of a reading where another range is expected.
    pub fn likelihood(&self, measured_m: f64, expected_m: f64) -> f64 {
        let parts = self.parts(measured_m, expected_m);
        self.z_hit * parts.hit
            + self.z_short * parts.short
            + self.z_max * parts.max
            + self.z_rand * parts.rand
    }
}

/// A beam model in steps of one bin.
#[derive(Debug, Clone)]
pub struct BeamTable {
    bin_m: f64,
    n_bins: usize,
    /// One row a measured range, one column an expected one.
    costs: Vec<u16>,
    ln_best: f64,
    ln_step: f64,
}

impl BeamTable {
    /// More bins than this make a table that does not stay in the cache.
    const MOST_BINS: usize = 1024;
    /// What is impossible counts as this unlikely, so that one reading does not rule out a place.
    const LEAST_LN: f64 = -30.0;

    /// A table with bins of about `bin_m`, fewer where the reach is long.
    pub fn new(shape: &BeamShape, bin_m: f64) -> BeamTable {
        let reach_m = shape.z_max_range_m;
        let n_steps = ((reach_m / bin_m).ceil()).clamp(1.0, (Self::MOST_BINS - 1) as f64);
        let (bin_m, n_bins) = (reach_m / n_steps, n_steps as usize + 1);
        let range = |bin: usize| if bin + 1 == n_bins { reach_m } else { bin as f64 * bin_m };
        let ln = |cell: usize| {
            shape.likelihood(range(cell / n_bins), range(cell % n_bins)).ln().max(Self::LEAST_LN)
        };
        let lns: Vec<f64> = (0..n_bins * n_bins).map(ln).collect();
        let (least, ln_best) =
            lns.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), ln| (a.min(*ln), b.max(*ln)));
        let ln_step = ((ln_best - least) / f64::from(u16::MAX)).max(f64::MIN_POSITIVE);
        let costs = lns.iter().map(|ln| ((ln_best - ln) / ln_step).round() as u16).collect();
        BeamTable { bin_m, n_bins, costs, ln_best, ln_step }
    }

    /// Width of a bin, meters.
    pub fn bin_m(&self) -> f64 {
        self.bin_m
    }

    /// The bin of a range in bins (rounded down), cut off at the reach.
    #[inline(always)]
    fn column(&self, range_bins: f64) -> usize {
        (range_bins as usize).min(self.n_bins - 1)
    }

    /// Costs of a reading by the bin of the expected range. Infinity, nothing within reach, is a reading too.
    pub fn row(&self, measured_m: f64) -> &[u16] {
        // A reading below the reach must not become one of nothing by rounding.
        let reach_bins = (self.n_bins - 1) as f64;
        let bins = measured_m / self.bin_m;
        let bin = if bins >= reach_bins { reach_bins } else { (bins + 0.5).min(reach_bins - 1.0) };
        let first = self.column(bin) * self.n_bins;
        &self.costs[first..first + self.n_bins]
    }

    /// Sum of ln p of readings, given by their rows, where these ranges are expected; `bins_each` of them are one bin.
    #[inline]
    pub fn ln_of(&self, rows: &[&[u16]], expected: &[f64], bins_each: f64) -> f64 {
        let cost = |(row, range): (&&[u16], &f64)| {
            let column = self.column(range * bins_each + 0.5);
            row.get(column).map_or(0, |cost| u32::from(*cost))
        };
        let total: u32 = rows.iter().zip(expected).map(cost).sum();
        self.ln_best * rows.len() as f64 - f64::from(total) * self.ln_step
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAPE: BeamShape = BeamShape {
        z_hit: 0.8,
        z_short: 0.1,
        z_max: 0.05,
        z_rand: 0.05,
        sigma_hit_m: 0.2,
        lambda_short_per_m: 0.5,
        z_max_range_m: 10.0,
    };

    #[test]
    fn densities_and_the_mass_at_the_reach_sum_to_one() {
        for expected_m in [0.05, 1.0, 5.0, 9.9] {
            let n = 100_000;
            let below: f64 = (0..n)
                .map(|k| SHAPE.likelihood((f64::from(k) + 0.5) * 10.0 / f64::from(n), expected_m))
                .sum::<f64>()
                * 10.0
                / f64::from(n);
            let all = below + SHAPE.likelihood(10.0, expected_m);
            assert!((all - 1.0).abs() < 1e-4, "{expected_m}: {all}");
        }
    }

    #[test]
    fn the_table_is_the_formula_at_the_middle_of_its_bins() {
        let table = BeamTable::new(&SHAPE, 0.05);
        assert!((table.bin_m() - 0.05).abs() < 1e-12);
        for measured_m in [0.0, 0.5, 3.0, 9.95, 10.0, 12.0, f64::INFINITY] {
            let row = table.row(measured_m);
            for expected_m in [0.0, 0.5, 2.95, 3.0, 3.3, 9.95, 10.0, 14.0] {
                let exact = SHAPE.likelihood(measured_m, f64::min(expected_m, 10.0)).ln();
                let found = table.ln_of(&[row], &[expected_m], 1.0 / table.bin_m());
                assert!((found - exact).abs() < 1e-3, "{measured_m} {expected_m}: {found} for {exact}");
            }
        }
        let summed = table.ln_of(&[table.row(3.0), table.row(5.0)], &[6.0, 10.0], 10.0);
        let exact = SHAPE.likelihood(3.0, 3.0).ln() + SHAPE.likelihood(5.0, 5.0).ln();
        assert!((summed - exact).abs() < 1e-3, "ranges in cells of half a meter");
    }

    #[test]
    fn a_reading_just_below_the_reach_is_a_reading() {
        let table = BeamTable::new(&SHAPE, 0.05);
        assert_ne!(table.row(9.999), table.row(10.0));
    }

    #[test]
    fn what_is_impossible_stays_finite_and_a_long_reach_makes_wide_bins() {
        let shape = BeamShape { z_hit: 1.0, z_short: 0.0, z_max: 0.0, z_rand: 0.0, ..SHAPE };
        let table = BeamTable::new(&shape, 1e-4);
        assert_eq!(table.row(3.0).len(), BeamTable::MOST_BINS);
        assert!((table.ln_of(&[table.row(9.0)], &[1.0], 1.0 / table.bin_m()) + 30.0).abs() < 1e-3);
    }
}
