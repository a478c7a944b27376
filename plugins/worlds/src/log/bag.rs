//! Bags as recordings that play themselves: MCAP files of this program and of ROS 2.

mod playback;
mod source;

pub use playback::BagPlayback;
pub use source::{BagSource, SourceError};
