//! The emulated device against the decoder.

use super::*;
use crate::imu::text::Decoder;

#[test]
fn it_says_its_attitude_in_degrees_with_its_noise() {
    let attitude_rad = [0.1, -0.2, 3.13];
    let mut emulator =
        Emulator::new(Box::new(move || Some(attitude_rad)), Settings::default(), 1, Time::ZERO);
    let (mut decoder, mut out) = (Decoder::new(360.0), Vec::new());
    emulator.transmit(Time::from_secs(100.0), None, &mut out);
    decoder.push(&out);
    let spoken: Vec<[f64; 3]> = std::iter::from_fn(|| decoder.next())
        .map(|spoken| spoken.map(|spoken| [spoken.roll, spoken.pitch, spoken.yaw]).unwrap())
        .collect();
    assert!((4990..=5001).contains(&spoken.len()), "{}", spoken.len());
    for (k, expected_rad) in attitude_rad.into_iter().enumerate() {
        let off_deg = |angles: &[f64; 3]| {
            rumbo_core::frames::wrap_angle(angles[k].to_radians() - expected_rad).to_degrees()
        };
        let variance = spoken.iter().map(|angles| off_deg(angles).powi(2)).sum::<f64>() / spoken.len() as f64;
        assert!((variance.sqrt() / 0.5 - 1.0).abs() < 0.05, "{}", variance.sqrt());
        assert!(spoken.iter().all(|angles| angles[k].abs() <= 180.0));
    }
}

#[test]
fn without_an_attitude_it_says_nothing() {
    let mut emulator = Emulator::new(Box::new(|| None), Settings::default(), 1, Time::ZERO);
    let mut out = Vec::new();
    emulator.transmit(Time::from_secs(1.0), None, &mut out);
    assert!(out.is_empty());
}
