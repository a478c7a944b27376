//! World files: walls, boxes, ramps, steps, people, doors and marks of a simulated place, in TOML.
//!
//! All faults of a file are found in one reading, each with line, column and key.

use std::path::{Path, PathBuf};

mod fault;
mod parse;
mod raster;
mod section;
mod things;

pub use fault::{WorldFault, WorldFileError};
pub use raster::{draw_mapped, mapped_outlines, raster_map, segment_cells};
pub use things::Things;

/// What a wall or box is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Material {
    /// Light and sound return.
    #[default]
    Opaque,
    /// Light passes, sound is reflected like by a mirror.
    Glass,
}

/// A straight, thin, vertical wall (`[[wall]]`).
#[derive(Debug, Clone, PartialEq)]
pub struct Wall {
    /// One end, meters.
    pub from: [f64; 2],
    /// The other end, meters.
    pub to: [f64; 2],
    /// Lower edge above the floor, meters.
    pub z_min_m: f64,
    /// Upper edge above the floor, meters.
    pub z_max_m: f64,
    /// What it is made of.
    pub material: Material,
    /// Whether a map of this world shows it.
    pub mapped: bool,
}

/// A cuboid (`[[box]]`): furniture, a table top, something unexpected.
#[derive(Debug, Clone, PartialEq)]
pub struct SolidBox {
    /// Name for messages.
    pub name: String,
    /// Center, meters.
    pub center: [f64; 2],
    /// Length and width, meters.
    pub size: [f64; 2],
    /// Turn about the center, radians.
    pub yaw_rad: f64,
    /// Lower face above the floor, meters.
    pub z_min_m: f64,
    /// Upper face above the floor, meters.
    pub z_max_m: f64,
    /// What it is made of.
    pub material: Material,
    /// Whether a map of this world shows it.
    pub mapped: bool,
}

impl SolidBox {
    /// The four corners, counter-clockwise.
    pub fn corners(&self) -> [[f64; 2]; 4] {
        let (sin, cos) = self.yaw_rad.sin_cos();
        let (half_x, half_y) = (self.size[0] / 2.0, self.size[1] / 2.0);
        [(-half_x, -half_y), (half_x, -half_y), (half_x, half_y), (-half_x, half_y)]
            .map(|(x, y)| [self.center[0] + cos * x - sin * y, self.center[1] + sin * x + cos * y])
    }
}

/// A raised piece of the floor: an inclined plane (`[[ramp]]`) or a level one (`[[step]]`), solid down to the floor. Where
/// several lie on top of each other, the highest counts.
#[derive(Debug, Clone, PartialEq)]
pub struct Ramp {
    /// Name for messages.
    pub name: String,
    /// Center, meters.
    pub center: [f64; 2],
    /// Length and width as seen from above, meters.
    pub size: [f64; 2],
    /// Turn about the center, radians.
    pub yaw_rad: f64,
    /// Height of the edge at its back, meters.
    pub z_from_m: f64,
    /// Height of the edge in front, one length along its x axis, meters.
    pub z_to_m: f64,
}

/// Somebody who walks along a route (`[[person]]`).
#[derive(Debug, Clone, PartialEq)]
pub struct Person {
    /// Name for messages.
    pub name: String,
    /// Corners of the route, meters; one corner is somebody who stands.
    pub route: Vec<[f64; 2]>,
    /// Walking speed.
    pub speed_m_s: f64,
    /// Time at which the person starts to walk.
    pub start_s: f64,
    /// From the last corner straight to the first, instead of back along the route.
    pub circular: bool,
    /// Two legs that step, instead of a disc.
    pub legs: bool,
    /// Radius of the disc; legs stand at half of it to both sides and have a quarter of it as radius.
    pub radius_m: f64,
    /// Height.
    pub height_m: f64,
    /// Stops so far in front of the robot's hull and goes on when it has gone, meters; none for somebody who does not see
    /// it.
    pub personal_space_m: Option<f64>,
    /// Walks back after waiting so long for the robot, seconds; none for somebody who waits for ever.
    pub turn_back_after_s: Option<f64>,
}

