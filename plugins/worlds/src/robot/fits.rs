//! Whether a base and a pipeline speak of the same robot.

use rumbo_core::frames::{Pose3, flatten, wrap_angle};
use rumbo_core::messages::{Data, Observation, RangeRing, SensorId};
use rumbo_core::robot::{Drive, Robot};
use rumbo_core::time::Time;

use super::link::Base;
use super::protocol::SonarGeometry;

/// Bearings and openings may differ by as much: half a degree.
const SAME_ANGLE_RAD: f64 = 0.0088;
/// Lengths may differ by as much.
const SAME_LENGTH_M: f64 = 0.01;

/// The wheels of the base are those of the pipeline, or what differs and what to do.
pub(super) fn check_base(base: &Base, robot: &Robot) -> Result<(), String> {
    let identity = &base.identity;
    let (found, wanted) = (identity.drive.name(), robot.drive.kind().name());
    if found != wanted {
        return Err(format!(
            "its drive is {found}, that of the pipeline is {wanted}; change `drive.kind` of [robot]"
        ));
    }
    match robot.drive {
        Drive::Differential { track_m } | Drive::Tricycle { track_m, .. }
            if identity.track_m > 0.0 && (identity.track_m - track_m).abs() > SAME_LENGTH_M =>
        {
            Err(format!(
                "its wheels are {:.3} m apart, those of the pipeline {track_m:.3} m; change `drive.track_m` of [robot]",
                identity.track_m
            ))
        }
        _ => Ok(()),
    }
}

/// What a sensor asks for: see [`rumbo_core::stages::Probe::Cones`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Cones<'a> {
    pub base_from_sensor: &'a Pose3,
    pub bearings_rad: &'a [f64],
    pub cone_rad: f64,
    pub ring_radius_m: f64,
    pub max_range_m: f64,
}

