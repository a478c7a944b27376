//! The receiver in simulated, recorded and real worlds.

use std::f64::consts::FRAC_PI_2;
use std::net::TcpListener;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use rumbo_core::frames::Pose3;
use rumbo_core::messages::SensorId;
use rumbo_core::registry::{Registry, Stage};
use rumbo_core::stages::Attitude;
use rumbo_kit::emulation::Outlet;

use super::*;
use crate::gps::emulator::{Emulator, Settings};
use crate::gps::local_frame::LocalFrame;
use crate::gps::nmea::Fix;
use crate::gps::{Origin, Outage};
use crate::test_world::{TestWorld, given};
use crate::text_device::tests::{Exchange, Talk, complaint_about, exchange};

const EXACT: GpsParams = GpsParams {
    error_m: 0.0,
    bias_m: [0.0; 3],
    dropout: 0.0,
    outages: Vec::new(),
    port: None,
    baud: 4800,
    file: None,
    origin: None,
    rotation_deg: 0.0,
    delay_s: 0.0,
};

fn world(position_m: [f64; 3], yaw_rad: f64) -> TestWorld {
    let mut world = TestWorld::with_wall(1.0);
    world.position_m = position_m;
    world.attitude = Attitude { attitude_rad: [0.0, 0.0, yaw_rad], ..Attitude::default() };
    world
}

fn poll_in(
    params: &GpsParams,
    context: &BuildContext,
    now: Time,
    world: &mut TestWorld,
) -> Result<Vec<Observation>, SensorError> {
    let mut sensor = params.build(context).unwrap();
    let (trace, mut out) = (Trace::unwatched(), Observations::default());
    sensor.poll(&mut Cx { now, trace: &trace }, world, &mut out)?;
    Ok(given(&out))
}

fn poll(params: &GpsParams, world: &mut TestWorld) -> Result<Vec<Observation>, SensorError> {
    poll_in(params, &BuildContext::bare("sensor"), Time(5), world)
}