/// A piece of wall that opens and closes (`[[door]]`).
#[derive(Debug, Clone, PartialEq)]
pub struct Door {
    /// Name for messages.
    pub name: String,
    /// One end, meters.
    pub from: [f64; 2],
    /// The other end, meters.
    pub to: [f64; 2],
    /// Height.
    pub height_m: f64,
    /// What it is made of.
    pub material: Material,
    /// When it opens; a door without times stays closed.
    pub open_at_s: Option<f64>,
    /// When it closes; before this a door without `open_at_s` is open.
    pub close_at_s: Option<f64>,
}

impl Door {
    /// Whether the door bars the way at a time.
    pub fn is_closed(&self, time_s: f64) -> bool {
        match (self.open_at_s, self.close_at_s) {
            (None, None) => true,
            (Some(open), None) => time_s < open,
            (None, Some(close)) => time_s >= close,
            (Some(open), Some(close)) if open <= close => time_s < open || time_s >= close,
            (Some(open), Some(close)) => (close..open).contains(&time_s),
        }
    }
}

/// A mark with an identity (`[[mark]]`), such as a bar code on a wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorldMark {
    /// Which mark.
    pub id: u32,
    /// Where, meters.
    pub at: [f64; 2],
}

/// A world file, checked.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct WorldScene {
    /// Name for messages and titles.
    pub name: String,
    /// Background map (a map_server YAML file), resolved from the world file's folder.
    pub map: Option<PathBuf>,
    /// The map that robots are given of this place (a map_server YAML file), where it is another than what is mapped here.
    pub robot_map: Option<PathBuf>,
    /// Height of the background map's occupied cells, meters.
    pub map_height_m: f64,
    /// Left, bottom, right and top edge, meters; what the map of a world without a background covers.
    pub bounds: Option<[f64; 4]>,
    /// Walls.
    pub walls: Vec<Wall>,
    /// Boxes.
    pub boxes: Vec<SolidBox>,
    /// Ramps and steps.
    pub ramps: Vec<Ramp>,
    /// People.
    pub persons: Vec<Person>,
    /// Doors.
    pub doors: Vec<Door>,
    /// Marks.
    pub marks: Vec<WorldMark>,
}

/// Height of walls, doors and occupied map cells that say nothing else.
pub const DEFAULT_WALL_HEIGHT_M: f64 = 2.0;

impl WorldScene {
    /// A world that is nothing but a map.
    pub fn of_map(map: PathBuf) -> Self {
        Self { map: Some(map), map_height_m: DEFAULT_WALL_HEIGHT_M, ..Self::default() }
    }
}

/// Loads a world: a TOML world file, or a map_server YAML file as a world that is only its map.
///
/// # Errors
/// [`WorldFileError`]: the file cannot be read, or all its faults.
pub fn load_world(path: &Path) -> Result<WorldScene, WorldFileError> {
    if path.extension().is_some_and(|extension| extension == "yaml" || extension == "yml") {
        return Ok(WorldScene::of_map(path.to_path_buf()));
    }
    let text = crate::small_file::read_text(path)
        .map_err(|source| WorldFileError::Unreadable { path: path.to_path_buf(), source })?;
    parse_world(&text, path)
}

/// Parses the text of a world file; `path` names it in messages, and its folder is where `map` is looked for.
///
/// # Errors
/// [`WorldFileError::Faults`] with every fault of the text.
pub fn parse_world(text: &str, path: &Path) -> Result<WorldScene, WorldFileError> {
    let (scene, faults) = parse::scene(text, path.parent().unwrap_or(Path::new("")));
    if faults.is_empty() {
        Ok(scene)
    } else {
        Err(WorldFileError::Faults { path: path.to_path_buf(), faults })
    }
}

#[cfg(test)]
mod tests;
