//! The emulated receiver against the decoder.

use super::*;
use crate::gps::nmea::{Decoder, Gga, Heard};

fn heard(emulator: &mut Emulator, until_s: f64) -> Vec<Heard> {
    let (mut decoder, mut out) = (Decoder::default(), Vec::new());
    emulator.transmit(Time::from_secs(until_s), None, &mut out);
    decoder.push(&out);
    std::iter::from_fn(|| decoder.next()).collect()
}

#[test]
fn once_a_second_it_says_where_it_is_within_its_digits() {
    for (latitude_deg, longitude_deg) in [(-22.0, -47.9), (48.1, 11.5), (0.0, 0.0), (59.999_999, -0.000_001)]
    {
        let frame = LocalFrame::new(latitude_deg, longitude_deg, 0.7);
        let settings = Settings { error_m: 0.0, ..Settings::default() };
        let position = Box::new(|| Some([12.0, -34.0, 5.0]));
        let mut emulator = Emulator::new(position, frame, settings, 1, Time::ZERO);
        let heard = heard(&mut emulator, 2.9);
        assert_eq!(heard.len(), 9);
        for (second, three) in heard.chunks(3).enumerate() {
            let Heard::Gga(Gga::Fix(fix)) = three[0] else { panic!("{three:?}") };
            assert_eq!(fix.utc_s, Some(43_200.0 + second as f64));
            let at = frame.map_m(fix.latitude_deg, fix.longitude_deg);
            // Half of the last digit.
            assert!((at.x - 12.0).hypot(at.y + 34.0) < 0.19, "{at}");
            assert_eq!(three[1..], [Heard::Other, Heard::Other]);
        }
    }
}

#[test]
fn without_satellites_it_says_that_it_has_no_fix() {
    let frame = LocalFrame::new(1.0, 2.0, 0.0);
    let mut emulator = Emulator::new(Box::new(|| None), frame, Settings::default(), 1, Time::ZERO);
    let heard = heard(&mut emulator, 0.9);
    assert_eq!(heard[0], Heard::Gga(Gga::NoFix { utc_s: Some(43_200.0) }));
    assert_eq!(heard[1..], [Heard::Other, Heard::Other]);
}

#[test]
fn it_errs_within_its_bound() {
    let frame = LocalFrame::new(1.0, 2.0, 0.0);
    let settings = Settings { rate_hz: 100.0, baud: 1_000_000, error_m: 5.0 };
    let mut emulator = Emulator::new(Box::new(|| Some([0.0; 3])), frame, settings, 1, Time::ZERO);
    let errors: Vec<f64> = heard(&mut emulator, 20.0)
        .into_iter()
        .filter_map(|heard| match heard {
            Heard::Gga(Gga::Fix(fix)) => Some(frame.map_m(fix.latitude_deg, fix.longitude_deg).x),
            _ => None,
        })
        .collect();
    assert!(errors.len() > 1990 && errors.iter().all(|error| error.abs() < 5.1));
    let variance = errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64;
    assert!((variance / (25.0 / 3.0) - 1.0).abs() < 0.1, "{variance}");
}
