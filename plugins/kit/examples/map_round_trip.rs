//! Every map_server map of a folder is read, rewritten and reread without a change of meaning: in the mode it has, and
//! in each of the three modes, as PGM and as PNG, black or white for occupied.
//!
//! `cargo run --release -p rumbo-kit --example map_round_trip FOLDER...`
#![allow(clippy::print_stdout)]

use rumbo_kit::map_file::{
    DEFAULT_MAX_CELLS, MapFileError, MapImage, MapMode, PictureFormat, ShadeReading, load_map,
    load_map_header, save_map_to_be_read,
};
use std::error::Error;
use std::path::{Path, PathBuf};

fn main() -> Result<(), Box<dyn Error>> {
    let mut yamls = Vec::new();
    for folder in std::env::args_os().skip(1) {
        for entry in std::fs::read_dir(folder)? {
            yamls.push(entry?.path());
        }
    }
    yamls.retain(|path| path.extension().is_some_and(|extension| extension == "yaml"));
    yamls.sort();
    if yamls.is_empty() {
        return Err("no map found; name folders with .yaml files of map_server".into());
    }
    let scratch = std::env::temp_dir().join(format!("rumbo-map-round-trip-{}", std::process::id()));
    std::fs::create_dir_all(&scratch)?;
    let results: Result<Vec<()>, _> = yamls.iter().map(|yaml| round_trips(yaml, &scratch)).collect();
    std::fs::remove_dir_all(&scratch)?;
    results?;
    println!("{} maps came back unchanged", yamls.len());
    Ok(())
}

/// All round trips of one map.
fn round_trips(yaml: &Path, scratch: &Path) -> Result<(), Box<dyn Error>> {
    let map = load_map(yaml, DEFAULT_MAX_CELLS)?;
    let own = load_map_header(yaml)?.reading();
    let has_unknown = map.cells.contains(&-1);
    let (mut n_trips, mut n_refused) = (0, 0);
    for mode in [own.mode, MapMode::Trinary, MapMode::Scale, MapMode::Raw] {
        for negate in [own.negate, !own.negate] {
            let reading = ShadeReading { mode, negate, ..own };
            for format in [PictureFormat::Pgm, PictureFormat::Png] {
                // A PGM has no transparent pixels, and mode scale has no other way to say unknown.
                let must_refuse = mode == MapMode::Scale && format == PictureFormat::Pgm && has_unknown;
                match comes_back(&map, &reading, format, &scratch.join("map.yaml")) {
                    Ok(()) if !must_refuse => n_trips += 1,
                    Err(Trip::File(MapFileError::Unsayable { .. })) if must_refuse => n_refused += 1,
                    Ok(()) => return Err(format!("{}: scale as PGM kept unknown?", yaml.display()).into()),
                    Err(trip) => {
                        return Err(format!("{}: {reading:?} {format:?}: {trip:?}", yaml.display()).into());
                    }
                }
            }
        }
    }
    let n = |wanted: fn(i8) -> bool| map.cells.iter().filter(|cell| wanted(**cell)).count();
    println!(
        "{}: {} x {}, {} occupied, {} free, {} unknown; {n_trips} round trips, {n_refused} refused (unknown in scale PGM)",
        yaml.display(),
        map.width,
        map.height,
        n(|cell| cell > 50),
        n(|cell| (0..50).contains(&cell)),
        n(|cell| cell < 0),
    );
    Ok(())
}

/// What can go wrong on the way.
#[derive(Debug)]
#[allow(dead_code, reason = "shown by its Debug form")]
enum Trip {
    File(MapFileError),
    Cells(usize),
    Header(PathBuf),
}

fn comes_back(
    map: &MapImage,
    reading: &ShadeReading,
    format: PictureFormat,
    yaml: &Path,
) -> Result<(), Trip> {
    save_map_to_be_read(yaml, map, reading, format).map_err(Trip::File)?;
    let back = load_map(yaml, DEFAULT_MAX_CELLS).map_err(Trip::File)?;
    let header = load_map_header(yaml).map_err(Trip::File)?;
    let n_changed = map.cells.iter().zip(&back.cells).filter(|(a, b)| a != b).count();
    if n_changed > 0 || map.cells.len() != back.cells.len() {
        return Err(Trip::Cells(n_changed));
    }
    let is_same = back == *map && header.reading() == *reading && header.origin == map.origin;
    if is_same { Ok(()) } else { Err(Trip::Header(yaml.to_path_buf())) }
}
