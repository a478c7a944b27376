//! The sensor `{{name}}`: a planar laser range finder with noise.
//!
//! Replace what [`Scanner::poll`] does by your own device; the rest can stay.

use rumbo_core::frames::Pose3;
use rumbo_core::messages::{Data, LaserScan, Observation, ObservationKind, Observations, SensorId};
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::rng::{Rng, RngExt};
use rumbo_core::stages::{Answer, BuildContext, BuildError, Cx, Probe, Sensor, SensorError, World, WorldError};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A planar laser range finder that sees half of the surroundings.
// These comments are what `rumbo plugins describe` and editors show.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Parameters {
    /// Ranges are off by at most this much to both sides, meters.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub noise_m: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        Parameters { noise_m: 0.01 }
    }
}

impl Params for Parameters {
    fn check(&self) -> Vec<BuildError> {
        let found = self.noise_m;
        let fits = (0.0..=1.0).contains(&found);
        let fault = || BuildError::at("noise_m", format!("is {found}, expected a number from 0 to 1"));
        (!fits).then(fault).into_iter().collect()
    }
}

impl Plugin<dyn Sensor> for Parameters {
    fn manifest(&self) -> Manifest {
        Manifest {
            produces: vec![ObservationKind::LaserScan],
            default_rate_hz: Some(10.0),
            ..Manifest::default()
        }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Sensor>, BuildError> {
        Ok(Box::new(Scanner {
            noise_m: self.noise_m,
            name: context.name.clone(),
            sensor: context.sensor,
            base_from_sensor: context.base_from_sensor,
            // All chance comes from here: the same seed gives the same readings.
            rng: context.rng(),
        }))
    }
}

struct Scanner {
    noise_m: f64,
    name: String,
    sensor: SensorId,
    base_from_sensor: Pose3,
    rng: Rng,
}

/// One beam a degree, from the right to the left.
const N_BEAMS: usize = 181;
const MIN_RANGE_M: f64 = 0.05;
const MAX_RANGE_M: f64 = 8.0;

impl Sensor for Scanner {
    fn poll(
        &mut self,
        cx: &mut Cx<'_>,
        world: &mut dyn World,
        out: &mut Observations,
    ) -> Result<(), SensorError> {
        let (first_bearing_rad, bearing_step_rad) = (-90f64.to_radians(), 1f64.to_radians());
        let beams = Probe::Beams {
            base_from_sensor: &self.base_from_sensor,
            first_bearing_rad,
            bearing_step_rad,
            n_beams: N_BEAMS,
            max_range_m: MAX_RANGE_M,
        };
        let answer = match world.probe(&beams) {
            // A recording has no beams to trace, but what was recorded under this sensor's name.
            Err(WorldError::Unsupported { .. }) => world.probe(&Probe::Channel { name: &self.name })?,
            answer => answer?,
        };
        let exact_m = match answer {
            Answer::Ranges(exact_m) if exact_m.len() == N_BEAMS => exact_m,
            Answer::Recorded(recorded) => {
                let (sensor, base_from_sensor) = (self.sensor, self.base_from_sensor);
                let mine = |seen: &Observation| Observation { sensor, base_from_sensor, ..seen.clone() };
                recorded.iter().map(mine).for_each(|observation| out.push(observation));
                return Ok(());
            }
            other => return Err(SensorError::WrongAnswer { expected: "beams", found: other.name() }),
        };
        // Buffers come from a pool and go back there: no memory is asked for in a warm run.
        let mut ranges_m = out.buffer(N_BEAMS);
        for (reading, exact_m) in ranges_m.make_mut().iter_mut().zip(exact_m) {
            let exact_m = f64::from(*exact_m);
            let off_m = self.noise_m * self.rng.random_range(-1.0..=1.0);
            *reading = match exact_m {
                // No reading, and nothing within reach (REP-117).
                m if !(m >= MIN_RANGE_M) => f32::NAN,
                m if m > MAX_RANGE_M => f32::INFINITY,
                m => (m + off_m).clamp(MIN_RANGE_M, MAX_RANGE_M) as f32,
            };
        }
        let scan = LaserScan {
            first_bearing_rad,
            bearing_step_rad,
            sweep_s: 0.0,
            min_range_m: MIN_RANGE_M as f32,
            max_range_m: MAX_RANGE_M as f32,
            ranges_m,
            ..LaserScan::default()
        };
        out.push(Observation {
            sensor: self.sensor,
            stamp: cx.now,
            base_from_sensor: self.base_from_sensor,
            valid: true,
            data: Data::LaserScan(scan),
        });
        Ok(())
    }
}

rumbo_core::register_sensor!(Parameters, "{{name}}", "a planar laser range finder that sees half of the surroundings");

// The line that makes a plugin library of this crate.
rumbo_core::export_plugins!();

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_core::messages::Command;
    use rumbo_core::stages::{Advance, Drove};
    use rumbo_core::time::Time;
    use rumbo_core::trace::Trace;

    /// A world in which every beam meets something at 2 m.
    struct Round(Vec<f32>);

    impl World for Round {
        fn now(&self) -> Time {
            Time::ZERO
        }

        fn advance(&mut self, to: Time) -> Result<Advance, WorldError> {
            Ok(Advance::Reached(to))
        }

        fn drive(&mut self, _: &Command) -> Result<Drove, WorldError> {
            Ok(Drove::Drove)
        }

        fn probe<'w>(&'w mut self, probe: &Probe<'_>) -> Result<Answer<'w>, WorldError> {
            let Probe::Beams { n_beams, .. } = probe else {
                return Err(WorldError::Unsupported { probe: probe.name() });
            };
            self.0 = vec![2.0; *n_beams];
            Ok(Answer::Ranges(&self.0))
        }
    }

    #[test]
    fn ranges_are_off_by_no_more_than_the_noise() {
        let mut sensor = Parameters { noise_m: 0.1 }.build(&BuildContext::bare("laser")).unwrap();
        let (mut out, trace) = (Observations::default(), Trace::unwatched());
        sensor.poll(&mut Cx { now: Time::ZERO, trace: &trace }, &mut Round(Vec::new()), &mut out).unwrap();
        let Some(Data::LaserScan(scan)) = out.iter().next().map(|seen| &seen.data) else { panic!("no scan") };
        assert_eq!(scan.ranges_m.len(), N_BEAMS);
        assert!(scan.ranges_m.iter().all(|range_m| (range_m - 2.0).abs() <= 0.1001));
        assert!(scan.ranges_m.iter().any(|range_m| (range_m - 2.0).abs() > 0.02), "there is noise");
    }
}
