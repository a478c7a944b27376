//! The functions of an entry: they look up the registered plugin and ask it.
#![allow(unsafe_code)]

use super::super::abi::*;
use super::super::convert::{cut_into, manifest_of, read, str_from, text_of, write_sized};
use super::super::status::Crosses as _;
use super::call::bad;
use super::context::context_from;
use super::guard::guarded;
use super::{avoider, localizer, map_builder, planner, sensor, slam};
use crate::registry::{Built, Configured, Linked, ParseFault};
use std::ffi::c_void;

/// The plugin with the parameters that the pipeline gives.
///
/// # Safety
/// `entry` is one of ours, and `config` the one of the present call.
unsafe fn configured(
    entry: *const rumbo_entry,
    config: *const rumbo_config,
) -> Result<Box<dyn Configured>, ParseFault> {
    let fault = |message: &str| ParseFault { path: String::new(), message: message.to_owned() };
    // SAFETY: as promised by the caller; the field was filled with a registered plugin.
    let linked = unsafe { read(entry).and_then(|entry| entry.user.cast::<Linked>().as_ref()) };
    let linked = linked.ok_or_else(|| fault("the host asks for an entry that is none of ours"))?;
    // SAFETY: as promised by the caller.
    let text = unsafe { read(config).and_then(|config| str_from(config.toml)) };
    let text = text.ok_or_else(|| fault("the host gave parameters that are no UTF-8"))?;
    let keys = toml::from_str(text).map_err(|e| fault(e.message()))?;
    (linked.source)().parse(keys)
}

/// Writes a fault of the parameters.
fn refuse(fault: &ParseFault, error: &mut rumbo_error) -> i32 {
    error.clear();
    cut_into(&mut error.path, &fault.path);
    error.say(&fault.message);
    RUMBO_BAD_CONFIG
}

/// Answers one of the host's questions about a plugin with parameters, or says what is wrong with them.
///
/// # Safety
/// All three belong to the present call, and `entry` is one of ours.
unsafe fn answered(
    entry: *const rumbo_entry,
    config: *const rumbo_config,
    error: *mut rumbo_error,
    answer: impl FnOnce(&dyn Configured, &mut rumbo_error) -> i32,
) -> i32 {
    // SAFETY: as promised by the caller.
    unsafe {
        guarded(error, |error| match configured(entry, config) {
            Ok(configured) => answer(configured.as_ref(), error),
            Err(fault) => refuse(&fault, error),
        })
    }
}

/// Makes an instance.
pub(super) unsafe extern "C" fn create(
    entry: *const rumbo_entry,
    _host: *const rumbo_host,
    config: *const rumbo_config,
    context: *const rumbo_context,
    instance: *mut *mut c_void,
    error: *mut rumbo_error,
) -> i32 {
    // SAFETY: for all blocks below: what the host hands over for this call.
    unsafe {
        answered(entry, config, error, |configured, error| {
            let context = match context_from(context) {
                Ok(context) => context,
                Err(view) => return bad(&view, error),
            };
            let this = match configured.build(&context) {
                Ok(Built::Planner(stage)) => planner::this(stage, context.robot),
                Ok(Built::Avoider(stage)) => avoider::this(stage, context.robot),
                Ok(Built::Localizer(stage)) => localizer::this(stage),
                Ok(Built::MapBuilder(stage)) => map_builder::this(stage),
                Ok(Built::Slam(stage)) => slam::this(stage),
                Ok(Built::Sensor(stage)) => sensor::this(stage),
                Ok(Built::World(_)) => return RUMBO_UNSUPPORTED,
                Err(fault) => return fault.cross(error),
            };
            match instance.is_null() {
                true => RUMBO_ERROR,
                false => {
                    instance.write(this);
                    RUMBO_OK
                }
            }
        })
    }
}

/// What it needs and gives.
pub(super) unsafe extern "C" fn manifest(
    entry: *const rumbo_entry,
    config: *const rumbo_config,
    out: *mut rumbo_manifest,
    error: *mut rumbo_error,
) -> i32 {
    // SAFETY: what the host hands over for this call.
    unsafe {
        answered(entry, config, error, |configured, _| {
            write_sized(out, &manifest_of(&configured.manifest()));
            RUMBO_OK
        })
    }
}

/// Every impossible value.
pub(super) unsafe extern "C" fn check(
    entry: *const rumbo_entry,
    config: *const rumbo_config,
    faults: *mut rumbo_fault_out,
    error: *mut rumbo_error,
) -> i32 {
    // SAFETY: what the host hands over for this call.
    unsafe {
        answered(entry, config, error, |configured, _| {
            let Some((out, push)) = read(faults).and_then(|out| Some((out, out.push?))) else {
                return RUMBO_ERROR;
            };
            for fault in configured.check() {
                let help = fault.help.as_deref().unwrap_or_default();
                push(out.ctx, text_of(&fault.path), text_of(&fault.message), text_of(help));
            }
            RUMBO_OK
        })
    }
}

/// All parameters as TOML.
pub(super) unsafe extern "C" fn parameters(
    entry: *const rumbo_entry,
    config: *const rumbo_config,
    text: *mut rumbo_bytes_out,
    error: *mut rumbo_error,
) -> i32 {
    // SAFETY: what the host hands over for this call.
    unsafe {
        answered(entry, config, error, |configured, _| {
            let Some((out, push)) = read(text).and_then(|out| Some((out, out.push?))) else {
                return RUMBO_ERROR;
            };
            push(out.ctx, text_of(&configured.parameters().to_string()));
            RUMBO_OK
        })
    }
}
