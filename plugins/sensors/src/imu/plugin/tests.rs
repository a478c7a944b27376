//! The device in simulated, recorded and real worlds.

use std::f64::consts::FRAC_PI_2;
use std::sync::atomic::Ordering;

use nalgebra::{Translation3, UnitQuaternion};
use rumbo_core::frames::{Pose3, wrap_angle};
use rumbo_core::messages::SensorId;
use rumbo_core::registry::{Registry, Stage};
use rumbo_core::trace::Trace;
use rumbo_kit::emulation::Outlet;

use super::*;
use crate::imu::AngleUnit;
use crate::imu::emulator::{Emulator, Settings};
use crate::imu::text::Spoken;
use crate::test_world::{TestWorld, given};
use crate::text_device::tests::{Exchange, Talk, complaint_about, exchange};

fn exact() -> ImuParams {
    ImuParams {
        yaw_noise_deg: 0.0,
        tilt_noise_deg: 0.0,
        rate_noise_deg_s: 0.0,
        acceleration_noise_m_s2: 0.0,
        ..ImuParams::default()
    }
}

fn world(attitude: Attitude) -> TestWorld {
    let mut world = TestWorld::with_wall(1.0);
    world.attitude = attitude;
    world
}

const TURNING: Attitude = Attitude {
    attitude_rad: [0.0, 0.0, 1.0],
    rates_rad_s: [0.0, 0.0, 0.5],
    accelerations_m_s2: [0.2, 0.0, 9.81],
};

fn poll_in(
    params: &ImuParams,
    context: &BuildContext,
    world: &mut TestWorld,
) -> Result<Vec<Observation>, SensorError> {
    let mut sensor = params.build(context).unwrap();
    let (trace, mut out) = (Trace::unwatched(), Observations::default());
    sensor.poll(&mut Cx { now: Time(5), trace: &trace }, world, &mut out)?;
    Ok(given(&out))
}

fn poll(params: &ImuParams, world: &mut TestWorld) -> Result<Vec<Observation>, SensorError> {
    poll_in(params, &BuildContext::bare("sensor"), world)
}

fn imu_of(observation: &Observation) -> Imu {
    match &observation.data {
        Data::Imu(imu) => *imu,
        other => panic!("{other:?}"),
    }
}

fn is_near(found: [f64; 3], expected: [f64; 3]) {
    assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?} for {expected:?}");
}

#[test]
fn a_simulated_device_sees_the_base_from_its_mount() {
    let seen = poll(&exact(), &mut world(TURNING)).unwrap();
    assert_eq!((seen.len(), seen[0].stamp, seen[0].valid), (1, Time(5), true));
    is_near(imu_of(&seen[0]).attitude_rad.unwrap(), [0.0, 0.0, 1.0]);
    // Mounted with its x axis to the left, and another upside down.
    for (turn, attitude_rad, rates_rad_s, accelerations_m_s2) in [
        (Vector3::z() * FRAC_PI_2, [0.0, 0.0, 1.0 + FRAC_PI_2], [0.0, 0.0, 0.5], [0.0, -0.2, 9.81]),
        (
            Vector3::x() * std::f64::consts::PI,
            [std::f64::consts::PI, 0.0, 1.0],
            [0.0, 0.0, -0.5],
            [0.2, 0.0, -9.81],
        ),
    ] {
        // On the axis of the turn it feels nothing of it.
        let base_from_sensor = Pose3::new(Vector3::new(0.0, 0.0, 0.2), turn);
        let context = BuildContext { base_from_sensor, ..BuildContext::bare("sensor") };
        let imu = imu_of(&poll_in(&exact(), &context, &mut world(TURNING)).unwrap()[0]);
        let off: Vec<f64> =
            imu.attitude_rad.unwrap().iter().zip(attitude_rad).map(|(a, b)| wrap_angle(a - b)).collect();
        assert!(
            off.iter().all(|off| off.abs() < 1e-9 || (off.abs() - 2.0 * std::f64::consts::PI).abs() < 1e-9)
        );
        is_near(imu.rates_rad_s, rates_rad_s);
        is_near(imu.accelerations_m_s2, accelerations_m_s2);
    }
}

