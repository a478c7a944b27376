use rumbo_core::time::Time;
use rumbo_core::trace::Trace;

use super::*;
use crate::test_world::{TestWorld, given};

fn ring(params: &SonarRingParams, wall_x_m: f64) -> RangeRing {
    let mut sensor = params.build(&BuildContext::bare("sensor")).unwrap();
    let (mut out, trace) = (Observations::default(), Trace::unwatched());
    sensor
        .poll(&mut Cx { now: Time(3), trace: &trace }, &mut TestWorld::with_wall(wall_x_m), &mut out)
        .unwrap();
    let Data::RangeRing(ring) = given(&out).remove(0).data else { panic!() };
    ring
}

#[test]
fn the_ring_hears_the_wall_ahead_from_the_hull_and_nothing_behind() {
    let ring = ring(&SonarRingParams { deviation_m: 0.0, ..SonarRingParams::default() }, 2.0);
    assert_eq!((ring.ranges_m.len(), ring.ring_radius_m), (16, 0.2));
    assert!((ring.ranges_m[0] - 1.8).abs() < 1e-6);
    assert!((ring.bearing_step_rad.to_degrees() - 22.5).abs() < 1e-12);
    assert!(ring.ranges_m[8].is_infinite());
}

#[test]
fn echoes_that_are_too_near_or_lost_are_no_readings() {
    let exact = SonarRingParams { deviation_m: 0.0, ..SonarRingParams::default() };
    assert!(ring(&exact, 0.3).ranges_m[0].is_nan());
    assert!(ring(&SonarRingParams { dropout: 1.0, ..exact }, 2.0).ranges_m[0].is_nan());
}

#[test]
fn a_transducer_that_faces_nothing_hears_its_neighbors_ping() {
    let exact = SonarRingParams { deviation_m: 0.0, ..SonarRingParams::default() };
    let alone = ring(&exact, 2.0);
    let mixed = ring(&SonarRingParams { crosstalk: 1.0, ..exact }, 2.0);
    let outermost = alone.ranges_m.iter().position(|range| range.is_infinite()).unwrap() - 1;
    let outer_m = alone.ranges_m[outermost];
    let inner_m = (outer_m + alone.ranges_m[outermost - 1]) / 2.0;
    // From the side that faces nothing comes no sound.
    assert!([outer_m, inner_m].contains(&mixed.ranges_m[outermost]));
    let beyond_m = mixed.ranges_m[outermost + 1];
    assert!(beyond_m == outer_m || beyond_m.is_infinite());
    assert!(mixed.ranges_m[8].is_infinite());
}

#[test]
fn readings_scatter_as_told() {
    let params = SonarRingParams { deviation_m: 0.05, ..SonarRingParams::default() };
    let mut sensor = params.build(&BuildContext::bare("sensor")).unwrap();
    let (mut out, trace) = (Observations::default(), Trace::unwatched());
    let mut errors = Vec::new();
    for _ in 0..5_000 {
        sensor
            .poll(&mut Cx { now: Time(3), trace: &trace }, &mut TestWorld::with_wall(2.0), &mut out)
            .unwrap();
        let Some(Observation { data: Data::RangeRing(ring), .. }) = out.pop_front() else { panic!() };
        errors.push(f64::from(ring.ranges_m[0]) - 1.8);
    }
    let n = errors.len() as f64;
    assert!((errors.iter().sum::<f64>() / n).abs() < 5.0 * 0.05 / n.sqrt());
    let deviation = (errors.iter().map(|error| error * error).sum::<f64>() / n).sqrt();
    assert!((deviation / 0.05 - 1.0).abs() < 5.0 / (2.0 * n).sqrt(), "{deviation}");
}

#[test]
fn impossible_rings_are_named() {
    let bad = SonarRingParams {
        transducers: 0,
        cone_deg: 0.0,
        ring_radius_m: -1.0,
        min_range_m: f64::NAN,
        max_range_m: 0.0,
        deviation_m: -1.0,
        dropout: 2.0,
        crosstalk: -0.1,
    };
    assert_eq!(bad.check().len(), 8);
    assert!(SonarRingParams::default().check().is_empty());
}
