//! A folder of depth pictures as a log.

mod camera;
mod pictures;
mod playback;

pub use camera::RecordedCamera;
pub use pictures::{PictureFault, PictureReader};
pub use playback::{RgbdChannel, RgbdPlayback};
