//! `include/rumbo_plugin.h` is what cbindgen makes of the ABI's Rust types, a C compiler sees the same layout as Rust, and
//! the example in its first lines is a plugin.

use crate::compiler::{self, Language};
use rumbo_core::boundary::abi::*;
use std::fmt::Write as _;
use std::mem::offset_of;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

const HEADER: &str = "include/rumbo_plugin.h";

/// Structs that are known by their address only; cbindgen would write arrays of no elements, which C does not have.
const OPAQUE: [&str; 8] = [
    "rumbo_block",
    "rumbo_values",
    "rumbo_give_up",
    "rumbo_rng",
    "rumbo_trace",
    "rumbo_world",
    "rumbo_observations",
    "rumbo_map_mut",
];

const FILES: [&str; 7] = ["basic", "module", "map", "observation", "inputs", "tables", "host"];

fn source(file: &str) -> PathBuf {
    compiler::root().join(format!("core/src/boundary/abi/{file}.rs"))
}

/// Every type of the ABI: without functions to reach them from, cbindgen would leave them out.
fn names() -> Vec<String> {
    let text: String = FILES.iter().map(|file| std::fs::read_to_string(source(file)).unwrap()).collect();
    let names = text.lines().filter_map(|line| {
        let name = line.strip_prefix("pub struct ").or_else(|| line.strip_prefix("pub type "))?;
        name.split([' ', ';']).next().map(str::to_owned)
    });
    names.filter(|name| !OPAQUE.contains(&name.as_str())).collect()
}

fn generated() -> String {
    let mut config = cbindgen::Config {
        language: cbindgen::Language::C,
        cpp_compat: false,
        documentation_style: cbindgen::DocumentationStyle::C99,
        style: cbindgen::Style::Both,
        line_length: 110,
        tab_width: 4,
        usize_is_size_t: true,
        include_guard: Some("RUMBO_PLUGIN_H".to_owned()),
        header: Some(include_str!("header/preamble.h").trim_end().to_owned()),
        sys_includes: ["math.h", "stdarg.h", "stdbool.h", "stddef.h", "stdint.h", "stdio.h", "string.h"]
            .map(str::to_owned)
            .to_vec(),
        no_includes: true,
        after_includes: Some(format!("\n{}", include_str!("header/opaque.h").trim_end())),
        trailer: Some(include_str!("header/helpers.h").trim_end().to_owned()),
        ..cbindgen::Config::default()
    };
    config.export.exclude = OPAQUE.map(str::to_owned).to_vec();
    config.export.include = names();
    config.function.args = cbindgen::Layout::Auto;
    let mut builder = cbindgen::Builder::new().with_config(config);
    for file in FILES {
        builder = builder.with_src(source(file));
    }
    let mut text = Vec::new();
    builder.generate().expect("cbindgen understands the ABI").write(&mut text);
    String::from_utf8(text).unwrap()
}

/// The committed header; written anew first where somebody asks for that.
fn committed() -> &'static str {
    static COMMITTED: OnceLock<String> = OnceLock::new();
    COMMITTED.get_or_init(|| {
        let path = compiler::root().join(HEADER);
        if std::env::var_os("RUMBO_UPDATE").is_some() {
            std::fs::write(&path, generated()).unwrap();
        }
        std::fs::read_to_string(&path).unwrap_or_default()
    })
}

#[test]
fn the_header_is_what_the_rust_types_say() {
    let (found, text) = (committed(), generated());
    let advice = "RUMBO_UPDATE=1 cargo test --test boundary header writes it anew";
    if let Some((idx, (a, b))) = found.lines().zip(text.lines()).enumerate().find(|(_, (a, b))| a != b) {
        panic!("{HEADER}:{} has\n  {a}\nexpected\n  {b}\n{advice}", idx + 1);
    }
    assert_eq!(found.len(), text.len(), "{HEADER}: {advice}");
}

/// Lines that fail to compile where C and Rust lay a struct out differently.
macro_rules! layout {
    ($text:ident: $($name:ident { $($field:ident),* $(,)? })*) => { $(
        writeln!($text, "CHECK(sizeof({0}) == {1}, \"{0}\");", stringify!($name), size_of::<$name>()).unwrap();
        $( writeln!(
            $text,
            "CHECK(offsetof({0}, {1}) == {2}, \"{0}.{1}\");",
            stringify!($name), stringify!($field), offset_of!($name, $field)
        ).unwrap(); )*
        // Every field is named here: one that is added must be checked as well.
        let _ = |s: $name| { let $name { $($field: _),* } = s; };
    )* };
}

