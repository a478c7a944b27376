//! Every plugin that we ship, through the boundary: the same runs to the bit, the same files, the same messages.
//!
//! Both sides sit in this one program; what is loaded from files has tests of its own.

use rayon::prelude::*;
use rumbo::load;
use rumbo_core::boundary::abi::{rumbo_host, rumbo_module};
use rumbo_core::boundary::export::{Exporter, module};
use rumbo_core::boundary::host::Library;
use rumbo_core::engine::{Engine, Observer, RunEnd, StepView};
use rumbo_core::messages::{Data, Observation};
use rumbo_core::registry::{Registry, Stage};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

const OURS: Exporter = Exporter {
    packages: &[
        "rumbo-sensors",
        "rumbo-maps",
        "rumbo-localizers",
        "rumbo-slam",
        "rumbo-planners",
        "rumbo-avoiders",
    ],
    crate_info: "ours 1.0.0",
    unwinds: true,
};

unsafe extern "C" fn ours(host: *const rumbo_host) -> *const rumbo_module {
    unsafe { module(host, OURS) }
}

/// Worlds that are linked in, everything else through the boundary.
fn through_the_boundary() -> Registry {
    let mut registry = Registry::default();
    registry.add_library(&unsafe { Library::of_function(ours, "ours") }.unwrap()).unwrap();
    let linked = rumbo::registry().unwrap();
    assert_eq!(
        registry.iter().count() + linked.of_stage(Stage::World).count(),
        linked.iter().count(),
        "all but worlds cross"
    );
    registry.add_stage_of(&linked, Stage::World);
    registry
}

/// Everything that an observer can see, as text to the bit.
#[derive(Default)]
struct Diary(String);

impl Observer for Diary {
    fn on_step(&mut self, view: &StepView<'_>) {
        use std::fmt::Write as _;
        writeln!(self.0, "{} {:?} {:?}", view.now, view.command, view.estimate).unwrap();
        for seen in view.observations {
            writeln!(self.0, "  {:?} {:?} {}", seen.sensor, seen.stamp, checksum(seen)).unwrap();
        }
        if let Some(grid) = &view.map.grid
            && view.step.is_multiple_of(500)
        {
            writeln!(self.0, "  map {}", sum(grid.cells.iter().map(|c| c.to_bits()))).unwrap();
        }
        for event in view.events {
            writeln!(self.0, "  {} {}", event.stamp, event.kind).unwrap();
        }
        if let Some(path) = view.path {
            write!(self.0, " {:x}", path.points().len() as u64 ^ path.cost.to_bits()).unwrap();
        }
    }
}

fn sum(bits: impl Iterator<Item = u32>) -> u64 {
    bits.fold(7, |sum: u64, bits| sum.wrapping_mul(0x0100_0000_01b3) ^ u64::from(bits))
}

fn checksum(seen: &Observation) -> u64 {
    match &seen.data {
        Data::LaserScan(scan) => sum(scan.ranges_m.iter().map(|r| r.to_bits())),
        other => sum(format!("{other:?}").bytes().map(u32::from)),
    }
}

/// So much of the world's time is enough for every part of a pipeline to speak; with `RUMBO_WHOLE` in the environment, as in the
/// checks that take long, runs go on to their end.
const LIMIT_S: f64 = 30.0;

fn run(file: &Path, registry: &Registry) -> (String, RunEnd) {
    let mut ready =
        load::load(file, &[], registry).unwrap_or_else(|_| panic!("{} has faults", file.display()));
    if std::env::var_os("RUMBO_WHOLE").is_none() {
        ready.limit(LIMIT_S);
    }
    let mut engine = Engine::build(&ready.pipeline).unwrap();
    let mut diary = Diary::default();
    let end = engine.run(&mut [&mut diary], &AtomicBool::new(false));
    (diary.0, end)
}

fn runs_the_same(file: &Path, linked: &Registry, dynamic: &Registry) {
    let (expected, end) = run(file, linked);
    let (found, found_end) = run(file, dynamic);
    if let Some((a, b)) = expected.lines().zip(found.lines()).find(|(a, b)| a != b) {
        panic!("{}:\nlinked  {a}\ndynamic {b}", file.display());
    }
    assert_eq!((expected.len(), end), (found.len(), found_end), "{}", file.display());
    assert!(expected.len() > 10_000);
}

#[test]
fn every_shipped_pipeline_runs_the_same_through_the_boundary_to_the_bit() {
    let (linked, dynamic) = (rumbo::registry().unwrap(), through_the_boundary());
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines");
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|file| {
        // In real time no run is the same as another.
        file.extension().is_some_and(|e| e == "toml")
            && !std::fs::read_to_string(file).unwrap().contains("plugin = \"robot\"")
    });
    assert!(files.len() >= 5, "only {} pipelines", files.len());
    // This is the longest test of its program: when all others are over it still has both processors to run on.
    files.par_iter().for_each(|file| runs_the_same(file, &linked, &dynamic));
}

#[test]
fn entries_say_the_same_through_the_boundary() {
    let (linked, dynamic) = (rumbo::registry().unwrap(), through_the_boundary());
    for (a, b) in linked.iter().zip(dynamic.iter()) {
        assert_eq!((a.stage, &a.name, &a.summary, &a.version), (b.stage, &b.name, &b.summary, &b.version));
        assert_eq!(a.source.schema(), b.source.schema(), "{}", a.name);
        assert_eq!(a.source.defaults(), b.source.defaults(), "{}", a.name);
        let parse = |keys: &str| {
            let keys: toml::Table = toml::from_str(keys).unwrap();
            (a.source.parse(keys.clone()), b.source.parse(keys))
        };
        let (Ok(x), Ok(y)) = parse("") else { panic!("{} does not take its defaults", a.name) };
        assert_eq!(x.manifest(), y.manifest(), "{}", a.name);
        assert_eq!(x.parameters(), y.parameters(), "{}", a.name);
        assert_eq!(x.check(), y.check(), "{}", a.name);
        let (x, y) = parse("no_such_key = 1");
        assert_eq!(x.err(), y.err(), "{}", a.name);
    }
}
