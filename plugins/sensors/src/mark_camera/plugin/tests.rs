//! What the camera says of marks, of a recording, and of nonsense.

use rumbo_core::frames::Pose3;
use rumbo_core::messages::SensorId;
use rumbo_core::registry::{Registry, Stage};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;

use super::*;
use crate::test_world::{TestWorld, given};

fn world(marks: Vec<Mark>) -> TestWorld {
    let mut world = TestWorld::with_wall(1.0);
    world.marks.marks = marks;
    world
}

fn poll(params: &MarkCameraParams, world: &mut TestWorld) -> Result<Vec<Observation>, SensorError> {
    let mut sensor = params.build(&BuildContext::bare("sensor")).unwrap();
    let (trace, mut out) = (Trace::unwatched(), Observations::default());
    sensor.poll(&mut Cx { now: Time(5), trace: &trace }, world, &mut out)?;
    Ok(given(&out))
}

fn marks_in(observation: &Observation) -> &Marks {
    match &observation.data {
        Data::Marks(marks) => marks,
        other => panic!("{other:?}"),
    }
}

const EXACT: Mark = Mark { identity: Some(7), range_m: 4.0, bearing_rad: 0.25 };

#[test]
fn a_perfect_camera_gives_what_is_in_view_and_claims_its_deviations() {
    let params = MarkCameraParams {
        range_deviation_m: 0.0,
        range_share: 0.0,
        bearing_deviation_deg: 0.0,
        miss_share: 0.0,
        ..MarkCameraParams::default()
    };
    let seen = poll(&params, &mut world(vec![EXACT])).unwrap();
    assert_eq!((seen.len(), seen[0].stamp, seen[0].valid), (1, Time(5), true));
    assert_eq!(marks_in(&seen[0]).marks, [EXACT]);
    let params = MarkCameraParams { range_share: 0.02, ..MarkCameraParams::default() };
    let params = MarkCameraParams { miss_share: 0.0, range_deviation_m: 1e-9, ..params };
    let seen = poll(&params, &mut world(vec![EXACT])).unwrap();
    let marks = marks_in(&seen[0]);
    assert!((marks.range_deviation_m - 0.02 * marks.marks[0].range_m).abs() < 1e-8);
    assert!((marks.bearing_deviation_rad.to_degrees() - 1.0).abs() < 1e-12);
}

#[test]
fn a_picture_without_marks_is_a_reading_and_nonsense_is_none() {
    let seen = poll(&MarkCameraParams::default(), &mut world(Vec::new())).unwrap();
    assert!(seen[0].valid && marks_in(&seen[0]).marks.is_empty());
    for range_m in [f64::NAN, f64::INFINITY, -1.0] {
        let seen = poll(&MarkCameraParams::default(), &mut world(vec![Mark { range_m, ..EXACT }])).unwrap();
        assert!(!seen[0].valid && marks_in(&seen[0]).marks.is_empty(), "{range_m}");
    }
}

#[test]
fn a_recording_is_passed_on_under_the_cameras_own_name() {
    let recorded = Observation {
        sensor: SensorId(9),
        stamp: Time(3),
        base_from_sensor: Pose3::translation(1.0, 0.0, 0.0),
        valid: true,
        data: Data::Marks(Marks { marks: vec![EXACT], ..Marks::default() }),
    };
    let seen = poll(&MarkCameraParams::default(), &mut TestWorld::recorded(vec![recorded.clone()])).unwrap();
    let bare = BuildContext::bare("sensor");
    assert_eq!((seen[0].sensor, seen[0].base_from_sensor), (bare.sensor, bare.base_from_sensor));
    assert_eq!((seen[0].stamp, &seen[0].data), (Time(3), &recorded.data));
}

#[test]
fn it_is_no_device_that_could_be_read() {
    let mut live = world(Vec::new());
    live.is_live = true;
    let error = poll(&MarkCameraParams::default(), &mut live).unwrap_err();
    assert!(matches!(error, SensorError::WrongAnswer { expected: "marks", .. }), "{error}");
}

#[test]
fn every_bad_value_is_named() {
    let bad = MarkCameraParams {
        field_of_view_deg: 0.0,
        max_range_m: f64::INFINITY,
        range_deviation_m: -1.0,
        range_share: f64::NAN,
        bearing_deviation_deg: -0.1,
        miss_share: 1.1,
        wrong_identity_share: 0.7,
        unknown_identity_share: 0.6,
    };
    let keys: Vec<String> = bad.check().into_iter().map(|fault| fault.path).collect();
    let expected = [
        "field_of_view_deg",
        "max_range_m",
        "range_deviation_m",
        "range_share",
        "bearing_deviation_deg",
        "miss_share",
        "unknown_identity_share",
    ];
    assert_eq!(keys, expected);
    assert!(MarkCameraParams::default().check().is_empty());
    assert!(Registry::linked().unwrap().get(Stage::Sensor, "mark_camera").is_some());
}
