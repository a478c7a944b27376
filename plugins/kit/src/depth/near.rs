//! Things that came too near to be seen.
//!
//! A depth camera has no reading nearer than its least distance, and a robot stops at about that distance: what is nearest
//! vanishes from the picture just where it matters. Regions of the picture that lost their readings after they had been
//! near are therefore taken for occupied: where they were last, or as near as they can have come since.

use super::{HeightBand, Rays, SizeMismatch};

/// When a region counts as occupied.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearRule {
    /// A region that was nearer than this may have come too near, meters.
    pub near_m: f64,
    /// Nothing is put nearer than this, meters.
    pub least_m: f64,
    /// How fast a thing may come nearer, m/s.
    pub closing_m_s: f64,
    /// Meters of one count.
    pub unit_m: f64,
}

/// Remembers what was near in each region of a picture.
///
/// A region is freed by a reading of its own, or by readings below it: what stands on the floor hides the floor in front
/// of what is behind. (A thing that hangs is forgotten so, once it is too near; a robot that turns away from a wall
/// towards an empty hall sees the hall's floor and is free again.)
#[derive(Debug, Clone, Default)]
pub struct NearMemory {
    regions: Vec<Region>,
    n_across: usize,
    /// In each column of regions, from the bottom up: something is seen.
    seen_below: Vec<bool>,
}

/// A square of the picture.
#[derive(Debug, Clone, Copy, Default)]
struct Region {
    n_pixels: u32,
    n_valid: u32,
    /// Nearest count within the band, of this picture; 0 for none.
    nearest: u16,
    /// Nearest depth of the last picture in which the region had readings, meters.
    was_m: Option<f64>,
    /// Time since then, seconds.
    since_s: f64,
}

impl Region {
    /// A region with fewer readings than a quarter of its pixels has lost them.
    fn is_seen(&self) -> bool {
        4 * self.n_valid >= self.n_pixels
    }
}

/// Pixels along the edges of a region.
const EDGE: usize = 8;

impl NearMemory {
    /// Puts what is too near into a picture, `elapsed_s` after the last one, and gives the number of pixels that it filled.
    pub fn fill(
        &mut self,
        rays: &Rays,
        band: &HeightBand,
        rule: &NearRule,
        elapsed_s: f64,
        counts: &mut [u16],
    ) -> Result<usize, SizeMismatch> {
        SizeMismatch::check("a depth picture", counts.len(), rays.n_pixels())?;
        self.look(rays, band, rule, counts);
        let n_across = self.n_across;
        let mut n_filled = 0;
        self.seen_below.clear();
        self.seen_below.resize(n_across, false);
        for idx in (0..self.regions.len()).rev() {
            let Some((region, below)) =
                self.regions.get_mut(idx).zip(self.seen_below.get_mut(idx % n_across))
            else {
                continue;
            };
            if region.is_seen() {
                (region.was_m, region.since_s) = (nearest_m(region, rule), 0.0);
                *below = true;
                continue;
            }
            if *below {
                region.was_m = None;
            }
            region.since_s += elapsed_s.max(0.0);
            if let Some(was_m) = region.was_m {
                let now_m = (was_m - rule.closing_m_s * region.since_s).max(rule.least_m);
                let count = (now_m / rule.unit_m).ceil().clamp(1.0, f64::from(u16::MAX)) as u16;
                n_filled += fill_region(rays, n_across, idx, count, counts);
            }
        }
        Ok(n_filled)
    }

    /// Counts readings of each region, and finds the nearest.
    fn look(&mut self, rays: &Rays, band: &HeightBand, rule: &NearRule, counts: &[u16]) {
        let (n_columns, n_rows) = (rays.n_columns(), rays.n_rows());
        self.n_across = n_columns.div_ceil(EDGE);
        self.regions.resize(self.n_across * n_rows.div_ceil(EDGE), Region::default());
        for region in &mut self.regions {
            (region.n_pixels, region.n_valid, region.nearest) = (0, 0, 0);
        }
        let [rise_x, rise_y, rise_z] = band.rise.map(|rise| (rise * rule.unit_m) as f32);
        let [lowest_m, highest_m] = band.heights_m.map(|height_m| (height_m - band.camera_m) as f32);
        for (row, (pixels, up)) in counts.chunks_exact(n_columns).zip(&rays.up_f32).enumerate() {
            let rise_of_row = rise_x + rise_z * up;
            let regions = self.regions.iter_mut().skip(row / EDGE * self.n_across);
            let pieces = pixels.chunks(EDGE).zip(rays.left_f32.chunks(EDGE));
            for ((pixels, lefts), region) in pieces.zip(regions) {
                for (count, left) in pixels.iter().zip(lefts).filter(|(count, _)| **count > 0) {
                    region.n_valid += 1;
                    let rise_m = f32::from(*count) * (rise_of_row + rise_y * left);
                    let is_nearer = region.nearest == 0 || *count < region.nearest;
                    if is_nearer && rise_m >= lowest_m && rise_m <= highest_m {
                        region.nearest = *count;
                    }
                }
                region.n_pixels += pixels.len() as u32;
            }
        }
    }
}

/// The nearest depth of a region, if it is near.
fn nearest_m(region: &Region, rule: &NearRule) -> Option<f64> {
    let nearest_m = f64::from(region.nearest) * rule.unit_m;
    (region.nearest > 0 && nearest_m < rule.near_m).then_some(nearest_m)
}

/// Gives all pixels of a region without a reading this one.
fn fill_region(rays: &Rays, n_across: usize, idx: usize, count: u16, counts: &mut [u16]) -> usize {
    let (top, left) = (idx / n_across * EDGE, idx % n_across * EDGE);
    let n_columns = rays.n_columns();
    let mut n_filled = 0;
    for pixels in counts.chunks_exact_mut(n_columns).skip(top).take(EDGE) {
        for pixel in pixels.iter_mut().skip(left).take(EDGE).filter(|pixel| **pixel == 0) {
            *pixel = count;
            n_filled += 1;
        }
    }
    n_filled
}
