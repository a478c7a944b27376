//! Attitudes of a device without one, as a virtual sensor of the framework.

use nalgebra::Vector3;
use rumbo_core::messages::{Data, Imu, Observation, ObservationKind, Observations, Seen, SensorId};
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::stages::{BuildContext, BuildError, Cx, Sensor, SensorError, World};
use rumbo_kit::nav_filter::{ImuSample, Leveler};

use super::AttitudeFilterParams;

rumbo_core::register_sensor!(
    AttitudeFilterParams,
    "attitude_filter",
    "roll and pitch of a device that measures turning rates and accelerations only"
);

/// Gives readings attitudes.
#[derive(Debug)]
pub struct AttitudeFilter {
    sensor: SensorId,
    leveler: Leveler,
    n_used: u64,
    n_dropped: u64,
}

impl Plugin<dyn Sensor> for AttitudeFilterParams {
    fn manifest(&self) -> Manifest {
        Manifest {
            consumes: vec![vec![ObservationKind::Imu]],
            produces: vec![ObservationKind::Imu],
            is_virtual: true,
            ..Manifest::default()
        }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Sensor>, BuildError> {
        if let Some(fault) = self.check().into_iter().next() {
            return Err(fault);
        }
        let leveler = Leveler::new(self.settings());
        Ok(Box::new(AttitudeFilter { sensor: context.sensor, leveler, n_used: 0, n_dropped: 0 }))
    }
}

impl Sensor for AttitudeFilter {
    fn poll(&mut self, _: &mut Cx<'_>, _: &mut dyn World, _: &mut Observations) -> Result<(), SensorError> {
        Err(SensorError::Other("this sensor levels the readings of `inputs` and reads no world".to_owned()))
    }

    fn derive(
        &mut self,
        cx: &mut Cx<'_>,
        inputs: Seen<'_>,
        out: &mut Observations,
    ) -> Result<(), SensorError> {
        for observation in inputs.iter().filter(|observation| observation.valid) {
            if let Data::Imu(imu) = &observation.data {
                self.level(observation, imu, out);
            }
        }
        cx.trace.count("samples_used", self.n_used as f64);
        cx.trace.count("samples_dropped", self.n_dropped as f64);
        cx.trace.count("tilt_deviation_deg", self.leveler.tilt_std_rad().to_degrees());
        Ok(())
    }
}

impl AttitudeFilter {
    /// The attitude is that of the device itself, as devices with an attitude give theirs.
    fn level(&mut self, observation: &Observation, imu: &Imu, out: &mut Observations) {
        let sample = ImuSample {
            rates_rad_s: Vector3::from(imu.rates_rad_s),
            forces_m_s2: Vector3::from(imu.accelerations_m_s2),
        };
        if !self.leveler.take(observation.stamp, &sample) {
            self.n_dropped += 1;
            return;
        }
        self.n_used += 1;
        let Some(attitude) = self.leveler.nav_from_body() else { return };
        let (roll_rad, pitch_rad, yaw_rad) = attitude.euler_angles();
        let imu = Imu { attitude_rad: Some([roll_rad, pitch_rad, yaw_rad]), ..*imu };
        out.push(Observation { sensor: self.sensor, data: Data::Imu(imu), ..observation.clone() });
    }
}

#[cfg(test)]
mod tests;
