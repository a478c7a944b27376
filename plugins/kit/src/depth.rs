//! Depth pictures: what a pixel is in space, what the picture shows, and what a real device makes of it.
//!
//! The picture's row 0 is on top. The camera's frame has x ahead along the optical axis, y left, z up; the depth of a pixel
//! is its x, not the length of its ray. [`Rays`] turns pixels into points; [`points`] does so for a picture, [`closest`]
//! finds the nearest of them, [`VirtualScan`] makes a planar scan of the picture, and [`DepthDevice`] spoils an exact
//! picture as a device would. Nothing here allocates once it is warm.
//!
//! Depth cameras in navigation: Valverde Moreno (2015), sections 4.1 and 5.2; the virtual scan: Arroyo Sánchez (2013),
//! section 5.3.

mod band;
mod closest;
mod decode;
mod depths;
mod device;
mod median;
mod near;
mod points;
mod rays;
mod scan;
#[cfg(test)]
mod tests;

pub use band::HeightBand;
pub use closest::{Closest, ClosestPoint, closest};
pub use decode::{DepthScale, RAW_MAX, channels_to_raw};
pub use depths::{Depths, SizeMismatch};
pub use device::{DepthDevice, DepthStep};
pub use median::MedianFilter;
pub use near::{NearMemory, NearRule};
pub use points::{Counted, points};
pub use rays::{Counting, Rays, RaysError, pinhole_of_view};
pub use scan::{Beams, ScanError, ScanLimits, Scanned, VirtualScan};

/// The straightforward twins in double precision: what the fast ones are tested against.
pub mod slow {
    pub use super::points::point_slowly;
    pub use super::scan::scan_slowly;
}
