//! Why a folder cannot be used.

use std::path::PathBuf;

use thiserror::Error;

use crate::depth_file::DepthFileError;
use crate::mrclam::MrclamError;
use crate::trajectory::TrajectoryError;

/// Why a folder of depth pictures cannot be read or written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RgbdError {
    /// A list is missing or empty, or cannot be read at all; lists are read like the tables of MRCLAM.
    #[error(transparent)]
    List(#[from] MrclamError),
    /// The poses cannot be read.
    #[error(transparent)]
    Poses(#[from] TrajectoryError),
    /// There is no file of poses.
    #[error("{}: there is neither groundtruth.txt nor groundtruth.txt.gz, so nobody knows where the camera was", folder.display())]
    NoPoses {
        /// The folder.
        folder: PathBuf,
    },
    /// Not one of the pictures that are listed is there.
    #[error("{}: none of the {n_listed} pictures of depth.txt is there, the first is {first}", folder.display())]
    NoPictures {
        /// The folder.
        folder: PathBuf,
        /// How many are listed.
        n_listed: usize,
        /// The first.
        first: String,
    },
    /// A picture cannot be written.
    #[error(transparent)]
    Picture(#[from] DepthFileError),
    /// A picture's stamp is that of the one before it, or earlier.
    #[error(
        "a picture of {stamp_s:.6} s comes after one of {last_s:.6} s; stamps of a folder are microseconds that go up"
    )]
    Order {
        /// Its stamp.
        stamp_s: f64,
        /// The one before it.
        last_s: f64,
    },
    /// A file or folder cannot be written.
    #[error("{}: cannot be written: {source}", path.display())]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
}
