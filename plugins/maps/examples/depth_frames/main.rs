//! Real depth pictures with poses, through everything that a robot does with them: points, closest point, virtual scan,
//! and a grid of all the scans. Prints the figures of `docs/depth-recordings.md` and writes pictures.
//!
//! `cargo run --release -p rumbo-maps --example depth_frames -- FOLDER OUT`: FOLDER as in `frames.rs`; OUT gets the pictures,
//! and the same recording as a TUM RGB-D folder, `OUT/tum`, for the world `log`.
#![allow(missing_docs, clippy::print_stdout)]

mod frames;
mod level;
mod picture;

use std::collections::BTreeMap;
use std::error::Error;
use std::path::{Path, PathBuf};

use nalgebra::{Matrix3, Point3, UnitQuaternion, Vector3};
use rumbo_core::frames::{Pose3, flatten, pose2};
use rumbo_core::map::{Cell, CellClass, Map};
use rumbo_core::messages::{Data, Estimate, Intrinsics, LaserScan, Observation, Seen, SensorId};
use rumbo_core::registry::Plugin;
use rumbo_core::stages::{BuildContext, Cx, MapBuilder, MapInput};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;
use rumbo_kit::depth::{Beams, Closest, Depths, HeightBand, Rays, ScanLimits, VirtualScan, closest, points};
use rumbo_kit::depth_file::DepthEncoding;
use rumbo_kit::tum_rgbd::{FolderWriter, camera_from_optical};
use rumbo_maps::occupancy_grid::OccupancyGridParams;

use frames::{Frame, UNIT_M};

/// What a robot of a meter and a half could bump into, meters over the floor.
const HEIGHTS_M: [f64; 2] = [0.10, 1.50];
/// What a Kinect v1 measures, meters.
const RANGES_M: [f64; 2] = [0.4, 4.5];

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let (Some(folder), Some(out)) = (arguments.next(), arguments.next()) else {
        return Err("expected the folder of the pictures and one for the results".into());
    };
    std::fs::create_dir_all(&out)?;
    let (camera, frames) = frames::read(&folder)?;
    let rays = Rays::pinhole(&camera)?;
    let level = level::level(&rays, &frames).ok_or("no plane says what is level")?;
    let fit = &level.fit;
    println!("{} pictures of {} x {} pixels", frames.len(), camera.width, camera.height);
    println!(
        "level: {} of {} points within 2 cm of a plane, deviation {:.1} mm, {:.2} m over the lowest points",
        fit.n_near,
        level.n_points,
        1e3 * fit.deviation_m,
        level.plane_height_m
    );
    let map_from_camera =
        |frame: &Frame| level.map_from_world * frame.world_from_optical * camera_from_optical().inverse();
    print_cameras(&frames, map_from_camera);
    agreement(&rays, &camera, &frames);
    let scans = look(&rays, &frames, map_from_camera, &out)?;
    map(&scans, &out)?;
    write_tum(&frames, &level.map_from_world, &out.join("tum"))
}

fn print_cameras(frames: &[Frame], map_from_camera: impl Fn(&Frame) -> Pose3) {
    let poses: Vec<Pose3> = frames.iter().map(map_from_camera).collect();
    let heights_m = poses.iter().map(|pose| pose.translation.z).collect();
    let angles = |k: usize| {
        poses.iter().map(move |pose| <[f64; 3]>::from(pose.rotation.euler_angles())[k].to_degrees())
    };
    println!("camera height: {} m", spread(heights_m));
    println!(
        "camera roll: {} degrees, pitch: {} degrees",
        spread(angles(0).collect()),
        spread(angles(1).collect())
    );
}

/// Least, median and largest.
fn spread(mut values: Vec<f64>) -> String {
    values.sort_by(f64::total_cmp);
    let at = |share: f64| values.get((share * (values.len().max(1) - 1) as f64) as usize).copied();
    let told = |share| at(share).map_or("none".to_owned(), |value: f64| format!("{value:.3}"));
    format!("{} / {} / {}", told(0.0), told(0.5), told(1.0))
}

