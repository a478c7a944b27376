//! The localizer `{{name}}`: dead reckoning from a known start.
//!
//! Replace what [`DeadReckoning::update`] does by your own algorithm; the rest can stay.

use rumbo_core::frames::Pose2;
use rumbo_core::map::Map;
use rumbo_core::messages::{Check, Estimate, ObservationKind, Prior, Seen};
use rumbo_core::nalgebra::{Matrix3, Vector3};
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::stages::{BuildContext, BuildError, Cx, LocalizeError, Localizer};
use rumbo_core::time::Time;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Follows the odometer from a known start.
// These comments are what `rumbo plugins describe` and editors show.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Parameters {
    /// Error that each meter of the way adds to the place, meters.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub error_m_per_m: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        Parameters { error_m_per_m: 0.02 }
    }
}

impl Params for Parameters {
    fn check(&self) -> Vec<BuildError> {
        let found = self.error_m_per_m;
        let fits = (0.0..=1.0).contains(&found);
        let fault = || BuildError::at("error_m_per_m", format!("is {found}, expected a number from 0 to 1"));
        (!fits).then(fault).into_iter().collect()
    }
}

impl Plugin<dyn Localizer> for Parameters {
    fn manifest(&self) -> Manifest {
        Manifest {
            consumes: vec![vec![ObservationKind::Odometry]],
            needs_start_pose: true,
            ..Manifest::default()
        }
    }

    fn build(&self, _: &BuildContext) -> Result<Box<dyn Localizer>, BuildError> {
        Ok(Box::new(DeadReckoning { parameters: self.clone(), way: None }))
    }
}

struct DeadReckoning {
    parameters: Parameters,
    way: Option<Way>,
}

/// The way since the start.
struct Way {
    map_from_base: Pose2,
    odom_from_base: Pose2,
    /// Variances of x, y and yaw.
    variances: Vector3<f64>,
    /// Stamp of the newest reading; none before the first.
    stamp: Option<Time>,
}

/// No robot goes farther from one reading to the next, meters.
const LONGEST_STEP_M: f64 = 1000.0;
/// Error that each meter of the way adds to the heading, radians.
const ERROR_RAD_PER_M: f64 = 0.01;

impl Localizer for DeadReckoning {
    fn start(&mut self, prior: &Prior, _: &Map) -> Result<(), LocalizeError> {
        prior.check()?;
        let needs = "a pose";
        match prior {
            Prior::Unknown => Err(LocalizeError::Prior { prior: "an unknown pose", needs }),
            Prior::Saved(_) => Err(LocalizeError::Prior { prior: "a saved state", needs }),
            Prior::Pose { map_from_base, odom_from_base, covariance } => {
                let variances = covariance.diagonal().map(|variance| variance.max(0.0));
                let (map_from_base, odom_from_base) = (*map_from_base, *odom_from_base);
                self.way = Some(Way { map_from_base, odom_from_base, variances, stamp: None });
                Ok(())
            }
        }
    }

    fn update(&mut self, cx: &mut Cx<'_>, seen: Seen<'_>, _: &Map) -> Result<Estimate, LocalizeError> {
        let way = self.way.as_mut().ok_or(LocalizeError::NotStarted)?;
        for (observation, odometry) in seen.odometry().filter(|(observation, _)| observation.valid) {
            odometry.check()?;
            if way.stamp.is_some_and(|stamp| observation.stamp <= stamp) {
                // A newer reading has told the whole way already.
                continue;
            }
            let step = way.odom_from_base.inverse() * odometry.odom_from_base;
            // An odometer that talks nonsense must not make numbers of the estimate that are none.
            let length_m = step.translation.vector.norm().min(LONGEST_STEP_M);
            let (error_m, error_rad) = (self.parameters.error_m_per_m * length_m, ERROR_RAD_PER_M * length_m);
            way.map_from_base *= step;
            way.odom_from_base = odometry.odom_from_base;
            way.variances += Vector3::new(error_m, error_m, error_rad).map(|error| error * error);
            way.stamp = Some(observation.stamp);
        }
        let covariance = Matrix3::from_diagonal(&way.variances);
        let stamp = way.stamp.unwrap_or(cx.now);
        Ok(Estimate::planar(stamp, way.map_from_base, way.odom_from_base, covariance))
    }
}

rumbo_core::register_localizer!(Parameters, "{{name}}", "follows the odometer from a known start");

// The line that makes a plugin library of this crate.
rumbo_core::export_plugins!();

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_core::frames::{Pose3, pose2};
    use rumbo_core::messages::{Data, Observation, Odometry, SensorId};
    use rumbo_core::trace::Trace;

    #[test]
    fn the_way_is_laid_on_from_the_start() {
        let mut localizer = Parameters::default().build(&BuildContext::bare("localizer")).unwrap();
        let covariance = Matrix3::zeros();
        let (map_from_base, odom_from_base) = (pose2(2.0, 1.0, 0.0), pose2(10.0, 0.0, 0.0));
        let prior = Prior::Pose { map_from_base, odom_from_base, covariance };
        localizer.start(&prior, &Map::default()).unwrap();
        let seen = [Observation {
            sensor: SensorId(0),
            stamp: Time::from_secs(1.0),
            base_from_sensor: Pose3::identity(),
            valid: true,
            data: Data::Odometry(Odometry { odom_from_base: pose2(11.0, 0.5, 0.0), ..Odometry::default() }),
        }];
        let trace = Trace::unwatched();
        let mut cx = Cx { now: Time::from_secs(1.0), trace: &trace };
        let estimate = localizer.update(&mut cx, Seen::sorted(&seen), &Map::default()).unwrap();
        let place = estimate.pose2().translation;
        assert!((place.x - 3.0).abs() < 1e-9 && (place.y - 1.5).abs() < 1e-9, "{place}");
    }
}
