//! `rumbo eval map`: how good a map is.

use super::{figures, positive};
use crate::exit::{Exit, Failure};
use crate::terminal::Terminal;
use rumbo_kit::map_comparison::{MapComparison, WallDistance, compare_maps, usual_tolerance_m};
use rumbo_kit::map_file::{DEFAULT_MAX_CELLS, MapImage, load_map};
use std::path::{Path, PathBuf};

/// Walls and area of a map against a reference map of the same place
///
/// Both are YAML files of map_server. They may differ in resolution and origin; both must lie in the same frame.
#[derive(clap::Args)]
pub struct Args {
    /// The map to judge
    map: PathBuf,
    /// The map that is right
    reference: PathBuf,
    /// How near a wall must be to count as found [default: two cells of the coarser map]
    #[arg(long, value_name = "METERS", value_parser = positive)]
    tolerance: Option<f64>,
    /// Print the figures as one JSON object
    #[arg(long)]
    json: bool,
}

/// Does it.
pub fn run(args: &Args, terminal: &Terminal) -> Result<Exit, Failure> {
    let (map, reference) = (load(&args.map)?, load(&args.reference)?);
    let tolerance_m = args.tolerance.unwrap_or_else(|| usual_tolerance_m(&map, &reference));
    let found = compare_maps(&map, &reference, tolerance_m);
    let found = found.map_err(|error| {
        let (map, reference) = (args.map.display(), args.reference.display());
        Failure::Usage(format!("{map} against {reference}: {error}"))
    })?;
    if args.json {
        terminal.json(&found)?;
    } else {
        say(args, &found, terminal);
    }
    Ok(Exit::Success)
}

fn load(path: &Path) -> Result<MapImage, Failure> {
    load_map(path, DEFAULT_MAX_CELLS).map_err(|error| Failure::Usage(error.to_string()))
}

fn say(args: &Args, found: &MapComparison, terminal: &Terminal) {
    let title = format!("{} against {}", args.map.display(), args.reference.display());
    let percent = |share: f64| format!("{:.2} %", 100.0 * share);
    let away = |way: &WallDistance| {
        format!("mean {:.4} m, 95 % within {:.4} m, max {:.4} m", way.mean_m, way.p95_m, way.max_m)
    };
    let rows = [
        ("walls", format!("{} cells, {} in the reference", found.n_occupied, found.n_occupied_reference)),
        ("precision", format!("{} within {:.3} m", percent(found.precision), found.tolerance_m)),
        ("recall", format!("{} within {:.3} m", percent(found.recall), found.tolerance_m)),
        ("F1", percent(found.f1)),
        ("map to reference", away(&found.map_to_reference)),
        ("reference to map", away(&found.reference_to_map)),
        ("known", format!("{} of what the reference knows", percent(found.coverage))),
        (
            "agreement",
            found.agreement.map_or_else(
                || "nothing is known to both".to_owned(),
                |share| format!("{} of what both know", percent(share)),
            ),
        ),
    ];
    figures::lines(&title, &rows, terminal);
}
