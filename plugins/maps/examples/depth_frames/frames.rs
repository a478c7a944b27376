//! A folder of depth pictures with camera poses: `depth/NNNNNN.png` in millimeters, `poses.txt` with lines of a picture's
//! number and the upper three rows of its camera-to-world matrix (z ahead, x right, y down), and `intrinsics.txt` with `fx fy
//! cx cy`.

use std::error::Error;
use std::path::Path;

use nalgebra::{Matrix3, Rotation3, Translation3, UnitQuaternion};
use rumbo_core::frames::Pose3;
use rumbo_core::messages::Intrinsics;
use rumbo_kit::depth_file::{DepthEncoding, DepthPicture, read_depth};

/// Meters of one count.
pub const UNIT_M: f32 = 0.001;
/// A count that is no reading, besides 0.
const NO_READING: u16 = 65_535;

/// One picture.
pub struct Frame {
    /// Its number, 30 of them a second.
    pub number: u32,
    /// Where the camera was, with optical axes.
    pub world_from_optical: Pose3,
    /// What it saw.
    pub picture: DepthPicture,
}

/// Reads a folder.
pub fn read(folder: &Path) -> Result<(Intrinsics, Vec<Frame>), Box<dyn Error>> {
    let mut frames = Vec::new();
    for (line, numbers) in numbers(&folder.join("poses.txt"), 13)? {
        let [number, pose @ ..] = numbers.as_slice() else { return Err("a line without numbers".into()) };
        let world_from_optical = pose_of(pose).ok_or_else(|| format!("poses.txt:{line}: no rotation"))?;
        let number = *number as u32;
        let path = folder.join(format!("depth/{number:06}.png"));
        let mut picture = read_depth(&path, DepthEncoding::Gray16)?;
        picture.counts.iter_mut().filter(|count| **count == NO_READING).for_each(|count| *count = 0);
        frames.push(Frame { number, world_from_optical, picture });
    }
    let first = frames.first().ok_or("poses.txt has no pose")?;
    let (width, height) = (first.picture.width, first.picture.height);
    let camera = numbers(&folder.join("intrinsics.txt"), 4)?;
    let [fx, fy, cx, cy, ..] = camera.first().map(|(_, numbers)| numbers.as_slice()).unwrap_or_default()
    else {
        return Err("intrinsics.txt: expected fx fy cx cy".into());
    };
    Ok((Intrinsics { width, height, focal_px: [*fx, *fy], center_px: [*cx, *cy] }, frames))
}

/// A line's number, and the numbers in it.
type Row = (usize, Vec<f64>);

/// The numbers of each line that has some, and the line's number; at least `n` in each.
fn numbers(path: &Path, n: usize) -> Result<Vec<Row>, Box<dyn Error>> {
    let text = std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let lines = (1..).zip(text.lines()).filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'));
    lines
        .map(|(number, line)| {
            let place = || format!("{}:{number}", path.display());
            let found: Vec<f64> = line.split_whitespace().map_while(|word| word.parse().ok()).collect();
            if found.len() < n {
                Err(format!("{}: expected {n} numbers", place()).into())
            } else {
                Ok((number, found))
            }
        })
        .collect()
}

fn pose_of(rows: &[f64]) -> Option<Pose3> {
    let [a, b, c, x, d, e, f, y, g, h, i, z] = *rows else { return None };
    let svd = Matrix3::new(a, b, c, d, e, f, g, h, i).svd(true, true);
    let nearest = svd.u? * svd.v_t?;
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(nearest));
    (nearest.determinant() > 0.0).then(|| Pose3::from_parts(Translation3::new(x, y, z), rotation))
}
