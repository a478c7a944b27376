//! Sensors: probes, answers, observations.

use crate::doubles::desk;
use crate::stage;
use crate::worlds::{Rich, ask_everything, everything};
use rumbo_core::messages::{Observation, Observations, Seen, SensorId};
use rumbo_core::registry::Stage;
use rumbo_core::stages::{Cx, Sensor};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;

fn drained(out: &mut Observations) -> Vec<Observation> {
    std::iter::from_fn(|| out.pop_front()).collect()
}

/// As the host hands them on: all from the sensor that was asked.
fn expected() -> Vec<Observation> {
    everything().into_iter().map(|seen| Observation { sensor: SensorId(0), ..seen }).collect()
}

#[test]
fn a_sensor_asks_the_world_and_says_what_it_saw() {
    let mut sensor: Box<dyn Sensor> = stage(Stage::Sensor, "double");
    let (mut world, mut out, trace) = (Rich::new(), Observations::default(), Trace::watched());
    desk(|desk| desk.observations_to_give = everything());
    let mut cx = Cx { now: Time(5), trace: &trace };
    sensor.poll(&mut cx, &mut world, &mut out).unwrap();
    let mut answers = ask_everything(&mut Rich::new());
    let broken = answers.last().unwrap().clone();
    assert!(broken.contains("x.log"), "{broken}");
    answers.push("lent [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]".to_owned());
    desk(|desk| assert_eq!(desk.answers, answers));
    assert_eq!(drained(&mut out), expected());
    assert_eq!(trace.take().1, [("calls", 1.0)]);
}

#[test]
fn a_virtual_sensor_makes_something_of_its_inputs() {
    let mut sensor: Box<dyn Sensor> = stage(Stage::Sensor, "double");
    let (mut out, trace) = (Observations::default(), Trace::unwatched());
    let inputs = everything();
    let mut cx = Cx { now: Time(5), trace: &trace };
    sensor.derive(&mut cx, Seen::sorted(&inputs), &mut out).unwrap();
    assert_eq!(drained(&mut out), expected());
}

#[test]
fn buffers_of_a_sensor_come_back_to_the_pool_of_the_host() {
    let mut sensor: Box<dyn Sensor> = stage(Stage::Sensor, "double");
    let (mut world, mut out, trace) = (Rich::new(), Observations::default(), Trace::unwatched());
    desk(|desk| desk.observations_to_give.clear());
    let mut cx = Cx { now: Time(5), trace: &trace };
    for _ in 0..3 {
        // What is recycled here is what `lend_f32` hands out again.
        let mut lent = out.buffer(361);
        lent.make_mut()[0] = 1.0;
        sensor.poll(&mut cx, &mut world, &mut out).unwrap();
        for seen in drained(&mut out) {
            out.recycle(seen);
        }
    }
}
