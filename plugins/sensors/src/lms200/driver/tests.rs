use super::*;
use crate::lms200::emulator::{Emulator, Faults};

const MS: Span = Span(1_000_000);
const HALF: Variant = Variant { field_deg: 180, resolution_centideg: 50 };

fn settings() -> Settings {
    Settings {
        connect: LineSpeed::ALL.to_vec(),
        speed: LineSpeed::Baud500000,
        variant: HALF,
        partials: false,
        unit: CountUnit::Millimeters,
        measuring_mode: MeasuringMode::FieldsAbDazzle,
    }
}

/// What the device sees: every value of a scan follows from the first and from its place, and scans differ.
fn ranges() -> crate::lms200::emulator::Ranges {
    Box::new(|bearing_rad, at| {
        let idx = ((bearing_rad.to_degrees() + 90.0) * 4.0).round() as i64;
        Some((value(at.0 / 1000 % 3989, idx) as f64 / 1000.0, 0))
    })
}

/// In millimeters, for steps of a quarter of a degree.
fn value(first: i64, idx: i64) -> i64 {
    first + idx * idx * 7 % 4001
}

/// The scan is one that the device measured.
fn is_true(scan: &DeviceScan, step: i64) -> bool {
    let words = &scan.measured.words;
    let offset = i64::from(scan.measured.partial.unwrap_or(0));
    let first = i64::from(words[0]) - value(0, offset);
    words.iter().enumerate().all(|(idx, word)| i64::from(*word) == value(first, idx as i64 * step + offset))
}

/// Device, driver and a clock between them.
struct Bench {
    device: Emulator,
    driver: Driver,
    speed: LineSpeed,
    now: Time,
    scans: Vec<DeviceScan>,
}

impl Bench {
    fn new(settings: Settings) -> Self {
        let mut device = Emulator::new(ranges(), Faults::none(5), Time::ZERO);
        // The message after power-on has passed before anybody listens.
        device.transmit(Time::from_secs(1.0), LineSpeed::Baud9600, &mut Vec::new());
        Self::with(device, settings, Time::from_secs(1.0))
    }

    fn with(device: Emulator, settings: Settings, now: Time) -> Self {
        let driver = Driver::new(settings, now);
        Self { device, driver, speed: LineSpeed::Baud9600, now, scans: Vec::new() }
    }

    fn step(&mut self) {
        while let Some(action) = self.driver.next_action() {
            match action {
                Action::SetSpeed(speed) => {
                    self.device.transmit(self.now, self.speed, &mut Vec::new());
                    self.device.flush();
                    self.speed = speed;
                }
                Action::Send(bytes) => self.device.receive(self.now, self.speed, &bytes),
                Action::Deliver(scan) => self.scans.push(scan),
            }
        }
        self.now = self.now + MS;
        let mut bytes = Vec::new();
        self.device.transmit(self.now, self.speed, &mut bytes);
        self.driver.receive(self.now, &bytes);
        self.driver.tick(self.now);
    }

    fn run(&mut self, seconds: f64) {
        let end = self.now + Span::from_secs(seconds);
        while self.now < end {
            self.step();
        }
    }

    /// Seconds until the next scan came.
    fn until_scan(&mut self, most_s: f64) -> f64 {
        let (began, n_before) = (self.now, self.scans.len());
        while self.scans.len() == n_before {
            self.step();
            let waited_s = (self.now - began).as_secs();
            assert!(waited_s < most_s, "no scan: {:?}, {:?}", self.driver, self.driver.last_fault());
        }
        (self.now - began).as_secs()
    }
}

/// A device that streams already at one of its speeds, as another program has left it.
fn streaming_at(speed: LineSpeed) -> Emulator {
    let mut device = Emulator::new(ranges(), Faults::none(5), Time::ZERO);
    let commands = [Command::Switch(Mode::Speed(speed)), Command::Switch(Mode::Continuous)];
    for (speed, command) in [LineSpeed::Baud9600, speed].into_iter().zip(commands) {
        device.receive(Time::ZERO, speed, &command.to_bytes());
    }
    device.transmit(Time::from_secs(1.111), speed, &mut Vec::new());
    assert_eq!(device.speed(), speed);
    device
}