impl Cones<'_> {
    /// The sensor's sonars are those of the base, or what differs.
    pub fn check(&self, ring: &SonarGeometry) -> Result<(), String> {
        let (n_sensor, n_base) = (self.bearings_rad.len(), ring.n_sonars);
        if n_sensor != n_base as usize {
            return Err(format!("the sensor has {n_sensor} sonars, the base {n_base}; change `transducers`"));
        }
        let mount = flatten(self.base_from_sensor);
        let off_m = mount.translation.vector.norm();
        if off_m > SAME_LENGTH_M {
            return Err(format!(
                "the sonars of the base are around its middle, the sensor is mounted {off_m:.3} m off; change `mount`"
            ));
        }
        let expected = (0..n_base).map(|k| ring.first_bearing_rad + ring.bearing_step_rad * f64::from(k));
        for (k, (found, expected)) in self.bearings_rad.iter().zip(expected).enumerate() {
            let found_rad = found + mount.rotation.angle();
            if wrap_angle(found_rad - expected).abs() > SAME_ANGLE_RAD {
                return Err(format!(
                    "sonar {k} of the sensor looks to {:.1} degrees, that of the base to {:.1}; change the yaw of `mount`",
                    wrap_angle(found_rad).to_degrees(),
                    wrap_angle(expected).to_degrees()
                ));
            }
        }
        if (self.cone_rad - ring.cone_rad).abs() > SAME_ANGLE_RAD {
            return Err(format!(
                "the sensor's cones open {:.1} degrees, those of the base {:.1}; change `cone_deg`",
                self.cone_rad.to_degrees(),
                ring.cone_rad.to_degrees()
            ));
        }
        if (self.ring_radius_m - ring.ring_radius_m).abs() > SAME_LENGTH_M {
            return Err(format!(
                "the sensor's ring has a radius of {:.3} m, that of the base {:.3} m; change `ring_radius_m`",
                self.ring_radius_m, ring.ring_radius_m
            ));
        }
        Ok(())
    }

    /// What the base measured, as the sensor says it. Sensor and mount are the sensor's to fill in.
    pub fn observation(&self, ring: &SonarGeometry, stamp: Time, ranges_m: &[f32]) -> Observation {
        let max_range_m = self.max_range_m.min(ring.max_range_m) as f32;
        let within = |range_m: &f32| if *range_m > max_range_m { f32::INFINITY } else { *range_m };
        let data = RangeRing {
            first_bearing_rad: self.bearings_rad.first().copied().unwrap_or_default(),
            bearing_step_rad: ring.bearing_step_rad,
            cone_rad: self.cone_rad,
            ring_radius_m: self.ring_radius_m,
            min_range_m: ring.min_range_m as f32,
            max_range_m,
            ranges_m: ranges_m.iter().map(within).collect::<Vec<f32>>().into(),
        };
        Observation {
            sensor: SensorId(0),
            stamp,
            base_from_sensor: Pose3::identity(),
            valid: true,
            data: Data::RangeRing(data),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use rumbo_core::frames::{lift, pose2};
    use rumbo_core::robot::DriveKind;

    use super::super::protocol::{BaseIdentity, BumperGeometry};
    use super::*;

    const RING: SonarGeometry = SonarGeometry {
        n_sonars: 4,
        first_bearing_rad: 0.0,
        bearing_step_rad: TAU / 4.0,
        cone_rad: 0.4,
        ring_radius_m: 0.2,
        min_range_m: 0.1,
        max_range_m: 5.0,
    };

    const BEARINGS_RAD: [f64; 4] = [0.0, TAU / 4.0, TAU / 2.0, TAU * 3.0 / 4.0];

    fn mounted(base_from_sensor: &Pose3) -> Cones<'_> {
        Cones {
            base_from_sensor,
            bearings_rad: &BEARINGS_RAD,
            cone_rad: 0.4,
            ring_radius_m: 0.2,
            max_range_m: 6.0,
        }
    }

    #[test]
    fn sonars_that_are_not_those_of_the_base_say_which_key_to_change() {
        let (turned, moved) = (lift(&pose2(0.0, 0.0, 0.3)), lift(&pose2(0.1, 0.0, 0.0)));
        let middle = Pose3::identity();
        let fine = mounted(&middle);
        assert_eq!(fine.check(&RING), Ok(()));
        for (key, cones) in [
            ("`transducers`", Cones { bearings_rad: &[0.0], ..fine }),
            ("`mount`", mounted(&moved)),
            ("yaw of `mount`", mounted(&turned)),
            ("`cone_deg`", Cones { cone_rad: 0.5, ..fine }),
            ("`ring_radius_m`", Cones { ring_radius_m: 0.3, ..fine }),
        ] {
            let fault = cones.check(&RING).unwrap_err();
            assert!(fault.contains(key), "{key}: {fault}");
        }
        // A ring that is turned by one sonar numbers them in another way.
        assert!(mounted(&lift(&pose2(0.0, 0.0, TAU / 4.0))).check(&RING).is_err());
    }

    #[test]
    fn readings_beyond_the_sensors_reach_are_nothing() {
        let mount = Pose3::identity();
        let cones = Cones { max_range_m: 3.0, ..mounted(&mount) };
        let observation = cones.observation(&RING, Time(5), &[1.0, 4.0, f32::NAN, f32::INFINITY]);
        let Data::RangeRing(ring) = observation.data else { panic!() };
        assert_eq!((ring.ranges_m[0], ring.ranges_m[1], ring.max_range_m), (1.0, f32::INFINITY, 3.0));
        assert!(ring.ranges_m[2].is_nan() && ring.ranges_m[3].is_infinite());
    }

    #[test]
    fn another_drive_or_track_is_told() {
        let base = |drive: DriveKind, track_m: f64| Base {
            identity: BaseIdentity {
                version: 1,
                boot: 1,
                drive,
                track_m,
                watchdog_s: 0.5,
                name: "B".to_owned(),
            },
            sonars: RING,
            bumpers: BumperGeometry { n_bumpers: 0, first_bearing_rad: 0.0, bearing_step_rad: 0.0 },
        };
        let robot = Robot::default();
        assert_eq!(check_base(&base(DriveKind::Differential, 0.362), &robot), Ok(()));
        assert_eq!(check_base(&base(DriveKind::Differential, 0.0), &robot), Ok(()), "not told");
        let track = check_base(&base(DriveKind::Differential, 0.5), &robot).unwrap_err();
        assert!(track.contains("0.500 m apart") && track.contains("`drive.track_m`"), "{track}");
        let kind = check_base(&base(DriveKind::Omnidirectional, 0.36), &robot).unwrap_err();
        assert!(kind.contains("`drive.kind`"), "{kind}");
    }
}
