//! Shipped pipelines in hard places, against the world that they drove in.

use crate::slam::off as off_walls_m;
use rumbo_core::engine::{EndReason, Engine};
use rumbo_core::frames::flatten;
use rumbo_core::map::{Line, Map};
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// Walls of a world file.
fn walls(file: &str) -> Vec<Line> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines/worlds").join(file);
    let table: toml::Table = std::fs::read_to_string(path).unwrap().parse().unwrap();
    let point = |end: &toml::Value| [0, 1].map(|k| end[k].as_float().unwrap());
    let wall =
        |wall: &toml::Value| Line { from: point(&wall["from"]), to: point(&wall["to"]), ..Line::default() };
    table["wall"].as_array().unwrap().iter().map(wall).collect()
}

/// 95 % of the occupied cells are at most so far from a wall, meters.
fn most_off_m(map: &Map, walls: &[Line]) -> f64 {
    let grid = map.grid.as_ref().unwrap();
    let occupied = grid.cells.iter().enumerate().filter(|(_, cell)| **cell > 1.0);
    let mut off: Vec<f64> = occupied
        .map(|(idx, _)| {
            let center = grid.center_of(grid.cell_of(idx));
            off_walls_m([center.x, center.y], walls)
        })
        .collect();
    assert!(off.len() > 1000, "{} cells", off.len());
    off.sort_by(f64::total_cmp);
    off[off.len() * 95 / 100]
}

/// How far the robot is from where it believes to be at the end, and how far its map is off, meters.
fn ends(pipeline: &str, seed: u32) -> [f64; 2] {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines").join(pipeline);
    let sets = [format!("seed={seed}")];
    let ready = rumbo::load::load(&file, &sets, &rumbo::registry().unwrap()).ok().unwrap();
    let mut engine = Engine::build(&ready.pipeline).unwrap();
    assert_eq!(engine.run(&mut [], &AtomicBool::new(false)).reason, EndReason::Finished);
    let view = engine.view();
    let truth = flatten(&view.truth.unwrap().map_from_base);
    let end_m = (view.map_from_base.inverse() * truth).translation.vector.norm();
    [end_m, most_off_m(&engine.slam_map().unwrap(), &walls("rubble_loop_dense.toml"))]
}

#[test]
fn a_camera_comes_back_to_where_it_began_and_its_walls_are_where_they_are() {
    for seed in 1..4 {
        let [end_m, map_m] = ends("finder_depth_camera.toml", seed);
        assert!(end_m <= 0.15 && map_m <= 0.15, "seed {seed}: {end_m} m at the end, walls {map_m} m");
    }
}

/// What it drifted by before is spread over the map when the loop is closed, and its walls are twice as far off.
#[test]
fn a_camera_closes_its_loop() {
    for seed in 1..4 {
        let [end_m, map_m] = ends("finder_camera_loop.toml", seed);
        assert!(end_m <= 0.05 && map_m <= 0.25, "seed {seed}: {end_m} m at the end, walls {map_m} m");
    }
}