/// Points of one picture, put into another by the poses, against what that one saw: nothing of ours but the directions of
/// the pixels is in it, and the poses are KinectFusion's.
fn agreement(rays: &Rays, camera: &Intrinsics, frames: &[Frame]) {
    for apart in [1, 20, 100] {
        let mut off_m = Vec::new();
        for a in frames {
            let Some(b) = frames.iter().find(|b| b.number == a.number + apart) else { continue };
            let b_from_a = camera_from_optical()
                * b.world_from_optical.inverse()
                * a.world_from_optical
                * camera_from_optical().inverse();
            for (pixel, count) in
                a.picture.counts.iter().enumerate().step_by(97).filter(|(_, count)| **count > 0)
            {
                let depth_m = f64::from(*count) * f64::from(UNIT_M);
                let point = rays.point(pixel % rays.n_columns(), pixel / rays.n_columns(), depth_m);
                let Some(point) = point.map(|point_m| b_from_a * Point3::from(point_m)) else { continue };
                if let Some(seen_m) = depth_at(camera, b, &point) {
                    off_m.push((seen_m - point.x).abs());
                }
            }
        }
        off_m.sort_by(f64::total_cmp);
        let at = |share: f64| off_m.get((share * off_m.len() as f64) as usize).map_or(f64::NAN, |m| 1e3 * m);
        println!(
            "pictures {apart} apart: {} points, off by {:.1} mm (median), {:.1} mm (75 %), {:.1} mm (90 %)",
            off_m.len(),
            at(0.5),
            at(0.75),
            at(0.9)
        );
    }
}

/// What a picture saw where a point of its camera's frame would be.
fn depth_at(camera: &Intrinsics, frame: &Frame, point: &Point3<f64>) -> Option<f64> {
    let column = (camera.center_px[0] - camera.focal_px[0] * point.y / point.x).round();
    let row = (camera.center_px[1] - camera.focal_px[1] * point.z / point.x).round();
    let is_inside = point.x > 0.1
        && (0.0..f64::from(camera.width)).contains(&column)
        && (0.0..f64::from(camera.height)).contains(&row);
    let pixel = row as usize * camera.width as usize + column as usize;
    let count = frame.picture.counts.get(pixel).filter(|count| is_inside && **count > 0)?;
    Some(f64::from(*count) * f64::from(UNIT_M))
}

/// A scan in the level frame below its camera.
struct Taken {
    number: u32,
    map_from_camera: Pose3,
    scan: LaserScan,
}

fn look(
    rays: &Rays,
    frames: &[Frame],
    map_from_camera: impl Fn(&Frame) -> Pose3,
    out: &Path,
) -> Result<Vec<Taken>, Box<dyn Error>> {
    let limits = ScanLimits { heights_m: HEIGHTS_M, ranges_m: RANGES_M, rows: None };
    let beams = Beams::over(rays);
    let Beams::Uniform { first_bearing_rad, bearing_step_rad, .. } = beams else {
        return Err("no beams".into());
    };
    let mut virtual_scan = VirtualScan::new(rays.clone(), limits, beams)?;
    let mut cloud = vec![[0.0_f32; 3]; rays.n_pixels()];
    let (mut scans, mut valid, mut kept, mut nearest_m, mut seen) =
        (Vec::new(), Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for frame in frames {
        let map_from_camera = map_from_camera(frame);
        let depths = Depths::Counts { counts: &frame.picture.counts, unit_m: UNIT_M };
        // Heights are along the map's z axis: wherever the camera is, the map serves as its mount.
        let band = HeightBand::of_mount(&map_from_camera, HEIGHTS_M);
        let counted = points(rays, depths, RANGES_M[1] as f32, Some(&band), &mut cloud)?;
        let Closest { point, .. } = closest(&cloud, rays.n_columns(), None);
        valid.push(100.0 * counted.n_valid as f64 / rays.n_pixels() as f64);
        kept.push(100.0 * counted.n_kept as f64 / rays.n_pixels() as f64);
        nearest_m.extend(point.map(|point| point.planar_m));
        let yaw = flatten(&map_from_camera).rotation.angle();
        let level_from_map = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -yaw);
        virtual_scan.face(&(level_from_map * map_from_camera.rotation), map_from_camera.translation.z);
        let mut ranges_m = vec![0.0; virtual_scan.bearings_rad().len()];
        let scanned = virtual_scan.scan(depths, &mut ranges_m)?;
        seen.push(100.0 * scanned.n_seen as f64 / ranges_m.len() as f64);
        // A grid learns nothing from what is too near to be measured.
        ranges_m.iter_mut().filter(|range_m| **range_m < 0.0).for_each(|range_m| *range_m = f32::NAN);
        let scan = LaserScan {
            first_bearing_rad,
            bearing_step_rad,
            max_range_m: RANGES_M[1] as f32,
            ranges_m: ranges_m.into(),
            ..LaserScan::default()
        };
        if frame.number % 100 == 0 {
            let marked = point.map(|point| [point.column, point.row]);
            picture::depth(
                &out.join(format!("depth_{:03}.png", frame.number)),
                &frame.picture,
                4500,
                marked,
            )?;
        }
        scans.push(Taken { number: frame.number, map_from_camera, scan });
    }
    println!("pixels with a reading: {} %, between the heights: {} %", spread(valid), spread(kept));
    println!(
        "closest point in {} of {} pictures, at {} m",
        nearest_m.len(),
        frames.len(),
        spread(nearest_m.clone())
    );
    println!("beams of the virtual scan with a range: {} %", spread(seen));
    Ok(scans)
}

