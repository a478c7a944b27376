//! Writing a folder, picture by picture.

use std::fs::{File, create_dir_all};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use rumbo_core::frames::Pose3;
use rumbo_core::time::Time;

use super::error::RgbdError;
use crate::depth_file::{DepthEncoding, DepthPicture, write_depth};

/// Writes a folder of the TUM RGB-D kind. Stamps are written as microseconds, as those of the data set are.
#[derive(Debug)]
pub struct FolderWriter {
    folder: PathBuf,
    encoding: DepthEncoding,
    pictures: List,
    poses: List,
    accelerations: List,
    last: Option<Time>,
}

/// A list on its way.
#[derive(Debug)]
struct List {
    path: PathBuf,
    file: Option<BufWriter<File>>,
    heading: &'static str,
}

impl List {
    fn new(folder: &Path, name: &str, heading: &'static str) -> List {
        List { path: folder.join(name), file: None, heading }
    }

    /// Adds a line; the file begins with the first one.
    fn add(&mut self, line: std::fmt::Arguments<'_>) -> Result<(), RgbdError> {
        let unwritable = |source| RgbdError::Unwritable { path: self.path.clone(), source };
        let file = match &mut self.file {
            Some(file) => file,
            empty => {
                let mut file = BufWriter::new(File::create(&self.path).map_err(unwritable)?);
                writeln!(file, "# {}", self.heading).map_err(unwritable)?;
                empty.insert(file)
            }
        };
        writeln!(file, "{line}").map_err(unwritable)
    }

    fn finish(mut self) -> Result<(), RgbdError> {
        let flushed = self.file.as_mut().map_or(Ok(()), Write::flush);
        flushed.map_err(|source| RgbdError::Unwritable { path: self.path, source })
    }
}

impl FolderWriter {
    /// In a folder, which is made where it is not there.
    ///
    /// # Errors
    /// [`RgbdError::Unwritable`].
    pub fn create(folder: &Path, encoding: DepthEncoding) -> Result<FolderWriter, RgbdError> {
        let pictures = folder.join("depth");
        create_dir_all(&pictures).map_err(|source| RgbdError::Unwritable { path: pictures, source })?;
        Ok(FolderWriter {
            folder: folder.to_owned(),
            encoding,
            pictures: List::new(folder, "depth.txt", "timestamp filename"),
            poses: List::new(folder, "groundtruth.txt", "timestamp tx ty tz qx qy qz qw"),
            accelerations: List::new(folder, "accelerometer.txt", "timestamp ax ay az"),
            last: None,
        })
    }

    /// Adds a picture.
    ///
    /// # Errors
    /// [`RgbdError`] where it cannot be written, or is not newer than the one before it by a microsecond.
    pub fn picture(&mut self, stamp: Time, picture: &DepthPicture) -> Result<(), RgbdError> {
        let stamp_s = stamp.as_secs();
        if let Some(last) = self.last.filter(|last| stamp.0 - last.0 < 1000) {
            return Err(RgbdError::Order { stamp_s, last_s: last.as_secs() });
        }
        self.last = Some(stamp);
        let name = format!("depth/{stamp_s:.6}.png");
        write_depth(&self.folder.join(&name), self.encoding, picture)?;
        self.pictures.add(format_args!("{stamp_s:.6} {name}"))
    }

    /// Adds where the optical center (z ahead, x right, y down) was.
    ///
    /// # Errors
    /// [`RgbdError::Unwritable`].
    pub fn pose(&mut self, stamp: Time, world_from_optical: &Pose3) -> Result<(), RgbdError> {
        let (at, q) = (world_from_optical.translation.vector, world_from_optical.rotation.coords);
        self.poses.add(format_args!(
            "{:.6} {:.6} {:.6} {:.6} {:.8} {:.8} {:.8} {:.8}",
            stamp.as_secs(),
            at.x,
            at.y,
            at.z,
            q.x,
            q.y,
            q.z,
            q.w
        ))
    }

    /// Adds the specific force along the accelerometer's axes: x left, y up, z along the optical axis, m/s².
    ///
    /// # Errors
    /// [`RgbdError::Unwritable`].
    pub fn acceleration(&mut self, stamp: Time, [x, y, z]: [f64; 3]) -> Result<(), RgbdError> {
        self.accelerations.add(format_args!("{:.6} {x:.6} {y:.6} {z:.6}", stamp.as_secs()))
    }

    /// Ends the lists.
    ///
    /// # Errors
    /// [`RgbdError::Unwritable`].
    pub fn finish(self) -> Result<(), RgbdError> {
        [self.pictures, self.poses, self.accelerations].into_iter().try_for_each(List::finish)
    }
}
