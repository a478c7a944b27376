//! An emulated device that talks by itself, a sensor that listens, and a record of every byte between them.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use rumbo_core::messages::{Observation, Observations};
use rumbo_core::stages::{Cx, Sensor};
use rumbo_core::trace::Trace;
use rumbo_kit::emulation::{EmulatedDevice, LineFaultParams, LineFaults, Outlet, Served};

use super::*;
use crate::test_world::{TestWorld, given};

/// Nothing here takes longer, however busy the machine is.
const MOST: Duration = Duration::from_secs(120);

/// What a test does to a device.
#[derive(Debug, Default)]
pub(crate) struct Hands {
    /// The sensor listens: from the next line on all bytes are kept.
    shall_begin: AtomicBool,
    /// They are, and lines may come to harm.
    pub has_begun: AtomicBool,
    /// The plug is out.
    pub is_unplugged: AtomicBool,
    shall_end: AtomicBool,
    sent: Mutex<Vec<u8>>,
}

/// Says what is through the wire by now, at its speed; told whether lines may come to harm, and whether the plug is out.
pub(crate) type Talk = Box<dyn FnMut(Time, Option<u32>, &Hands, &mut Vec<u8>) + Send>;

struct Chatter {
    talk: Talk,
    hands: Arc<Hands>,
    has_ended: bool,
}

impl EmulatedDevice for Chatter {
    fn receive(&mut self, _: Time, _: Option<u32>, _: &[u8]) {}

    fn transmit(&mut self, now: Time, baud: Option<u32>, out: &mut Vec<u8>) {
        if self.has_ended {
            return;
        }
        let n_before = out.len();
        (self.talk)(now, baud, &self.hands, out);
        if self.hands.shall_end.load(Ordering::Relaxed) {
            self.has_ended = true;
            out.extend(b"\r\n");
        }
        let mut new = out.get(n_before..).unwrap_or_default();
        if self.hands.has_begun.load(Ordering::Relaxed) {
            self.hands.sent.lock().unwrap().extend(new);
        } else if self.hands.shall_begin.load(Ordering::Relaxed)
            && let Some(end) = new.iter().position(|byte| *byte == b'\n')
        {
            new = new.get(end + 1..).unwrap_or_default();
            self.hands.sent.lock().unwrap().extend(new);
            self.hands.has_begun.store(true, Ordering::Relaxed);
        }
    }
}

/// What came of it.
pub(crate) struct Exchange {
    /// Every byte that passed the line, from the beginning of a line on.
    pub sent: Vec<u8>,
    /// Everything that the sensor said since.
    pub given: Vec<Observation>,
    /// By how much its counters have grown since.
    pub counted: Vec<(&'static str, f64)>,
}

impl Exchange {
    /// By how much this counter has grown.
    pub fn n(&self, name: &str) -> usize {
        self.counted.iter().find(|(counter, _)| *counter == name).map_or(0, |(_, n)| *n as usize)
    }
}

/// A sensor at a device.
pub(crate) struct Listening {
    sensor: Box<dyn Sensor>,
    clock: WallClock,
    given: Vec<Observation>,
    counters: Vec<(&'static str, f64)>,
    /// What it complained of.
    pub errors: Vec<String>,
    began: Instant,
}

impl Listening {
    /// A sensor that has not been asked yet.
    pub fn new(sensor: Box<dyn Sensor>, clock: WallClock) -> Self {
        let (given, counters, errors) = (Vec::new(), Vec::new(), Vec::new());
        Self { sensor, clock, given, counters, errors, began: Instant::now() }
    }

