use std::collections::BTreeSet;
use std::f64::consts::FRAC_PI_2;
use std::net::TcpListener;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64};
use std::time::Duration;
use std::time::Instant;

use rumbo_core::messages::{Data, Observation, Observations};
use rumbo_core::registry::Plugin as _;
use rumbo_core::stages::{BuildContext, Cx, Sensor};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;
use rumbo_kit::emulation::{EmulatedDevice, LineFaultParams, LineFaults, Outlet, Served};

use super::*;
use crate::lms200::Lms200Params;
use crate::lms200::emulator::{Emulator, Faults};
use crate::lms200::protocol::{Decoder, LineSpeed, Reply, Telegram, Token};
use crate::test_world::{TestWorld, given};

/// Nothing here takes longer, however busy the machine is.
const MOST: Duration = Duration::from_secs(120);

/// What the device sees: every value of a scan follows from the scan's number, which its first value tells.
fn range_m(number: u64, bearing_rad: f64) -> f64 {
    let idx = ((bearing_rad.to_degrees() + 90.0) * 2.0).round() as u64;
    (1000 + (number * 37 + idx * idx * 7) % 4001) as f64 / 1000.0
}

/// A device whose scans are numbered, with a plug and a switch.
struct Numbered {
    emulator: Emulator,
    hands: Arc<Hands>,
    /// What has left the device, as somebody reads it who is never held up.
    left: Decoder,
    /// Scans that have left since the call before.
    just_left: Vec<u64>,
    last_call: Time,
    last_held_up: Time,
}

/// The device sends its bytes no further apart than this, or its scan does not count: a host may give it up.
const MOST_HELD_UP: Span = Span(15_000_000);
/// Longer than a scan is on its way.
const ON_ITS_WAY: Span = Span(40_000_000);

/// What a test does to a device.
#[derive(Debug, Default)]
struct Hands {
    pull_plug: AtomicBool,
    switch_off_and_on: AtomicBool,
    /// Share of bytes that are lost, and of those that are damaged, on the way from the device: in millionths.
    damage_ppm: AtomicU64,
    /// Numbers of the scans that left the device whole and without a pause.
    whole: Mutex<Vec<u64>>,
}

impl Numbered {
    fn new(hands: &Arc<Hands>, now: Time) -> Self {
        let (mut number, mut measured_at) = (0, None);
        let ranges = move |bearing_rad, at| {
            if measured_at.replace(at) != Some(at) {
                number += 1;
            }
            Some((range_m(number, bearing_rad), 0))
        };
        let emulator = Emulator::new(Box::new(ranges), Faults::none(8), now);
        let hands = Arc::clone(hands);
        let left = Decoder::default();
        Self { emulator, hands, left, just_left: Vec::new(), last_call: now, last_held_up: now }
    }

    /// A scan is whole when all its bytes leave in time, those of the call before too.
    fn note_whole(&mut self, now: Time, sent: &[u8]) {
        if now - self.last_call > MOST_HELD_UP {
            self.last_held_up = now;
        }
        self.last_call = now;
        let just_left = std::mem::take(&mut self.just_left);
        if now - self.last_held_up > ON_ITS_WAY {
            self.hands.whole.lock().unwrap().extend(just_left);
        }
        self.left.push(sent);
        while let Some(token) = self.left.next() {
            let Token::Frame(payload) = token else { continue };
            if let Ok(Telegram { reply: Reply::Scan(measured), .. }) = Telegram::of_payload(&payload) {
                self.just_left.extend(number_of(f64::from(measured.words[0]) / 1000.0, -FRAC_PI_2));
            }
        }
    }

    fn speed(&self, baud: Option<u32>) -> LineSpeed {
        baud.map_or(self.emulator.speed(), |baud| LineSpeed::of_baud(baud).unwrap())
    }
}

impl EmulatedDevice for Numbered {
    fn receive(&mut self, now: Time, baud: Option<u32>, bytes: &[u8]) {
        self.emulator.receive(now, self.speed(baud), bytes);
    }

    fn transmit(&mut self, now: Time, baud: Option<u32>, out: &mut Vec<u8>) {
        self.emulator.faults.is_unplugged = self.hands.pull_plug.load(Ordering::Relaxed);
        if self.hands.switch_off_and_on.swap(false, Ordering::Relaxed) {
            self.emulator.switch_on(now);
        }
        let damage = self.hands.damage_ppm.load(Ordering::Relaxed) as f64 * 1e-6;
        (self.emulator.faults.flip, self.emulator.faults.drop) = (damage, damage);
        // A terminal that nobody has opened yet has some speed that the device does not know.
        let n_before = out.len();
        if baud.is_none_or(|baud| LineSpeed::of_baud(baud).is_some()) {
            self.emulator.transmit(now, self.speed(baud), out);
        }
        self.note_whole(now, &out[n_before..]);
    }
}

