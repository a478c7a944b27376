//! From a file to the layer of landmarks.

use std::path::Path;

use rumbo_core::map::{Landmark, Landmarks};
use rumbo_kit::mark_file::load_marks;
use rumbo_kit::mrclam::read_landmarks;
use rumbo_kit::world_file::load_world;

/// The kind of every landmark that comes from a file: a mark with an identity of its own.
const KIND: u32 = 0;

/// The table of landmarks in an MRCLAM folder.
const MRCLAM_TABLE: &str = "Landmark_Groundtruth.dat";

fn landmark(identity: u32, position: [f64; 2], [x_m, y_m]: [f64; 2]) -> Landmark {
    Landmark { identity, kind: KIND, position, covariance: [x_m * x_m, 0.0, y_m * y_m] }
}

/// The marks of a TOML list, of an MRCLAM folder, or of the table of landmarks in one. A mark is at least as unsure as
/// `least_deviation_m`.
///
/// # Errors
/// The message of whatever is wrong with the file.
pub fn load_marks_at(path: &Path, least_deviation_m: f64) -> Result<Landmarks, String> {
    let unsure = |deviations_m: [f64; 2]| deviations_m.map(|deviation_m| deviation_m.max(least_deviation_m));
    let is_table = path.file_name().and_then(|name| name.to_str()).is_some_and(|name| {
        name == MRCLAM_TABLE || name.strip_suffix(".gz").is_some_and(|plain| plain == MRCLAM_TABLE)
    });
    let folder = if is_table { path.parent() } else { Some(path).filter(|path| path.is_dir()) };
    let landmarks: Vec<Landmark> = match folder {
        Some(folder) => {
            let places = read_landmarks(folder).map_err(|error| error.to_string())?;
            let mark = |place: &rumbo_kit::mrclam::LandmarkPlace| {
                landmark(place.subject, place.position_m, unsure(place.deviation_m))
            };
            places.iter().map(mark).collect()
        }
        None => {
            let places = load_marks(path).map_err(|error| error.to_string())?;
            let mark = |place: &rumbo_kit::mark_file::MarkPlace| {
                landmark(place.identity, place.position_m, unsure(place.deviation_m))
            };
            places.iter().map(mark).collect()
        }
    };
    Ok(Landmarks { landmarks: landmarks.into() })
}

/// The marks of a world file, each as unsure as `deviation_m`.
///
/// # Errors
/// The message of whatever is wrong with the file, that it has no marks, or one of them twice.
pub fn load_world_marks(file: &Path, deviation_m: f64) -> Result<Landmarks, String> {
    let scene = load_world(file).map_err(|error| error.to_string())?;
    if scene.marks.is_empty() {
        return Err(format!("{}: the world has no [[mark]]; name a file of marks", file.display()));
    }
    let mut identities: Vec<u32> = scene.marks.iter().map(|mark| mark.id).collect();
    identities.sort_unstable();
    if let Some([twice, ..]) = identities.windows(2).find(|pair| pair.first() == pair.last()) {
        return Err(format!("{}: mark {twice} is there twice, expected once", file.display()));
    }
    let mark = |mark: &rumbo_kit::world_file::WorldMark| landmark(mark.id, mark.at, [deviation_m; 2]);
    let landmarks: Vec<Landmark> = scene.marks.iter().map(mark).collect();
    Ok(Landmarks { landmarks: landmarks.into() })
}
