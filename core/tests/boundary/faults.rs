//! What goes wrong on the plugin's side stays there.

use crate::crossing::request;
use crate::doubles::desk;
use crate::worlds::{Rich, everything, full_estimate, full_map};
use crate::{EXPORTER, build, stage};
use rumbo_core::boundary::abi::*;
use rumbo_core::boundary::export::{Exporter, module};
use rumbo_core::boundary::host::{Library, ModuleError};
use rumbo_core::messages::{Observations, Seen};
use rumbo_core::registry::{Built, Stage};
use rumbo_core::stages::*;
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;
use std::sync::Mutex;

const CALL: &str = "panic_in_call = true";

#[test]
fn a_panic_in_create_is_an_error_with_place_and_words() {
    for of in
        [Stage::Planner, Stage::Avoider, Stage::Localizer, Stage::MapBuilder, Stage::Slam, Stage::Sensor]
    {
        let error = build(of, "double", "panic_in_create = true").err().unwrap().to_string();
        assert!(error.contains("plugin `double` of doubles.so panicked"), "{error}");
        assert!(error.contains("doubles.rs:") && error.contains("made to panic in create"), "{error}");
    }
}

#[test]
fn an_instance_that_panicked_is_never_called_again_but_dropped() {
    let Ok(Built::Planner(mut planner)) = build(Stage::Planner, "double", CALL) else { panic!("not built") };
    let first = planner.plan(&request()).unwrap_err().to_string();
    assert!(
        first.contains("plugin `double` of doubles.so panicked") && first.contains("in a call"),
        "{first}"
    );
    desk(|desk| (desk.dropped, desk.map) = (0, None));
    let second = planner.plan(&request()).unwrap_err().to_string();
    assert!(second.contains("is not called again"), "{second}");
    desk(|desk| assert!(desk.map.is_none() && desk.dropped == 0));
    drop(planner);
    desk(|desk| assert_eq!(desk.dropped, 1));
}

#[test]
fn a_panic_in_any_stage_is_an_error_of_that_stage() {
    let trace = Trace::unwatched();
    let mut cx = Cx { now: Time(5), trace: &trace };
    let (mut map, seen) = (full_map(), everything());
    let says = |error: String| assert!(error.contains("made to panic in a call"), "{error}");
    match build(Stage::Localizer, "double", CALL) {
        Ok(Built::Localizer(mut stage)) => {
            says(stage.update(&mut cx, Seen::sorted(&seen), &map).unwrap_err().to_string());
        }
        _ => panic!("not built"),
    }
    match build(Stage::MapBuilder, "double", CALL) {
        Ok(Built::MapBuilder(mut stage)) => {
            let estimate = full_estimate();
            let input = MapInput { seen: Seen::sorted(&seen), estimate: &estimate };
            says(stage.insert(&mut cx, &input, &mut map).unwrap_err().to_string());
            // The map came back, with what was written before the panic.
            assert_eq!(map.version, 42);
            assert_eq!(map.coarse_grids.len(), 3);
        }
        _ => panic!("not built"),
    }
    match build(Stage::Slam, "double", CALL) {
        Ok(Built::Slam(mut stage)) => {
            says(stage.update(&mut cx, Seen::sorted(&seen), &mut map).unwrap_err().to_string());
            assert!(map.grid.is_some());
        }
        _ => panic!("not built"),
    }
    match build(Stage::Sensor, "double", CALL) {
        Ok(Built::Sensor(mut stage)) => {
            let mut out = Observations::default();
            says(stage.poll(&mut cx, &mut Rich::new(), &mut out).unwrap_err().to_string());
        }
        _ => panic!("not built"),
    }
}

#[test]
fn a_panic_in_drop_goes_no_further() {
    desk(|desk| desk.dropped = 0);
    drop(build(Stage::Localizer, "double", "panic_in_drop = true").ok().unwrap());
    desk(|desk| assert_eq!(desk.dropped, 1));
}

