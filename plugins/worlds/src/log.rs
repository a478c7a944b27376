//! The `log` world: a recording that plays itself.
//!
//! Time is virtual and begins at the first stamp of the log; observations come at their recorded stamps, in the order of
//! these stamps. What the recording lacks, it does not answer.

mod bag;
mod channel;
mod mrclam;
mod odometer;
mod params;
mod playback;
mod plugin;
mod rgbd;
mod truth;

pub use bag::{BagPlayback, BagSource};
pub use mrclam::{MrclamChannel, MrclamPlayback};
pub use params::{LogParams, LogStart, RecordedChannel, TRUTH_INSIDE};
pub use playback::Playback;
pub use plugin::{BagWorld, LogWorld, MrclamWorld, RgbdWorld};
pub use rgbd::{PictureFault, PictureReader, RecordedCamera, RgbdChannel, RgbdPlayback};
pub use truth::KnownTruth;
