//! A port that is opened as often as needed: devices are unplugged, and bridges restart.

use std::io::Result;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use super::Port;

/// While it waits, the thread looks this often whether it shall stop.
const LOOK: Duration = Duration::from_millis(20);

/// Opens the port and lets `serve` use it until `shall_stop`; when it cannot be opened, or is gone, `trouble` hears why, and
/// it is opened again after `reopen`.
pub fn keep_open(
    address: &str,
    baud: u32,
    reopen: Duration,
    shall_stop: &AtomicBool,
    mut serve: impl FnMut(Port) -> Result<()>,
    mut trouble: impl FnMut(String),
) {
    let is_over = || shall_stop.load(Ordering::Relaxed);
    while !is_over() {
        let ended = match Port::open(address, baud) {
            Ok(port) => {
                serve(port).map_err(|error| format!("the port is gone ({error}); is the cable plugged in?"))
            }
            Err(fault) => Err(fault.to_string()),
        };
        if let Err(reason) = ended {
            trouble(reason);
        }
        let n_looks = reopen.as_millis() / LOOK.as_millis();
        for _ in 0..n_looks {
            if is_over() {
                return;
            }
            std::thread::sleep(LOOK);
        }
    }
}
