//! A depth picture of 640 x 480. Bars: 0.12 ms as points, 2 ms as a scan; Open3D needs 2.84 ms for the points.
#![allow(clippy::expect_used)]

use divan::counter::BytesCount;
use nalgebra::UnitQuaternion;
use rumbo_core::rng::{RngExt as _, stream};
use rumbo_kit::depth::{
    Beams, DepthDevice, DepthStep, Depths, HeightBand, MedianFilter, Rays, ScanLimits, VirtualScan, closest,
    pinhole_of_view, points, slow,
};

fn main() {
    divan::main();
}

const COLUMNS: usize = 640;
const PIXELS: usize = COLUMNS * 480;
const UNIT_M: f32 = 0.001;

fn rays() -> Rays {
    let half = [28.5_f64.to_radians(), 21.5_f64.to_radians()];
    Rays::pinhole(&pinhole_of_view(640, 480, half)).expect("a camera")
}

/// A room with a floor, 0.3 m under the camera, a wall at 2.5 m, and a tenth of the pixels without a reading.
fn room_m() -> Vec<f32> {
    let (rays, mut rng) = (rays(), stream(1, "room"));
    (0..PIXELS)
        .map(|pixel| {
            let up = rays.up()[pixel / COLUMNS] as f32;
            let floor_m = if up < 0.0 { -0.3 / up } else { f32::INFINITY };
            if rng.random::<f64>() < 0.1 { f32::NAN } else { floor_m.min(2.5) }
        })
        .collect()
}

fn room() -> Vec<u16> {
    room_m().into_iter().map(|depth_m| (depth_m / UNIT_M) as u16).collect()
}

#[divan::bench]
fn counts_to_points(bencher: divan::Bencher) {
    let (rays, counts, mut out) = (rays(), room(), vec![[0.0; 3]; PIXELS]);
    bencher.counter(BytesCount::new(PIXELS * 14)).bench_local(|| {
        points(&rays, Depths::Counts { counts: &counts, unit_m: UNIT_M }, 4.0, None, &mut out)
    });
}

#[divan::bench]
fn counts_to_points_of_a_height_band(bencher: divan::Bencher) {
    let (rays, counts, mut out) = (rays(), room(), vec![[0.0; 3]; PIXELS]);
    let band = HeightBand::of_pitch(0.3, 0.0, [0.05, 0.4]);
    bencher.counter(BytesCount::new(PIXELS * 14)).bench_local(|| {
        points(&rays, Depths::Counts { counts: &counts, unit_m: UNIT_M }, 4.0, Some(&band), &mut out)
    });
}

#[divan::bench]
fn meters_to_points(bencher: divan::Bencher) {
    let (rays, depths_m, mut out) = (rays(), room_m(), vec![[0.0; 3]; PIXELS]);
    bencher
        .counter(BytesCount::new(PIXELS * 16))
        .bench_local(|| points(&rays, Depths::Meters(&depths_m), 4.0, None, &mut out));
}

#[divan::bench]
fn counts_to_points_slowly(bencher: divan::Bencher) {
    let (rays, counts) = (rays(), room());
    let mut out = vec![[f32::NAN; 3]; PIXELS];
    let depths = Depths::Counts { counts: &counts, unit_m: UNIT_M };
    bencher.counter(BytesCount::new(PIXELS * 14)).bench_local(|| {
        for (pixel, point) in out.iter_mut().enumerate() {
            let slow = slow::point_slowly(&rays, depths, 4.0, None, pixel);
            *point = slow.map_or([f32::NAN; 3], |point| point.map(|v| v as f32));
        }
    });
}

#[divan::bench]
fn closest_point(bencher: divan::Bencher) {
    let (rays, counts, mut out) = (rays(), room(), vec![[0.0; 3]; PIXELS]);
    points(&rays, Depths::Counts { counts: &counts, unit_m: UNIT_M }, 4.0, None, &mut out).expect("points");
    bencher.counter(BytesCount::new(PIXELS * 12)).bench_local(|| closest(&out, COLUMNS, None));
}

#[divan::bench]
fn median(bencher: divan::Bencher) {
    let (counts, mut out, mut filter) = (room(), vec![0; PIXELS], MedianFilter::default());
    bencher.counter(BytesCount::new(PIXELS * 4)).bench_local(|| filter.filter(COLUMNS, &counts, &mut out));
}

fn scan(bencher: divan::Bencher, pitches_rad: &[f64], beams: fn(&Rays) -> Beams) {
    let (rays, counts) = (rays(), room());
    let limits = ScanLimits { heights_m: [0.05, 0.5], ranges_m: [0.4, 4.0], rows: None };
    let beams = beams(&rays);
    let mut scan = VirtualScan::new(rays, limits, beams).expect("a scan");
    let mut ranges_m = vec![0.0; scan.bearings_rad().len()];
    let mut pitches_rad = pitches_rad.iter().cycle();
    bencher.counter(BytesCount::new(PIXELS * 2)).bench_local(|| {
        let pitch_rad = pitches_rad.next().copied().unwrap_or_default();
        scan.face(&UnitQuaternion::from_euler_angles(0.0, pitch_rad, 0.0), 0.3);
        scan.scan(Depths::Counts { counts: &counts, unit_m: UNIT_M }, &mut ranges_m)
    });
}

#[divan::bench]
fn scan_of_a_level_camera_per_column(bencher: divan::Bencher) {
    scan(bencher, &[0.0], |_| Beams::PerColumn);
}

#[divan::bench]
fn scan_of_a_level_camera(bencher: divan::Bencher) {
    scan(bencher, &[0.0], Beams::over);
}

#[divan::bench]
fn scan_of_a_tilted_camera(bencher: divan::Bencher) {
    scan(bencher, &[0.2], Beams::over);
}

#[divan::bench]
fn scan_of_a_camera_that_rocks(bencher: divan::Bencher) {
    scan(bencher, &[0.2, 0.21], Beams::over);
}

#[divan::bench]
fn errors_of_the_device(bencher: divan::Bencher) {
    let (exact_m, mut counts, mut rng) = (room_m(), vec![0; PIXELS], stream(2, "device"));
    let device = DepthDevice {
        deviation: [0.001, 0.0015],
        step: DepthStep::Disparity(0.00285),
        unit_m: 0.001,
        min_m: 0.4,
        near_m: 0.2,
        max_m: 3.5,
        edge_m: 0.1,
        edge_holes: 0.5,
        dropout: 0.005,
        sunlight: 0.0,
    };
    bencher
        .counter(BytesCount::new(PIXELS * 6))
        .bench_local(|| device.read(&exact_m, COLUMNS, &mut counts, &mut rng));
}