/// The scan whose value at this bearing is so far.
fn number_of(seen_m: f64, bearing_rad: f64) -> Option<u64> {
    (0..4001).find(|number| (seen_m - range_m(*number, bearing_rad)).abs() < 1e-6)
}

/// One byte in 50,000 is lost, and one is damaged: about one telegram in 40.
fn serve(outlet: Outlet, hands: &Arc<Hands>, clock: WallClock) -> Served {
    let params = LineFaultParams { loss: 2e-5, flips: 2e-5, ..LineFaultParams::default() };
    let device = Box::new(Numbered::new(hands, clock.now()));
    Served::start(outlet, device, LineFaults::new(params, 5, "line"), Arc::new(move || clock.now())).unwrap()
}

/// A sensor that is polled, and every scan of it so far looked at.
struct Watched {
    sensor: Box<dyn Sensor>,
    clock: WallClock,
    last: Option<(u64, Time)>,
    n_scans: usize,
    numbers: BTreeSet<u64>,
    errors: Vec<String>,
}

impl Watched {
    fn new(port: &str, clock: WallClock) -> Self {
        let sensor = sensor(port, Lms200Params::default());
        Self { sensor, clock, last: None, n_scans: 0, numbers: BTreeSet::new(), errors: Vec::new() }
    }

