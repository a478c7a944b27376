//! What a real device says, as an attitude in the map.

use nalgebra::{Rotation3, Vector3};
use rumbo_core::frames::wrap_angle;
use rumbo_core::messages::Imu;
use rumbo_core::time::Time;

use super::params::AngleUnit;
use super::text::{Decoder, Spoken, Tally};
use crate::text_device::TextDecoder;

/// Standard gravity, m/s².
const GRAVITY_M_S2: f64 = 9.806_65;
/// Attitudes that lie farther apart than this say nothing about rates, seconds.
const LONGEST_STEP_S: f64 = 0.5;

/// How a device's numbers become attitudes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Interpretation {
    unit: AngleUnit,
    sign: f64,
    offset_rad: f64,
    last: Option<(Time, Rotation3<f64>)>,
}

impl Interpretation {
    /// Yaw in the map is `offset_rad` and `sign` times what the device says.
    pub fn new(unit: AngleUnit, sign: f64, offset_rad: f64) -> Self {
        Self { unit, sign, offset_rad, last: None }
    }

    /// A full turn in the device's unit.
    pub fn full_turn(&self) -> f64 {
        self.unit.full_turn()
    }

    /// The attitude that was spoken of at a time.
    pub fn read(&mut self, stamp: Time, spoken: &Spoken) -> Imu {
        let Spoken { yaw, pitch, roll } = *spoken;
        let [yaw, pitch, roll] = [yaw, pitch, roll].map(|angle| self.unit.to_rad(angle));
        let attitude_rad =
            [wrap_angle(roll), wrap_angle(pitch), wrap_angle(self.sign * yaw + self.offset_rad)];
        let [roll, pitch, yaw] = attitude_rad;
        let map_from_sensor = Rotation3::from_euler_angles(roll, pitch, yaw);
        let rates_rad_s = self.rates_rad_s(stamp, &map_from_sensor);
        self.last = Some((stamp, map_from_sensor));
        let up = Vector3::new(0.0, 0.0, GRAVITY_M_S2);
        Imu {
            attitude_rad: Some(attitude_rad),
            rates_rad_s,
            accelerations_m_s2: (map_from_sensor.inverse() * up).into(),
        }
    }

    /// By the attitude before this one.
    fn rates_rad_s(&self, stamp: Time, map_from_sensor: &Rotation3<f64>) -> [f64; 3] {
        let Some((last, map_from_last)) = &self.last else { return [0.0; 3] };
        let step_s = (stamp - *last).as_secs();
        if step_s <= 0.0 || step_s > LONGEST_STEP_S {
            return [0.0; 3];
        }
        let turned = map_from_last.inverse() * map_from_sensor;
        (turned.scaled_axis() / step_s).into()
    }
}

/// Attitudes of a stream.
#[derive(Debug)]
pub(super) struct Listener {
    decoder: Decoder,
    last_refusal: Option<String>,
}

impl Listener {
    /// To a device that calls a full turn so much.
    pub fn new(full_turn: f64) -> Self {
        Self { decoder: Decoder::new(full_turn), last_refusal: None }
    }
}

impl TextDecoder for Listener {
    type Reading = Spoken;
    type Tally = Tally;

    fn push(&mut self, bytes: &[u8]) {
        self.decoder.push(bytes);
    }

    fn break_off(&mut self) {
        self.decoder.break_off();
    }

    fn next(&mut self) -> Option<Spoken> {
        loop {
            match self.decoder.next()? {
                Ok(spoken) => return Some(spoken),
                Err(refusal) => self.last_refusal = Some(refusal.to_string()),
            }
        }
    }

    fn tally(&self) -> Tally {
        self.decoder.tally()
    }

    fn instead(&self) -> String {
        let refusal = |refusal: &String| format!("the last record was refused ({refusal})");
        self.last_refusal.as_ref().map_or_else(|| "no record of it has ended".to_owned(), refusal)
    }
}
