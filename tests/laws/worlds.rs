//! Laws of worlds, sensors and map builders.

use crate::{entries, twins};
use rumbo_core::frames::{Pose3, Twist, is_finite3};
use rumbo_core::map::Map;
use rumbo_core::messages::{Check, Command, ObservationKind, Observations};
use rumbo_core::registry::Stage;
use rumbo_core::stages::{Advance, BuildContext, Cx, MapBuilder, Probe, Sensor, World, WorldError};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;
use std::path::PathBuf;

fn context(name: &str) -> BuildContext {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("pipelines");
    BuildContext { folder: root, world_map: Some(office()), ..BuildContext::bare(name) }
}

fn office() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("pipelines/worlds/office-20m.yaml")
}

#[test]
fn time_runs_forwards_only_and_bad_commands_are_refused() {
    for entry in entries(Stage::World) {
        let (mut world, _): (Box<dyn World>, Box<dyn World>) = twins(&entry, &context("world"));
        assert_eq!(
            world.advance(Time::from_secs(1.0)),
            Ok(Advance::Reached(Time::from_secs(1.0))),
            "{entry:?}"
        );
        let back = world.advance(Time::from_secs(0.5));
        assert!(matches!(back, Err(WorldError::Backwards { .. })), "{entry:?}: {back:?}");
        let mad = Command { stamp: world.now(), twist: Twist::new(f64::NAN, 0.0) };
        assert_eq!(world.drive(&mad), Err(WorldError::NotFinite), "{entry:?}");
    }
}

#[test]
fn a_world_answers_or_says_that_it_cannot() {
    let mount = Pose3::identity();
    let beams = |n_beams, max_range_m| Probe::Beams {
        base_from_sensor: &mount,
        first_bearing_rad: -1.0,
        bearing_step_rad: 0.01,
        n_beams,
        max_range_m,
    };
    for entry in entries(Stage::World) {
        let (mut world, _): (Box<dyn World>, Box<dyn World>) = twins(&entry, &context("world"));
        let channel = Probe::Channel { name: "nothing" };
        for probe in [beams(0, 8.0), beams(10, 0.0), beams(200, 8.0), Probe::Wheels, Probe::Position, channel]
        {
            match world.probe(&probe) {
                Ok(_) | Err(WorldError::Unsupported { .. }) => {}
                Err(error) => panic!("{entry:?}: {}: {error}", probe.name()),
            }
        }
        if let Some(truth) = world.truth() {
            assert!(is_finite3(&truth.map_from_base), "{entry:?}");
        }
    }
}

#[test]
fn every_sensor_reads_the_simulator_and_gives_messages_that_pass_their_own_check() {
    for entry in entries(Stage::Sensor) {
        let (mut one, mut other): (Box<dyn Sensor>, Box<dyn Sensor>) = twins(&entry, &context("sensor"));
        let read = |sensor: &mut Box<dyn Sensor>| {
            let worlds = entries(Stage::World);
            let sim = worlds.iter().find(|entry| entry.name == "sim").unwrap();
            let (mut world, _): (Box<dyn World>, Box<dyn World>) = twins(sim, &context("world"));
            let (trace, mut out) = (Trace::unwatched(), Observations::default());
            let twist = Twist::new(0.2, 0.1);
            for k in 0..20 {
                let now = Time(k * 100_000_000);
                world.advance(now).unwrap();
                world.drive(&Command { stamp: now, twist }).unwrap();
                let polled = sensor.poll(&mut Cx { now, trace: &trace }, world.as_mut(), &mut out);
                polled.unwrap_or_else(|e| panic!("{entry:?}: {e}"));
            }
            let seen: Vec<_> = std::iter::from_fn(|| out.pop_front()).collect();
            assert!(!seen.is_empty(), "{entry:?} saw nothing");
            for observation in &seen {
                assert_eq!(observation.check(), Ok(()), "{entry:?}");
                assert!(observation.stamp <= world.now(), "{entry:?} knows the future");
            }
            seen
        };
        let text = |seen: Vec<_>| format!("{seen:?}");
        assert_eq!(text(read(&mut one)), text(read(&mut other)), "{entry:?}: same seed, other readings");
    }
}

#[test]
fn lasers_and_wheels_pass_on_a_recording_as_it_is() {
    let log = entries(Stage::World).into_iter().find(|entry| entry.name == "log").unwrap();
    for entry in entries(Stage::Sensor) {
        let manifest = entry.source.parse(toml::Table::new()).ok().unwrap().manifest();
        let n_recorded = match manifest.produces.as_slice() {
            [ObservationKind::LaserScan] => 13,
            [ObservationKind::Odometry] => 26,
            _ => continue,
        };
        let (mut world, _): (Box<dyn World>, Box<dyn World>) = twins(&log, &context("world"));
        let (mut sensor, _): (Box<dyn Sensor>, Box<dyn Sensor>) = twins(&entry, &context("sensor"));
        let (trace, mut out) = (Trace::unwatched(), Observations::default());
        while let Ok(Advance::Reached(now)) = world.advance(world.next_recorded().unwrap()) {
            let polled = sensor.poll(&mut Cx { now, trace: &trace }, world.as_mut(), &mut out);
            polled.unwrap_or_else(|e| panic!("{entry:?}: {e}"));
        }
        let stamps: Vec<Time> = out.iter().map(|observation| observation.stamp).collect();
        assert_eq!(stamps.len(), n_recorded, "{entry:?}");
        assert!(stamps.is_sorted() && stamps.first() == Some(&Time::ZERO), "{entry:?}: {stamps:?}");
        assert!(out.iter().all(|observation| observation.check().is_ok()), "{entry:?}");
    }
}

#[test]
fn a_map_builder_gives_the_layers_that_it_declares() {
    for entry in entries(Stage::MapBuilder) {
        let configured = entry.source.parse(toml::Table::new()).ok().unwrap();
        let manifest = configured.manifest();
        let wanted_layers = manifest.gives_layers.clone();
        let context = BuildContext { wanted_layers, ..context("map_builder") };
        let (mut builder, mut twin): (Box<dyn MapBuilder>, Box<dyn MapBuilder>) = twins(&entry, &context);
        let (mut map, mut again) = (Map::default(), Map::default());
        builder.start(&mut map).unwrap_or_else(|e| panic!("{entry:?}: {e}"));
        twin.start(&mut again).unwrap();
        assert!(manifest.gives_layers.iter().all(|layer| map.has(*layer)), "{entry:?}");
        assert_eq!(map, again, "{entry:?}");
    }
}