/// A body that rolls and pitches about its base, with a device beside that: what it feels is what bends its way, by second
/// differences, and gravity.
#[test]
fn a_device_beside_the_middle_feels_how_the_base_turns() {
    let arm = Pose3::new(Vector3::new(0.15, -0.1, 0.3), Vector3::new(0.2, 0.1, 0.5));
    let context = BuildContext { base_from_sensor: arm, ..BuildContext::bare("sensor") };
    let mut sensor: Box<dyn Sensor> = exact().build(&context).unwrap();
    let truth = |t: f64| {
        let tilt = UnitQuaternion::from_euler_angles(0.3 * (3.0 * t).sin(), 0.2 * (2.0 * t).cos(), 0.4 * t);
        Pose3::from_parts(Translation3::identity(), tilt)
    };
    let (step_s, h, up) = (0.001, 1e-4, Vector3::z() * 9.81);
    let trace = Trace::unwatched();
    for k in 0..500 {
        let t = f64::from(k) * step_s;
        let (before, now, after) = (truth(t - h), truth(t), truth(t + h));
        let rates = (before.rotation.inverse() * after.rotation).scaled_axis() / (2.0 * h);
        let (roll, pitch, yaw) = now.rotation.euler_angles();
        let attitude = Attitude {
            attitude_rad: [roll, pitch, yaw],
            rates_rad_s: rates.into(),
            accelerations_m_s2: (now.rotation.inverse() * up).into(),
        };
        let mut out = Observations::default();
        let mut cx = Cx { now: Time::from_secs(t), trace: &trace };
        sensor.poll(&mut cx, &mut world(attitude), &mut out).unwrap();
        let felt = Vector3::from(imu_of(&given(&out)[0]).accelerations_m_s2);
        let place = |pose: &Pose3| (pose * arm).translation.vector;
        let bent = (place(&before) + place(&after) - place(&now) * 2.0) / (h * h);
        let expected = (now * arm).rotation.inverse() * (bent + up);
        // The change of the rates is that of half a step ago.
        assert!(k == 0 || (felt - expected).norm() < 0.005, "{t}: {felt} for {expected}");
    }
}

#[test]
fn rates_that_are_none_are_not_remembered() {
    let context = BuildContext {
        base_from_sensor: Pose3::new(Vector3::x(), Vector3::zeros()),
        ..BuildContext::bare("sensor")
    };
    let mut sensor: Box<dyn Sensor> = exact().build(&context).unwrap();
    let trace = Trace::unwatched();
    let mut poll = |stamp: i64, attitude: Attitude| {
        let mut out = Observations::default();
        sensor.poll(&mut Cx { now: Time(stamp), trace: &trace }, &mut world(attitude), &mut out)
    };
    assert!(poll(1_000, Attitude { rates_rad_s: [0.0, 0.0, f64::NAN], ..TURNING }).is_err());
    assert!(poll(2_000, TURNING).is_ok());
}

#[test]
fn a_recording_is_passed_on_and_nonsense_is_an_error() {
    let recorded = Observation {
        sensor: SensorId(9),
        stamp: Time(3),
        base_from_sensor: Pose3::identity(),
        valid: true,
        data: Data::Imu(Imu { rates_rad_s: [1.0, 2.0, 3.0], ..Imu::default() }),
    };
    let seen = poll(&exact(), &mut TestWorld::recorded(vec![recorded.clone()])).unwrap();
    assert_eq!((seen[0].sensor, seen[0].stamp, &seen[0].data), (SensorId(0), Time(3), &recorded.data));
    let nonsense = Attitude { rates_rad_s: [f64::NAN; 3], ..TURNING };
    assert!(matches!(poll(&exact(), &mut world(nonsense)), Err(SensorError::Message(_))));
}

#[test]
fn every_bad_value_is_named_and_a_real_device_needs_its_unit() {
    let bad = ImuParams {
        yaw_bias_deg: f64::NAN,
        yaw_drift_deg_min: f64::NAN,
        yaw_noise_deg: -1.0,
        tilt_noise_deg: -1.0,
        rate_bias_deg_s: f64::NAN,
        rate_noise_deg_s: -1.0,
        acceleration_noise_m_s2: -1.0,
        port: Some(String::new()),
        baud: 0,
        unit: None,
        yaw_offset_deg: f64::NAN,
        sign: 0,
        delay_s: -1.0,
    };
    let keys: Vec<String> = bad.check().into_iter().map(|fault| fault.path).collect();
    let expected = [
        "yaw_bias_deg",
        "yaw_drift_deg_min",
        "rate_bias_deg_s",
        "yaw_offset_deg",
        "yaw_noise_deg",
        "tilt_noise_deg",
        "rate_noise_deg_s",
        "acceleration_noise_m_s2",
        "delay_s",
        "port",
        "unit",
        "baud",
        "sign",
    ];
    assert_eq!(keys, expected);
    assert!(ImuParams::default().check().is_empty());
    assert!(Registry::linked().unwrap().get(Stage::Sensor, "imu").is_some());
    let mut live = world(TURNING);
    live.is_live = true;
    let error = poll(&exact(), &mut live).unwrap_err().to_string();
    assert!(error.contains("`unit` does not say"), "{error}");
    let unit = Some(AngleUnit::Degrees);
    let error = poll(&ImuParams { unit, ..exact() }, &mut live).unwrap_err().to_string();
    assert!(error.contains("`port` does not say"), "{error}");
}

/// Of numbers in degrees and radians, clockwise and not, with an offset.
#[test]
fn what_is_said_becomes_an_attitude_in_the_map() {
    let spoken = Spoken { yaw: -170.0, pitch: 10.0, roll: -20.0 };
    let attitude = |params: &ImuParams, spoken: &Spoken| {
        params.interpretation().unwrap().read(Time::ZERO, spoken).attitude_rad.unwrap().map(f64::to_degrees)
    };
    let unit = Some(AngleUnit::Degrees);
    let degrees = ImuParams { unit, ..exact() };
    is_near(attitude(&degrees, &spoken), [-20.0, 10.0, -170.0]);
    let compass = ImuParams { sign: -1, yaw_offset_deg: 90.0, ..degrees };
    is_near(attitude(&compass, &spoken), [-20.0, 10.0, -100.0]);
    let radians = ImuParams { unit: Some(AngleUnit::Radians), ..exact() };
    // The first line of the literature, were it radians.
    let spoken = Spoken { yaw: -1.82, pitch: -0.05, roll: 0.48 };
    is_near(attitude(&radians, &spoken), [0.48f64, -0.05, -1.82].map(f64::to_degrees));
}