/// A record that lives as long as the program, where a leak check can find it.
fn kept(record: rumbo_module) -> *const rumbo_module {
    struct Kept(#[expect(dead_code)] *const rumbo_module);
    unsafe impl Send for Kept {}
    static KEPT: Mutex<Vec<Kept>> = Mutex::new(Vec::new());
    let at: *const rumbo_module = Box::into_raw(Box::new(record));
    KEPT.lock().unwrap().push(Kept(at));
    at
}

fn refused(function: unsafe extern "C" fn(*const rumbo_host) -> *const rumbo_module) -> ModuleError {
    unsafe { Library::of_function(function, "odd.so") }.unwrap_err()
}

#[test]
fn a_library_that_would_abort_is_refused() {
    unsafe extern "C" fn aborts(host: *const rumbo_host) -> *const rumbo_module {
        let good = unsafe { *module(host, Exporter { ..EXPORTER }) };
        kept(rumbo_module { flags: 0, ..good })
    }
    let error = refused(aborts);
    assert_eq!(error, ModuleError::Aborts);
    assert!(error.to_string().contains("panic = \"unwind\""));
}

#[test]
fn records_that_do_not_hold_together_are_refused_before_anything_is_called() {
    unsafe extern "C" fn nothing(_: *const rumbo_host) -> *const rumbo_module {
        std::ptr::null()
    }
    unsafe extern "C" fn magic(host: *const rumbo_host) -> *const rumbo_module {
        let good = unsafe { *module(host, EXPORTER) };
        kept(rumbo_module { magic: 7, ..good })
    }
    unsafe extern "C" fn major(host: *const rumbo_host) -> *const rumbo_module {
        let good = unsafe { *module(host, EXPORTER) };
        kept(rumbo_module { abi_major: 2, abi_minor: 3, ..good })
    }
    unsafe extern "C" fn small(host: *const rumbo_host) -> *const rumbo_module {
        let good = unsafe { *module(host, EXPORTER) };
        kept(rumbo_module { size: 16, ..good })
    }
    unsafe extern "C" fn more(host: *const rumbo_host) -> *const rumbo_module {
        let good = unsafe { *module(host, EXPORTER) };
        kept(rumbo_module { n_entries: good.n_entries + 1, ..good })
    }
    unsafe extern "C" fn fewer(host: *const rumbo_host) -> *const rumbo_module {
        let good = unsafe { *module(host, EXPORTER) };
        kept(rumbo_module { n_entries: good.n_entries - 1, ..good })
    }
    unsafe extern "C" fn countless(host: *const rumbo_host) -> *const rumbo_module {
        let good = unsafe { *module(host, EXPORTER) };
        kept(rumbo_module { n_entries: usize::MAX, ..good })
    }
    assert_eq!(refused(nothing), ModuleError::Refused);
    assert_eq!(refused(magic), ModuleError::Magic { found: 7 });
    assert_eq!(refused(major), ModuleError::Major { found_major: 2, found_minor: 3 });
    assert!(refused(major).to_string().contains("2.3"));
    assert!(matches!(refused(small), ModuleError::Size { found: 16, .. }));
    assert!(matches!(refused(more), ModuleError::Count { says, .. } if says > 6));
    assert!(matches!(refused(fewer), ModuleError::Count { .. }));
    assert!(matches!(refused(countless), ModuleError::Count { says: usize::MAX, .. }));
}

#[test]
fn a_plugin_refuses_a_host_of_another_major_and_an_older_one() {
    let ours = stage::<Box<dyn Planner>>(Stage::Planner, "double");
    drop(ours);
    unsafe extern "C" fn asks_wrongly(host: *const rumbo_host) -> *const rumbo_module {
        let newer = rumbo_host { abi_major: 2, ..unsafe { *host } };
        let smaller = rumbo_host { size: 40, ..unsafe { *host } };
        unsafe {
            assert!(module(&raw const newer, EXPORTER).is_null());
            assert!(module(&raw const smaller, EXPORTER).is_null());
            assert!(module(std::ptr::null(), EXPORTER).is_null());
            module(host, EXPORTER)
        }
    }
    assert!(unsafe { Library::of_function(asks_wrongly, "asks.so") }.is_ok());
}
