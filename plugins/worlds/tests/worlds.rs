//! The worlds that come with Rumbo are what their sources say, and the simulator sees what is in them.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use std::path::{Path, PathBuf};
use std::sync::Arc;

use nalgebra::UnitQuaternion;
use rumbo_core::frames::{Pose3, Twist, flatten, pose2};
use rumbo_core::messages::Command;
use rumbo_core::pipeline::Script;
use rumbo_core::registry::Plugin;
use rumbo_core::robot::{Drive, Robot};
use rumbo_core::stages::{Answer, BuildContext, BuildError, Probe, World};
use rumbo_core::time::Time;
use rumbo_kit::map_file::{DEFAULT_MAX_CELLS, load_map};
use rumbo_kit::world_file::{load_world, parse_world};
use rumbo_worlds::sim::{SimParams, Start, Wheels};

#[path = "../examples/draw_worlds/convert.rs"]
mod convert;
#[path = "../examples/draw_worlds/office.rs"]
mod office;

/// As in the example: a world as it is written.
pub enum Drawn {
    Toml(String),
    Map(rumbo_kit::map_file::MapImage),
}

fn data() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data")
}

fn worlds() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pipelines/worlds")
}

fn world(name: &str, start: Start) -> Result<Box<dyn World>, BuildError> {
    let params = SimParams { map: Some(worlds().join(name)), start, ..SimParams::default() };
    params.build(&BuildContext::bare("world"))
}

fn start(x_m: f64, y_m: f64, yaw_deg: f64) -> Start {
    Start { x_m, y_m, yaw_deg }
}

fn ranges(world: &mut dyn World, mount: &Pose3, bearings_deg: &[f64]) -> Vec<f64> {
    bearings_deg
        .iter()
        .map(|bearing_deg| {
            let probe = Probe::Beams {
                base_from_sensor: mount,
                first_bearing_rad: bearing_deg.to_radians(),
                bearing_step_rad: 0.01,
                n_beams: 1,
                max_range_m: 100.0,
            };
            match world.probe(&probe) {
                Ok(Answer::Ranges(ranges)) => f64::from(ranges[0]),
                other => panic!("{other:?}"),
            }
        })
        .collect()
}

/// `cargo run -p rumbo-worlds --example draw_worlds` writes them anew.
#[test]
fn the_committed_worlds_are_what_the_program_draws() {
    let mut drawn = convert::all(&data()).unwrap();
    drawn.push(("office-20m".into(), Drawn::Map(office::draw())));
    assert_eq!(drawn.len(), 9);
    for (name, drawn) in drawn {
        match drawn {
            Drawn::Toml(text) => {
                let committed = std::fs::read_to_string(worlds().join(format!("{name}.toml"))).unwrap();
                assert!(committed == text, "{name}.toml differs from what the program draws");
                parse_world(&text, Path::new("drawn.toml")).unwrap();
            }
            Drawn::Map(map) => {
                let committed = load_map(&worlds().join(format!("{name}.yaml")), DEFAULT_MAX_CELLS).unwrap();
                assert!(committed == map, "{name}.yaml differs from what the program draws");
            }
        }
    }
}

/// CRC-32 of the bytes 0 and 1, top line first, as the source of the maps gives it.
#[test]
fn the_cell_maps_have_the_published_checksums() {
    let source: toml::Table =
        toml::from_str(&std::fs::read_to_string(data().join("natural_landmark_maps.toml")).unwrap()).unwrap();
    for map in source["map"].as_array().unwrap() {
        let name = map["name"].as_str().unwrap();
        let image =
            load_map(&worlds().join(format!("natural_landmark_{name}.yaml")), DEFAULT_MAX_CELLS).unwrap();
        let bytes = image.cells.chunks(image.width).rev().flatten().map(|cell| u8::from(*cell > 50));
        let crc = !bytes.fold(u32::MAX, |crc, byte| {
            (0..8)
                .fold(crc ^ u32::from(byte), |crc, _| (crc >> 1) ^ if crc & 1 == 1 { 0xEDB8_8320 } else { 0 })
        });
        assert_eq!(i64::from(crc), map["crc32_row_major_bytes"].as_integer().unwrap(), "{name}");
        let occupied = image.cells.iter().filter(|cell| **cell > 50).count();
        assert_eq!(occupied as i64, map["occupied_cells"].as_integer().unwrap(), "{name}");
    }
}