fn layout_lines() -> String {
    let mut text = String::new();
    layout! { text:
        rumbo_str { data, len }
        rumbo_error { size, place, values, path, text, message, help }
        rumbo_point { x_m, y_m }
        rumbo_pose2 { x_m, y_m, cos_yaw, sin_yaw }
        rumbo_pose3 { position_m, quaternion }
        rumbo_twist { forward_m_s, left_m_s, turn_rad_s }
        rumbo_f32_array { block, len, data }
        rumbo_u16_array { block, len, data }
        rumbo_u8_array { block, len, data }
        rumbo_point3_array { block, len, data }
        rumbo_module { magic, size, abi_major, abi_minor, flags, build_info, n_entries, entries }
        rumbo_entry {
            size, stage, reserved, name, version, summary, schema_json, defaults_toml, user, table, create, manifest,
            check, parameters,
        }
        rumbo_config { size, toml, values }
        rumbo_fault_out { size, ctx, push }
        rumbo_manifest {
            size, needs_layers, gives_layers, produces, drives, n_consumes, consumes, overlays, is_virtual,
            needs_start_pose, wishes_motion, default_rate_hz, max_rate_hz, uses, reserved,
            field_of_view_rad,
        }
        rumbo_robot {
            size, drive, guard_stop_zone, track_m, wheelbase_m, max_steer_deg, max_steer_rate_deg_s, radius_m,
            n_corners, corners, height_m, max_speed_m_s, max_turn_deg_s, max_accel_m_s2, max_turn_accel_deg_s2,
            braking_m_s2, guard_margin_m, guard_latency_s, guard_stale_after_s, is_steered_behind,
            reserved,
        }
        rumbo_context {
            size, name, sensor, dry_run, is_threaded, wanted_layers, robot, base_from_sensor, rate_hz, seed, rng,
            folder, world_map, world_recording, latency_ns, abort,
        }
        rumbo_grid { size, width, height, resolution_m, origin, occupied_above, free_below, cells }
        rumbo_line { from, to, covariance }
        rumbo_line_array { block, len, data }
        rumbo_landmark { identity, kind, position, covariance }
        rumbo_landmark_array { block, len, data }
        rumbo_voxel_chunk { index, reserved, log_odds }
        rumbo_voxels { size, resolution_m, origin, n_chunks, chunks }
        rumbo_map { size, version, grid, n_coarse, coarse_stride, coarse, lines, landmarks, voxels }
        rumbo_observation { size, stamp_ns, kind, sensor, valid, reserved, base_from_sensor, data }
        rumbo_seen { size, len, stride, first }
        rumbo_odometry { size, odom_from_base, twist, noise }
        rumbo_wheel_speeds { size, n_wheels, reserved, rim_m_s }
        rumbo_steering_angle { size, angle_rad }
        rumbo_laser_scan {
            size, first_bearing_rad, bearing_step_rad, sweep_s, min_range_m, max_range_m, ranges_m, intensities,
        }
        rumbo_range_ring {
            size, first_bearing_rad, bearing_step_rad, cone_rad, ring_radius_m, min_range_m, max_range_m, ranges_m,
        }
        rumbo_bumpers {
            size, pressed, first_bearing_rad, bearing_step_rad, ring_radius_m, n_bumpers, reserved,
        }
        rumbo_intrinsics { width, height, focal_px, center_px }
        rumbo_depth_image { size, intrinsics, unit_m, reserved, depth }
        rumbo_point_cloud { size, points_m }
        rumbo_imu { size, has_attitude, reserved, attitude_rad, rates_rad_s, accelerations_m_s2 }
        rumbo_position_fix { size, position_m, deviation_m }
        rumbo_mark { has_identity, identity, range_m, bearing_rad }
        rumbo_marks { size, len, marks, range_deviation_m, bearing_deviation_rad }
        rumbo_custom { size, schema, bytes }
        rumbo_call { size, now_ns, trace, is_watched, reserved }
        rumbo_candidate { map_from_base, score }
        rumbo_estimate {
            size, stamp_ns, map_from_odom, map_from_base, covariance, status, wish_kind, wish, n_candidates,
            candidates,
        }
        rumbo_path_point { position, yaw_rad }
        rumbo_path { size, cost, len, points }
        rumbo_obstacle { position, radius_m, stamp_ns }
        rumbo_plan_request {
            size, map, grid, start, goal, goal_yaw_rad, robot, n_obstacles, obstacles, give_up,
        }
        rumbo_avoid_input {
            size, map_from_base, twist, estimate, seen, map, grid, path, path_number, arrival_radius_m, n_obstacles,
            obstacles, robot,
        }
        rumbo_steering { size, kind, reserved, twist }
        rumbo_prior { size, kind, reserved, map_from_base, odom_from_base, covariance, saved }
        rumbo_path_out { size, ctx, push, cost }
        rumbo_obstacle_out { size, ctx, push }
        rumbo_candidate_out { size, ctx, push }
        rumbo_stamped_pose { stamp_ns, map_from_base }
        rumbo_trajectory_out { size, ctx, push }
        rumbo_bytes_out { size, ctx, push }
        rumbo_probe {
            size, kind, n_beams, base_from_sensor, first_bearing_rad, bearing_step_rad, max_range_m, n_cones,
            bearings_rad, cone_rad, ring_radius_m, intrinsics, field_of_view_rad, name,
        }
        rumbo_answer {
            size, kind, n_wheels, n_ranges, ranges_m, rolled_m, turned_rad, steering_rad, twist, attitude_rad,
            rates_rad_s, accelerations_m_s2, position_m, n_contacts, contacts_rad, marks, recorded,
        }
        rumbo_planner_table { size, destroy, plan }
        rumbo_avoider_table { size, destroy, steer }
        rumbo_localizer_table { size, destroy, start, update }
        rumbo_map_builder_table { size, destroy, start, insert, save }
        rumbo_slam_table { size, destroy, start, update, save, trajectory, relocate, save_map }
        rumbo_sensor_table { size, destroy, poll, derive }
        rumbo_host {
            size, abi_major, abi_minor, log, block_new, block_retain, block_release, make_mut_f32, config_f64,
            config_i64, config_bool, config_str, config_len, random_u64, random_uniform, random_normal,
            give_up_is_raised, give_up_retain, give_up_release, draw_polyline, draw_points, count, world_now_ns,
            world_is_real_time, probe, lend_f32, lend_u16, lend_point3, observe, map_version, map_set_version,
            map_n_coarse, map_take_grid, map_put_grid, map_take_lines, map_put_lines, map_take_landmarks,
            map_put_landmarks, map_voxels, map_take_chunk, map_new_voxels, map_put_chunk, map_remove,
        }
    }
    text
}

