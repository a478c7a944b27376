mod device;
mod near;
mod pictures;
mod scans;
mod vectors;

use super::*;
use rumbo_core::rng::{Rng, RngExt as _};

/// A file of known answers.
macro_rules! data {
    ($name:literal) => {
        include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/depth/", $name))
    };
}
use data;

/// A camera of any size.
fn camera(columns: u32, rows: u32) -> Rays {
    Rays::pinhole(&pinhole_of_view(columns, rows, [0.5, 0.4])).unwrap()
}

/// Counts of millimeters: mostly readings up to 6 m, with holes.
fn random_picture(n_pixels: usize, rng: &mut Rng) -> Vec<u16> {
    (0..n_pixels).map(|_| if rng.random::<f64>() < 0.2 { 0 } else { rng.random_range(1..6000) }).collect()
}

fn millimeters(counts: &[u16]) -> Depths<'_> {
    Depths::Counts { counts, unit_m: 0.001 }
}