#[test]
fn a_device_that_streams_at_any_speed_is_found_and_set_up() {
    for found_at in LineSpeed::ALL {
        for wanted in [LineSpeed::Baud38400, LineSpeed::Baud500000] {
            let settings = Settings { speed: wanted, ..settings() };
            let mut bench = Bench::with(streaming_at(found_at), settings, Time::from_secs(1.111));
            let waited_s = bench.until_scan(9.0);
            assert_eq!(bench.device.speed(), wanted, "found at {found_at:?}");
            assert_eq!(bench.driver.device_type(), Some("LMS200;301063;V02.30"));
            assert_eq!(
                bench.driver.counters().n_restarts,
                0,
                "{found_at:?}: {:?}",
                bench.driver.last_fault()
            );
            bench.run(2.0);
            assert!(
                bench.scans.iter().all(|scan| is_true(scan, 2)),
                "found at {found_at:?} after {waited_s} s"
            );
        }
    }
}

#[test]
fn every_variant_unit_and_mode_is_set_before_the_first_scan() {
    for variant in Variant::OFFERED {
        for (unit, measuring_mode) in [
            (CountUnit::Centimeters, MeasuringMode::FieldsAbDazzle),
            (CountUnit::Millimeters, MeasuringMode::Reflector8),
            (CountUnit::Millimeters, MeasuringMode::FieldA),
        ] {
            let mut bench = Bench::new(Settings { variant, unit, measuring_mode, ..settings() });
            bench.until_scan(9.0);
            assert_eq!(bench.scans[0].measured.words.len(), variant.n_values());
            assert_eq!(bench.scans[0].measured.unit, unit);
            assert_eq!(bench.device.configuration().measuring_mode(), Some(measuring_mode));
        }
    }
}

#[test]
fn a_configuration_that_fits_is_not_written_again() {
    let mut bench = Bench::new(settings());
    let mut written = 0;
    for _ in 0..20_000 {
        let is_writing = |bench: &Bench| matches!(bench.driver.task, Task::Command(setup::Step::Write(_)));
        let before = is_writing(&bench);
        bench.step();
        written += u32::from(!before && is_writing(&bench));
        if bench.now.0 % 6_000_000_000 == 0 {
            bench.driver.fail(DriverFault::Silent, bench.now);
        }
    }
    assert_eq!(written, 1);
    assert!(bench.driver.counters().n_restarts >= 2 && bench.driver.is_streaming());
}

#[test]
fn partial_scans_come_at_75_a_second_with_their_numbers() {
    let variant = Variant { field_deg: 180, resolution_centideg: 100 };
    let mut bench = Bench::new(Settings { variant, partials: true, ..settings() });
    bench.until_scan(9.0);
    bench.scans.clear();
    bench.run(4.0);
    assert!((299..=301).contains(&bench.scans.len()), "{}", bench.scans.len());
    assert!(bench.scans.iter().all(|scan| is_true(scan, 4)));
    let numbers: Vec<u8> = bench.scans.iter().filter_map(|scan| scan.measured.partial).collect();
    assert!(numbers.windows(2).all(|pair| pair[1] == (pair[0] + 1) % 4));
}

/// The middle of the measurement: the device began a scan's turns 26.67 ms before it sent it.
#[test]
fn stamps_are_the_middle_of_the_measurement() {
    let mut bench = Bench::new(settings());
    bench.until_scan(9.0);
    bench.run(1.0);
    for pair in bench.scans.windows(2) {
        let apart_ms = (pair[1].measured_at - pair[0].measured_at).as_secs() * 1000.0;
        assert!((apart_ms - 26.67).abs() < 1.1, "{apart_ms}");
    }
    for scan in &bench.scans {
        // The device's own time is in the first value, in microseconds modulo 3989.
        let ended_us = i64::from(scan.measured.words[0]);
        let middle_us = (scan.measured_at.0 / 1000 + 13_333).rem_euclid(3989);
        let late_us = (middle_us - ended_us).rem_euclid(3989);
        assert!(late_us <= 1001, "late by {late_us} us, at most the clock's millisecond");
    }
}

