//! Both sides of the plugin boundary in one program: what goes in comes out on the other side, to the bit, and what
//! goes wrong there stays there. Without a library to load, Miri can run all of this.
#![allow(unsafe_code, missing_docs, clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod crossing;
mod doubles;
mod faults;
mod sensing;
mod worlds;

use rumbo_core::boundary::abi::{rumbo_host, rumbo_module};
use rumbo_core::boundary::export::{Exporter, module};
use rumbo_core::boundary::host::Library;
use rumbo_core::registry::{Built, Registry, Stage};
use rumbo_core::stages::{BuildContext, BuildError};

const EXPORTER: Exporter =
    Exporter { packages: &[env!("CARGO_PKG_NAME")], crate_info: "doubles 0.0.0", unwinds: true };

unsafe extern "C" fn entry(host: *const rumbo_host) -> *const rumbo_module {
    unsafe { module(host, EXPORTER) }
}

/// The doubles, through the boundary.
fn registry() -> Registry {
    let mut registry = Registry::default();
    registry.add_library(&unsafe { Library::of_function(entry, "doubles.so") }.unwrap()).unwrap();
    registry
}

fn build(stage: Stage, name: &str, keys: &str) -> Result<Built, BuildError> {
    let registry = registry();
    let entry = registry.get(stage, name).unwrap();
    let configured = entry.source.parse(toml::from_str(keys).unwrap()).expect("keys are understood");
    configured.build(&BuildContext::bare("under_test"))
}

fn stage<T: TryFrom<Built, Error = BuildError>>(of: Stage, name: &str) -> T {
    build(of, name, "").and_then(T::try_from).unwrap()
}
