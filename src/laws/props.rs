//! Files that laws need: the hall as a map, and the drive through it as a recording.

use super::drive::{Drive, N_FRAMES};
use super::law::Trouble;
use super::text_world::TextWorld;
use super::turn::Turn;
use rumbo_core::frames::Point2;
use rumbo_core::map::{Cell, CellClass};
use rumbo_core::messages::Data;
use std::fmt::Write as _;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Scans, and readings of the odometer, of the recording.
pub const N_RECORDED: usize = N_FRAMES;

/// A folder with the files; it is removed at the end.
#[derive(Debug)]
pub struct Props {
    folder: Option<PathBuf>,
}

/// Several verifications may run in one process.
static COUNT: AtomicUsize = AtomicUsize::new(0);

impl Props {
    /// Writes the files; where that fails, laws that need them say so.
    pub fn make() -> Props {
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        let name = format!("rumbo-laws-{}-{number}", std::process::id());
        let folder = std::env::temp_dir().join(name);
        let props = Props { folder: Some(folder.clone()) };
        match write_all(&folder) {
            Ok(()) => props,
            // What was written so far is removed with the old value.
            Err(_) => Props { folder: None },
        }
    }

    /// The map_server file of the hall, seen from this side.
    pub fn map(&self, turn: Turn) -> Option<PathBuf> {
        self.folder.as_ref().map(|folder| folder.join(format!("{}.yaml", file_name(turn))))
    }

    /// The world file of the hall with its marks, seen from this side.
    pub fn world(&self, turn: Turn) -> Option<PathBuf> {
        self.folder.as_ref().map(|folder| folder.join(format!("{}.toml", file_name(turn))))
    }

    /// The recording of the drive through the hall.
    pub fn recording(&self) -> Option<PathBuf> {
        self.folder.as_ref().map(|folder| folder.join("drive.clf"))
    }
}

impl Drop for Props {
    fn drop(&mut self) {
        if let Some(folder) = &self.folder {
            // A folder that stays behind does no harm where nobody looks.
            let _ = std::fs::remove_dir_all(folder);
        }
    }
}

fn file_name(turn: Turn) -> &'static str {
    match turn {
        Turn::None => "hall",
        Turn::Quarter => "hall-turned",
        Turn::Mirror => "hall-mirrored",
    }
}

fn write_all(folder: &Path) -> io::Result<()> {
    std::fs::create_dir_all(folder)?;
    let own = |_: Trouble| io::Error::other("the hall cannot be made");
    let hall = TextWorld::hall().map_err(own)?;
    for turn in [Turn::None, Turn::Quarter, Turn::Mirror] {
        let world = hall.turned(turn).map_err(own)?;
        let name = file_name(turn);
        std::fs::write(folder.join(format!("{name}.pgm")), picture(&world))?;
        let yaml = format!(
            "image: {name}.pgm\nmode: trinary\nresolution: {}\norigin: [0.0, 0.0, 0.0]\nnegate: 0\n\
             occupied_thresh: 0.65\nfree_thresh: 0.196\n",
            world.grid.resolution_m()
        );
        std::fs::write(folder.join(format!("{name}.yaml")), yaml)?;
        std::fs::write(folder.join(format!("{name}.toml")), world_file(name, &world))?;
    }
    let drive = Drive::seen_from(Turn::None).map_err(own)?;
    std::fs::write(folder.join("drive.clf"), log(&drive))
}

/// A binary PGM picture, top row first.
fn picture(world: &TextWorld) -> Vec<u8> {
    let grid = &world.grid;
    let mut bytes = format!("P5\n{} {}\n255\n", grid.width(), grid.height()).into_bytes();
    for row in (0..grid.height()).rev() {
        for col in 0..grid.width() {
            bytes.push(match grid.class(Cell { col, row }) {
                CellClass::Occupied => 0,
                CellClass::Free => 254,
                CellClass::Unknown => 205,
            });
        }
    }
    bytes
}

/// The map with marks on its walls.
fn world_file(name: &str, world: &TextWorld) -> String {
    let mark = |(identity, at): &(u32, Point2)| {
        format!("[[mark]]\nid = {identity}\nat = [{:.6}, {:.6}]\n", at.x, at.y)
    };
    let marks: String = world.marks.iter().map(mark).collect();
    format!("map = \"{name}.yaml\"\n{marks}")
}

/// A CARMEN log, with the true poses inside its laser messages.
fn log(drive: &Drive) -> String {
    let mut text = String::from("# a drive through a hall, made up\n");
    for frame in &drive.frames {
        let stamp_s = 1000.0 + frame.now.as_secs();
        let numbers = |pose: &rumbo_core::frames::Pose2| {
            let [x, y] = [pose.translation.x, pose.translation.y];
            format!("{x:.6} {y:.6} {:.6}", pose.rotation.angle())
        };
        let (odometer, truth) = (numbers(&frame.odom_from_base), numbers(&frame.map_from_base));
        for observation in &frame.seen {
            // A String takes everything.
            let _ = match &observation.data {
                Data::Odometry(odometry) => writeln!(
                    text,
                    "ODOM {odometer} {} {} 0 {stamp_s:.6} made-up {stamp_s:.6}",
                    odometry.twist.forward_m_s, odometry.twist.turn_rad_s
                ),
                Data::LaserScan(scan) => {
                    let ranges: Vec<String> =
                        scan.ranges_m.iter().map(|range| format!("{:.3}", range.min(80.0))).collect();
                    writeln!(
                        text,
                        "FLASER {} {} {truth} {odometer} {stamp_s:.6} made-up {stamp_s:.6}",
                        ranges.len(),
                        ranges.join(" ")
                    )
                }
                _ => Ok(()),
            };
        }
    }
    text
}
