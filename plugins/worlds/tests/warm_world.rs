//! A warm simulation allocates nothing.
//!
//! Its own test program, since the counting allocator counts for the whole process.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs, unsafe_code)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use rumbo_core::frames::{Pose3, Twist};
use rumbo_core::messages::{Command, Intrinsics};
use rumbo_core::registry::Plugin;
use rumbo_core::stages::{Answer, BuildContext, Probe, World};
use rumbo_core::time::Time;
use rumbo_worlds::sim::{SimParams, Start, Sway};

struct Counting;
static ALLOCATIONS: AtomicU64 = AtomicU64::new(0);

// SAFETY: passes every call on to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        unsafe { System.dealloc(block, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// One tenth of a second: drives, looks at everything a sensor may ask for.
fn tick(world: &mut dyn World, number: i64) {
    world.drive(&Command { twist: Twist::new(0.3, 0.4), ..Command::default() }).unwrap();
    world.advance(Time(number * 100_000_000)).unwrap();
    let level = Pose3::translation(0.1, 0.0, 0.3);
    let tilted = level * nalgebra::UnitQuaternion::from_euler_angles(0.0, 0.3, 0.0);
    for base_from_sensor in [&level, &tilted] {
        let beams = Probe::Beams {
            base_from_sensor,
            first_bearing_rad: -1.5,
            bearing_step_rad: 0.01,
            n_beams: 301,
            max_range_m: 8.0,
        };
        assert!(matches!(world.probe(&beams), Ok(Answer::Ranges(ranges)) if ranges.len() == 301));
    }
    let bearings_rad = &[0.0, 0.4, -0.4];
    let (cone_rad, ring_radius_m, max_range_m) = (0.4, 0.2, 5.0);
    let cones = Probe::Cones { base_from_sensor: &level, bearings_rad, cone_rad, ring_radius_m, max_range_m };
    assert!(world.probe(&cones).is_ok());
    let intrinsics = &Intrinsics { width: 32, height: 24, focal_px: [30.0, 30.0], center_px: [16.0, 12.0] };
    assert!(world.probe(&Probe::Depth { base_from_sensor: &level, intrinsics, max_range_m }).is_ok());
    let _ = world.probe(&Probe::Person { name: "nobody" });
    for probe in [Probe::Wheels, Probe::Attitude, Probe::Position, Probe::Contacts] {
        assert!(world.probe(&probe).is_ok());
    }
}

/// One test: two would count each other's allocations.
#[test]
fn a_warm_world_with_people_or_slopes_allocates_nothing() {
    let worlds = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pipelines/worlds");
    let start = Start { x_m: 4.0, y_m: 8.0, yaw_deg: 0.0 };
    let people = SimParams { map: Some(worlds.join("office_people.toml")), start, ..SimParams::default() };
    let hill = "ramp = [{ center = [4.0, 8.5], size = [3.0, 3.0], z_to_m = 0.5 }]";
    let add = toml::from_str(&format!("{hill}\nwall = [{{ from = [-1, 0], to = [9, 0] }}]")).ok();
    let slopes = SimParams {
        add,
        sway: Some(Sway { roll_deg: 5.0, ..Sway::default() }),
        start,
        ..SimParams::default()
    };
    for params in [people, slopes] {
        let mut world = params.build(&BuildContext::bare("world")).unwrap();
        (1..20).for_each(|number| tick(&mut *world, number));
        let before = ALLOCATIONS.load(Ordering::Relaxed);
        (20..120).for_each(|number| tick(&mut *world, number));
        assert_eq!(ALLOCATIONS.load(Ordering::Relaxed) - before, 0);
    }
}
