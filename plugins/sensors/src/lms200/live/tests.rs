use std::io::{Read, Write};
use std::net::TcpListener;
use std::time::Duration;

use rumbo_core::messages::{Data, Observation, Observations};
use rumbo_core::registry::Plugin as _;
use rumbo_core::stages::{BuildContext, Cx, Sensor};
use rumbo_core::trace::Trace;

use super::*;
use crate::lms200::Lms200Params;
use crate::lms200::emulator::{Emulator, Faults};
use crate::test_world::{TestWorld, given};

/// A wall 2 m before the device, and nothing behind 60 degrees on the left.
fn device(faults: Faults, now: Time) -> Emulator {
    let wall = |bearing_rad: f64, _| (bearing_rad < 1.0).then(|| (2.0 / bearing_rad.cos().max(0.3), 6));
    Emulator::new(Box::new(wall), faults, now)
}

/// Serves the device until the other side closes or the time is over.
fn serve(mut line: impl Read + Write, faults: Faults, clock: Clock, most_s: f64) {
    let mut device = device(faults, clock.now());
    let mut buffer = [0u8; 256];
    let end = clock.now() + Span::from_secs(most_s);
    while clock.now() < end {
        let n_bytes = match line.read(&mut buffer) {
            Ok(0) => return,
            Ok(n_bytes) => n_bytes,
            // Nothing came, or nobody has opened the port yet.
            Err(_) => {
                std::thread::sleep(Duration::from_millis(1));
                0
            }
        };
        let speed = device.speed();
        device.receive(clock.now(), speed, &buffer[..n_bytes]);
        let mut bytes = Vec::new();
        device.transmit(clock.now(), speed, &mut bytes);
        if line.write_all(&bytes).is_err() {
            return;
        }
    }
}

/// Polls for so long, and gives what came and the errors on the way.
fn poll_for(sensor: &mut dyn Sensor, clock: Clock, seconds: f64) -> (Vec<Observation>, Vec<SensorError>) {
    let (mut out, trace, mut errors) = (Observations::default(), Trace::unwatched(), Vec::new());
    let mut world = TestWorld::with_wall(1.0);
    world.is_live = true;
    let end = clock.now() + Span::from_secs(seconds);
    while clock.now() < end {
        let mut cx = Cx { now: clock.now(), trace: &trace };
        errors.extend(sensor.poll(&mut cx, &mut world, &mut out).err());
        std::thread::sleep(Duration::from_millis(10));
    }
    (given(&out), errors)
}

fn sensor(port: &str, params: Lms200Params) -> Box<dyn Sensor> {
    let params = Lms200Params { port: Some(port.to_owned()), baud: 500_000, ..params };
    params.build(&BuildContext::bare("sensor")).unwrap()
}

fn faults() -> Faults {
    let mut faults = Faults::none(8);
    (faults.flip, faults.drop) = (2e-5, 2e-5);
    faults
}

fn check_scans(found: &[Observation], errors: &[SensorError], at_least: usize) {
    assert!(found.len() >= at_least, "{} scans, {:?}", found.len(), errors.last());
    for observation in found {
        let Data::LaserScan(scan) = &observation.data else { panic!() };
        assert_eq!((scan.ranges_m.len(), observation.valid), (361, true));
        assert!((scan.ranges_m[180] - 2.0).abs() < 1e-6, "{}", scan.ranges_m[180]);
        assert!((scan.bearing_rad(0) + std::f64::consts::FRAC_PI_2).abs() < 1e-9);
        assert!(scan.ranges_m[360].is_infinite() && scan.ranges_m[0].is_finite());
    }
    let stamps: Vec<Time> = found.iter().map(|observation| observation.stamp).collect();
    assert!(stamps.windows(2).all(|pair| pair[0] < pair[1]), "{stamps:?}");
}

#[test]
fn a_device_behind_a_bridge_is_read_in_spite_of_a_bad_line() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("tcp://{}", listener.local_addr().unwrap());
    let clock = Clock { began: Instant::now() };
    let server = std::thread::spawn(move || {
        let (line, _) = listener.accept().unwrap();
        line.set_read_timeout(Some(Duration::from_millis(2))).unwrap();
        serve(line, faults(), clock, 8.0);
    });
    let mut sensor = sensor(&address, Lms200Params::default());
    let (found, errors) = poll_for(sensor.as_mut(), clock, 5.0);
    drop(sensor);
    server.join().unwrap();
    // Finding and setting it up takes about a second; 37.5 scans a second are less where others use the machine.
    check_scans(&found, &errors, 40);
    assert!(errors.iter().all(|error| error.to_string().contains("no answer from tcp://")), "{errors:?}");
}