/// The lane of the rubble loop: straight pieces and quarter arcs of radius 1.5, counter-clockwise.
fn on_lane(mut way_m: f64) -> [f64; 3] {
    let (straights, radius) = ([11.0, 6.2, 11.0, 6.2], 1.5);
    let arc = radius * std::f64::consts::FRAC_PI_2;
    let mut pose = pose2(-5.5, -4.6, 0.0);
    for straight in straights {
        pose *= pose2(way_m.clamp(0.0, straight), 0.0, 0.0);
        way_m -= straight;
        let turn = way_m.clamp(0.0, arc) / radius;
        pose *= pose2(radius * turn.sin(), radius * (1.0 - turn.cos()), turn);
        way_m -= arc;
    }
    [pose.translation.x, pose.translation.y, pose.rotation.angle()]
}

#[test]
fn rays_in_the_rubble_loop_have_the_published_ranges() {
    let text = std::fs::read_to_string(data().join("slam2d_sim_loop_world.json")).unwrap();
    let source: serde_json::Value = serde_json::from_str(&text).unwrap();
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    for sample in source["lane"]["samples"].as_array().unwrap() {
        let pose = on_lane(number(&sample["s"]));
        for (found, expected) in pose.iter().zip(sample["pose"].as_array().unwrap()) {
            assert!((found.sin() - number(expected).sin()).abs() < 1e-9, "{pose:?} {sample}");
        }
    }
    let mut n_rays = 0;
    for check in source["raycast_checks"].as_array().unwrap() {
        let [x, y, yaw] = on_lane(number(&check["s"]));
        let bearings: Vec<f64> = check["bearings_deg"].as_array().unwrap().iter().map(number).collect();
        for (name, key) in
            [("rubble_loop.toml", "ranges_base"), ("rubble_loop_dense.toml", "ranges_with_dense")]
        {
            let mut world = world(name, start(x, y, yaw.to_degrees())).unwrap();
            let mount = Pose3::translation(0.0, 0.0, 0.3);
            for (found, expected) in
                ranges(&mut *world, &mount, &bearings).iter().zip(check[key].as_array().unwrap())
            {
                // The source's corners are rounded to 0.1 mm; its own tolerance is 5 mm.
                assert!((found - number(expected)).abs() < 5e-4, "{name} {check}: {found}");
                n_rays += 1;
            }
        }
    }
    assert_eq!(n_rays, 42);
}

/// FinDER, as `pipelines/common/finder.toml` has it.
fn finder() -> Robot {
    Robot {
        drive: Drive::Differential { track_m: 0.5 },
        radius_m: 0.30,
        height_m: 0.60,
        max_speed_m_s: 1.38,
        max_turn_deg_s: 120.0,
        max_accel_m_s2: 1.0,
        max_turn_accel_deg_s2: 360.0,
        braking_m_s2: 1.5,
        ..Robot::default()
    }
}

fn finder_in(name: &str) -> Box<dyn World> {
    let wheels = Wheels { radius_m: 0.254, ..Wheels::default() };
    let start = start(-5.5, -4.6, 0.0);
    let params = SimParams { map: Some(worlds().join(name)), start, wheels, ..SimParams::default() };
    params.build(&BuildContext { robot: Arc::new(finder()), ..BuildContext::bare("world") }).unwrap()
}

/// How far a place is from the lane, and how far along it the nearest place is, searched from `way_m` on.
fn beside_lane(at: &Pose3, way_m: f64) -> (f64, f64) {
    (0..200)
        .map(|step| way_m - 0.5 + 0.01 * f64::from(step))
        .map(|way_m| {
            let [x, y, _] = on_lane(way_m.rem_euclid(LANE_M));
            ((at.translation.x - x).hypot(at.translation.y - y), way_m)
        })
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .unwrap()
}

const LANE_M: f64 = 34.4 + 1.5 * std::f64::consts::TAU;

