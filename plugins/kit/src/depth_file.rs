//! Depth pictures from files: PNG of 16 bits, PGM of 16 bits, and PNG whose red and green channels share 13 bits.
//!
//! A picture is counts; what one count is in meters is known of a folder, not of a file (TUM RGB-D: 1/5000 m, most others:
//! 1 mm). Sources: the PNG and PGM specifications; J. Sturm, N. Engelhard, F. Endres, W. Burgard, D. Cremers, *A benchmark
//! for the evaluation of RGB-D SLAM systems* (2012) for the first; J. Valverde Moreno (2015), equation 5.1, for the two
//! channels.

mod error;
mod pgm;
mod picture;
mod png;
mod write;

pub use error::DepthFileError;
pub use picture::{DepthEncoding, DepthPicture, read_depth};
pub use write::write_depth;

#[cfg(test)]
mod tests;
