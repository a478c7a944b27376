use std::sync::atomic::AtomicU64;
use std::time::{Duration, Instant};

use super::*;
use crate::emulation::LineFaultParams;
use crate::port::Port;

/// Says every byte again, greater by one.
struct Echo(Vec<u8>);

impl EmulatedDevice for Echo {
    fn receive(&mut self, _: Time, _: Option<u32>, bytes: &[u8]) {
        self.0.extend(bytes.iter().map(|byte| byte.wrapping_add(1)));
    }

    fn transmit(&mut self, _: Time, _: Option<u32>, out: &mut Vec<u8>) {
        out.append(&mut self.0);
    }
}

/// A clock that a test sets, milliseconds.
fn clock(millis: &Arc<AtomicU64>) -> Clock {
    let millis = Arc::clone(millis);
    Arc::new(move || Time(millis.load(Ordering::Relaxed) as i64 * 1_000_000))
}

fn outlets() -> Vec<Outlet> {
    vec![
        Outlet::tcp("127.0.0.1:0").unwrap(),
        #[cfg(unix)]
        Outlet::terminal().unwrap(),
    ]
}

/// Reads until so many bytes are there, or for a minute.
fn read(port: &mut Port, n_bytes: usize) -> Vec<u8> {
    let (mut heard, mut buffer, began) = (Vec::new(), [0u8; 64], Instant::now());
    while heard.len() < n_bytes && began.elapsed() < Duration::from_secs(60) {
        let n_bytes = port.receive(&mut buffer).unwrap();
        heard.extend_from_slice(&buffer[..n_bytes]);
    }
    heard
}

#[test]
fn a_device_answers_every_host_that_comes() {
    for outlet in outlets() {
        let faults = LineFaults::new(LineFaultParams::default(), 1, "line");
        let served =
            Served::start(outlet, Box::new(Echo(Vec::new())), faults, clock(&Arc::default())).unwrap();
        for _ in 0..3 {
            let mut port = Port::open(served.address(), 38_400).unwrap();
            let sent: Vec<u8> = (0..=255).collect();
            port.send(&sent).unwrap();
            let expected: Vec<u8> = (1..=255).chain([0]).collect();
            assert_eq!(read(&mut port, 256), expected, "{}", served.address());
        }
    }
}

#[cfg(unix)]
#[test]
fn a_terminal_tells_the_speed_of_its_host() {
    let outlet = Outlet::terminal().unwrap();
    let mut port = Port::open(&outlet.address(), 9600).unwrap();
    assert_eq!(outlet.baud(), Some(9600));
    port.set_baud(500_000).unwrap();
    assert_eq!(outlet.baud(), Some(500_000));
}

#[test]
fn nothing_passes_while_the_plug_is_out() {
    for outlet in outlets() {
        let millis = Arc::new(AtomicU64::new(9_500));
        let params = LineFaultParams { unplug_every_s: 10.0, ..LineFaultParams::default() };
        let faults = LineFaults::new(params, 1, "line");
        let served = Served::start(outlet, Box::new(Echo(Vec::new())), faults, clock(&millis)).unwrap();
        let mut port = Port::open(served.address(), 38_400).unwrap();
        port.send(b"lost").unwrap();
        let mut buffer = [0u8; 8];
        // That nothing comes can only be waited for; a late machine makes this weaker, not wrong.
        for _ in 0..20 {
            assert_eq!(port.receive(&mut buffer).unwrap_or(0), 0, "{}", served.address());
        }
        millis.store(10_500, Ordering::Relaxed);
        let mut port = reopened(port, served.address());
        let began = Instant::now();
        let heard = loop {
            port.send(b"a").unwrap();
            let n_bytes = port.receive(&mut buffer).unwrap();
            if n_bytes > 0 || began.elapsed() > Duration::from_secs(60) {
                break n_bytes;
            }
        };
        assert!(heard > 0 && buffer[..heard].iter().all(|byte| *byte == b'b'), "{buffer:?}");
    }
}

/// Whoever was sent away comes again.
fn reopened(mut port: Port, address: &str) -> Port {
    let is_gone = port.receive(&mut [0u8; 8]).is_err();
    if is_gone {
        drop(port);
        return Port::open(address, 38_400).unwrap();
    }
    port
}

/// A host may sleep. What it does not read is lost, and the device lives on.
#[test]
fn a_host_that_does_not_read_holds_nobody_up() {
    struct Chatty(Arc<AtomicU64>);
    impl EmulatedDevice for Chatty {
        fn receive(&mut self, _: Time, _: Option<u32>, _: &[u8]) {}
        fn transmit(&mut self, _: Time, _: Option<u32>, out: &mut Vec<u8>) {
            out.extend([b'x'; 100_000]);
            self.0.fetch_add(100_000, Ordering::Relaxed);
        }
    }
    for outlet in outlets() {
        let n_sent = Arc::<AtomicU64>::default();
        let faults = LineFaults::new(LineFaultParams::default(), 1, "line");
        let device = Box::new(Chatty(Arc::clone(&n_sent)));
        let served = Served::start(outlet, device, faults, clock(&Arc::default())).unwrap();
        let mut port = Port::open(served.address(), 38_400).unwrap();
        assert!(read(&mut port, 1).iter().all(|byte| *byte == b'x'));
        let began = Instant::now();
        // More than any buffer on the way holds.
        while n_sent.load(Ordering::Relaxed) < 20_000_000 {
            assert!(began.elapsed() < Duration::from_secs(120), "{}", served.address());
            std::thread::sleep(Duration::from_millis(5));
        }
        drop(served);
        drop(port);
    }
}
