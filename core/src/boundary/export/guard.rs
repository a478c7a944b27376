//! Where panics of plugins end.
#![allow(unsafe_code)]

use super::super::abi::{RUMBO_ERROR, RUMBO_PANIC, rumbo_error};
use std::any::Any;
use std::cell::{Cell, RefCell};
use std::ffi::c_void;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Once;

thread_local! {
    static GUARDED: Cell<u32> = const { Cell::new(0) };
    static PLACE: RefCell<String> = const { RefCell::new(String::new()) };
}

/// A panic inside of a guarded call is the host's to tell, with its place; others print as ever.
pub(super) fn quiet() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let before = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            if GUARDED.get() == 0 {
                return before(info);
            }
            let place =
                info.location().map(|at| format!("{}:{}: ", at.file(), at.line())).unwrap_or_default();
            PLACE.with_borrow_mut(|kept| *kept = place);
        }));
    });
}

/// Runs `body` and makes a status of a panic.
///
/// # Safety
/// `error` is null or the error struct of the present call.
pub(super) unsafe fn guarded(error: *mut rumbo_error, body: impl FnOnce(&mut rumbo_error) -> i32) -> i32 {
    // SAFETY: as promised by the caller.
    let Some(error) = (unsafe { error.as_mut() }) else { return RUMBO_ERROR };
    match caught(|| body(&mut *error)) {
        Ok(code) => code,
        Err(words) => {
            error.clear();
            error.say(&words);
            RUMBO_PANIC
        }
    }
}

/// Ends an instance of any stage; a panic in its drop goes no further.
///
/// # Safety
/// Called once, on a `Side` that was boxed for the host.
pub(super) unsafe extern "C" fn destroy<Side>(this: *mut c_void) {
    // SAFETY: as promised by the caller.
    let _ = caught(|| drop(unsafe { Box::from_raw(this.cast::<Side>()) }));
}

/// What `body` gives, or the place and words of its panic.
fn caught<T>(body: impl FnOnce() -> T) -> Result<T, String> {
    GUARDED.set(GUARDED.get() + 1);
    let result = catch_unwind(AssertUnwindSafe(body));
    GUARDED.set(GUARDED.get() - 1);
    result.map_err(|payload| {
        let place = PLACE.take();
        let words = format!("{place}{}", words_of(payload.as_ref()));
        // What was thrown may panic again when it is dropped.
        let _ = catch_unwind(AssertUnwindSafe(|| drop(payload)));
        words
    })
}

fn words_of(payload: &(dyn Any + Send)) -> &str {
    let text = payload.downcast_ref::<&str>().copied();
    text.or_else(|| payload.downcast_ref::<String>().map(String::as_str)).unwrap_or("(no message)")
}