#[test]
fn c_and_cpp_see_the_layout_that_rust_has() {
    let lines = layout_lines();
    let structs = lines.lines().filter(|line| line.starts_with("CHECK(sizeof")).count();
    let in_header = committed().matches("\ntypedef struct rumbo_").count() - OPAQUE.len();
    assert_eq!(structs, in_header, "every struct of the header is checked");
    for (language, check) in [(Language::C, "_Static_assert"), (Language::Cpp, "static_assert")] {
        let text = format!("#include \"rumbo_plugin.h\"\n#define CHECK {check}\n{lines}");
        compiler::checked(&text, language, "layout");
    }
}

/// The lines of the example in the header's first comment that begin with `start`, without the comment's margin.
fn example() -> String {
    let preamble = include_str!("header/preamble.h");
    let lines = preamble
        .lines()
        .skip_while(|line| !line.contains("#include"))
        .map(|line| line.trim_start_matches(" *"));
    lines.take_while(|line| !line.trim_start().starts_with("cc ")).collect::<Vec<_>>().join("\n")
}

#[test]
fn the_example_in_the_header_is_a_plugin() {
    assert!(!committed().is_empty());
    let library = compiler::library_of_text(&example(), Language::C, "straight");
    let mut registry = rumbo::registry().unwrap();
    registry.load(Path::new(&library), None).unwrap();
    assert_eq!(
        registry.get(rumbo_core::registry::Stage::Planner, "straight").unwrap().summary,
        "Goes straight"
    );
}