/// All scans with their poses into one grid.
fn map(scans: &[Taken], out: &Path) -> Result<(), Box<dyn Error>> {
    let params = OccupancyGridParams {
        resolution_m: 0.03,
        size_cells: 64,
        map_with_known_poses: true,
        min_range_m: RANGES_M[0],
        max_range_m: RANGES_M[1],
        ..OccupancyGridParams::default()
    };
    let mut builder: Box<dyn MapBuilder> = params.build(&BuildContext::bare("map"))?;
    let (mut map, trace) = (Map::default(), Trace::watched());
    builder.start(&mut map)?;
    for taken in scans {
        let stamp = Time::from_secs(f64::from(taken.number) / 30.0);
        let map_from_base = flatten(&taken.map_from_camera);
        let estimate =
            Estimate::planar(stamp, map_from_base, pose2(0.0, 0.0, 0.0), Matrix3::identity() * 1e-6);
        let seen = [Observation {
            sensor: SensorId(0),
            stamp,
            base_from_sensor: Pose3::identity(),
            valid: true,
            data: Data::LaserScan(taken.scan.clone()),
        }];
        let mut cx = Cx { now: stamp, trace: &trace };
        builder.insert(&mut cx, &MapInput { seen: Seen::sorted(&seen), estimate: &estimate }, &mut map)?;
    }
    let mut counters = BTreeMap::new();
    trace.take().1.into_iter().for_each(|(name, value)| *counters.entry(name).or_insert(0.0) += value);
    println!("{counters:?}");
    let grid = map.grid.as_ref().ok_or("there is no grid")?;
    let cells = (0..grid.height()).flat_map(|row| (0..grid.width()).map(move |col| Cell { col, row }));
    let (mut n_free, mut n_occupied) = (0, 0);
    for cell in cells {
        n_free += usize::from(grid.class(cell) == CellClass::Free);
        n_occupied += usize::from(grid.class(cell) == CellClass::Occupied);
    }
    let cell_m2 = grid.resolution_m() * grid.resolution_m();
    println!(
        "grid: {:.2} m² free, {:.2} m² occupied, of {} x {} cells",
        n_free as f64 * cell_m2,
        n_occupied as f64 * cell_m2,
        grid.width(),
        grid.height()
    );
    let places: Vec<[f64; 2]> =
        scans.iter().map(|taken| taken.map_from_camera.translation.vector.xy().into()).collect();
    Ok(picture::grid(&out.join("grid.png"), grid, &places, 4)?)
}

/// The same recording as a folder that the world `log` plays, and the keys that it needs.
fn write_tum(frames: &[Frame], map_from_world: &Pose3, folder: &Path) -> Result<(), Box<dyn Error>> {
    let mut writer = FolderWriter::create(folder, DepthEncoding::Gray16)?;
    for frame in frames {
        let stamp = Time::from_secs(f64::from(frame.number) / 30.0);
        writer.picture(stamp, &frame.picture)?;
        writer.pose(stamp, &frame.world_from_optical)?;
    }
    writer.finish()?;
    let (at, angles) = (map_from_world.translation, <[f64; 3]>::from(map_from_world.rotation.euler_angles()));
    let [roll, pitch, yaw] = angles.map(f64::to_degrees);
    println!(
        "map_from_world = {{ x_m = {:.4}, y_m = {:.4}, z_m = {:.4}, roll_deg = {roll:.3}, pitch_deg = {pitch:.3}, yaw_deg = {yaw:.3} }}",
        at.x, at.y, at.z
    );
    Ok(())
}
