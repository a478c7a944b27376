//! Hardship by hardship: what is wrong with a perfect device is wrong with the filter.

use super::*;

/// Worst planar error, meters; worst tilt after half a second, degrees; at the end: turn, degrees.
fn errors(drive: &Drive) -> [f64; 3] {
    let found = follow(&mut *localizer(&NavFilterParams::default()), drive);
    let worst = |of: &dyn Fn(&(f64, Estimate, Pose3)) -> f64| found.iter().map(of).fold(0.0, f64::max);
    let (_, last, truth) = found.last().unwrap();
    [
        worst(&|(_, estimate, truth)| off(estimate, truth).0),
        worst(&|(t, estimate, truth)| if *t > 0.5 { tilt_deg(estimate, truth) } else { 0.0 }),
        off(last, truth).1,
    ]
}

/// Errors at most, meters and degrees: of the place, of the tilt, and of the turn at the end.
fn holds(device: Device, bars: [f64; 3]) {
    for (what, speed_m_s, turn_rad_s, sway_deg, seconds) in [
        ("stands", 0.0, 0.0, 0.0, 20.0),
        ("slowly ahead", 0.2, 0.0, 0.0, 20.0),
        ("a curve", 0.8, 0.4, 0.0, 30.0),
        ("stands and sways", 0.0, 0.0, 20.0, 20.0),
        ("sways on a curve", 0.5, 0.3, 20.0, 20.0),
    ] {
        let found = errors(&Drive { seconds, speed_m_s, turn_rad_s, sway_deg, device, ..Drive::default() });
        assert!(found.iter().zip(bars).all(|(found, bar)| *found < bar), "{what}: {found:.3?}");
    }
}

const PERFECT: Device = Device {
    rate_noise_rad_s: 0.0,
    rate_bias_rad_s: 0.0,
    force_noise_m_s2: 0.0,
    attitude_deg: 0.0,
    arm_m: [0.0; 3],
};

#[test]
fn a_perfect_device_makes_next_to_no_errors() {
    holds(PERFECT, [0.10, 0.6, 2.0]);
}

/// On a base that sways, a device 30 cm over its middle feels 3 m/s² of that.
#[test]
fn a_device_beside_the_middle_makes_none_either() {
    holds(Device { arm_m: [0.1, -0.05, 0.3], ..PERFECT }, [0.10, 0.6, 2.0]);
}

#[test]
fn noise_and_bias_make_them_little_worse() {
    let noisy = Device { rate_bias_rad_s: 0.0, attitude_deg: 0.0, ..Device::default() };
    holds(noisy, [0.15, 1.0, 2.0]);
    holds(Device { attitude_deg: 0.0, ..Device::default() }, [0.15, 1.0, 2.0]);
}
