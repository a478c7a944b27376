//! From a file to map layers.

use std::path::Path;

use rumbo_core::boundary::Buffer;
use rumbo_core::map::{Grid, GridFault, GridHeader, Line};
use rumbo_kit::map_file::{MapImage, UNKNOWN, load_map};
use rumbo_kit::world_file::{Wall, WorldScene, draw_mapped, load_world, mapped_outlines, raster_map};

use super::{StaticMapParams, wall_lines};

/// Lines of a world file are as exact as its numbers.
const EXACT_LINE_VARIANCE: f64 = 1e-6;

/// Loads a map_server YAML file or a TOML world file; lines only when they are wanted.
///
/// # Errors
/// The message of whatever is wrong with the file, or that it holds no map.
pub fn load_static(
    file: &Path,
    params: &StaticMapParams,
    with_lines: bool,
) -> Result<(Grid, Option<Vec<Line>>), String> {
    let scene = load_world(file).map_err(|error| error.to_string())?;
    // Who maps a place by himself gets no more than that map shows.
    let scene = scene.robot_map.clone().map_or(scene, WorldScene::of_map);
    let picture = match &scene.map {
        Some(map) => Some(load_map(map, params.max_cells).map_err(|error| error.to_string())?),
        None => None,
    };
    let lines = with_lines.then(|| {
        let mut lines =
            picture.as_ref().map_or_else(Vec::new, |picture| wall_lines(picture, params.min_line_m));
        lines.extend(exact_lines(&scene, params.min_line_m));
        lines
    });
    let image = match picture {
        Some(mut picture) => {
            draw_mapped(&scene, &mut picture);
            picture
        }
        None => raster_map(&scene, params.resolution_m, params.max_cells).ok_or_else(|| {
            format!(
                "{}: a grid of {} m cells over this world needs more than max_cells = {}; enlarge resolution_m",
                file.display(),
                params.resolution_m,
                params.max_cells
            )
        })?,
    };
    let grid = grid_of(&image).map_err(|fault| format!("{}: {fault}", file.display()))?;
    Ok((grid, lines))
}

/// A map file's grid as the framework keeps it.
///
/// # Errors
/// [`GridFault`] for a picture without cells or with an impossible resolution.
pub fn grid_of(image: &MapImage) -> Result<Grid, GridFault> {
    let log_odds = |percent: i8| match percent {
        UNKNOWN => 0.0,
        percent => {
            let probability = f32::from(percent) / 100.0;
            (probability / (1.0 - probability)).ln().clamp(-Grid::CERTAIN, Grid::CERTAIN)
        }
    };
    // 256 logarithms instead of one a cell.
    let table: Vec<f32> = (0..=u8::MAX).map(|byte| log_odds(byte.cast_signed())).collect();
    let mut cells = Buffer::zeroed(image.cells.len());
    for (cell, percent) in cells.make_mut().iter_mut().zip(&image.cells) {
        *cell = table[usize::from(percent.cast_unsigned())];
    }
    let header = GridHeader {
        width: image.width as u32,
        height: image.height as u32,
        resolution_m: image.resolution_m,
        origin: image.origin,
        occupied_above: Grid::OCCUPIED_ABOVE,
        free_below: Grid::FREE_BELOW,
    };
    Grid::new(header, cells)
}

/// Sides of boxes, and both faces of walls: each has its free side on the right.
fn exact_lines(scene: &WorldScene, min_line_m: f64) -> impl Iterator<Item = Line> {
    let long = move |[from, to]: &[[f64; 2]; 2]| (to[0] - from[0]).hypot(to[1] - from[1]) >= min_line_m;
    let faces = |wall: &Wall| [[wall.from, wall.to], [wall.to, wall.from]];
    let walls = scene.walls.iter().filter(|wall| wall.mapped).flat_map(faces);
    let without_walls = WorldScene { walls: Vec::new(), ..scene.clone() };
    let lines: Vec<[[f64; 2]; 2]> = walls.chain(mapped_outlines(&without_walls)).collect();
    lines.into_iter().filter(long).map(|[from, to]| Line {
        from,
        to,
        covariance: [EXACT_LINE_VARIANCE, 0.0, EXACT_LINE_VARIANCE],
    })
}
