//! The keys of a world file.

use std::path::{Path, PathBuf};

use toml::de::DeTable;

use super::section::{Faults, Must, Section};
use super::{
    DEFAULT_WALL_HEIGHT_M, Door, Material, Person, Ramp, SolidBox, Wall, WorldFault, WorldMark, WorldScene,
};

const MATERIALS: [(&str, Material); 2] = [("opaque", Material::Opaque), ("glass", Material::Glass)];

/// Reads everything that can be read; the scene is meaningful only when there are no faults.
pub(super) fn scene(text: &str, folder: &Path) -> (WorldScene, Vec<WorldFault>) {
    let (document, syntax) = DeTable::parse_recoverable(text);
    let mut faults = Faults::new(text);
    for error in &syntax {
        faults.add(error.span().unwrap_or_default(), String::new(), error.message().to_string());
    }
    let mut scene = WorldScene::default();
    // After a syntax error the tables may be mangled, and faults found in them would mislead.
    if syntax.is_empty() {
        let mut top = Section::new(document.get_ref(), 0..0, String::new(), &mut faults);
        read_top(&mut top, folder, &mut scene);
        top.finish();
    }
    let mut found = faults.found;
    found.sort_by_key(|fault| fault.span.start);
    (scene, found)
}

/// A map beside the world file, which must be there.
fn map_file(top: &mut Section<'_, '_, '_>, key: &'static str, folder: &Path) -> Option<PathBuf> {
    let file = folder.join(top.text(key)?);
    if !file.is_file() {
        let message =
            format!("no file {}; expected a map_server YAML file beside the world file", file.display());
        top.fault(key, message);
    }
    Some(file)
}

/// Things without a world around them.
pub(super) fn things(text: &str) -> (WorldScene, Vec<WorldFault>) {
    let (document, _) = DeTable::parse_recoverable(text);
    let (mut scene, mut faults) = (WorldScene::default(), Faults::new(text));
    let mut top = Section::new(document.get_ref(), 0..0, String::new(), &mut faults);
    read_things(&mut top, DEFAULT_WALL_HEIGHT_M, &mut scene);
    top.finish();
    (scene, faults.found)
}

fn read_top(top: &mut Section<'_, '_, '_>, folder: &Path, scene: &mut WorldScene) {
    scene.name = top.text("name").unwrap_or_default();
    let wall_height_m = top.number("wall_height_m", Must::BePositive).unwrap_or(DEFAULT_WALL_HEIGHT_M);
    scene.map_height_m = top.number("map_height_m", Must::BePositive).unwrap_or(wall_height_m);
    scene.map = map_file(top, "map", folder);
    scene.robot_map = map_file(top, "robot_map", folder);
    scene.bounds = top.numbers("bounds", false);
    if let Some([left, bottom, right, top_edge]) = scene.bounds.filter(|b| b[0] >= b[2] || b[1] >= b[3]) {
        let found = format!("[{left}, {bottom}, {right}, {top_edge}]");
        top.fault(
            "bounds",
            format!("is {found}, expected [left, bottom, right, top] with left < right, bottom < top"),
        );
    }
    read_things(top, wall_height_m, scene);
    if scene.map.is_none() && scene.walls.is_empty() && scene.boxes.is_empty() && scene.bounds.is_none() {
        top.missing("map", "a map, or at least one [[wall]] or [[box]], or bounds");
    }
}

fn read_things(top: &mut Section<'_, '_, '_>, wall_height_m: f64, scene: &mut WorldScene) {
    top.tables("wall", |section| scene.walls.extend(read_wall(section, wall_height_m)));
    top.tables("box", |section| scene.boxes.extend(read_box(section, wall_height_m)));
    top.tables("ramp", |section| scene.ramps.extend(read_ramp(section)));
    top.tables("step", |section| scene.ramps.extend(read_step(section)));
    top.tables("person", |section| scene.persons.extend(read_person(section)));
    top.tables("door", |section| scene.doors.extend(read_door(section, wall_height_m)));
    top.tables("mark", |section| scene.marks.extend(read_mark(section)));
}

/// `from` and `to` of a wall or door, which must differ.
fn ends(section: &mut Section<'_, '_, '_>) -> Option<([f64; 2], [f64; 2])> {
    let (from, to) = (section.numbers("from", true), section.numbers("to", true));
    let (from, to) = (from?, to?);
    if from == to {
        section.fault("to", format!("is {to:?} like from; a wall needs two different ends"));
        return None;
    }
    Some((from, to))
}

/// Heights from `z_min_m` to `z_max_m` (or its short form `height_m`).
fn heights(section: &mut Section<'_, '_, '_>, height_m: f64, key: &'static str) -> (f64, f64) {
    let z_min_m = section.number("z_min_m", Must::NotBeNegative).unwrap_or(0.0);
    let z_max_m = section.number(key, Must::BePositive).unwrap_or(height_m);
    if z_max_m <= z_min_m {
        section.fault(key, format!("the upper edge is at {z_max_m} m, expected above z_min_m = {z_min_m}"));
    }
    (z_min_m, z_max_m)
}

