//! Laws of map builders: their layers, from what was seen, the same from every side.

use super::drive::{Drive, Frame, N_FRAMES, observation, step_time};
use super::law::{Law, Trouble, Verdict, expect};
use super::memory::stays_finite;
use super::subject::Subject;
use super::text_world::TextWorld;
use super::turn::Turn;
use nalgebra::Matrix3;
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Point2, Pose2, pose2};
use rumbo_core::map::{CellClass, Layer, Map};
use rumbo_core::messages::{Data, Estimate, LaserScan, Observation, Seen};
use rumbo_core::stages::{Cx, MapBuilder, MapError, MapInput};
use rumbo_core::trace::Trace;

/// What every map builder keeps.
pub const LAWS: &[Law] = &[
    Law::new("it gives the layers that it declares", gives_its_layers),
    Law::new("it leaves other layers alone", leaves_others_alone),
    Law::new("the same drive gives the same map", deterministic).within("to the bit"),
    Law::new("every number of the map is finite", finite),
    Law::new("the map's version goes up with every change", counts_versions),
    Law::new("a world turned or mirrored turns the map with it", symmetric).within("5 % of the known cells"),
    Law::new("it saves the same twice, and goes on as if nobody had asked", saves).within("to the bit"),
    Law::new("it survives empty, impossible and huge scans, and goes on", survives_odd_scans),
    Law::new("it survives impossible and huge poses, and goes on", survives_odd_poses),
    Law::new("10,000 calls use finite memory", finite_memory).within("64 MiB").long(),
];

/// A map builder at work.
struct Work {
    builder: Box<dyn MapBuilder>,
    map: Map,
    trace: Trace,
}

impl Work {
    /// A new builder with its map started.
    fn new(subject: &Subject) -> Result<Work, Trouble> {
        Work::on(subject, Turn::None, Map::default())
    }

    /// One that needs a grid, to write on top of it, gets that of the hall, seen from this side.
    fn on(subject: &Subject, turn: Turn, mut map: Map) -> Result<Work, Trouble> {
        subject.needs_only(&[Layer::Grid])?;
        subject.sees_enough()?;
        if subject.manifest().needs_layers.contains(&Layer::Grid) {
            map.grid = Some(TextWorld::hall()?.turned(turn)?.grid);
        }
        let mut builder: Box<dyn MapBuilder> = subject.build()?;
        let started = builder.start(&mut map);
        started.map_err(|error| Trouble::broken(format!("it does not start: {error}"), "layers"))?;
        Ok(Work { builder, map, trace: Trace::unwatched() })
    }

    fn insert(&mut self, frame: &Frame) -> Result<(), MapError> {
        let sure = Matrix3::identity() * 1e-4;
        let estimate = Estimate::planar(frame.now, frame.map_from_base, frame.odom_from_base, sure);
        let input = MapInput { seen: Seen::sorted(&frame.seen), estimate: &estimate };
        self.builder.insert(&mut Cx { now: frame.now, trace: &self.trace }, &input, &mut self.map)
    }

    fn insert_all(mut self, drive: &Drive) -> Result<Work, Trouble> {
        for frame in &drive.frames {
            let inserted = self.insert(frame);
            inserted.map_err(|error| Trouble::broken(error.to_string(), "what was seen, on the map"))?;
        }
        Ok(self)
    }
}

/// The map of the whole drive, seen from this side.
fn map_of(subject: &Subject, turn: Turn) -> Result<Map, Trouble> {
    Ok(Work::on(subject, turn, Map::default())?.insert_all(&Drive::seen_from(turn)?)?.map)
}

fn gives_its_layers(subject: &Subject) -> Verdict {
    let work = Work::new(subject)?;
    let layers = subject.manifest().gives_layers;
    for layer in &layers {
        let found = || format!("no layer {} after the start", layer.name());
        expect(work.map.has(*layer), found, "every layer that it declares")?;
    }
    Ok(layers.iter().map(|layer| layer.name()).collect::<Vec<_>>().join(", "))
}

