//! The plugin's side: registered Rust plugins become the entries of a library's module record.
//!
//! The author writes the same plugin as one that is linked into the program, and one line in the root of a `cdylib`
//! crate: `rumbo_core::export_plugins!();`. Panics end here: they become a status that the host understands.
#![allow(unsafe_code)]

mod avoider;
mod call;
mod context;
mod entry;
mod guard;
mod localizer;
mod map_builder;
mod map_taken;
mod planner;
mod sensor;
mod slam;
mod world;

pub(crate) use call::HostFlag;
pub(crate) use world::HostLender;

use super::abi::*;
use super::buffer::allocate_with;
use super::convert::text_of;
use crate::registry::{Linked, Stage};
use std::ffi::c_void;
use std::sync::OnceLock;

/// The host that loaded this library.
static HOST: OnceLock<&'static rumbo_host> = OnceLock::new();

/// The host's functions.
pub(super) fn host() -> Option<&'static rumbo_host> {
    HOST.get().copied()
}

/// Says something through the program that loaded this plugin; false where this is that program.
pub(super) fn log_to_host(level: u32, target: &str, message: &str) -> bool {
    let Some(host) = host() else { return false };
    // SAFETY: a function of the host, with views that live until it returns.
    unsafe { (host.log)(level, text_of(target), text_of(message)) };
    true
}

/// What an author's crate says about itself.
#[derive(Debug, Clone, Copy)]
pub struct Exporter {
    /// Packages whose plugins are handed out.
    pub packages: &'static [&'static str],
    /// Name and version of the crate.
    pub crate_info: &'static str,
    /// Panics unwind, so that they can be caught.
    pub unwinds: bool,
}

struct Module(rumbo_module);
// SAFETY: the record and what it points to is written once and lives as long as the program.
unsafe impl Send for Module {}
// SAFETY: as above.
unsafe impl Sync for Module {}

/// What the entry function of a library does: null where the host is too old.
///
/// # Safety
/// `table` is null or points to the table of a host, which lives as long as the program.
pub unsafe fn module(table: *const rumbo_host, exporter: Exporter) -> *const rumbo_module {
    static MODULE: OnceLock<Module> = OnceLock::new();
    // SAFETY: as promised by the caller.
    let Some(found) = (unsafe { table.as_ref() }) else { return std::ptr::null() };
    if found.abi_major != RUMBO_ABI_MAJOR || found.size < size_of::<rumbo_host>() {
        return std::ptr::null();
    }
    guard::quiet();
    let host = *HOST.get_or_init(|| found);
    allocate_with(host.block_new);
    &raw const MODULE.get_or_init(|| Module(record(exporter))).0
}

/// Everything in it is leaked: a library is never unloaded.
fn record(exporter: Exporter) -> rumbo_module {
    let mut linked: Vec<&'static Linked> = inventory::iter::<Linked>
        .into_iter()
        .filter(|linked| exporter.packages.contains(&linked.package) && linked.stage != Stage::World)
        .collect();
    linked.sort_by_key(|linked| (linked.stage, linked.name));
    let mut entries: Vec<*const rumbo_entry> = linked
        .iter()
        .map(|linked| std::ptr::from_ref::<rumbo_entry>(Box::leak(Box::new(entry_of(linked)))))
        .collect();
    let n_entries = entries.len();
    entries.push(std::ptr::null());
    rumbo_module {
        magic: RUMBO_MAGIC,
        size: size_of::<rumbo_module>(),
        abi_major: RUMBO_ABI_MAJOR,
        abi_minor: RUMBO_ABI_MINOR,
        flags: if exporter.unwinds { RUMBO_CATCHES } else { 0 },
        build_info: leaked(format!(
            "{}, rumbo-core {}, {}",
            exporter.crate_info,
            env!("CARGO_PKG_VERSION"),
            env!("RUMBO_RUSTC"),
        )),
        n_entries,
        entries: Box::leak(entries.into_boxed_slice()).as_ptr(),
    }
}

fn leaked(text: String) -> rumbo_str {
    text_of(Box::leak(text.into_boxed_str()))
}

fn entry_of(linked: &'static Linked) -> rumbo_entry {
    let source = (linked.source)();
    let (stage, table): (u32, *const c_void) = match linked.stage {
        Stage::Sensor => (RUMBO_SENSOR, (&raw const sensor::TABLE).cast()),
        Stage::MapBuilder => (RUMBO_MAP_BUILDER, (&raw const map_builder::TABLE).cast()),
        Stage::Localizer => (RUMBO_LOCALIZER, (&raw const localizer::TABLE).cast()),
        Stage::Slam => (RUMBO_SLAM, (&raw const slam::TABLE).cast()),
        Stage::Planner => (RUMBO_PLANNER, (&raw const planner::TABLE).cast()),
        Stage::Avoider => (RUMBO_AVOIDER, (&raw const avoider::TABLE).cast()),
        Stage::World => (0, std::ptr::null()),
    };
    rumbo_entry {
        size: size_of::<rumbo_entry>(),
        stage,
        reserved: 0,
        name: text_of(linked.name),
        version: text_of(linked.version),
        summary: text_of(linked.summary),
        schema_json: leaked(source.schema().to_string()),
        defaults_toml: leaked(source.defaults().to_string()),
        user: std::ptr::from_ref(linked).cast(),
        table,
        create: Some(entry::create),
        manifest: Some(entry::manifest),
        check: Some(entry::check),
        parameters: Some(entry::parameters),
    }
}

/// Hands this crate's registered plugins to whoever loads the library: the one line that makes a `cdylib` of them.
///
/// `export_plugins!()` takes the plugins of the crate itself; `export_plugins!("some-package", ...)` those of the packages
/// named, which must be linked in (`use some_package as _;`).
#[macro_export]
macro_rules! export_plugins {
    () => {
        $crate::export_plugins!(env!("CARGO_PKG_NAME"));
    };
    ($($package:expr),+ $(,)?) => {
        /// The entry point of this plugin library.
        ///
        /// # Safety
        /// `host` is null or points to the table of a host.
        #[allow(unsafe_code)]
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn rumbo_plugin_entry_v1(
            host: *const $crate::boundary::abi::rumbo_host,
        ) -> *const $crate::boundary::abi::rumbo_module {
            let exporter = $crate::boundary::export::Exporter {
                packages: &[$($package),+],
                crate_info: concat!(env!("CARGO_PKG_NAME"), " ", env!("CARGO_PKG_VERSION")),
                unwinds: cfg!(panic = "unwind"),
            };
            // SAFETY: handed on as it came.
            unsafe { $crate::boundary::export::module(host, exporter) }
        }
    };
}