#[test]
fn rates_are_differences_and_forces_those_of_a_robot_at_rest() {
    let params = ImuParams { unit: Some(AngleUnit::Degrees), ..exact() };
    let mut interpretation = params.interpretation().unwrap();
    let level = |yaw| Spoken { yaw, pitch: 0.0, roll: 0.0 };
    let mut read =
        |milliseconds: i64, spoken: Spoken| interpretation.read(Time(milliseconds * 1_000_000), &spoken);
    assert_eq!(read(0, level(179.0)).rates_rad_s, [0.0; 3]);
    // Over half a turn the short way.
    is_near(read(100, level(-179.0)).rates_rad_s, [0.0, 0.0, 20f64.to_radians()]);
    is_near(read(100, level(-178.0)).rates_rad_s, [0.0; 3]);
    is_near(read(5000, level(0.0)).rates_rad_s, [0.0; 3]);
    is_near(read(5100, level(0.0)).accelerations_m_s2, [0.0, 0.0, 9.80665]);
    let on_its_nose = read(9000, Spoken { yaw: 0.0, pitch: 90.0, roll: 0.0 });
    is_near(on_its_nose.accelerations_m_s2, [-9.80665, 0.0, 0.0]);
}

const SPEED: Settings = Settings { rate_hz: 100.0, baud: 57_600, noise_deg: 0.5 };

/// A device whose yaw turns on from line to line, and whose lines come to harm once the sensor listens.
fn device() -> Talk {
    let mut n_lines = 0;
    let attitude = move || {
        n_lines += 1;
        Some([0.01, -0.02, wrap_angle(f64::from(n_lines) * 0.02)])
    };
    let mut attitude = Some(attitude);
    let mut emulator: Option<Emulator> = None;
    Box::new(move |now, baud, hands, out| {
        let emulator =
            emulator.get_or_insert_with(|| Emulator::new(Box::new(attitude.take().unwrap()), SPEED, 3, now));
        if hands.has_begun.load(Ordering::Relaxed) {
            let faults = &mut emulator.faults;
            (faults.truncated, faults.interleaved, faults.corrupted) = (0.1, 0.1, 0.1);
        }
        emulator.faults.is_unplugged = hands.is_unplugged.load(Ordering::Relaxed);
        emulator.transmit(now, baud, out);
    })
}

fn at_port(port: &str) -> Box<dyn Sensor> {
    let unit = Some(AngleUnit::Degrees);
    let params = ImuParams { port: Some(port.to_owned()), baud: SPEED.baud, unit, ..exact() };
    params.build(&BuildContext::bare("sensor")).unwrap()
}

/// Against a twin that has the whole stream.
fn every_good_record_once(outlet: Outlet) {
    let told: Exchange = exchange(outlet, device(), at_port, 240);
    let (good, n_bad) = crate::imu::text::tests::twin(std::str::from_utf8(&told.sent).unwrap());
    let mut interpretation =
        ImuParams { unit: Some(AngleUnit::Degrees), ..exact() }.interpretation().unwrap();
    let expected: Vec<[f64; 3]> =
        good.iter().map(|spoken| interpretation.read(Time::ZERO, spoken).attitude_rad.unwrap()).collect();
    let found: Vec<[f64; 3]> = told.given.iter().map(|o| imu_of(o).attitude_rad.unwrap()).collect();
    // Before the bytes were kept there were good records only.
    let n_before = found.len() - expected.len();
    assert_eq!(found[n_before..], expected);
    assert!(found.iter().take(n_before).zip(found.iter().skip(1)).all(|(a, b)| a[2] != b[2]));
    let n_refused = ["imu_incomplete", "imu_malformed"].map(|name| told.n(name));
    assert_eq!(n_refused.iter().sum::<usize>(), n_bad, "{n_refused:?}");
    assert!(n_bad > 40 && expected.len() > 150, "{n_bad} {}", expected.len());
}

#[test]
fn behind_a_bridge_every_good_record_comes_once_and_every_bad_one_is_counted() {
    every_good_record_once(Outlet::tcp("127.0.0.1:0").unwrap());
}

#[cfg(unix)]
#[test]
fn at_a_serial_port_every_good_record_comes_once_and_every_bad_one_is_counted() {
    every_good_record_once(Outlet::terminal().unwrap());
}

#[test]
fn a_device_that_says_something_else_is_told_with_what_it_says() {
    let told = complaint_about(b"$GPGGA,183706.000\r\n", at_port);
    assert!(told.contains("something else talks there") && told.contains("$GPGGA"), "{told}");
}
