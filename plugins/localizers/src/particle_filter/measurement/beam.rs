//! `model = "beam"`: readings should be as long as the map lets expect.

use super::{MeasurementModel, Obstacles, ScanLikelihood, no_share, not_positive};
use crate::particle_filter::beams::ScanBeams;
use rumbo_kit::beam_table::{BeamShape, BeamTable};
use rumbo_kit::grid_poses::GridPoses;
use rumbo_kit::ray::RayGrid;
use serde::{Deserialize, Serialize};

/// Ray-cast beam model: see [`rumbo_kit::beam_table`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BeamModel {
    /// Share of readings that hit what the map shows. All four shares must sum to 1.
    pub z_hit: f64,
    /// Share of those that hit something nearer, such as people.
    pub z_short: f64,
    /// Share of those that hit nothing.
    pub z_max: f64,
    /// Share of those that can be anything.
    pub z_rand: f64,
    /// Standard deviation of hits, meters.
    pub sigma_hit_m: f64,
    /// How fast things that the map does not show become rarer with the range, 1/m.
    pub lambda_short_per_m: f64,
    /// Reach of the device, meters: from here on a reading says that nothing was hit.
    pub z_max_range_m: f64,
}

impl Default for BeamModel {
    fn default() -> Self {
        BeamModel {
            z_hit: 0.8,
            z_short: 0.1,
            z_max: 0.05,
            z_rand: 0.05,
            sigma_hit_m: 0.2,
            lambda_short_per_m: 0.5,
            z_max_range_m: 30.0,
        }
    }
}

impl BeamModel {
    /// How far the sum of the shares may be from 1.
    const SUM_TOLERANCE: f64 = 1e-6;
    /// Bins of the table for each standard deviation.
    const BINS_PER_SIGMA: f64 = 4.0;

    /// The formula.
    pub fn shape(&self) -> BeamShape {
        BeamShape {
            z_hit: self.z_hit,
            z_short: self.z_short,
            z_max: self.z_max,
            z_rand: self.z_rand,
            sigma_hit_m: self.sigma_hit_m,
            lambda_short_per_m: self.lambda_short_per_m,
            z_max_range_m: self.z_max_range_m,
        }
    }
}

#[typetag::serde(name = "beam")]
impl MeasurementModel for BeamModel {
    fn on_map(&self, obstacles: &Obstacles<'_>) -> Box<dyn ScanLikelihood> {
        let Obstacles { size, resolution_m, occupied } = *obstacles;
        Box::new(BeamsOnMap {
            model: *self,
            rays: RayGrid::new(size, occupied),
            table: BeamTable::new(&self.shape(), self.sigma_hit_m / Self::BINS_PER_SIGMA),
            resolution_m,
        })
    }

    fn faults(&self) -> Vec<(&'static str, String)> {
        let mut faults = not_positive(&[
            ("sigma_hit_m", self.sigma_hit_m),
            ("lambda_short_per_m", self.lambda_short_per_m),
            ("z_max_range_m", self.z_max_range_m),
        ]);
        let shares = [
            ("z_hit", self.z_hit),
            ("z_short", self.z_short),
            ("z_max", self.z_max),
            ("z_rand", self.z_rand),
        ];
        faults.extend(no_share(&shares));
        let sum: f64 = shares.iter().map(|(_, share)| share).sum();
        if sum.is_nan() || (sum - 1.0).abs() > Self::SUM_TOLERANCE {
            let message = format!("z_hit + z_short + z_max + z_rand is {sum:.6}, expected 1");
            faults.push(("z_hit", message));
        }
        faults
    }

    fn boxed_clone(&self) -> Box<dyn MeasurementModel> {
        Box::new(*self)
    }
}

struct BeamsOnMap {
    model: BeamModel,
    rays: RayGrid,
    table: BeamTable,
    resolution_m: f64,
}

impl BeamsOnMap {
    /// A beam is explained when its range is within so many standard deviations of the expected one.
    const EXPLAINED_SIGMAS: f64 = 2.0;

    /// Ranges that the map lets expect from a pose, meters.
    fn expected_m(&self, beams: &ScanBeams, [x, y, heading]: [f64; 3]) -> Vec<f64> {
        let mut ranges = vec![0.0; beams.directions.len()];
        let reach = self.model.z_max_range_m / self.resolution_m;
        let (sin, cos) = heading.sin_cos();
        let [a, b] = beams.origin.map(|v| v / self.resolution_m);
        let origin = [x + cos * a - sin * b, y + sin * a + cos * b];
        self.rays.cast_fan(origin, heading, &beams.directions, reach, &mut ranges);
        ranges.iter_mut().for_each(|range| *range *= self.resolution_m);
        ranges
    }

    /// Infinite when the device or the model says that nothing was hit.
    fn reading_m(&self, range_m: f64) -> f64 {
        if range_m < self.model.z_max_range_m { range_m } else { f64::INFINITY }
    }
}

impl ScanLikelihood for BeamsOnMap {
    fn add_ln(&mut self, beams: &ScanBeams, poses: &GridPoses, ln_p: &mut [f64]) -> usize {
        let rows: Vec<&[u16]> = beams.ranges_m.iter().map(|range| self.table.row(*range)).collect();
        let mut ranges = vec![0.0; rows.len()];
        let reach = self.model.z_max_range_m / self.resolution_m;
        let bins_per_cell = self.resolution_m / self.table.bin_m();
        let [a, b] = beams.origin.map(|v| v / self.resolution_m);
        for ([x, y, cos, sin], ln_p) in poses.iter().zip(ln_p) {
            let [x, y, cos, sin] = [x, y, cos, sin].map(f64::from);
            let origin = [x + cos * a - sin * b, y + sin * a + cos * b];
            self.rays.cast_fan(origin, sin.atan2(cos), &beams.directions, reach, &mut ranges);
            *ln_p += self.table.ln_of(&rows, &ranges, bins_per_cell);
        }
        rows.len()
    }

    fn exact_ln(&self, beams: &ScanBeams, pose: [f64; 3]) -> f64 {
        let (shape, expected) = (self.model.shape(), self.expected_m(beams, pose));
        let pairs = beams.ranges_m.iter().zip(expected);
        pairs.map(|(measured, expected)| shape.likelihood(self.reading_m(*measured), expected).ln()).sum()
    }

    fn explained(&self, beams: &ScanBeams, pose: [f64; 3]) -> [usize; 2] {
        let (reach_m, model) = (self.model.z_max_range_m, &self.model);
        // A ray ends at the edge of a cell, the obstacle somewhere in it.
        let tolerance_m = Self::EXPLAINED_SIGMAS * model.sigma_hit_m + self.resolution_m;
        let expected = self.expected_m(beams, pose);
        let near = beams
            .ranges_m
            .iter()
            .zip(&expected)
            .filter(|(measured, expected)| (measured.min(reach_m) - **expected).abs() <= tolerance_m);
        [near.count(), expected.len()]
    }
}
