use std::path::PathBuf;

use rumbo_core::frames::Point2;
use rumbo_core::map::CellClass;
use rumbo_core::registry::{Registry, Stage};

use super::*;

fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("rumbo-static-map-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("map.yaml"), "image: map.pgm\nresolution: 0.5\norigin: [1, 2, 0]\n").unwrap();
    std::fs::write(folder.join("map.pgm"), "P2 4 3 255 0 254 254 254 205 254 254 254 0 0 0 0").unwrap();
    let world = "map = 'map.yaml'\n[[box]]\ncenter = [2.75, 2.75]\nsize = [0.4, 0.4]\n\
                 [[box]]\ncenter = [2.75, 3.25]\nsize = [0.4, 0.4]\nmapped = false\n";
    std::fs::write(folder.join("world.toml"), world).unwrap();
    folder
}

fn started(params: &StaticMapParams, context: &BuildContext) -> Map {
    let mut map = Map::default();
    params.build(context).unwrap().start(&mut map).unwrap();
    map
}

#[test]
fn the_grid_is_the_file_in_log_odds() {
    let context = BuildContext { folder: folder("grid"), ..BuildContext::bare("map") };
    let map =
        started(&StaticMapParams { file: Some("map.yaml".into()), ..StaticMapParams::default() }, &context);
    let grid = map.grid.unwrap();
    assert_eq!((grid.width(), grid.height(), grid.header().origin), (4, 3, [1.0, 2.0, 0.0]));
    let class = |x: f64, y: f64| grid.class(grid.cell_at(Point2::new(x, y)).unwrap());
    assert_eq!(class(1.1, 2.1), CellClass::Occupied);
    assert_eq!(class(1.1, 2.6), CellClass::Unknown);
    assert_eq!(class(1.6, 2.6), CellClass::Free);
    assert_eq!(grid.cells[0], Grid::CERTAIN);
    assert_eq!((map.version, map.lines), (1, None));
}

#[test]
fn the_file_defaults_to_the_worlds_map_and_shows_what_is_mapped() {
    let world_map = Some(folder("default").join("world.toml"));
    let wanted_layers = vec![Layer::Grid, Layer::Lines];
    let context = BuildContext { world_map, wanted_layers, ..BuildContext::bare("map") };
    let map = started(&StaticMapParams { min_line_m: 0.3, ..StaticMapParams::default() }, &context);
    let grid = map.grid.unwrap();
    let class = |x: f64, y: f64| grid.class(grid.cell_at(Point2::new(x, y)).unwrap());
    assert_eq!(class(2.75, 2.75), CellClass::Occupied, "the mapped box");
    assert_eq!(class(2.75, 3.25), CellClass::Free, "the unexpected one");
    let lines = map.lines.unwrap().lines;
    assert_eq!(lines.iter().filter(|line| line.covariance[0] == 1e-6).count(), 4, "the box's sides, exactly");
    assert!(lines.len() > 4, "and the picture's walls");
}

#[test]
fn faults_are_told_with_their_key() {
    let context = BuildContext { folder: folder("faults"), ..BuildContext::bare("map") };
    let build = |params: StaticMapParams| params.build(&context).err().unwrap();
    assert!(build(StaticMapParams::default()).help.is_some());
    let absent = build(StaticMapParams { file: Some("absent.yaml".into()), ..StaticMapParams::default() });
    assert!(absent.path == "file" && absent.message.contains("absent.yaml"), "{}", absent.message);
    let few = StaticMapParams { file: Some("map.yaml".into()), max_cells: 11, ..StaticMapParams::default() };
    assert!(build(few).message.contains("4 x 3 = 12 cells, more than max_cells = 11"));
    assert_eq!(
        build(StaticMapParams { resolution_m: f64::NAN, ..StaticMapParams::default() }).path,
        "resolution_m"
    );
    let registry = Registry::linked().unwrap();
    assert!(registry.get(Stage::MapBuilder, "static_map").is_some());
}
