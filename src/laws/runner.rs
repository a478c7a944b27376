//! Runs a law where a panic or an endless loop of the plugin harms nobody.

use std::any::Any;
use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Once;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// How a law ended that gave no verdict.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Ended {
    /// The plugin panicked, with this message.
    Panicked(String),
    /// The plugin did not come back for so long.
    Hung(Duration),
    /// The operating system gives no thread.
    NoThread(String),
}

/// Name of the threads that laws run on.
const THREAD: &str = "law";

thread_local! {
    /// Where this thread panicked.
    static PLACE: RefCell<String> = const { RefCell::new(String::new()) };
}

/// What `work` gives, unless it panics or takes longer than `patience`. In the latter case its thread is left behind.
pub fn guarded<T: Send + 'static>(
    patience: Duration,
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, Ended> {
    keep_panics_off_the_terminal();
    let (sender, receiver) = channel();
    let body = move || {
        let result = catch_unwind(AssertUnwindSafe(work)).map_err(|payload| message_of(payload.as_ref()));
        // Nobody listens any more after the time is over.
        let _ = sender.send(result);
    };
    let thread = std::thread::Builder::new().name(THREAD.into()).spawn(body);
    let thread = thread.map_err(|error| Ended::NoThread(error.to_string()))?;
    match receiver.recv_timeout(patience) {
        Ok(result) => {
            // It has sent its last word and ends by itself; its panics were caught.
            let _ = thread.join();
            result.map_err(Ended::Panicked)
        }
        Err(RecvTimeoutError::Timeout) => Err(Ended::Hung(patience)),
        Err(RecvTimeoutError::Disconnected) => Err(Ended::Panicked("while it was dropped".into())),
    }
}

/// What laws catch is told in their report.
fn keep_panics_off_the_terminal() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let usual = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            if std::thread::current().name() == Some(THREAD) {
                let place = info.location().map(|at| format!(" at {}:{}", at.file(), at.line()));
                PLACE.with_borrow_mut(|kept| *kept = place.unwrap_or_default());
            } else {
                usual(info);
            }
        }));
    });
}

fn message_of(payload: &(dyn Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().copied();
    let text = text.or_else(|| payload.downcast_ref::<String>().map(String::as_str));
    let place = PLACE.with_borrow_mut(std::mem::take);
    format!("`{}`{place}", text.unwrap_or("a panic without words"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_told_with_its_words_and_its_place() {
        let ended = guarded(Duration::from_secs(60), || panic!("of {}", 7));
        let Err(Ended::Panicked(message)) = ended else { panic!("{ended:?}") };
        assert!(message.starts_with("`of 7` at ") && message.contains("runner.rs:"), "{message}");
    }

    #[test]
    fn what_does_not_come_back_is_left_behind() {
        let (sender, receiver) = channel::<()>();
        let patience = Duration::from_millis(20);
        assert_eq!(guarded(patience, move || receiver.recv().is_ok()), Err(Ended::Hung(patience)));
        drop(sender);
        assert_eq!(guarded(Duration::from_secs(60), || 7), Ok(7));
    }
}
