//! One instance of a dynamic plugin, and how it is called.
#![allow(unsafe_code)]

use super::super::abi::*;
use super::super::says_other::SaysOther;
use super::super::status::Crosses;
use crate::rng::Rng;
use crate::stages::{Cx, GiveUp};
use crate::time::Time;
use crate::trace::Trace;
use std::ffi::c_void;
use std::sync::{Arc, OnceLock};

/// Which plugin of which file, for messages.
#[derive(Debug, Clone)]
pub(super) struct Who {
    /// Its name in a pipeline.
    pub name: String,
    /// The file that it comes from.
    pub origin: String,
}

impl std::fmt::Display for Who {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "plugin `{}` of {}", self.name, self.origin)
    }
}

/// A plugin's instance. Once it panicked, nothing but `destroy` is called again.
pub(super) struct Instance {
    this: *mut c_void,
    destroy: Option<unsafe extern "C" fn(*mut c_void)>,
    who: Who,
    poisoned: OnceLock<String>,
    error: Box<rumbo_error>,
    // What was handed over when the instance was made and lives as long as it.
    _rng: Box<Rng>,
    _abort: Arc<GiveUp>,
}

// SAFETY: the ABI asks of plugins that an instance may move between threads while one at a time uses it.
unsafe impl Send for Instance {}

/// What an instance is handed when it is made and keeps.
pub(super) struct Kept {
    /// Its random stream.
    pub rng: Box<Rng>,
    /// Raised when all work shall stop.
    pub abort: Arc<GiveUp>,
}

impl Instance {
    /// Takes over what `create` made.
    pub fn new(
        this: *mut c_void,
        destroy: Option<unsafe extern "C" fn(*mut c_void)>,
        who: Who,
        kept: Kept,
    ) -> Instance {
        let error = Box::new(rumbo_error::none());
        Instance { this, destroy, who, poisoned: OnceLock::new(), error, _rng: kept.rng, _abort: kept.abort }
    }

    /// Calls one of its functions.
    pub fn call<E: Crosses + SaysOther>(
        &mut self,
        function: impl FnOnce(*mut c_void, *mut rumbo_error) -> i32,
    ) -> Result<(), E> {
        self.refuse_poisoned()?;
        self.error.clear();
        let code = function(self.this, &raw mut *self.error);
        settle(code, &mut self.error, &self.who, &self.poisoned)
    }

    /// As [`call`](Self::call) for a function that only looks, of an instance that others may look at too.
    pub fn look<E: Crosses + SaysOther>(
        &self,
        function: impl FnOnce(*const c_void, *mut rumbo_error) -> i32,
    ) -> Result<(), E> {
        self.refuse_poisoned()?;
        let mut error = rumbo_error::none();
        let code = function(self.this.cast_const(), &raw mut error);
        settle(code, &mut error, &self.who, &self.poisoned)
    }

    fn refuse_poisoned<E: SaysOther>(&self) -> Result<(), E> {
        match self.poisoned.get() {
            Some(before) => Err(E::other(format!("{} is not called again: it {before}", self.who))),
            None => Ok(()),
        }
    }

    /// An answer that does not hold together.
    pub fn nonsense(&self, what: impl std::fmt::Display) -> String {
        format!("{} gave an answer that does not hold together: {what}", self.who)
    }
}

/// What a status and its words mean; a panic poisons the instance.
fn settle<E: Crosses + SaysOther>(
    code: i32,
    error: &mut rumbo_error,
    who: &Who,
    poisoned: &OnceLock<String>,
) -> Result<(), E> {
    match code {
        RUMBO_OK => Ok(()),
        RUMBO_PANIC => {
            let what = format!("panicked: {}", error.words(RUMBO_PANIC));
            let told = E::other(format!("{who} {what}"));
            let _ = poisoned.set(what);
            Err(told)
        }
        code => {
            if error.message().is_empty() {
                error.say(&format!("{who} failed with status {code} and said nothing"));
            }
            Err(E::from_code(code, error))
        }
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        if let Some(destroy) = self.destroy {
            // SAFETY: called once, on the pointer that `create` gave.
            unsafe { destroy(self.this) };
        }
    }
}

/// A view of what every call gets.
pub(super) fn lend_cx(cx: &Cx<'_>) -> rumbo_call {
    lend_call(cx.now, cx.trace)
}

/// The same from its parts.
pub(super) fn lend_call(now: Time, trace: &Trace) -> rumbo_call {
    rumbo_call {
        size: size_of::<rumbo_call>(),
        now_ns: now.0,
        trace: std::ptr::from_ref(trace).cast_mut().cast(),
        is_watched: trace.is_counting().into(),
        reserved: 0,
    }
}

/// What a plugin pushes, one after the other.
pub(super) struct Pushed<T> {
    /// What has come.
    pub items: Vec<T>,
    /// More than anybody can mean.
    is_too_much: bool,
    /// A list that points nowhere.
    is_broken: bool,
}

/// Bytes at most: a plugin that pushes for ever must not eat the memory.
const MOST_PUSHED: usize = 64 << 20;

impl<T: Copy> Pushed<T> {
    /// Nothing yet.
    pub fn new() -> Pushed<T> {
        Pushed { items: Vec::new(), is_too_much: false, is_broken: false }
    }

    /// Forgets everything; hands out the pointer for `push`.
    pub fn begin(&mut self) -> *mut c_void {
        self.items.clear();
        (self.is_too_much, self.is_broken) = (false, false);
        std::ptr::from_mut(self).cast()
    }

    /// What is wrong with what was pushed, if anything.
    pub fn fault(&self, what: &str) -> Option<String> {
        match (self.is_too_much, self.is_broken) {
            (true, _) => Some(format!("{what} without end (more than {} MB)", MOST_PUSHED >> 20)),
            (_, true) => Some(format!("{what} that points nowhere")),
            _ => None,
        }
    }

    /// Appends: what the `push` of the ABI's outputs does.
    ///
    /// # Safety
    /// `ctx` came from `begin` of a live `Pushed<T>`, and `first` points to `len` elements.
    pub unsafe extern "C" fn push(ctx: *mut c_void, first: *const T, len: usize) {
        // SAFETY: as promised by the caller.
        unsafe {
            let Some(pushed) = ctx.cast::<Pushed<T>>().as_mut() else { return };
            let Ok(items) = super::super::convert::slice(first, len) else {
                pushed.is_broken = true;
                return;
            };
            if pushed.is_too_much || size_of_val(items) + size_of_val(pushed.items.as_slice()) > MOST_PUSHED {
                pushed.is_too_much = true;
                pushed.items = Vec::new();
            } else {
                pushed.items.extend_from_slice(items);
            }
        }
    }
}

/// As `Pushed::push` for bytes.
///
/// # Safety
/// `ctx` came from `begin` of a live `Pushed<u8>`, and the view is alive.
pub(super) unsafe extern "C" fn push_bytes(ctx: *mut c_void, bytes: rumbo_str) {
    // SAFETY: as promised by the caller.
    unsafe { Pushed::<u8>::push(ctx, bytes.data.cast(), bytes.len) };
}