#[test]
fn the_scripted_drives_keep_to_the_lane_and_touch_nothing() {
    for (script, speed_m_s) in [("rubble_lane.csv", 1.38), ("rubble_lane_slow.csv", 1.0)] {
        let script = Script::read(&worlds().join("../drives").join(script)).unwrap();
        for name in ["rubble_loop.toml", "rubble_loop_dense.toml"] {
            let (mut world, mut way_m, mut fastest_m_s) = (finder_in(name), 0.0, 0.0f64);
            for tick in 0.. {
                let now = Time(tick * 50_000_000);
                world.advance(now).unwrap();
                let Some(twist) = script.at(now - Time::ZERO) else { break };
                world.drive(&Command { twist, ..Command::default() }).unwrap();
                let truth = world.truth().unwrap();
                let (beside_m, nearest_m) = beside_lane(&truth.map_from_base, way_m);
                assert!(beside_m < 0.02, "{beside_m} beside the lane after {way_m} m");
                assert!(truth.clearance_m > 0.1, "{name}: {} after {way_m} m", truth.clearance_m);
                (way_m, fastest_m_s) = (nearest_m, fastest_m_s.max(truth.twist.forward_m_s));
            }
            assert!((way_m - LANE_M - 1.0).abs() < 0.1, "{way_m}");
            assert!((fastest_m_s - speed_m_s).abs() < 1e-9);
        }
    }
}

/// Steered by the truth along the lane, at 0.7 m/s.
#[test]
fn the_search_robot_crosses_everything_on_the_slopes() {
    let mut world = finder_in("rubble_slopes.toml");
    let (mut way_m, mut highest_m, mut rolls, mut pitches) = (0.0, 0.0f64, [0.0f64; 2], [0.0f64; 2]);
    for tick in 1..2_000 {
        world.advance(Time(tick * 50_000_000)).unwrap();
        let truth = *world.truth().unwrap();
        assert_eq!(truth.contact_episodes, Some(0), "after {way_m} m");
        let at = truth.map_from_base;
        way_m = beside_lane(&at, way_m).1;
        let [x, y, _] = on_lane((way_m + 0.5).rem_euclid(LANE_M));
        let ahead = flatten(&at).inverse() * rumbo_core::frames::Point2::new(x, y);
        let twist = Twist::new(0.7, 2.0 * 0.7 * ahead.y / ahead.coords.norm_squared());
        world.drive(&Command { twist, ..Command::default() }).unwrap();
        let (roll, pitch, _) = at.rotation.euler_angles();
        highest_m = highest_m.max(at.translation.z);
        rolls = [rolls[0].min(roll.to_degrees()), rolls[1].max(roll.to_degrees())];
        pitches = [pitches[0].min(pitch.to_degrees()), pitches[1].max(pitch.to_degrees())];
        if way_m > LANE_M {
            break;
        }
    }
    assert!(way_m > LANE_M, "{way_m}");
    assert!((highest_m - 0.693).abs() < 1e-6, "{highest_m}");
    assert!(rolls[0] < -9.0 && rolls[1] > 9.0, "15 degrees aslant are more than 10 of roll: {rolls:?}");
    assert!((pitches[0] + 30.0).abs() < 0.5 && (pitches[1] - 30.0).abs() < 0.5, "{pitches:?}");
    assert!(world.truth().unwrap().map_from_base.translation.z.abs() < 1e-9);
}