fn read_wall(section: &mut Section<'_, '_, '_>, wall_height_m: f64) -> Option<Wall> {
    let ends = ends(section);
    let (z_min_m, z_max_m) = heights(section, wall_height_m, "height_m");
    let material = section.word("material", &MATERIALS, Material::Opaque);
    let mapped = section.flag("mapped").unwrap_or(true);
    let (from, to) = ends?;
    Some(Wall { from, to, z_min_m, z_max_m, material, mapped })
}

/// Center, edges and turn of a rectangle.
fn rectangle(section: &mut Section<'_, '_, '_>) -> (Option<[f64; 2]>, Option<[f64; 2]>, f64) {
    let center = section.numbers("center", true);
    let size = section.numbers::<2>("size", true);
    if let Some(wrong) = size.filter(|size| size.iter().any(|&edge| edge <= 0.0)) {
        section.fault("size", format!("is {wrong:?}, expected two lengths above 0"));
    }
    let yaw_rad = section.number("yaw_deg", Must::BeFinite).unwrap_or(0.0).to_radians();
    (center, size, yaw_rad)
}

fn read_ramp(section: &mut Section<'_, '_, '_>) -> Option<Ramp> {
    let name = section.text("name").unwrap_or_else(|| "ramp".to_string());
    let (center, size, yaw_rad) = rectangle(section);
    let z_from_m = section.number("z_from_m", Must::NotBeNegative).unwrap_or(0.0);
    let z_to_m =
        section.needed_number("z_to_m", Must::NotBeNegative, "the height of its front edge, 0 or more");
    if z_to_m == Some(0.0) && z_from_m == 0.0 {
        section.fault("z_to_m", "is 0 like z_from_m; expected a ramp that rises".into());
    }
    Some(Ramp { name, center: center?, size: size?, yaw_rad, z_from_m, z_to_m: z_to_m? })
}

fn read_step(section: &mut Section<'_, '_, '_>) -> Option<Ramp> {
    let name = section.text("name").unwrap_or_else(|| "step".to_string());
    let (center, size, yaw_rad) = rectangle(section);
    let height_m = section.needed_number("height_m", Must::BePositive, "a height above 0");
    let (z_from_m, z_to_m) = (height_m?, height_m?);
    Some(Ramp { name, center: center?, size: size?, yaw_rad, z_from_m, z_to_m })
}

fn read_box(section: &mut Section<'_, '_, '_>, wall_height_m: f64) -> Option<SolidBox> {
    let name = section.text("name").unwrap_or_else(|| "box".to_string());
    let (center, size, yaw_rad) = rectangle(section);
    let (z_min_m, z_max_m) = heights(section, wall_height_m, "z_max_m");
    let material = section.word("material", &MATERIALS, Material::Opaque);
    let mapped = section.flag("mapped").unwrap_or(true);
    Some(SolidBox { name, center: center?, size: size?, yaw_rad, z_min_m, z_max_m, material, mapped })
}

fn read_person(section: &mut Section<'_, '_, '_>) -> Option<Person> {
    let name = section.text("name").unwrap_or_else(|| "person".to_string());
    let route = section.points("route");
    let speed_m_s = section.number("speed_m_s", Must::NotBeNegative).unwrap_or(0.0);
    let start_s = section.number("start_s", Must::NotBeNegative).unwrap_or(0.0);
    let circular = section.word("at_end", &[("turn_back", false), ("circle", true)], false);
    let legs = section.word("shape", &[("disc", false), ("legs", true)], false);
    let radius_m = section.number("radius_m", Must::BePositive).unwrap_or(0.25);
    let height_m = section.number("height_m", Must::BePositive).unwrap_or(1.8);
    let personal_space_m = section.number("personal_space_m", Must::NotBeNegative);
    let turn_back_after_s = section.number("turn_back_after_s", Must::NotBeNegative);
    if turn_back_after_s.is_some() && personal_space_m.is_none() {
        section.fault(
            "turn_back_after_s",
            "is for who waits for the robot; expected personal_space_m as well".into(),
        );
    }
    if speed_m_s > 0.0 && route.windows(2).all(|leg| leg[0] == leg[1]) {
        section.fault(
            "route",
            "never leaves its first point; expected at least two different points, or speed_m_s = 0".into(),
        );
    }
    (!route.is_empty()).then_some(Person {
        name,
        route,
        speed_m_s,
        start_s,
        circular,
        legs,
        radius_m,
        height_m,
        personal_space_m,
        turn_back_after_s,
    })
}

fn read_door(section: &mut Section<'_, '_, '_>, wall_height_m: f64) -> Option<Door> {
    let name = section.text("name").unwrap_or_else(|| "door".to_string());
    let ends = ends(section);
    let height_m = section.number("height_m", Must::BePositive).unwrap_or(wall_height_m);
    let material = section.word("material", &MATERIALS, Material::Opaque);
    let open_at_s = section.number("open_at_s", Must::NotBeNegative);
    let close_at_s = section.number("close_at_s", Must::NotBeNegative);
    if let (Some(open), Some(close)) = (open_at_s, close_at_s)
        && open == close
    {
        section.fault("close_at_s", format!("is {close} like open_at_s; expected two different times"));
    }
    let (from, to) = ends?;
    Some(Door { name, from, to, height_m, material, open_at_s, close_at_s })
}

fn read_mark(section: &mut Section<'_, '_, '_>) -> Option<WorldMark> {
    let (id, at) = (section.whole_number("id"), section.numbers("at", true));
    Some(WorldMark { id: id?, at: at? })
}
