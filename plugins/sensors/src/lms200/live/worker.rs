//! The thread that owns the port: does what the driver says.

use std::sync::atomic::Ordering;
use std::time::Duration;

use rumbo_core::time::Span;
use rumbo_kit::port::{Port, keep_open};
use rumbo_kit::wall_clock::WallClock;

use crate::live_news::Shared;
use crate::lms200::driver::{Action, DeviceScan, Driver, Settings};
use crate::lms200::protocol::{LineSpeed, MOST_LEN};

/// Between attempts to open a port.
const REOPEN: Duration = Duration::from_secs(1);
/// The device gets this long to be told that it is over.
const MOST_FAREWELL: Span = Span(1_000_000_000);
/// At 500000 baud the device wants at least 55 µs from one byte to the next (telegram listing, chapter 3).
const BETWEEN_BYTES: Duration = Duration::from_micros(60);

/// Until it shall stop.
pub(super) fn work(address: &str, settings: &Settings, clock: WallClock, shared: &Shared<DeviceScan>) {
    let serve = |port| serve(port, Driver::new(settings.clone(), clock.now()), clock, shared);
    let trouble = |reason| shared.news().note(clock.now(), reason);
    keep_open(address, settings.speed.baud(), REOPEN, &shared.shall_stop, serve, trouble);
}

/// Until it shall stop or the port is gone.
fn serve(
    mut port: Port,
    mut driver: Driver,
    clock: WallClock,
    shared: &Shared<DeviceScan>,
) -> std::io::Result<()> {
    let mut buffer = [0u8; MOST_LEN];
    let mut farewell_ends_at = None;
    while !driver.is_stopped() && farewell_ends_at.is_none_or(|end| clock.now() < end) {
        if farewell_ends_at.is_none() && shared.shall_stop.load(Ordering::Relaxed) {
            driver.stop(clock.now());
            farewell_ends_at = Some(clock.now() + MOST_FAREWELL);
        }
        while let Some(action) = driver.next_action() {
            match action {
                Action::SetSpeed(speed) => port.set_baud(speed.baud())?,
                Action::Send(bytes) => send(&mut port, &bytes)?,
                Action::Deliver(scan) => shared.news().deliver(scan),
            }
        }
        // Should this thread be held up, then bytes may wait: the line is known to be silent until here only.
        let silent_until = clock.now();
        let n_bytes = port.receive(&mut buffer)?;
        let now = clock.now();
        driver.receive(now, buffer.get(..n_bytes).unwrap_or_default());
        driver.tick(silent_until);
        if !driver.is_streaming()
            && let Some(fault) = driver.last_fault()
        {
            shared.news().note(now, fault.to_string());
        }
    }
    Ok(())
}

/// Sends a telegram no faster than the device can take it.
fn send(port: &mut Port, telegram: &[u8]) -> std::io::Result<()> {
    if port.baud() != Some(LineSpeed::Baud500000.baud()) {
        return port.send(telegram);
    }
    for byte in telegram.chunks(1) {
        port.send(byte)?;
        std::thread::sleep(BETWEEN_BYTES);
    }
    Ok(())
}