fn leaves_others_alone(subject: &Subject) -> Verdict {
    let given = subject.manifest().gives_layers;
    let before = Map {
        lines: Some(Default::default()),
        landmarks: Some(Default::default()),
        voxels: Some(Default::default()),
        ..Map::default()
    };
    let work = Work::on(subject, Turn::None, before.clone())?;
    let after = work.insert_all(&Drive::seen_from(Turn::None)?)?.map;
    for (layer, is_same) in [
        (Layer::Lines, before.lines == after.lines),
        (Layer::Landmarks, before.landmarks == after.landmarks),
        (Layer::Voxels, before.voxels == after.voxels),
        (Layer::Grid, after.grid.is_none()),
    ] {
        let found = || format!("it writes the layer {}", layer.name());
        expect(is_same || given.contains(&layer), found, "only layers that it declares")?;
    }
    Ok(String::new())
}

fn deterministic(subject: &Subject) -> Verdict {
    let (one, other) = (map_of(subject, Turn::None)?, map_of(subject, Turn::None)?);
    expect(one == other, || "two maps of the same drive differ".into(), "the same map")?;
    Ok(String::new())
}

fn finite(subject: &Subject) -> Verdict {
    is_finite("the drive", &map_of(subject, Turn::None)?)?;
    Ok(String::new())
}

fn is_finite(what: &str, map: &Map) -> Result<(), Trouble> {
    let grids = map.grid.iter().chain(&map.coarse_grids);
    let n_bad: usize = grids.map(|grid| grid.cells.iter().filter(|v| !v.is_finite()).count()).sum();
    expect(n_bad == 0, || format!("{what}: {n_bad} cells are not finite"), "finite numbers")
}

fn counts_versions(subject: &Subject) -> Verdict {
    let mut work = Work::new(subject)?;
    for frame in &Drive::seen_from(Turn::None)?.frames {
        let before = work.map.clone();
        // Errors are judged by another law.
        let _ = work.insert(frame);
        let is_changed = Map { version: before.version, ..work.map.clone() } != before;
        let found = || format!("the map changed at {:.1} s, its version did not", frame.now.as_secs());
        expect(!is_changed || work.map.version > before.version, found, "a version that goes up")?;
    }
    Ok(format!("version {} in the end", work.map.version))
}

fn saves(subject: &Subject) -> Verdict {
    let drive = Drive::seen_from(Turn::None)?;
    let work = Work::new(subject)?.insert_all(&drive)?;
    let save = |work: &Work| -> Result<(Map, Option<Vec<u8>>), Trouble> {
        let mut map = work.map.clone();
        let saved = work.builder.save(&mut map);
        let saved = saved.map_err(|error| Trouble::broken(format!("it does not save: {error}"), "a map"))?;
        is_finite("what it saves", &map)?;
        Ok((map, saved))
    };
    let first = save(&work)?;
    expect(first == save(&work)?, || "it saves something else the second time".into(), "the same twice")?;
    // One that was asked on the way, and one that was not.
    let (before, after) = drive.frames.split_at(drive.frames.len() / 2);
    let part = |frames: &[Frame]| Drive { frames: frames.to_vec(), ..drive.clone() };
    let asked = Work::new(subject)?.insert_all(&part(before))?;
    save(&asked)?;
    let asked = asked.insert_all(&part(after))?;
    let found = || "it saves something else when it was asked half way before".into();
    expect(first == save(&asked)?, found, "the same")?;
    Ok(first
        .1
        .map_or_else(|| "nothing beside the map".into(), |kept| format!("{} bytes beside it", kept.len())))
}