#[cfg(unix)]
#[test]
fn a_device_at_a_serial_port_is_read_in_spite_of_a_bad_line() {
    use serialport::SerialPort as _;
    let (mut ours, theirs) = serialport::TTYPort::pair().unwrap();
    let address = theirs.name().unwrap();
    // The sensor wants the port for itself.
    drop(theirs);
    ours.set_timeout(Duration::from_millis(2)).unwrap();
    let clock = Clock { began: Instant::now() };
    let server = std::thread::spawn(move || serve(ours, faults(), clock, 8.0));
    let mut sensor = sensor(&address, Lms200Params::default());
    let (found, errors) = poll_for(sensor.as_mut(), clock, 5.0);
    drop(sensor);
    server.join().unwrap();
    check_scans(&found, &errors, 40);
    assert!(errors.iter().all(|error| error.to_string().contains("no answer from /dev/")), "{errors:?}");
}

#[test]
fn without_a_port_or_a_device_the_sensor_says_so() {
    let clock = Clock { began: Instant::now() };
    let mut portless = Lms200Params::default().build(&BuildContext::bare("laser")).unwrap();
    let (found, errors) = poll_for(portless.as_mut(), clock, 0.02);
    assert!(found.is_empty() && errors[0].to_string().contains("`port` does not say"), "{errors:?}");
    // A port that was free a moment ago has nobody who answers.
    let address = format!("tcp://{}", TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap());
    let (_, errors) = poll_for(sensor(&address, Lms200Params::default()).as_mut(), clock, 0.5);
    assert!(errors.iter().any(|error| error.to_string().contains(&address)), "{errors:?}");
}

#[test]
fn a_check_opens_no_port() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    listener.set_nonblocking(true).unwrap();
    let port = Some(format!("tcp://{}", listener.local_addr().unwrap()));
    let context = BuildContext { dry_run: true, ..BuildContext::bare("laser") };
    let mut sensor = Lms200Params { port, ..Lms200Params::default() }.build(&context).unwrap();
    let clock = Clock { began: Instant::now() };
    assert_eq!(poll_for(sensor.as_mut(), clock, 0.1), (Vec::new(), Vec::new()));
    assert!(listener.accept().is_err());
}

#[test]
fn values_become_ranges_with_their_reasons_and_levels() {
    use crate::lms200::protocol::{CountUnit, Measured, MeasuringMode, StatusByte};
    use crate::lms200::{Lms200Mode, Lms200Unit};
    let measuring_mode = MeasuringMode::Reflector8;
    let mut words = vec![1000; 181];
    words[..5].copy_from_slice(&[0x1FF7, 0x1FFF, 1 | 7 << 13, 1000 | 7 << 13, 8182]);
    let measured = Measured { unit: CountUnit::Millimeters, partial: None, words, indices: None };
    let scan = DeviceScan { measured_at: Time::ZERO, measured, status: StatusByte::HEALTHY };
    let mode = Lms200Mode::new(180.0, 1.0).unwrap();
    let read = |is_inverted: bool| {
        let unit = Lms200Unit::Millimeters;
        Interpretation { mode, unit, measuring_mode, is_inverted }
            .laser_scan(&scan, &mut Observations::default())
    };
    let upright = read(false);
    assert!(
        upright.ranges_m[0].is_infinite() && upright.ranges_m[1].is_nan() && upright.ranges_m[2].is_nan()
    );
    assert_eq!((upright.ranges_m[3], upright.ranges_m[4], upright.max_range_m), (1.0, 8.182, 8.182));
    assert_eq!((upright.intensities[3], upright.intensities[4]), (7.0, 0.0));
    let hanging = read(true);
    assert!(hanging.ranges_m[180].is_infinite() && hanging.ranges_m[179].is_nan());
    assert_eq!((hanging.ranges_m[177], hanging.intensities[177]), (1.0, 7.0));
    assert!((hanging.first_bearing_rad + std::f64::consts::FRAC_PI_2).abs() < 1e-12);
}