    fn until(&mut self, what: &str, mut is_done: impl FnMut(&Self) -> bool) {
        let (began, trace, mut world) = (Instant::now(), Trace::unwatched(), TestWorld::with_wall(1.0));
        world.is_live = true;
        while !is_done(self) {
            assert!(began.elapsed() < MOST, "{what}: {} scans, {:?}", self.n_scans, self.errors.last());
            let mut out = Observations::default();
            let mut cx = Cx { now: self.clock.now(), trace: &trace };
            self.errors.extend(self.sensor.poll(&mut cx, &mut world, &mut out).err().map(|e| e.to_string()));
            given(&out).iter().for_each(|observation| self.look_at(observation));
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    /// It is one that the device measured, and a later one than the last.
    fn look_at(&mut self, observation: &Observation) {
        let Data::LaserScan(scan) = &observation.data else { panic!() };
        assert_eq!((scan.ranges_m.len(), observation.valid), (361, true));
        let number = number_of(f64::from(scan.ranges_m[0]), scan.bearing_rad(0)).unwrap();
        for (idx, range) in scan.ranges_m.iter().enumerate() {
            assert!(is_near(*range, range_m(number, scan.bearing_rad(idx))), "scan {number}, beam {idx}");
        }
        if let Some((last, stamp)) = self.last {
            assert!(number > last && observation.stamp > stamp, "scan {number} after {last}");
        }
        self.last = Some((number, observation.stamp));
        self.numbers.insert(number);
        self.n_scans += 1;
    }

    fn until_scans(&mut self, what: &str, n_scans: usize) {
        let n_before = self.n_scans;
        self.until(what, |watched| watched.n_scans >= n_before + n_scans);
    }

    fn until_error(&mut self, what: &str) {
        let n_before = self.errors.len();
        self.until(what, |watched| watched.errors.len() > n_before);
    }
}

fn is_near(range: f32, expected_m: f64) -> bool {
    (f64::from(range) - expected_m).abs() < 1e-6
}

fn sensor(port: &str, params: Lms200Params) -> Box<dyn Sensor> {
    let params = Lms200Params { port: Some(port.to_owned()), baud: 500_000, ..params };
    params.build(&BuildContext::bare("sensor")).unwrap()
}

/// Polls for so long, and gives what came and the errors on the way.
fn poll_for(sensor: &mut dyn Sensor, clock: WallClock, seconds: f64) -> (Vec<Observation>, Vec<SensorError>) {
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

/// A bad line, a plug that is out until the driver has given up, and a loss of power: no wrong scan, and scans after each.
fn live_through_everything(outlet: Outlet) {
    let (hands, clock) = (Arc::new(Hands::default()), WallClock::start());
    let served = serve(outlet, &hands, clock);
    let mut watched = Watched::new(served.address(), clock);
    watched.until_scans("at first", 40);
    hands.pull_plug.store(true, Ordering::Relaxed);
    watched.until_error("with the plug out");
    assert!(watched.errors.last().unwrap().contains(served.address()), "{:?}", watched.errors);
    hands.pull_plug.store(false, Ordering::Relaxed);
    watched.until_scans("with the plug in again", 20);
    hands.switch_off_and_on.store(true, Ordering::Relaxed);
    watched.until_error("after a loss of power");
    watched.until_scans("set up anew", 20);
    assert!(served.is_alive());
}

/// Five seconds of a bad line, with the plug out twice: whatever left the device whole is delivered.
fn deliver_all(outlet: Outlet) {
    let (hands, clock) = (Arc::new(Hands::default()), WallClock::start());
    let device = Box::new(Numbered::new(&hands, clock.now()));
    let faults = LineFaults::new(LineFaultParams::default(), 5, "line");
    let served = Served::start(outlet, device, faults, Arc::new(move || clock.now())).unwrap();
    let mut watched = Watched::new(served.address(), clock);
    watched.until_scans("at first", 2);
    let first = watched.last.unwrap().0;
    hands.damage_ppm.store(40, Ordering::Relaxed);
    let began = clock.now();
    watched.until("for five seconds", |_| {
        let since_s = (clock.now() - began).as_secs();
        hands
            .pull_plug
            .store((1.5..1.8).contains(&since_s) || (3.2..3.3).contains(&since_s), Ordering::Relaxed);
        since_s > 5.0
    });
    hands.damage_ppm.store(0, Ordering::Relaxed);
    watched.until_scans("at the end", 2);
    let last = watched.last.unwrap().0;
    assert_eq!(watched.errors, [] as [String; 0], "it streams all the time");
    let whole = hands.whole.lock().unwrap();
    let counted = whole.iter().filter(|number| (first..=last).contains(number));
    let n_missing = counted.clone().filter(|number| !watched.numbers.contains(number)).count() as u64;
    assert!(n_missing <= 2 * served.n_overruns(), "{n_missing} of {}", counted.count());
    assert!(last - first > watched.n_scans as u64, "some came to harm");
}

#[test]
fn all_good_scans_of_a_device_behind_a_bridge_are_delivered() {
    deliver_all(Outlet::tcp("127.0.0.1:0").unwrap());
}

#[cfg(unix)]
#[test]
fn all_good_scans_of_a_device_at_a_serial_port_are_delivered() {
    deliver_all(Outlet::terminal().unwrap());
}

#[test]
fn a_device_behind_a_bridge_is_read_in_spite_of_everything() {
    live_through_everything(Outlet::tcp("127.0.0.1:0").unwrap());
}

#[cfg(unix)]
#[test]
fn a_device_at_a_serial_port_is_read_in_spite_of_everything() {
    live_through_everything(Outlet::terminal().unwrap());
}

#[test]
fn a_bridge_that_goes_and_comes_again_is_found_again() {
    let (hands, clock) = (Arc::new(Hands::default()), WallClock::start());
    let served = serve(Outlet::tcp("127.0.0.1:0").unwrap(), &hands, clock);
    let address = served.address().to_owned();
    let mut watched = Watched::new(&address, clock);
    watched.until_scans("at first", 3);
    drop(served);
    watched.until("without a bridge", |watched| {
        watched.errors.last().is_some_and(|error| error.contains("nobody listens there"))
    });
    // Another device, whose scans begin with number one again.
    watched.last = None;
    let _served = serve(Outlet::tcp(address.trim_start_matches("tcp://")).unwrap(), &hands, clock);
    watched.until_scans("with a bridge again", 3);
}

/// Somebody else's device: it sends, but nothing that an LMS 200 would.
#[test]
fn a_wrong_device_is_told_from_none() {
    struct Other;
    impl EmulatedDevice for Other {
        fn receive(&mut self, _: Time, _: Option<u32>, _: &[u8]) {}
        fn transmit(&mut self, _: Time, _: Option<u32>, out: &mut Vec<u8>) {
            out.extend(b"$GPGGA,123519,4807.038,N*47\r\n");
        }
    }
    let clock = WallClock::start();
    let faults = LineFaults::new(LineFaultParams::default(), 5, "line");
    let outlet = Outlet::tcp("127.0.0.1:0").unwrap();
    let served = Served::start(outlet, Box::new(Other), faults, Arc::new(move || clock.now())).unwrap();
    let mut watched = Watched::new(served.address(), clock);
    watched.until_error("of another device");
    let error = watched.errors.last().unwrap();
    assert!(error.contains("something else answers"), "{error}");
}

#[test]
fn without_a_port_or_a_device_the_sensor_says_so() {
    let clock = WallClock::start();
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
    let clock = WallClock::start();
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
    assert!((hanging.first_bearing_rad + FRAC_PI_2).abs() < 1e-12);
}
