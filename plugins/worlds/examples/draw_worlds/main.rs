//! Draws the worlds that come with Rumbo: `cargo run -p rumbo-worlds --example draw_worlds [FOLDER]`.
//!
//! The office is this program's own; the others are converted from the files in `tests/data`. The results are committed
//! in `pipelines/worlds`, and a test compares them.

use std::error::Error;
use std::path::{Path, PathBuf};

use rumbo_kit::map_file::{MapImage, PictureFormat, SavedAs, save_map};

mod convert;
mod office;

/// A world as it is written.
pub enum Drawn {
    /// A TOML world file.
    Toml(String),
    /// A map_server YAML file with a PNG.
    Map(MapImage),
}

fn main() -> Result<(), Box<dyn Error>> {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder =
        std::env::args().nth(1).map_or_else(|| package.join("../../pipelines/worlds"), PathBuf::from);
    for (name, drawn) in all(&package.join("tests/data"))? {
        match drawn {
            Drawn::Toml(text) => std::fs::write(folder.join(format!("{name}.toml")), text)?,
            Drawn::Map(map) => {
                save_map(&folder.join(format!("{name}.yaml")), &map, SavedAs::Trinary, PictureFormat::Png)?;
            }
        }
    }
    Ok(())
}

/// Every world with its name.
fn all(data: &Path) -> Result<Vec<(String, Drawn)>, Box<dyn Error>> {
    let mut worlds = vec![("office-20m".to_string(), Drawn::Map(office::draw()))];
    worlds.extend(convert::all(data)?);
    Ok(worlds)
}
