use nalgebra::UnitQuaternion;
use rand_distr::{Distribution, StandardNormal};
use rumbo_core::frames::Pose3;
use rumbo_core::messages::Check;
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;

use super::*;
use crate::test_world::given;

const GRAVITY_M_S2: f64 = 9.80665;

fn sensor(params: &AttitudeFilterParams) -> Box<dyn Sensor> {
    params.build(&BuildContext::bare("attitude")).unwrap()
}

fn reading(stamp_s: f64, rates: Vector3<f64>, forces: Vector3<f64>) -> Observation {
    let imu = Imu { attitude_rad: None, rates_rad_s: rates.into(), accelerations_m_s2: forces.into() };
    Observation {
        sensor: SensorId(1),
        stamp: Time::from_secs(stamp_s),
        base_from_sensor: Pose3::identity(),
        valid: true,
        data: Data::Imu(imu),
    }
}

fn derive(sensor: &mut dyn Sensor, seen: &[Observation]) -> (Vec<Imu>, Vec<(&'static str, f64)>) {
    let (trace, mut out) = (Trace::counting(), Observations::default());
    sensor.derive(&mut Cx { now: Time::ZERO, trace: &trace }, Seen::sorted(seen), &mut out).unwrap();
    let imus = given(&out).into_iter().map(|observation| {
        observation.check().unwrap();
        let Data::Imu(imu) = observation.data else { panic!("an imu") };
        imu
    });
    (imus.collect(), trace.take().1)
}

/// 45 degrees steep for five seconds, then level: within a degree all the time, and what the device said is passed on.
#[test]
fn steep_and_level_again_the_attitude_is_right_within_a_degree() {
    let mut filter = sensor(&AttitudeFilterParams::default());
    let mut rng = rumbo_core::rng::stream(2, "attitude");
    let mut normal = |std: f64| -> f64 { std * Distribution::<f64>::sample(&StandardNormal, &mut rng) };
    let bias = Vector3::new(0.005, -0.008, 0.01);
    for k in 0..1600 {
        let t = f64::from(k) / 200.0;
        let (share, rate) = match t {
            t if t < 0.5 => (0.0, 0.0),
            t if t < 1.0 => (2.0 * (t - 0.5), 2.0),
            t if t < 6.0 => (1.0, 0.0),
            t if t < 6.5 => (1.0 - 2.0 * (t - 6.0), -2.0),
            _ => (0.0, 0.0),
        };
        let pitch_rad = std::f64::consts::FRAC_PI_4 * share;
        let truth = UnitQuaternion::from_euler_angles(0.0, pitch_rad, 0.0);
        let rates = Vector3::new(0.0, std::f64::consts::FRAC_PI_4 * rate, 0.0) + bias;
        let rates = rates + Vector3::from_fn(|_, _| normal(0.005));
        let up = truth.inverse() * Vector3::z() * GRAVITY_M_S2;
        let forces = up + Vector3::from_fn(|_, _| normal(0.05));
        let (imus, _) = derive(&mut *filter, &[reading(t, rates, forces)]);
        let [roll, pitch, _] = imus[0].attitude_rad.unwrap();
        assert!(
            roll.to_degrees().abs() < 1.0 && (pitch - pitch_rad).to_degrees().abs() < 1.0,
            "{t}: {pitch}"
        );
        assert_eq!(Vector3::from(imus[0].rates_rad_s), rates);
        assert_eq!(Vector3::from(imus[0].accelerations_m_s2), forces);
    }
}

#[test]
fn a_robot_that_speeds_up_is_not_taken_for_one_that_tilts() {
    let mut filter = sensor(&AttitudeFilterParams::default());
    let rest = Vector3::new(0.0, 0.0, GRAVITY_M_S2);
    let mut last = 0.0;
    for k in 0..1000 {
        // After three seconds of rest, 2 m/s² for one second: the forces lean by 11 degrees.
        let forces = if (600..800).contains(&k) { rest + Vector3::new(2.0, 0.0, 0.0) } else { rest };
        let (imus, _) = derive(&mut *filter, &[reading(f64::from(k) / 200.0, Vector3::zeros(), forces)]);
        last = imus[0].attitude_rad.unwrap()[1].abs().max(last);
    }
    assert!(last.to_degrees() < 2.0, "{} degrees", last.to_degrees());
}

#[test]
fn readings_that_are_none_or_not_newer_are_dropped_and_counted() {
    let mut filter = sensor(&AttitudeFilterParams::default());
    let rest = Vector3::new(0.0, 0.0, GRAVITY_M_S2);
    let bad = [
        reading(0.9, Vector3::zeros(), Vector3::new(f64::NAN, 0.0, 9.8)),
        reading(0.9, Vector3::new(40.0, 0.0, 0.0), rest),
        reading(0.9, Vector3::zeros(), Vector3::new(0.0, 0.0, 200.0)),
        reading(0.9, Vector3::zeros(), Vector3::zeros()),
        Observation { valid: false, ..reading(0.95, Vector3::zeros(), rest) },
        reading(1.0, Vector3::zeros(), rest),
        reading(1.0, Vector3::zeros(), rest),
    ];
    let (imus, counters) = derive(&mut *filter, &bad);
    assert_eq!(imus.len(), 1);
    let count = |name: &str| counters.iter().find(|(known, _)| *known == name).unwrap().1;
    assert_eq!((count("samples_used"), count("samples_dropped")), (1.0, 5.0));
    assert_eq!(imus[0].attitude_rad, Some([0.0, 0.0, 0.0]));
}

#[test]
fn bad_values_are_named() {
    let bad = AttitudeFilterParams {
        gyro_noise_deg_s: 0.0,
        gyro_bias_deg_s: -1.0,
        leveling_rate_hz: f64::INFINITY,
        ..AttitudeFilterParams::default()
    };
    let keys: Vec<String> = Params::check(&bad).into_iter().map(|fault| fault.path).collect();
    assert_eq!(keys, ["gyro_noise_deg_s", "gyro_bias_deg_s", "leveling_rate_hz"]);
    assert!(bad.build(&BuildContext::bare("attitude")).is_err());
}
