//! What the tracker says of a person, of a recording, and of worlds that know nobody.

use rumbo_core::frames::Pose3;
use rumbo_core::messages::{Check as _, PersonPosition, SensorId};
use rumbo_core::registry::{Registry, Stage};
use rumbo_core::stages::WorldError;
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;

use super::*;
use crate::test_world::{TestWorld, given};

fn exact(person: &str) -> PersonTrackerParams {
    PersonTrackerParams { person: person.into(), deviation_m: 0.0, ..PersonTrackerParams::default() }
}

fn poll(
    params: &PersonTrackerParams,
    world: &mut TestWorld,
    seconds: &[f64],
) -> Result<Vec<Observation>, SensorError> {
    let mut sensor = params.build(&BuildContext::bare("sensor")).unwrap();
    let (trace, mut out) = (Trace::unwatched(), Observations::default());
    for seconds in seconds {
        sensor.poll(&mut Cx { now: Time::from_secs(*seconds), trace: &trace }, world, &mut out)?;
    }
    Ok(given(&out))
}

fn person_of(observation: &Observation) -> PersonPosition {
    let Data::Custom(custom) = &observation.data else { panic!("{observation:?}") };
    PersonPosition::read(custom).unwrap().unwrap()
}

#[test]
fn it_says_where_its_person_is_in_the_published_schema() {
    let mut world = TestWorld::with_wall(1.0);
    world.person = Some(("anna".into(), [3.0, -1.0, 0.0]));
    let seen = poll(&exact("anna"), &mut world, &[0.5]).unwrap();
    assert_eq!((seen.len(), seen[0].stamp, seen[0].valid), (1, Time::from_secs(0.5), true));
    assert_eq!(person_of(&seen[0]), PersonPosition { position: Point2::new(3.0, -1.0), deviation_m: 0.0 });
    let late = PersonTrackerParams { delay_s: 1.0, ..exact("anna") };
    let seen = poll(&late, &mut world, &[0.0, 0.5, 1.0, 1.4]).unwrap();
    assert_eq!(seen.iter().map(|seen| seen.stamp).collect::<Vec<_>>(), [Time::ZERO]);
    let noisy = PersonTrackerParams { deviation_m: 0.25, ..exact("anna") };
    assert_eq!(person_of(&poll(&noisy, &mut world, &[0.0]).unwrap()[0]).deviation_m, 0.25);
    assert!(
        poll(&PersonTrackerParams { dropout_share: 1.0, ..exact("anna") }, &mut world, &[0.0, 1.0])
            .unwrap()
            .is_empty()
    );
}

#[test]
fn nonsense_is_not_measured_and_who_is_not_there_is_a_failure() {
    let mut world = TestWorld::with_wall(1.0);
    world.person = Some(("anna".into(), [f64::NAN, 0.0, 0.0]));
    assert!(poll(&exact("anna"), &mut world, &[0.0]).unwrap().is_empty());
    let nobody = poll(&exact("bert"), &mut world, &[0.0]).unwrap_err();
    assert_eq!(nobody, SensorError::World(WorldError::Unsupported { probe: "person of this name" }));
    world.is_live = true;
    let live = poll(&exact("anna"), &mut world, &[0.0]).unwrap_err();
    assert!(live.to_string().contains("person_at"), "{live}");
}

#[test]
fn a_recording_is_passed_on_with_its_own_stamps() {
    let person = PersonPosition { position: Point2::new(1.0, 2.0), deviation_m: 0.1 };
    let recorded = Observation {
        sensor: SensorId(9),
        stamp: Time(42),
        base_from_sensor: Pose3::translation(1.0, 0.0, 0.0),
        valid: true,
        data: Data::Custom(person.to_custom()),
    };
    let seen = poll(&exact("anna"), &mut TestWorld::recorded(vec![recorded]), &[1.0]).unwrap();
    assert_eq!((seen.len(), seen[0].sensor, seen[0].stamp), (1, SensorId(0), Time(42)));
    assert_eq!(person_of(&seen[0]), person);
    assert!(seen[0].check().is_ok());
}

#[test]
fn the_registry_knows_it() {
    let registry = Registry::linked().unwrap();
    let entry = registry.get(Stage::Sensor, "person_tracker").unwrap();
    let table = toml::from_str("person = 'anna'\ndeviation_m = 0.3").unwrap();
    assert_eq!(entry.source.parse(table).unwrap().manifest().produces, [ObservationKind::Custom]);
}
