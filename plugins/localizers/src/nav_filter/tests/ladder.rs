//! Hardship by hardship.

use super::*;

/// Worst planar error, meters; at the end; worst tilt after a second, degrees; worst height.
fn errors(drive: &Drive) -> [f64; 5] { errors_of(&NavFilterParams::default(), drive) }
fn errors_of(params: &NavFilterParams, drive: &Drive) -> [f64; 5] {
    let found = follow(&mut *localizer(params), drive);
    let worst = |of: &dyn Fn(&(f64, Estimate, Pose3)) -> f64| found.iter().map(of).fold(0.0, f64::max);
    let (_, last, truth) = found.last().unwrap();
    [
        worst(&|(_, estimate, truth)| off(estimate, truth).0),
        off(last, truth).0,
        worst(&|(t, estimate, truth)| if *t > 1.0 { tilt_deg(estimate, truth) } else { 0.0 }),
        worst(&|(_, estimate, _)| estimate.map_from_base.translation.z.abs()),
        worst(&|(_, estimate, truth)| off(estimate, truth).1),
    ]
}

#[test]
fn ladder() {
    let perfect =
        Device { rate_noise_rad_s: 0.0, rate_bias_rad_s: 0.0, force_noise_m_s2: 0.0, attitude_deg: 0.0 };
    let noisy = Device { rate_bias_rad_s: 0.0, attitude_deg: 0.0, ..Device::default() };
    let biased = Device { attitude_deg: 0.0, ..Device::default() };
    for (name, device) in
        [("perfect", perfect), ("noisy", noisy), ("biased", biased), ("attitude", Device::default())]
    {
        for (what, speed_m_s, turn_rad_s, sway_deg, seconds) in [
            ("stands", 0.0, 0.0, 0.0, 20.0),
            ("straight", 0.2, 0.0, 0.0, 20.0),
            ("curve", 0.8, 0.4, 0.0, 30.0),
            ("stands swaying", 0.0, 0.0, 20.0, 20.0),
            ("swaying curve", 0.5, 0.3, 20.0, 20.0),
            ("swaying 10", 0.5, 0.3, 10.0, 60.0),
        ] {
            if !std::env::var("ONLY").map_or(true, |o| format!("{name} {what}").contains(&o)) { continue; }
            let drive = Drive { seconds, speed_m_s, turn_rad_s, sway_deg, device, ..Drive::default() };
            println!("{name:>8} {what:>15}: {:.3?}", errors(&drive));
        }
    }
}

#[test]
fn variants() {
    let perfect =
        Device { rate_noise_rad_s: 0.0, rate_bias_rad_s: 0.0, force_noise_m_s2: 0.0, attitude_deg: 0.0 };
    let p = NavFilterParams::default();
    for (device, dn) in [(perfect, "perfect"), (Device::default(), "default")] {
    for (what, speed_m_s, turn_rad_s, sway_deg, seconds) in [
        ("curve", 0.8, 0.4, 0.0, 30.0),
        ("straight", 0.2, 0.0, 0.0, 20.0),
        ("stands swaying", 0.0, 0.0, 20.0, 20.0),
        ("swaying curve", 0.5, 0.3, 20.0, 20.0),
        ("swaying 10", 0.5, 0.3, 10.0, 60.0),
    ] {
        let drive = Drive { seconds, speed_m_s, turn_rad_s, sway_deg, device, ..Drive::default() };
        for (name, params) in [
            ("0.15/6", p.clone()),
            ("0.3/12", NavFilterParams { key_distance_m: 0.3, key_angle_deg: 12.0, ..p.clone() }),
            ("0.5/20", NavFilterParams { key_distance_m: 0.5, key_angle_deg: 20.0, ..p.clone() }),
            ("1/30", NavFilterParams { key_distance_m: 1.0, key_angle_deg: 30.0, ..p.clone() }),
            ("0.5/20 within 0.25", NavFilterParams { key_distance_m: 0.5, key_angle_deg: 20.0,leveled_within_deg: 0.25, ..p.clone() }),
            ("0.5/20 within 1", NavFilterParams { key_distance_m: 0.5, key_angle_deg: 20.0,leveled_within_deg: 1.0, ..p.clone() }),
        ] {
            println!("{dn} {what:>15} {name:>15}: {:.3?}", errors_of(&params, &drive));
        }
    }
    }
}
