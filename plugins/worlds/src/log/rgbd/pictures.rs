//! Recorded pictures as messages.

use std::path::{Path, PathBuf};

use rumbo_core::boundary::Buffer;
use rumbo_core::messages::{DepthImage, Intrinsics};
use rumbo_kit::depth_file::{DepthEncoding, DepthFileError, DepthPicture, read_depth};
use rumbo_kit::tum_rgbd::DepthFrame;

use super::camera::RecordedCamera;

/// Why a picture cannot be shown.
#[derive(Debug, thiserror::Error)]
pub enum PictureFault {
    /// It cannot be read.
    #[error(transparent)]
    File(#[from] DepthFileError),
    /// It has another size than the first one.
    #[error("{}: is {} x {} pixels, expected {} x {} as the first picture", path.display(), found[0], found[1], expected[0], expected[1])]
    Size {
        /// The file.
        path: PathBuf,
        /// Its columns and rows.
        found: [u32; 2],
        /// Those of the first picture.
        expected: [u32; 2],
    },
}

/// Reads the pictures of one camera.
#[derive(Debug, Clone)]
pub struct PictureReader {
    encoding: DepthEncoding,
    unit_m: f32,
    no_reading: Option<u16>,
    intrinsics: Intrinsics,
}

impl PictureReader {
    /// Of a camera whose pictures have the size of the first one that can be read.
    ///
    /// # Errors
    /// The fault of the first picture where none can be read; nothing where there is none.
    pub fn of(camera: &RecordedCamera, frames: &[DepthFrame]) -> Result<PictureReader, Option<PictureFault>> {
        let mut fault = None;
        for frame in frames {
            match read_depth(&frame.path, camera.encoding) {
                Ok(picture) => return Ok(PictureReader::of_size(camera, picture.width, picture.height)),
                Err(error) => fault = fault.or(Some(error.into())),
            }
        }
        Err(fault)
    }

    /// Of a camera with so many columns and rows.
    pub fn of_size(camera: &RecordedCamera, width: u32, height: u32) -> PictureReader {
        let focal_px = 525.0 * f64::from(width) / 640.0;
        let middle = [width, height].map(|n| (f64::from(n) - 1.0) / 2.0);
        let intrinsics = Intrinsics {
            width,
            height,
            focal_px: camera.focal_px.unwrap_or([focal_px; 2]),
            center_px: camera.center_px.unwrap_or(middle),
        };
        let RecordedCamera { encoding, unit_m, no_reading, .. } = *camera;
        PictureReader { encoding, unit_m: unit_m as f32, no_reading, intrinsics }
    }

    /// The camera.
    pub fn intrinsics(&self) -> &Intrinsics {
        &self.intrinsics
    }

    /// Reads a picture.
    ///
    /// # Errors
    /// [`PictureFault`].
    pub fn read(&self, path: &Path) -> Result<DepthImage, PictureFault> {
        let DepthPicture { width, height, mut counts } = read_depth(path, self.encoding)?;
        let Intrinsics { width: columns, height: rows, .. } = self.intrinsics;
        if (width, height) != (columns, rows) {
            let (found, expected) = ([width, height], [columns, rows]);
            return Err(PictureFault::Size { path: path.to_owned(), found, expected });
        }
        if let Some(no_reading) = self.no_reading {
            counts.iter_mut().filter(|count| **count == no_reading).for_each(|count| *count = 0);
        }
        let depth = Buffer::from(counts);
        Ok(DepthImage { intrinsics: self.intrinsics, unit_m: self.unit_m, depth })
    }
}