#[test]
fn every_shipped_world_loads_and_a_robot_can_stand_in_it() {
    let stands = [
        ("dc_office.toml", start(-3.97, -4.0, 90.0)),
        ("dc_arena.toml", start(0.0, 0.0, 57.0)),
        ("fc_warehouse.toml", start(18.0, 6.0, 0.0)),
        ("forklift_hall.toml", start(19.5, 10.0, 90.0)),
        ("two_rooms_marks.toml", start(2.0, 2.0, 0.0)),
        ("rubble_loop.toml", start(-5.5, -4.6, 0.0)),
        ("rubble_loop_dense.toml", start(-5.5, -4.6, 0.0)),
        ("rubble_slopes.toml", start(-5.5, -4.6, 0.0)),
        ("natural_landmark_5x5.yaml", start(2.0, 2.0, 0.0)),
        ("natural_landmark_10x10.yaml", start(2.0, 6.0, 0.0)),
        ("natural_landmark_20x20.yaml", start(2.0, 13.0, 0.0)),
        ("office-20m.yaml", start(2.0, 3.0, 90.0)),
        ("office_blocked.toml", start(2.0, 3.0, 90.0)),
        ("office_unreachable.toml", start(2.0, 3.0, 90.0)),
        ("office_people.toml", start(2.0, 3.0, 90.0)),
        ("glass_corridor.toml", start(2.0, 3.0, 90.0)),
        ("natural_landmark_5x5.toml", start(2.0, 2.0, 0.0)),
        ("natural_landmark_10x10.toml", start(2.0, 6.0, 0.0)),
        ("natural_landmark_20x20.toml", start(2.0, 13.0, 0.0)),
        ("laboratory.toml", start(3.9, 1.3, 90.0)),
        ("laboratory-map.yaml", start(3.9, 1.3, 90.0)),
        ("department.toml", start(3.4, 6.3, 0.0)),
        ("department-map.yaml", start(3.4, 6.3, 0.0)),
    ];
    let mut names: Vec<String> = std::fs::read_dir(worlds())
        .unwrap()
        .map(|file| file.unwrap().file_name().into_string().unwrap())
        .filter(|name| name.ends_with(".toml") || name.ends_with(".yaml"))
        // Where to go in the world beside it.
        .filter(|name| !name.ends_with(".mission.toml"))
        .collect();
    for (name, start) in stands {
        load_world(&worlds().join(name)).unwrap_or_else(|error| panic!("{error}"));
        world(name, start).unwrap_or_else(|error| panic!("{name}: {error}"));
        names.retain(|other| other != name);
    }
    assert!(names.is_empty(), "no test stands in {names:?}");
}

/// A robot of 0.20 m needs 0.30 m; the doors leave 0.5 m to both sides of their middle.
#[test]
fn the_office_has_room_where_its_missions_go() {
    let clearance = |x, y| world("office-20m.yaml", start(x, y, 0.0)).unwrap().truth().unwrap().clearance_m;
    for (x, y) in
        [(2.0, 3.0), (15.0, 12.0), (4.0, 18.5), (26.0, 21.6), (25.0, 12.0), (14.0, 5.5), (20.0, 2.0)]
    {
        assert!(clearance(x, y) > 0.3, "({x}, {y}): {}", clearance(x, y));
    }
    assert!((clearance(13.7, 9.05) - 0.3).abs() < 1e-9, "in the middle of a door");
}

#[test]
fn the_blocked_corridor_is_blocked_and_the_shut_doors_are_shut() {
    let mount = Pose3::from_parts([0.0, 0.0, 0.3].into(), UnitQuaternion::identity());
    let ahead = |name: &str, start: Start| ranges(&mut *world(name, start).unwrap(), &mount, &[0.0])[0];
    let corridor = start(8.0, 8.0, 0.0);
    assert!((ahead("office-20m.yaml", corridor) - 20.8).abs() < 1e-5);
    assert!((ahead("office_blocked.toml", corridor) - 3.65).abs() < 1e-6);
    assert!((ahead("glass_corridor.toml", corridor) - 20.8).abs() < 1e-5, "light goes through");
    let door = start(13.7, 8.0, 90.0);
    assert!((ahead("office-20m.yaml", door) - 6.3).abs() < 1e-5, "to the bench inside");
    assert!((ahead("office_unreachable.toml", door) - 1.05).abs() < 1e-6);
}

/// The boxes fill the cells of the pictures, which have the counts of the source.
#[test]
fn the_offices_as_boxes_are_those_of_their_pictures() {
    for (name, n_occupied) in [("5x5", 1_630), ("10x10", 7_186), ("20x20", 21_190)] {
        let scene = load_world(&worlds().join(format!("natural_landmark_{name}.toml"))).unwrap();
        let picture = load_map(scene.robot_map.as_ref().unwrap(), 1_000_000).unwrap();
        assert_eq!(picture.cells.iter().filter(|cell| **cell > 50).count(), n_occupied, "{name}");
        for (idx, cell) in picture.cells.iter().enumerate() {
            let middle =
                [idx % picture.width, idx / picture.width].map(|n| (n as f64 + 0.5) * picture.resolution_m);
            let is_inside = scene.boxes.iter().any(|solid| {
                (0..2).all(|axis| (middle[axis] - solid.center[axis]).abs() < solid.size[axis] / 2.0)
            });
            assert_eq!(is_inside, *cell > 50, "{name} at {middle:?}");
        }
    }
}
