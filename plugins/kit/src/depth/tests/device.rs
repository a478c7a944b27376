//! What the device does to an exact picture.

use super::*;
use rumbo_core::rng::stream;

const EXACT: DepthDevice = DepthDevice {
    deviation: [0.0, 0.0],
    step: DepthStep::Even,
    unit_m: 0.001,
    min_m: 0.4,
    near_m: 0.0,
    max_m: 4.0,
    edge_m: 0.1,
    edge_holes: 0.0,
    dropout: 0.0,
    sunlight: 0.0,
};

fn read(device: &DepthDevice, exact_m: &[f32], n_columns: usize) -> Vec<u16> {
    let mut counts = vec![9; exact_m.len()];
    device.read(exact_m, n_columns, &mut counts, &mut stream(7, "device")).unwrap();
    counts
}

#[test]
fn an_exact_device_counts_millimeters_within_its_range() {
    let exact_m = [0.399, 0.4, 1.2344, 1.2346, 4.0, 4.01, f32::INFINITY, f32::NAN, 0.0, -1.0];
    assert_eq!(read(&EXACT, &exact_m, 10), [0, 400, 1234, 1235, 4000, 0, 0, 0, 0, 0]);
    assert!(EXACT.read(&exact_m, 10, &mut [0; 9], &mut stream(7, "device")).is_err());
}

/// The simulated v1 of the source: 13 bits from the near plane on, at which everything nearer stays.
#[test]
fn a_device_with_a_near_plane_keeps_what_is_nearer_at_it() {
    let step = DepthStep::From { near_m: 0.2, step_m: 3.3 / 8191.0 };
    let device = DepthDevice { step, unit_m: 0.0001, min_m: 0.0, near_m: 0.2, max_m: 3.5, ..EXACT };
    // 768 of 8191 steps are 0.509413 m.
    let counts = read(&device, &[0.01, 0.1999, 0.2, 0.5094, 0.5096, 3.5, 3.6], 7);
    assert_eq!(counts, [2000, 2000, 2000, 5094, 5094, 35_000, 0]);
}

/// Khoshelham and Oude Elberink (2012), figure 10: 1.5 mm at 1 m, growing with the square of the depth.
#[test]
fn errors_have_no_mean_and_deviations_grow_with_the_square_of_the_depth() {
    let device = DepthDevice { deviation: [0.001, 0.0015], unit_m: 0.0001, min_m: 0.1, max_m: 5.0, ..EXACT };
    for depth_m in [0.8_f64, 1.6, 3.2] {
        const N: usize = 40_000;
        let readings: Vec<f64> = read(&device, &[depth_m as f32; N], N)
            .into_iter()
            .map(|count| f64::from(count) * 0.0001 - depth_m)
            .collect();
        let mean_m = readings.iter().sum::<f64>() / N as f64;
        let deviation_m = (readings.iter().map(|off| (off - mean_m).powi(2)).sum::<f64>() / N as f64).sqrt();
        let expected_m = 0.001 + 0.0015 * depth_m * depth_m;
        assert!(mean_m.abs() < 4.0 * expected_m / (N as f64).sqrt() + 1e-5, "{depth_m}: {mean_m}");
        // The deviation of N readings is itself known to 1 / sqrt(2 N).
        assert!((deviation_m / expected_m - 1.0).abs() < 4.0 / (2.0 * N as f64).sqrt(), "{deviation_m}");
    }
}

/// The same paper, equation 7: steps of 2.85 mm at 1 m and of the square of the depth times as much elsewhere.
#[test]
fn steps_of_disparity_grow_with_the_square_of_the_depth() {
    let device = DepthDevice { step: DepthStep::Disparity(0.00285), unit_m: 0.0001, max_m: 5.0, ..EXACT };
    for depth_m in [1.0_f64, 2.0, 4.0] {
        let exact_m: Vec<f32> = (0..4000).map(|k| (depth_m + f64::from(k) * 0.0001) as f32).collect();
        let mut counts = read(&device, &exact_m, 4000);
        assert!(exact_m.iter().zip(&counts).all(|(m, count)| {
            let step_m = f64::from(m * m) * 0.00285;
            (f64::from(*count) * 0.0001 - f64::from(*m)).abs() < 0.51 * step_m + 0.0001
        }));
        counts.dedup();
        let step_m = f64::from(counts[2] - counts[1]) * 0.0001;
        assert!((step_m / (0.00285 * depth_m * depth_m) - 1.0).abs() < 0.04, "{depth_m}: {step_m}");
    }
}

#[test]
fn pixels_are_lost_by_chance_in_sunlight_and_beyond_edges() {
    let share =
        |counts: &[u16]| counts.iter().filter(|count| **count == 0).count() as f64 / counts.len() as f64;
    let far = [2.0_f32; 20_000];
    let lost = DepthDevice { dropout: 0.3, ..EXACT };
    assert!((share(&read(&lost, &far, 100)) - 0.3).abs() < 0.015);
    let sunny = DepthDevice { sunlight: 1.0, ..EXACT };
    assert!(
        (share(&read(&sunny, &far, 100)) - 0.25).abs() < 0.015,
        "half of the range, a quarter of the light"
    );
    assert_eq!(share(&read(&DepthDevice { sunlight: 5.0, ..EXACT }, &far, 100)), 1.0);
    // A post in front of a wall: its shadow is on the wall, and the post itself is seen.
    let post: Vec<f32> =
        (0..1000).map(|pixel| if (4..6).contains(&(pixel % 10)) { 1.0 } else { 2.0 }).collect();
    let counts = read(&DepthDevice { edge_holes: 1.0, ..EXACT }, &post, 10);
    for (pixel, count) in counts.iter().enumerate() {
        let expected = [2000, 2000, 2000, 0, 1000, 1000, 0, 2000, 2000, 2000];
        assert_eq!(*count, expected[pixel % 10], "pixel {pixel}");
    }
}

#[test]
fn the_same_seed_gives_the_same_picture() {
    let device = DepthDevice { deviation: [0.001, 0.0015], dropout: 0.1, edge_holes: 0.5, ..EXACT };
    let exact_m: Vec<f32> = (0..4800).map(|pixel| 1.0 + (pixel % 64) as f32 * 0.04).collect();
    assert_eq!(read(&device, &exact_m, 64), read(&device, &exact_m, 64));
}
