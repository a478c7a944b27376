//! Folders of the TUM RGB-D kind: depth pictures with their stamps, where the camera was, and its accelerometer.
//!
//! Source: J. Sturm, N. Engelhard, F. Endres, W. Burgard, D. Cremers, *A benchmark for the evaluation of RGB-D SLAM systems*
//! (2012), and the page of its file formats. `depth.txt` lists `timestamp filename`; `groundtruth.txt` has `timestamp tx ty
//! tz qx qy qz qw`, the optical center of the camera in the world of the motion capture; `accelerometer.txt`, where it is
//! there, has `timestamp ax ay az`. Each may be plain or gzip, with `.gz` behind its name. The colors of `rgb.txt` are not
//! read.
//!
//! The lists are long and may be damaged: lines that cannot be read and pictures that are not there are left out and told.
//! The poses must be whole.

mod error;
mod folder;
mod place;
mod write;

pub use error::RgbdError;
pub use folder::{DepthFrame, RgbdFolder, is_folder, read_camera_track, read_folder};
pub use place::{CameraMounting, CameraPlace, PlaceInSpace, camera_from_optical};
pub use write::FolderWriter;

#[cfg(test)]
mod tests;