    /// Asks it until this is so.
    pub fn until(&mut self, what: &str, mut is_done: impl FnMut(&Self) -> bool) {
        while !is_done(self) {
            assert!(
                self.began.elapsed() < MOST,
                "{what}: {} given, {:?}",
                self.given.len(),
                self.errors.last()
            );
            let (trace, mut world, mut out) =
                (Trace::counting(), TestWorld::with_wall(1.0), Observations::default());
            world.is_live = true;
            let mut cx = Cx { now: self.clock.now(), trace: &trace };
            self.errors.extend(self.sensor.poll(&mut cx, &mut world, &mut out).err().map(|e| e.to_string()));
            self.given.extend(given(&out));
            self.counters = trace.take().1;
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    fn n_given(&self) -> usize {
        self.given.len()
    }
}

/// Serves a device at an outlet.
pub(crate) fn serve(outlet: Outlet, talk: Talk, hands: &Arc<Hands>, clock: WallClock) -> Served {
    let device = Chatter { talk, hands: Arc::clone(hands), has_ended: false };
    let faults = LineFaults::new(LineFaultParams::default(), 5, "line");
    Served::start(outlet, Box::new(device), faults, Arc::new(move || clock.now())).unwrap()
}

/// Lets a device talk on a bad line whose plug is out twice, until `n_readings` have come.
pub(crate) fn exchange(
    outlet: Outlet,
    talk: Talk,
    sensor: impl FnOnce(&str) -> Box<dyn Sensor>,
    n_readings: usize,
) -> Exchange {
    let (hands, clock) = (Arc::new(Hands::default()), WallClock::start());
    let served = serve(outlet, talk, &hands, clock);
    let mut listening = Listening::new(sensor(served.address()), clock);
    listening.until("at first", |listening| listening.n_given() >= 2);
    // All that come to harm come later.
    let counters_before = listening.counters.clone();
    hands.shall_begin.store(true, Ordering::Relaxed);
    for part in 1..=3 {
        listening.until("a bad line", |listening| listening.n_given() >= n_readings * part / 3);
        hands.is_unplugged.store(part < 3, Ordering::Relaxed);
        let pulled_at = clock.now();
        listening.until("the plug is out", |_| clock.now() - pulled_at > Span::from_secs(0.15));
        hands.is_unplugged.store(false, Ordering::Relaxed);
    }
    hands.shall_end.store(true, Ordering::Relaxed);
    let ended_at = clock.now();
    listening.until("the end", |_| clock.now() - ended_at > Span::from_secs(0.5));
    assert_eq!(served.n_overruns(), 0, "a line as slow as this is never full");
    assert_eq!(listening.errors, [] as [String; 0]);
    let grown = |(name, n): &(&'static str, f64)| {
        let before = counters_before.iter().find(|(counter, _)| counter == name).map_or(0.0, |(_, n)| *n);
        (*name, n - before)
    };
    let sent = hands.sent.lock().unwrap().clone();
    Exchange { sent, given: listening.given, counted: listening.counters.iter().map(grown).collect() }
}

/// What a sensor says of a device that says nothing that it understands.
pub(crate) fn complaint_about(said: &'static [u8], sensor: impl FnOnce(&str) -> Box<dyn Sensor>) -> String {
    let (hands, clock) = (Arc::new(Hands::default()), WallClock::start());
    let mut last = Time::ZERO;
    let talk: Talk = Box::new(move |now, _, _, out| {
        if now - last > Span::from_secs(0.02) {
            last = now;
            out.extend(said);
        }
    });
    let served = serve(Outlet::tcp("127.0.0.1:0").unwrap(), talk, &hands, clock);
    let mut listening = Listening::new(sensor(served.address()), clock);
    listening.until("a complaint", |listening| !listening.errors.is_empty());
    assert!(listening.given.is_empty());
    listening.errors.remove(0)
}

#[test]
fn a_bridge_that_goes_is_told_and_found_again() {
    use rumbo_core::registry::Plugin as _;
    use rumbo_core::stages::BuildContext;
    let (hands, clock) = (Arc::new(Hands::default()), WallClock::start());
    let talk = || -> Talk { Box::new(|_, _, _, out| out.extend(b"Y: 1.0 P: 2.0 R: 3.0\r\n")) };
    let served = serve(Outlet::tcp("127.0.0.1:0").unwrap(), talk(), &hands, clock);
    let address = served.address().to_owned();
    let params = crate::imu::ImuParams {
        port: Some(address.clone()),
        unit: Some(crate::imu::AngleUnit::Degrees),
        ..crate::imu::ImuParams::default()
    };
    let sensor = params.build(&BuildContext::bare("sensor")).unwrap();
    let mut listening = Listening::new(sensor, clock);
    listening.until("at first", |listening| listening.n_given() >= 3);
    drop(served);
    listening.until("without a bridge", |listening| {
        listening.errors.last().is_some_and(|error| error.contains("nobody listens there"))
    });
    let n_before = listening.n_given();
    let _served = serve(Outlet::tcp(address.trim_start_matches("tcp://")).unwrap(), talk(), &hands, clock);
    listening.until("with a bridge again", |listening| listening.n_given() > n_before + 3);
}
