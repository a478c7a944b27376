//! Speed of the simulator in the office: one scan, and a second of robot time.
#![allow(missing_docs, clippy::unwrap_used)]

use std::path::Path;

use rumbo_core::frames::{Pose3, Twist};
use rumbo_core::messages::{Command, Intrinsics};
use rumbo_core::registry::Plugin;
use rumbo_core::stages::{Answer, BuildContext, Probe, World};
use rumbo_core::time::Time;
use rumbo_worlds::sim::{SimParams, Start};

fn main() {
    divan::main();
}

fn office(name: &str) -> Box<dyn World> {
    let worlds = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pipelines/worlds");
    let start = Start { x_m: 2.0, y_m: 8.0, yaw_deg: 0.0 };
    let params = SimParams { map: Some(worlds.join(name)), start, ..SimParams::default() };
    params.build(&BuildContext::bare("world")).unwrap()
}

fn scan(world: &mut dyn World, mount: &Pose3) -> f32 {
    let probe = Probe::Beams {
        base_from_sensor: mount,
        first_bearing_rad: -std::f64::consts::FRAC_PI_2,
        bearing_step_rad: 0.5f64.to_radians(),
        n_beams: 361,
        max_range_m: 8.0,
    };
    match world.probe(&probe) {
        Ok(Answer::Ranges(ranges)) => ranges.iter().filter(|range| range.is_finite()).sum(),
        _ => f32::NAN,
    }
}

const WORLDS: [&str; 2] = ["office-20m.yaml", "office_people.toml"];

#[divan::bench(args = WORLDS)]
fn scan_of_361_beams(bencher: divan::Bencher<'_, '_>, name: &str) {
    let mut world = office(name);
    let mount = Pose3::translation(0.0, 0.0, 0.3);
    bencher.bench_local(|| scan(&mut *world, &mount));
}

/// Drives in a circle: 37.5 scans and 20 looks at the wheels in a second, as the engine would ask.
#[divan::bench(args = WORLDS)]
fn second_of_robot_time(bencher: divan::Bencher<'_, '_>, name: &str) {
    let mut world = office(name);
    let mount = Pose3::translation(0.0, 0.0, 0.3);
    let mut n_seconds = 0;
    bencher.bench_local(|| {
        let start_ns = n_seconds * 1_000_000_000;
        n_seconds += 1;
        let mut sum = 0.0;
        let (mut n_scans, mut n_wheels) = (0i64, 0i64);
        while n_scans < 37 || n_wheels < 20 {
            let (scan_ns, wheels_ns) = (n_scans * 26_666_667, n_wheels * 50_000_000);
            world.advance(Time(start_ns + scan_ns.min(wheels_ns))).unwrap();
            if scan_ns <= wheels_ns {
                sum += scan(&mut *world, &mount);
                n_scans += 1;
            } else {
                world.drive(&Command { twist: Twist::new(0.2, 0.25), ..Command::default() }).unwrap();
                sum += f32::from(world.probe(&Probe::Wheels).is_ok());
                n_wheels += 1;
            }
        }
        sum
    });
}

#[divan::bench(args = ["office-20m.yaml"])]
fn build_and_first_scan(bencher: divan::Bencher<'_, '_>, name: &str) {
    let mount = Pose3::translation(0.0, 0.0, 0.3);
    bencher.bench_local(|| scan(&mut *office(name), &mount));
}

/// Exact pictures of the Kinect at its full size and at a quarter of it. Bar: 33 ms, a picture of a camera of 30 Hz.
#[divan::bench(args = [(640, 480), (160, 120)])]
fn depth_picture(bencher: divan::Bencher<'_, '_>, (width, height): (u32, u32)) {
    let mut world = office("office_people.toml");
    let mount = Pose3::translation(0.0, 0.0, 0.3);
    let focal_px = f64::from(width) / 2.0 / 28.5f64.to_radians().tan();
    let center_px = [width, height].map(|n| (f64::from(n) - 1.0) / 2.0);
    let camera = Intrinsics { width, height, focal_px: [focal_px; 2], center_px };
    bencher.bench_local(|| {
        let probe = Probe::Depth { base_from_sensor: &mount, intrinsics: &camera, max_range_m: 3.5 };
        matches!(world.probe(&probe), Ok(Answer::Ranges(_)))
    });
}
