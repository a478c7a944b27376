//! What a depth camera makes of an exact picture.
//!
//! Structured light (Kinect v1): Khoshelham and Oude Elberink, *Accuracy and Resolution of Kinect Depth Data for Indoor
//! Mapping Applications*, Sensors 12 (2012): the deviation and the step between depths grow with the square of the depth,
//! the step being 2.85 mm at 1 m. No reading: nearer than the device's least distance, at the edges of things (the light's
//! shadow), and in sunlight, the sooner the farther off.

use rand::RngExt as _;
use rand_distr::{Distribution as _, StandardNormal};
use rumbo_core::rng::Rng;

use super::SizeMismatch;

/// The steps in which a device tells depths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DepthStep {
    /// Whole counts only.
    Even,
    /// Even steps from a near plane on: Valverde Moreno (2015), section 5.1.
    From {
        /// The near plane, meters.
        near_m: f64,
        /// One step, meters.
        step_m: f64,
    },
    /// Even steps of disparity (the inverse of the depth), 1/m: depths are a step of about `Z² * step` apart.
    Disparity(f64),
}

/// A device.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthDevice {
    /// Standard deviation of a depth Z: the first, meters, plus the second, 1/m, times Z².
    pub deviation: [f64; 2],
    /// Steps of the depths.
    pub step: DepthStep,
    /// Meters of one count.
    pub unit_m: f64,
    /// Nothing nearer is read, meters.
    pub min_m: f64,
    /// What is read nearer than this reads as this, meters.
    pub near_m: f64,
    /// Nothing farther is read, meters.
    pub max_m: f64,
    /// Neighbors in a row that differ by more than this are at an edge, meters. (The projector sits beside the camera, so
    /// that its shadows lie to the side.)
    pub edge_m: f64,
    /// Share of the pixels on the far side of an edge that are not read.
    pub edge_holes: f64,
    /// Share of all pixels that are not read, by chance.
    pub dropout: f64,
    /// Share of the pixels at the largest depth that sunlight hides; nearer ones by the square of their depth. Above 1,
    /// everything is hidden from some depth on.
    pub sunlight: f64,
}

impl DepthDevice {
    /// The picture that the device gives of exact depths (meters along the axis, infinite where nothing is), in counts;
    /// 0 is no reading.
    pub fn read(
        &self,
        exact_m: &[f32],
        n_columns: usize,
        counts: &mut [u16],
        rng: &mut Rng,
    ) -> Result<(), SizeMismatch> {
        SizeMismatch::check("a picture", counts.len(), exact_m.len())?;
        let [fixed_m, growing] = self.deviation;
        let is_exact = fixed_m == 0.0 && growing == 0.0;
        for (pixel, (exact, count)) in exact_m.iter().zip(counts).enumerate() {
            *count = 0;
            let exact_m_here = f64::from(*exact);
            // What is not there, or too far for any noise to bring back, needs no draws.
            if !(exact_m_here > 0.0 && exact_m_here <= 1.5 * self.max_m) {
                continue;
            }
            let noise: f64 = if is_exact { 0.0 } else { StandardNormal.sample(rng) };
            let read_m = exact_m_here + noise * (fixed_m + growing * exact_m_here * exact_m_here);
            if self.is_lost(exact_m_here, rng)
                || self.is_hole(exact_m, n_columns, pixel, rng)
                || !(self.min_m..=self.max_m).contains(&read_m)
            {
                continue;
            }
            *count = self.counted(read_m.max(self.near_m));
        }
        Ok(())
    }

    /// Counts of a depth in the device's steps; at least 1, for 0 is no reading.
    fn counted(&self, depth_m: f64) -> u16 {
        let stepped_m = match self.step {
            DepthStep::Even => depth_m,
            DepthStep::From { near_m, step_m } => near_m + ((depth_m - near_m) / step_m).round() * step_m,
            DepthStep::Disparity(step) => 1.0 / ((1.0 / (depth_m * step)).round().max(1.0) * step),
        };
        // A step may end just beyond what may be told.
        let stepped_m = stepped_m.clamp(self.near_m, self.max_m);
        (stepped_m / self.unit_m).round().clamp(1.0, f64::from(u16::MAX)) as u16
    }

    /// Chance and sunlight take the pixel.
    fn is_lost(&self, depth_m: f64, rng: &mut Rng) -> bool {
        let hidden = (self.sunlight * (depth_m / self.max_m).powi(2)).min(1.0);
        let lost = self.dropout + hidden - self.dropout * hidden;
        lost > 0.0 && rng.random::<f64>() < lost
    }

    /// The pixel lies beyond the edge of something nearer, where the light does not come.
    fn is_hole(&self, exact_m: &[f32], n_columns: usize, pixel: usize, rng: &mut Rng) -> bool {
        if self.edge_holes <= 0.0 || n_columns == 0 {
            return false;
        }
        let is_nearer = |neighbor: Option<&f32>| {
            let ahead_m = neighbor.map_or(0.0, |m| f64::from(exact_m[pixel]) - f64::from(*m));
            ahead_m > self.edge_m
        };
        let column = pixel % n_columns;
        let left = if column > 0 { exact_m.get(pixel - 1) } else { None };
        let right = if column + 1 < n_columns { exact_m.get(pixel + 1) } else { None };
        [left, right].into_iter().any(is_nearer) && rng.random::<f64>() < self.edge_holes
    }
}
