use rumbo_core::registry::{Registry, Stage};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;

use super::*;
use crate::test_world::{TestWorld, given};

#[test]
fn partial_scans_follow_each_other_with_their_own_stamps() {
    let params = Lms200Params { resolution_deg: 0.25, exact: true, ..Lms200Params::default() };
    let mut sensor = params.build(&BuildContext::bare("sensor")).unwrap();
    let (mut out, trace) = (Observations::default(), Trace::unwatched());
    for tick in 0..5 {
        let mut cx = Cx { now: Time(tick * 13_333_333), trace: &trace };
        sensor.poll(&mut cx, &mut TestWorld::with_wall(2.0), &mut out).unwrap();
    }
    let firsts_deg: Vec<f64> = given(&out)
        .iter()
        .map(|observation| match &observation.data {
            Data::LaserScan(scan) => scan.first_bearing_rad.to_degrees(),
            _ => f64::NAN,
        })
        .collect();
    for (found, expected) in firsts_deg.iter().zip([-90.0, -89.75, -89.5, -89.25, -90.0]) {
        assert!((found - expected).abs() < 1e-9, "{firsts_deg:?}");
    }
    assert_eq!(given(&out)[3].stamp, Time(39_999_999));
}

#[test]
fn the_unit_sets_reach_and_steps() {
    let scan = |unit: Lms200Unit| {
        let params = Lms200Params { unit, exact: true, ..Lms200Params::default() };
        let mut sensor = params.build(&BuildContext::bare("sensor")).unwrap();
        let (mut out, trace) = (Observations::default(), Trace::unwatched());
        sensor
            .poll(&mut Cx { now: Time(0), trace: &trace }, &mut TestWorld::with_wall(8.0), &mut out)
            .unwrap();
        let Data::LaserScan(scan) = given(&out)[0].data.clone() else { panic!() };
        scan
    };
    let fine = scan(Lms200Unit::Millimeters);
    assert_eq!((fine.ranges_m.len(), fine.max_range_m), (361, 8.182));
    // 8 / cos(10 deg) = 8.1234 m is said in millimeters, 8 / cos(20 deg) = 8.51 m is beyond reach.
    assert!((fine.ranges_m[200] - 8.123).abs() < 1e-5, "{}", fine.ranges_m[200]);
    assert!(fine.ranges_m[220].is_infinite());
    let coarse = scan(Lms200Unit::Centimeters);
    assert!((coarse.ranges_m[200] - 8.12).abs() < 1e-5 && (coarse.ranges_m[220] - 8.51).abs() < 1e-5);
}

#[test]
fn impossible_rates_and_variants_are_refused() {
    let build = |resolution_deg: f64, rate_hz: f64| {
        let params = Lms200Params { resolution_deg, ..Lms200Params::default() };
        params.build(&BuildContext { rate_hz: Some(rate_hz), ..BuildContext::bare("sensor") }).map(|_| ())
    };
    assert_eq!(build(0.5, 37.5), Ok(()));
    assert_eq!(build(1.0, 75.0), Ok(()));
    let error = build(0.5, 40.0).unwrap_err();
    assert_eq!(error.path, "rate_hz");
    assert!(error.message.contains("at most 37.5 scans"), "{}", error.message);
    assert_eq!(build(0.3, 5.0).unwrap_err().path, "resolution_deg");
    let manifest = Plugin::<dyn Sensor>::manifest(&Lms200Params::default());
    assert_eq!(manifest.max_rate_hz, Some(37.5));
}

#[test]
fn the_file_says_mm_or_cm() {
    let registry = Registry::linked().unwrap();
    let entry = registry.get(Stage::Sensor, "lms200").unwrap();
    assert!(entry.source.parse(toml::from_str("unit = 'cm'").unwrap()).is_ok());
    assert!(entry.source.parse(toml::from_str("unit = 'inch'").unwrap()).is_err());
    assert!(registry.get(Stage::Sensor, "laser_2d").is_some());
    assert!(registry.get(Stage::Sensor, "wheel_encoders").is_some());
}