#[test]
fn every_fault_of_the_device_is_lived_through() {
    let mut bench = Bench::new(settings());
    bench.device.faults.n_naks = 2;
    bench.until_scan(9.0);
    assert_eq!(bench.driver.counters().n_refused, 2);

    bench.device.faults.status_bits = 0xC3;
    bench.run(1.0);
    let counters = bench.driver.counters();
    assert!(
        counters.n_polluted > 30 && counters.n_implausible > 30 && counters.n_errors > 30,
        "{counters:?}"
    );
    assert!(bench.scans.last().unwrap().status.is_polluted());
    bench.device.faults.status_bits = 0;

    // Telegrams that come late are scans all the same.
    bench.device.faults.delay = Span::from_secs(0.2);
    bench.run(2.0);
    bench.device.faults.delay = Span::ZERO;
    assert!(bench.driver.counters().n_gaps >= 1);
    assert_eq!(bench.driver.counters().n_restarts, 0);

    bench.device.faults.is_mute = true;
    bench.run(5.5);
    assert_eq!(bench.driver.last_fault(), Some(&DriverFault::Silent));
    bench.device.faults.is_mute = false;
    bench.until_scan(4.0);

    // Power fails: the message after power-on is at another speed and not understood.
    bench.device.switch_on(bench.now);
    let waited_s = bench.until_scan(15.0);
    assert!(waited_s > 5.0);

    bench.device.faults.is_unplugged = true;
    bench.run(60.0);
    assert_eq!(bench.driver.last_fault(), Some(&DriverFault::NotFound));
    bench.device.faults.is_unplugged = false;
    bench.until_scan(9.0);
    assert!(bench.scans.iter().all(|scan| is_true(scan, 2)));
}

/// At 9600 baud the message after power-on is heard, and the driver does not wait for the silence.
#[test]
fn a_device_that_restarts_is_set_up_again_at_once() {
    let mut bench = Bench::new(Settings { speed: LineSpeed::Baud9600, ..settings() });
    bench.until_scan(9.0);
    bench.device.switch_on(bench.now);
    assert!(bench.until_scan(5.0) < 4.0);
    assert_eq!(bench.driver.last_fault(), Some(&DriverFault::Restarted));
}

#[test]
fn a_stopped_device_is_silent_at_9600_baud() {
    let mut bench = Bench::new(settings());
    bench.until_scan(9.0);
    bench.driver.stop(bench.now);
    bench.run(1.0);
    assert!(bench.driver.is_stopped());
    assert_eq!(bench.device.speed(), LineSpeed::Baud9600);
    let n_scans = bench.scans.len();
    bench.run(6.0);
    assert_eq!(bench.scans.len(), n_scans);
}

/// Ten minutes of a bad line: bytes lost, bits flipped, the cable pulled five times and the power twice. Every scan whose
/// bytes all came through is delivered or was not wanted, and no other.
#[test]
fn ten_minutes_of_a_bad_line_give_all_good_scans_and_no_wrong_one() {
    let mut bench = Bench::new(settings());
    bench.until_scan(9.0);
    bench.device.faults.flip = 4e-5;
    bench.device.faults.drop = 4e-5;
    for round in 0..10 {
        bench.run(50.0);
        if round % 2 == 0 {
            bench.device.faults.is_unplugged = true;
            bench.run(if round % 4 == 0 { 0.7 } else { 8.0 });
            bench.device.faults.is_unplugged = false;
        }
        if round == 3 || round == 7 {
            bench.device.switch_on(bench.now);
        }
        bench.run(10.0);
    }
    bench.device.faults.flip = 0.0;
    bench.device.faults.drop = 0.0;
    bench.run(0.1);
    let counters = bench.driver.counters();
    let n_wrong = bench.scans.iter().filter(|scan| !is_true(scan, 2)).count();
    assert_eq!(n_wrong, 0, "{counters:?}");
    assert_eq!(bench.scans.len() as u64, counters.n_scans);
    assert_eq!(
        counters.n_scans + counters.n_ignored_scans,
        bench.device.n_whole_scans(),
        "of {} sent: {counters:?}",
        bench.device.n_sent_scans()
    );
    assert!(counters.n_checksum_failures > 500 && counters.n_gaps >= 5, "{counters:?}");
    assert!(counters.n_scans > 18_000, "{counters:?}");
}