fn symmetric(subject: &Subject) -> Verdict {
    const MOST_SHARE: f64 = 0.05;
    let manifest = subject.manifest();
    if manifest.consumes.is_empty() {
        return Err(Trouble::not_applicable("its map is not made of what is seen"));
    }
    if !manifest.gives_layers.contains(&Layer::Grid) {
        return Err(Trouble::not_applicable("it gives no grid, and only grids are compared here"));
    }
    let world = Drive::seen_from(Turn::None)?.world;
    let height_m = world.height_m();
    let class = |map: &Map, at: Point2| {
        let grid = map.grid.as_ref();
        grid.and_then(|grid| grid.cell_at(at).map(|cell| grid.class(cell))).unwrap_or(CellClass::Unknown)
    };
    let as_is = map_of(subject, Turn::None)?;
    let mut worst = 0f64;
    for turn in Turn::BOTH {
        let turned = map_of(subject, turn)?;
        let (mut n_known, mut n_other) = (0, 0);
        for index in 0..world.grid.cells.len() {
            let at = world.grid.center_of(world.grid.cell_of(index));
            let (here, there) = (class(&as_is, at), class(&turned, turn.point(at, height_m)));
            n_known += usize::from(here != CellClass::Unknown || there != CellClass::Unknown);
            n_other += usize::from(here != there);
        }
        expect(n_known > 0, || "no cell is known after the drive".into(), "a map of what was seen")?;
        let share = n_other as f64 / n_known as f64;
        worst = worst.max(share);
        let found = || format!("{:.1} % of {n_known} cells differ, {}", share * 100.0, turn.name());
        expect(share <= MOST_SHARE, found, format!("at most {} %", MOST_SHARE * 100.0))?;
    }
    Ok(format!("at most {:.2} % of the cells differ", worst * 100.0))
}

fn survives_odd_scans(subject: &Subject) -> Verdict {
    let scans: [(&str, Buffer<f32>, f32); 8] = [
        ("no beams", Buffer::default(), 15.0),
        ("one beam", Buffer::filled(1, 1.0), 15.0),
        ("beams without a reading", Buffer::filled(181, f32::NAN), 15.0),
        ("beams that meet nothing", Buffer::filled(181, f32::INFINITY), 15.0),
        ("beams of 0 m", Buffer::filled(181, 0.0), 15.0),
        ("beams of -1 m", Buffer::filled(181, -1.0), 15.0),
        ("beams of 1e30 m", Buffer::filled(181, 1e30), 1e31),
        ("a reach of NaN", Buffer::filled(181, 1.0), f32::NAN),
    ];
    for (what, ranges_m, max_range_m) in scans {
        let scan = LaserScan {
            first_bearing_rad: -std::f64::consts::FRAC_PI_2,
            bearing_step_rad: 1f64.to_radians(),
            max_range_m,
            ranges_m,
            ..LaserScan::default()
        };
        survives(subject, what, |frame| {
            frame.seen = vec![observation(1, frame.now, Data::LaserScan(scan.clone()))];
        })?;
    }
    Ok(String::new())
}

fn survives_odd_poses(subject: &Subject) -> Verdict {
    let poses: [(&str, Pose2); 3] = [
        ("a pose at NaN", pose2(f64::NAN, 0.0, 0.0)),
        ("a heading of NaN", pose2(2.0, 2.0, f64::NAN)),
        ("a pose at 1e300 m", pose2(1e300, -1e300, 0.0)),
    ];
    for (what, pose) in poses {
        survives(subject, what, |frame| frame.map_from_base = pose)?;
    }
    Ok(String::new())
}

/// A drive with some spoiled frames gives a finite map, and in the end everything is taken again.
fn survives(subject: &Subject, what: &str, spoil: impl Fn(&mut Frame)) -> Result<(), Trouble> {
    let mut work = Work::new(subject)?;
    let drive = Drive::seen_from(Turn::None)?;
    for (k, frame) in drive.frames.iter().enumerate().step_by(5) {
        let mut frame = frame.clone();
        let is_odd = (10..30).contains(&k);
        if is_odd {
            spoil(&mut frame);
        }
        let inserted = work.insert(&frame);
        is_finite(what, &work.map)?;
        if let Err(error) = inserted.as_ref().map_err(MapError::to_string)
            && k >= N_FRAMES - 5
        {
            let found = format!("{what}: 12 s later still \"{error}\"");
            return Err(Trouble::broken(found, "a map, once the input is fine again"));
        }
    }
    Ok(())
}

fn finite_memory(subject: &Subject) -> Verdict {
    let drive = Drive::seen_from(Turn::None)?;
    let mut work = Work::new(subject)?;
    let mut frames = drive.frames.iter().chain(drive.frames.iter().rev()).cycle();
    stays_finite(|k| {
        if let Some(frame) = frames.next() {
            let mut frame = frame.clone();
            frame.now = step_time(k);
            let stamp = frame.now;
            frame.seen.iter_mut().for_each(|seen: &mut Observation| seen.stamp = stamp);
            // What it answers is judged by other laws.
            let _ = work.insert(&frame);
        }
        Ok(())
    })
}