fn fix_of(observation: &Observation) -> PositionFix {
    match &observation.data {
        Data::PositionFix(fix) => *fix,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_simulated_fix_is_of_the_antenna_and_claims_what_even_errors_deviate() {
    let seen = poll(&EXACT, &mut world([1.0, 2.0, 0.5], 0.3)).unwrap();
    assert_eq!((seen.len(), seen[0].stamp, seen[0].valid), (1, Time(5), true));
    assert_eq!(fix_of(&seen[0]).position_m, [1.0, 2.0, 0.5]);
    let mount = Pose3::translation(0.4, 0.1, 0.9);
    let context = BuildContext { base_from_sensor: mount, ..BuildContext::bare("sensor") };
    let params = GpsParams { bias_m: [0.0, 0.0, 2.0], ..EXACT };
    let seen = poll_in(&params, &context, Time(5), &mut world([1.0, 2.0, 0.5], FRAC_PI_2)).unwrap();
    let at = fix_of(&seen[0]).position_m;
    let expected = [1.0 - 0.1, 2.0 + 0.4, 0.5 + 0.9 + 2.0];
    assert!(at.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{at:?}");
    assert_eq!(seen[0].base_from_sensor, mount);
    let seen = poll(&GpsParams { error_m: 5.0, ..EXACT }, &mut world([0.0; 3], 0.0)).unwrap();
    let fix = fix_of(&seen[0]);
    assert!(fix.position_m.iter().all(|part| part.abs() <= 5.0 && *part != 0.0));
    assert!((fix.deviation_m[0] - 5.0 / 3f64.sqrt()).abs() < 1e-12);
}

#[test]
fn without_satellites_it_says_so_and_a_lost_fix_says_nothing() {
    let outages = vec![Outage { from_s: 1.0, to_s: 2.0 }];
    let params = GpsParams { outages, ..EXACT };
    let context = BuildContext::bare("sensor");
    let seen = poll_in(&params, &context, Time::from_secs(1.5), &mut world([3.0; 3], 0.0)).unwrap();
    assert!(!seen[0].valid && fix_of(&seen[0]) == PositionFix::default(), "no old numbers: {seen:?}");
    let seen = poll(&GpsParams { dropout: 1.0, ..EXACT }, &mut world([3.0; 3], 0.0)).unwrap();
    assert!(seen.is_empty());
}

#[test]
fn a_recording_is_passed_on_under_the_sensors_own_name_and_nonsense_is_an_error() {
    let recorded = Observation {
        sensor: SensorId(9),
        stamp: Time(3),
        base_from_sensor: Pose3::translation(1.0, 0.0, 0.0),
        valid: true,
        data: Data::PositionFix(PositionFix { position_m: [1.0, 2.0, 3.0], deviation_m: [0.1; 3] }),
    };
    let seen = poll(&EXACT, &mut TestWorld::recorded(vec![recorded.clone()])).unwrap();
    let bare = BuildContext::bare("sensor");
    assert_eq!((seen[0].sensor, seen[0].base_from_sensor), (bare.sensor, bare.base_from_sensor));
    assert_eq!((seen[0].stamp, &seen[0].data), (Time(3), &recorded.data));
    assert!(poll(&EXACT, &mut world([f64::NAN; 3], 0.0)).is_err());
}

#[test]
fn every_bad_value_is_named() {
    let bad = GpsParams {
        error_m: -1.0,
        bias_m: [0.0, f64::NAN, 0.0],
        dropout: 1.5,
        outages: vec![Outage { from_s: 2.0, to_s: 1.0 }],
        port: Some(String::new()),
        baud: 0,
        file: Some("capture.nmea".into()),
        origin: Some(Origin { latitude_deg: 90.0, longitude_deg: 181.0, altitude_m: Some(f64::NAN) }),
        rotation_deg: f64::INFINITY,
        delay_s: f64::NAN,
    };
    let keys: Vec<String> = bad.check().into_iter().map(|fault| fault.path).collect();
    let expected = [
        "error_m",
        "delay_s",
        "bias_m[1]",
        "dropout",
        "outages[0]",
        "port",
        "file",
        "baud",
        "rotation_deg",
        "origin.latitude_deg",
        "origin.longitude_deg",
        "origin.altitude_m",
    ];
    assert_eq!(keys, expected);
    assert!(GpsParams::default().check().is_empty());
    assert!(Registry::linked().unwrap().get(Stage::Sensor, "gps").is_some());
}

/// The sample sentences: two fixes a second apart, then another place and no fix.
const CAPTURE: &str = "\
noise at the beginning\r\n\
$GPGGA,183706.000,2200.8942,S,04753.7441,W,1,05,1.4,831.7,M,-4.3,M,,0000*4B\r\n\
$GPGSA,A,3,15,12,24,06,25,,,,,,2.4,1.4,1.9*39\r\n\
$GPRMC,183706.000,A,2200.8942,S,04753.7441,W,0.00,,241115,,,A*72\r\n\
$GPGGA,183707.000,2200.8942,S,04753.7441,W,1,05,1.4,831.7,M,-4.3,M,,0000*4A\r\n\
$GPGGA,183706.000,2200.8942,S,04753.7441,W,1,05,1.4,831.7,M,-4.3,M,,0000*4C\r\n\
$GPGGA,183708.000,,,,,0,00,,,M,,M,,0000*7D";

#[test]
fn a_capture_is_played_at_its_own_pace_and_its_first_fix_is_the_origin() {
    let path = std::env::temp_dir().join(format!("rumbo-gps-{}.nmea", std::process::id()));
    std::fs::write(&path, CAPTURE).unwrap();
    let mut sensor =
        GpsParams { file: Some(path.clone()), ..EXACT }.build(&BuildContext::bare("gps")).unwrap();
    std::fs::remove_file(&path).unwrap();
    let mut at = |seconds| {
        let (trace, mut out) = (Trace::counting(), Observations::default());
        let mut cx = Cx { now: Time::from_secs(seconds), trace: &trace };
        sensor.poll(&mut cx, &mut TestWorld::with_wall(1.0), &mut out).unwrap();
        let counters = trace.take().1;
        let n = |name| counters.iter().find(|(counter, _)| *counter == name).map(|(_, n)| *n);
        assert_eq!((n("gps_cut_off"), n("gps_checksum"), n("gps_fixes")), (Some(1.0), Some(1.0), Some(2.0)));
        given(&out)
    };
    let first = at(0.5);
    assert_eq!((first.len(), first[0].stamp, fix_of(&first[0]).position_m), (1, Time::ZERO, [0.0; 3]));
    assert_eq!(at(0.9), []);
    let rest = at(3.0);
    assert_eq!(
        rest.iter().map(|o| (o.stamp.as_secs(), o.valid)).collect::<Vec<_>>(),
        [(1.0, true), (2.0, false)]
    );
    assert_eq!(at(9.0), []);
}

#[test]
fn a_capture_that_is_none_is_a_fault_of_its_key() {
    let build = |file: &str| GpsParams { file: Some(file.into()), ..EXACT }.build(&BuildContext::bare("gps"));
    let fault = |file: &str| build(file).err().map(|fault| (fault.path, fault.message));
    assert_eq!(fault("no_such_capture.nmea").unwrap().0, "file");
    assert!(fault(".").unwrap().1.contains("not a file"));
    let (path, message) = fault("Cargo.toml").unwrap();
    assert!(path == "file" && message.contains("no GGA sentence in it"), "{message}");
}

#[test]
fn heights_are_over_the_origin_and_a_height_that_is_not_said_is_not_known() {
    let mut interpretation = GpsParams { error_m: 3.0, ..EXACT }.interpretation();
    let fix = Fix {
        utc_s: None,
        latitude_deg: -22.0,
        longitude_deg: -47.9,
        quality: 1,
        satellites: None,
        hdop: None,
        altitude_m: None,
        geoid_separation_m: None,
    };
    let first = interpretation.position(&fix);
    assert_eq!((first.position_m, first.deviation_m[2]), ([0.0; 3], 1000.0));
    let ground = interpretation.position(&Fix { altitude_m: Some(800.0), ..fix });
    assert_eq!((ground.position_m[2], ground.deviation_m[2]), (0.0, 3.0 / 3f64.sqrt()));
    assert_eq!(interpretation.position(&Fix { altitude_m: Some(801.5), ..fix }).position_m[2], 1.5);
    let origin = Origin { latitude_deg: -22.0, longitude_deg: -47.9, altitude_m: Some(790.0) };
    let mut surveyed = GpsParams { origin: Some(origin), ..EXACT }.interpretation();
    assert_eq!(surveyed.position(&Fix { altitude_m: Some(800.0), ..fix }).position_m, [0.0, 0.0, 10.0]);
}

const HERE: Origin = Origin { latitude_deg: -22.0, longitude_deg: -47.9, altitude_m: None };
const SPEED: Settings = Settings { rate_hz: 40.0, baud: 115_200, error_m: 50.0 };

/// A receiver that finds satellites when the sensor listens, and whose lines come to harm from then on.
fn receiver() -> Talk {
    let frame = LocalFrame::new(HERE.latitude_deg, HERE.longitude_deg, 0.0);
    let has_begun = Arc::new(std::sync::atomic::AtomicBool::new(false));
    let theirs = Arc::clone(&has_begun);
    let position = move || theirs.load(Ordering::Relaxed).then_some([10.0, 20.0, 0.0]);
    let mut emulator: Option<Emulator> = None;
    let mut position = Some(position);
    Box::new(move |now, baud, hands, out| {
        let emulator = emulator
            .get_or_insert_with(|| Emulator::new(Box::new(position.take().unwrap()), frame, SPEED, 3, now));
        if hands.has_begun.load(Ordering::Relaxed) {
            has_begun.store(true, Ordering::Relaxed);
            let faults = &mut emulator.faults;
            (faults.truncated, faults.interleaved, faults.corrupted) = (0.1, 0.1, 0.1);
        }
        emulator.faults.is_unplugged = hands.is_unplugged.load(Ordering::Relaxed);
        emulator.transmit(now, baud, out);
    })
}

fn at_port(port: &str) -> Box<dyn Sensor> {
    let params = GpsParams { port: Some(port.to_owned()), baud: SPEED.baud, origin: Some(HERE), ..EXACT };
    params.build(&BuildContext::bare("sensor")).unwrap()
}

/// Against a twin that has the whole stream.
fn every_good_line_once(outlet: Outlet) {
    let told: Exchange = exchange(outlet, receiver(), at_port, 90);
    let (fixes, n_good, n_bad) = crate::gps::nmea::decoder::tests::twin(&told.sent);
    let mut interpretation = GpsParams { origin: Some(HERE), ..EXACT }.interpretation();
    let expected: Vec<[f64; 3]> = fixes.iter().map(|fix| interpretation.position(fix).position_m).collect();
    let fixes: Vec<&Observation> = told.given.iter().filter(|observation| observation.valid).collect();
    let found: Vec<[f64; 3]> = fixes.iter().map(|observation| fix_of(observation).position_m).collect();
    assert_eq!(found, expected);
    assert!(fixes.iter().zip(fixes.iter().skip(1)).all(|(a, b)| a.stamp <= b.stamp));
    let n_refused = ["gps_cut_off", "gps_checksum", "gps_too_long", "gps_content"].map(|name| told.n(name));
    assert_eq!(n_refused.iter().sum::<usize>(), n_bad, "{n_refused:?}, {n_good} others");
    assert!(n_bad > 20 && found.len() > 60, "{n_bad} {}", found.len());
    // The device errs by up to 50 m from where it is.
    assert!(found.iter().all(|[x, y, _]| (x - 10.0).abs() < 50.2 && (y - 20.0).abs() < 50.2));
}

#[test]
fn behind_a_bridge_every_good_line_comes_once_and_every_bad_one_is_counted() {
    every_good_line_once(Outlet::tcp("127.0.0.1:0").unwrap());
}

#[cfg(unix)]
#[test]
fn at_a_serial_port_every_good_line_comes_once_and_every_bad_one_is_counted() {
    every_good_line_once(Outlet::terminal().unwrap());
}

#[test]
fn a_device_that_says_something_else_is_told_with_what_it_says() {
    let told =
        complaint_about(b"$GPRMC,183706.000,A,2200.8942,S,04753.7441,W,0.00,,241115,,,A*72\r\n", at_port);
    assert!(told.contains("sentences of other kinds, and no GGA"), "{told}");
    let told = complaint_about(b"\xF3\x12\x00garbage\n", at_port);
    assert!(told.contains("something else talks there") && told.contains("refused"), "{told}");
    let told = complaint_about(b"", at_port);
    assert!(told.contains("nothing comes"), "{told}");
}

#[test]
fn without_a_port_it_says_so_and_a_check_opens_none() {
    let mut live = world([0.0; 3], 0.0);
    live.is_live = true;
    let error = poll(&EXACT, &mut live).unwrap_err();
    assert!(error.to_string().contains("`port` does not say"), "{error}");
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    listener.set_nonblocking(true).unwrap();
    let port = Some(format!("tcp://{}", listener.local_addr().unwrap()));
    let context = BuildContext { dry_run: true, ..BuildContext::bare("sensor") };
    let seen = poll_in(&GpsParams { port, ..EXACT }, &context, Time(5), &mut live).unwrap();
    assert!(seen.is_empty() && listener.accept().is_err());
}
