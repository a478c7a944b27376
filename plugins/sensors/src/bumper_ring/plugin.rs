//! The bumper ring as a sensor of the framework.

use std::f64::consts::TAU;

use rumbo_core::frames::flatten;
use rumbo_core::messages::{Bumpers, Data, Observation, ObservationKind, Observations};
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::stages::{Answer, BuildContext, BuildError, Cx, Probe, Sensor, SensorError, World};

use super::BumperRingParams;
use crate::recorded::Seat;

rumbo_core::register_sensor!(BumperRingParams, "bumper_ring", "touch sensors around the hull");

/// A ring of touch sensors.
#[derive(Debug)]
pub struct BumperRing {
    seat: Seat,
    n_bumpers: u32,
    ring_radius_m: f64,
}

impl Plugin<dyn Sensor> for BumperRingParams {
    fn manifest(&self) -> Manifest {
        Manifest {
            produces: vec![ObservationKind::Bumpers],
            default_rate_hz: Some(20.0),
            ..Manifest::default()
        }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Sensor>, BuildError> {
        if let Some(fault) = self.check().into_iter().next() {
            return Err(fault);
        }
        let ring_radius_m = context.robot.hull().outer_radius_m();
        Ok(Box::new(BumperRing { seat: Seat::of(context), n_bumpers: self.bumpers, ring_radius_m }))
    }
}

/// Which bumper feels a touch at a bearing of the ring.
fn pressed(bearing_rad: f64, n_bumpers: u32) -> u32 {
    let sector = (bearing_rad.rem_euclid(TAU) / TAU * f64::from(n_bumpers)).round() as u32;
    sector % n_bumpers
}

impl Sensor for BumperRing {
    fn poll(
        &mut self,
        cx: &mut Cx<'_>,
        world: &mut dyn World,
        out: &mut Observations,
    ) -> Result<(), SensorError> {
        let ring_yaw_rad = flatten(&self.seat.base_from_sensor).rotation.angle();
        let felt = |answer: &Answer<'_>| {
            let Answer::Contacts(bearings_rad) = answer else { return None };
            let press = |bits, bearing: &f64| bits | 1 << pressed(bearing - ring_yaw_rad, self.n_bumpers);
            Some(bearings_rad.iter().fold(0u64, press))
        };
        let asked = self.seat.ask(world, &Probe::Contacts, "contacts", out, felt)?;
        let Some(touched) = asked else { return Ok(()) };
        let bumpers = Bumpers {
            n_bumpers: self.n_bumpers,
            pressed: touched,
            first_bearing_rad: 0.0,
            bearing_step_rad: TAU / f64::from(self.n_bumpers),
            ring_radius_m: self.ring_radius_m,
        };
        out.push(Observation {
            sensor: self.seat.sensor,
            stamp: cx.now,
            base_from_sensor: self.seat.base_from_sensor,
            valid: true,
            data: Data::Bumpers(bumpers),
        });
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use rumbo_core::time::Time;
    use rumbo_core::trace::Trace;

    use super::*;
    use crate::test_world::{TestWorld, given};

    #[test]
    fn a_touch_presses_the_bumper_of_its_sector() {
        for (bearing_deg, expected) in
            [(0.0, 0), (11.0, 0), (-11.0, 0), (12.0, 1), (-12.0, 15), (180.0, 8), (-180.0, 8)]
        {
            assert_eq!(pressed(f64::to_radians(bearing_deg), 16), expected, "{bearing_deg}");
        }
        assert_eq!(pressed(3.0, 1), 0);
    }

    #[test]
    fn contacts_are_told_as_bits_around_the_hull() {
        let mut world = TestWorld::with_wall(1.0);
        world.contacts_rad = vec![0.0, -0.4];
        let mut sensor = BumperRingParams::default().build(&BuildContext::bare("sensor")).unwrap();
        let (mut out, trace) = (Observations::default(), Trace::unwatched());
        sensor.poll(&mut Cx { now: Time(1), trace: &trace }, &mut world, &mut out).unwrap();
        let Data::Bumpers(bumpers) = given(&out)[0].data else { panic!() };
        assert_eq!((bumpers.pressed, bumpers.ring_radius_m), (1 | 1 << 15, 0.2));
        assert!(BumperRingParams { bumpers: 65 }.build(&BuildContext::bare("sensor")).is_err());
    }
}
