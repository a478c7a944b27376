//! The YAML half of a map_server file.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::{MapFileError, ShadeReading};

/// How a gray value becomes an occupancy (ROS wiki, *map_server*, "Value interpretation").
#[doc(alias = "map_mode")]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum MapMode {
    /// Occupied, free or unknown by the two thresholds.
    #[default]
    Trinary,
    /// Between the thresholds the occupancy rises linearly.
    Scale,
    /// The pixel is the occupancy in percent; above 100 it is unknown.
    Raw,
}

impl MapMode {
    /// The word in the file.
    pub fn name(self) -> &'static str {
        match self {
            MapMode::Trinary => "trinary",
            MapMode::Scale => "scale",
            MapMode::Raw => "raw",
        }
    }
}

/// A map_server YAML file, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct MapHeader {
    /// The picture, relative to the YAML file's folder resolved.
    pub image: PathBuf,
    /// Edge of a cell.
    pub resolution_m: f64,
    /// Pose of the lower-left corner: x, y in meters, yaw in radians.
    pub origin: [f64; 3],
    /// Whether white means occupied.
    pub negate: bool,
    /// Occupation probability above which a cell is occupied.
    pub occupied_thresh: f64,
    /// Occupation probability below which a cell is free.
    pub free_thresh: f64,
    /// How gray becomes occupancy.
    pub mode: MapMode,
}

/// Maps made by ROS 1 write 0 or 1, Nav2 also accepts a YAML boolean.
#[derive(Deserialize)]
#[serde(untagged)]
enum Flag {
    Bool(bool),
    Number(i64),
}

#[derive(Deserialize)]
struct RawHeader {
    image: String,
    resolution: f64,
    origin: Vec<f64>,
    negate: Option<Flag>,
    occupied_thresh: Option<f64>,
    free_thresh: Option<f64>,
    mode: Option<MapMode>,
}

/// Reads and checks the YAML file alone; the picture is not opened.
///
/// # Errors
/// [`MapFileError::Unreadable`], [`MapFileError::Header`] or [`MapFileError::Value`].
pub fn load_map_header(yaml: &Path) -> Result<MapHeader, MapFileError> {
    let text = crate::small_file::read_text(yaml)
        .map_err(|source| MapFileError::Unreadable { path: yaml.to_path_buf(), source })?;
    let raw: RawHeader = serde_saphyr::from_str(&text).map_err(|error| MapFileError::Header {
        path: yaml.to_path_buf(),
        message: first_line(&error.to_string()),
    })?;
    raw.checked(yaml)
}

fn first_line(message: &str) -> String {
    message.lines().next().unwrap_or_default().trim_end_matches(['.', ';']).to_string()
}

impl RawHeader {
    fn checked(self, yaml: &Path) -> Result<MapHeader, MapFileError> {
        let value =
            |key, found, expected| MapFileError::Value { path: yaml.to_path_buf(), key, found, expected };
        if self.image.is_empty() {
            return Err(value("image", "empty".to_string(), "the name of a PGM or PNG file"));
        }
        if !(self.resolution.is_finite() && self.resolution > 0.0) {
            return Err(value(
                "resolution",
                self.resolution.to_string(),
                "meters per cell, finite and above 0",
            ));
        }
        let &[x, y, yaw] = self.origin.as_slice() else {
            let found = format!("a list of {} numbers", self.origin.len());
            return Err(value("origin", found, "three numbers [x, y, yaw]"));
        };
        if !(x.is_finite() && y.is_finite() && yaw.is_finite()) {
            return Err(value("origin", format!("{:?}", self.origin), "finite numbers [x, y, yaw]"));
        }
        let negate = match self.negate {
            None | Some(Flag::Bool(false) | Flag::Number(0)) => false,
            Some(Flag::Bool(true) | Flag::Number(1)) => true,
            Some(Flag::Number(other)) => return Err(value("negate", other.to_string(), "0 or 1")),
        };
        let (occupied_thresh, free_thresh) =
            (self.occupied_thresh.unwrap_or(0.65), self.free_thresh.unwrap_or(0.196));
        if !(0.0..=1.0).contains(&occupied_thresh) {
            return Err(value(
                "occupied_thresh",
                occupied_thresh.to_string(),
                "a probability between 0 and 1",
            ));
        }
        if !(0.0..=1.0).contains(&free_thresh) || free_thresh >= occupied_thresh {
            return Err(value("free_thresh", free_thresh.to_string(), "a probability below occupied_thresh"));
        }
        let folder = yaml.parent().unwrap_or(Path::new(""));
        Ok(MapHeader {
            image: folder.join(&self.image),
            resolution_m: self.resolution,
            origin: [x, y, yaw],
            negate,
            occupied_thresh,
            free_thresh,
            mode: self.mode.unwrap_or_default(),
        })
    }
}

impl MapHeader {
    /// How shades are read.
    pub fn reading(&self) -> ShadeReading {
        let &MapHeader { mode, negate, occupied_thresh, free_thresh, .. } = self;
        ShadeReading { mode, negate, occupied_thresh, free_thresh }
    }
}
