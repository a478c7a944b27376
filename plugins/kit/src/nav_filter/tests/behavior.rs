//! What the filter does with whole drives, and with what it should not get.

use super::*;

fn tilt_error_deg(filter: &NavFilter, truth: &UnitQuaternion<f64>) -> f64 {
    let (state, _) = filter.state().unwrap();
    let (a, b) = (state.nav_from_body.inverse() * Vector3::z(), truth.inverse() * Vector3::z());
    a.angle(&b).to_degrees()
}

fn seconds(k: usize, rate_hz: f64) -> Time {
    Time::from_secs(k as f64 / rate_hz)
}

fn is_sound(filter: &NavFilter, now: Time) {
    let output = filter.output(now).unwrap();
    assert!(rumbo_core::frames::is_finite3(&output.odom_from_base));
    assert!((output.covariance - output.covariance.transpose()).amax() == 0.0);
    let least = output.covariance.symmetric_eigenvalues().min();
    assert!(least >= 1e-12, "{least:e} {}", output.covariance);
}

/// The specification's test of a robot that stands steeply for five seconds and is level again, with devices of the default
/// noise; up to 60 degrees, forward and sideways.
#[test]
fn steep_for_five_seconds_and_level_again_the_attitude_is_right_within_a_degree() {
    for (roll_deg, pitch_deg) in [(0.0, 45.0), (45.0, 0.0), (0.0, -60.0), (60.0, 0.0), (30.0, 60.0)] {
        let (mut filter, mut rng) = (filter(), rumbo_core::rng::stream(3, "imu"));
        let mut normal = |std: f64| -> f64 { std * Distribution::<f64>::sample(&StandardNormal, &mut rng) };
        let (rate_hz, steep) = (200.0, angles(roll_deg, pitch_deg, 0.0));
        let axis = steep.scaled_axis();
        let mut worst_deg = 0f64;
        for k in 0..2400 {
            let t = k as f64 / rate_hz;
            // One second level, one second up, five seconds there, one second down, level.
            let (share, rate) = match t {
                t if (1.0..2.0).contains(&t) => (t - 1.0, 1.0),
                t if (2.0..7.0).contains(&t) => (1.0, 0.0),
                t if (7.0..8.0).contains(&t) => (8.0 - t, -1.0),
                _ => (0.0, 0.0),
            };
            let truth = UnitQuaternion::from_scaled_axis(axis * share);
            let mut sample = at_rest(&truth);
            sample.rates_rad_s = axis * rate + Vector3::from_fn(|_, _| normal(0.01));
            sample.forces_m_s2 += Vector3::from_fn(|_, _| normal(0.05));
            assert!(filter.take_imu(seconds(k, rate_hz), &sample));
            // While it turns, the corner of the made-up motion counts as well.
            worst_deg = worst_deg.max(tilt_error_deg(&filter, &truth));
        }
        is_sound(&filter, seconds(2400, rate_hz));
        assert!(worst_deg < 1.0, "{worst_deg} degrees off at {roll_deg} and {pitch_deg}");
    }
}

/// Drives a circle with biased devices; steps over the floor come 10 times a second, 50 ms late.
fn circle(settings: NavSettings, gyro_bias: f64, late: usize) -> (NavFilter, Pose2) {
    let mut filter = NavFilter::new(settings).unwrap();
    let mut rng = rumbo_core::rng::stream(5, "circle");
    let mut normal = |std: f64| -> f64 { std * Distribution::<f64>::sample(&StandardNormal, &mut rng) };
    let (rate_hz, speed, turn) = (200.0, 1.0, 0.5);
    let pose = |t: f64| rumbo_core::frames::Twist::new(speed, turn).integrate(t);
    let mut pending = Vec::new();
    for k in 0..4000 {
        let t = k as f64 / rate_hz;
        let sample = ImuSample {
            rates_rad_s: Vector3::new(gyro_bias, 0.0, turn + gyro_bias)
                + Vector3::from_fn(|_, _| normal(0.005)),
            forces_m_s2: Vector3::new(0.0, speed * turn, GRAVITY_M_S2) + Vector3::from_fn(|_, _| normal(0.1)),
        };
        filter.take_imu(seconds(k, rate_hz), &sample);
        if k % 20 == 0 && k > 0 {
            let step = pose(t - 0.1).inverse() * pose(t);
            let noisy = step * pose2(normal(0.002), normal(0.002), normal(0.001));
            pending.push((k, noisy));
        }
        if let Some((at, step)) = pending.first().copied().filter(|(at, _)| k >= at + late) {
            pending.remove(0);
            let covariance = Matrix3::from_diagonal(&Vector3::new(4e-6, 4e-6, 1e-6));
            let step = PlanarPose { pose: step, covariance };
            assert!(filter.take_step(seconds(at, rate_hz), Some((&step, Fusion::Alone))));
        }
    }
    (filter, pose(3999.0 / rate_hz))
}

#[test]
fn steps_over_the_floor_hold_position_velocity_attitude_and_bias() {
    for late in [0, 10] {
        let (filter, truth) = circle(NavSettings::default(), 0.01, late);
        let output = filter.output(seconds(4000, 200.0)).unwrap();
        let chain = FrameChain::of(&output.odom_from_base);
        let off = truth.inverse() * chain.odom_from_footprint;
        assert!(
            off.translation.vector.norm() < 0.15,
            "{} m after 20 m, {late}",
            off.translation.vector.norm()
        );
        assert!(off.rotation.angle().abs() < 0.03, "{}", off.rotation.angle());
        assert!((output.twist.forward_m_s - 1.0).abs() < 0.05 && output.twist.left_m_s.abs() < 0.05);
        assert!(chain.height_m.abs() < 0.3, "{}", chain.height_m);
        assert!(tilt_error_deg(&filter, &UnitQuaternion::identity()) < 1.0);
        let (state, _) = filter.state().unwrap();
        assert!((state.gyro_bias_rad_s.z - 0.01).abs() < 0.002, "{}", state.gyro_bias_rad_s);
        is_sound(&filter, seconds(4000, 200.0));
        let off_std = off.translation.vector.norm() / output.covariance[(0, 0)].sqrt();
        assert!(off_std < 4.0, "it knows how sure it is: {off_std}");
        assert!((output.dead_reckoned.inverse() * chain.odom_from_footprint).translation.vector.norm() < 1.0);
    }
}

#[test]
fn late_steps_are_as_good_as_punctual_ones() {
    let (punctual, _) = circle(NavSettings::default(), 0.0, 0);
    let (late, _) = circle(NavSettings::default(), 0.0, 6);
    let pose = |filter: &NavFilter| filter.output(Time::ZERO).unwrap().odom_from_base.translation.vector;
    assert!((pose(&punctual) - pose(&late)).norm() < 0.02, "{} {}", pose(&punctual), pose(&late));
}

#[test]
fn a_late_pose_changes_the_past_and_the_samples_since_are_gone_through_again() {
    let sample = ImuSample { forces_m_s2: Vector3::new(0.5, 0.0, GRAVITY_M_S2), ..ImuSample::default() };
    let measured = PlanarPose { pose: pose2(0.1, 0.02, 0.01), covariance: Matrix3::identity() * 1e-4 };
    let (mut late, mut punctual) = (filter(), filter());
    for k in 0..60 {
        late.take_imu(seconds(k, 100.0), &sample);
        punctual.take_imu(seconds(k, 100.0), &sample);
        if k == 40 {
            assert!(punctual.take_pose(seconds(40, 100.0), &measured));
        }
    }
    assert!(late.take_pose(seconds(40, 100.0), &measured));
    let (a, b) = (late.state().unwrap(), punctual.state().unwrap());
    assert!(a.0.minus(b.0).amax() < 1e-12 && (a.1 - b.1).amax() < 1e-12);
    assert!(!late.take_pose(Time(-1), &measured) && !late.take_pose(seconds(99, 100.0), &measured));
    assert_eq!(late.counts().n_untimely, 2);
    for k in 60..300 {
        late.take_imu(seconds(k, 100.0), &sample);
    }
    assert!((100..=103).contains(&late.n_moments()), "a second is kept: {}", late.n_moments());
    assert!(!late.take_pose(seconds(100, 100.0), &measured));
}

#[test]
fn bad_samples_are_dropped_and_counted() {
    let mut filter = filter();
    assert_eq!(filter.status(Time::ZERO), NavStatus::NotInitialized);
    let good = at_rest(&UnitQuaternion::identity());
    assert!(filter.take_imu(seconds(1, 1.0), &good));
    let nan = Vector3::new(f64::NAN, 0.0, 0.0);
    for bad in [
        ImuSample { rates_rad_s: nan, ..good },
        ImuSample { forces_m_s2: nan, ..good },
        ImuSample { forces_m_s2: Vector3::new(0.0, 0.0, 161.0), ..good },
        ImuSample { rates_rad_s: Vector3::new(36.0, 0.0, 0.0), ..good },
        ImuSample { forces_m_s2: Vector3::zeros(), ..good },
    ] {
        assert!(!filter.take_imu(seconds(2, 1.0), &bad));
    }
    assert!(!filter.take_imu(seconds(1, 1.0), &good) && !filter.take_imu(Time::ZERO, &good));
    let counts = filter.counts();
    assert_eq!((counts.n_bad, counts.n_not_newer, counts.n_samples), (5, 2, 1));
}

#[test]
fn nothing_is_integrated_over_a_gap_and_the_velocity_is_less_sure() {
    let mut filter = filter();
    let pushed = ImuSample { forces_m_s2: Vector3::new(1.0, 0.0, GRAVITY_M_S2), ..ImuSample::default() };
    for k in 0..20 {
        filter.take_imu(seconds(k, 100.0), &pushed);
    }
    let (before, p_before) = filter.state().map(|(state, p)| (*state, *p)).unwrap();
    filter.take_imu(seconds(519, 100.0), &at_rest(&before.nav_from_body));
    let (after, p_after) = filter.state().unwrap();
    // 5 s at 100 m/s² and 3 rad/s would be far away; what the aids change is small.
    assert!((after.position_m - before.position_m).norm() < 0.5 && filter.counts().n_gaps == 1);
    assert!(p_after[(6, 6)] > p_before[(6, 6)] + 0.5 * (3.0f64 * 5.0).powi(2));
}

#[test]
fn without_samples_the_filter_says_so_and_gets_less_sure_of_roll_and_pitch() {
    let mut filter = filter();
    for k in 0..100 {
        filter.take_imu(seconds(k, 100.0), &at_rest(&UnitQuaternion::identity()));
    }
    assert_eq!(filter.status(Time::from_secs(1.5)), NavStatus::Ok);
    let fresh = filter.output(Time::from_secs(1.0)).unwrap();
    let late = Time::from_secs(0.99 + 3.0);
    assert_eq!(filter.status(late), NavStatus::Stale);
    let stale = filter.output(late).unwrap();
    assert_eq!(stale.odom_from_base, fresh.odom_from_base);
    assert!((stale.covariance[(4, 4)] - fresh.covariance[(4, 4)] - 0.15f64.powi(2)).abs() < 1e-9);
}

#[test]
fn poses_that_are_none_are_refused_and_bad_covariances_make_it_less_sure() {
    let mut filter = filter();
    for k in 0..50 {
        filter.take_imu(seconds(k, 100.0), &at_rest(&UnitQuaternion::identity()));
    }
    let before = filter.state().map(|(state, p)| (*state, *p)).unwrap();
    let now = seconds(49, 100.0);
    let pose = PlanarPose { pose: pose2(f64::NAN, 0.0, 0.0), covariance: Matrix3::identity() };
    assert!(!filter.take_pose(now, &pose));
    assert_eq!(filter.state().map(|(state, p)| (*state, *p)).unwrap(), before);
    let negative = PlanarPose { pose: Pose2::identity(), covariance: -Matrix3::identity() };
    assert!(!filter.take_pose(now, &negative));
    let after = filter.state().map(|(state, p)| (*state, *p)).unwrap();
    assert!(after.0 == before.0 && (after.1 - before.1 * 2.0).amax() < 1e-12);
    let counts = filter.counts();
    assert_eq!((counts.n_rejected, counts.n_not_positive), (1, 1));
    is_sound(&filter, now);
}

/// Somebody put the robot on a slope of 40 degrees without a sample in between: gravity says all the time that the attitude is
/// wrong, and in the end it is what gravity says; at once where the robot is known to stand. Its yaw stays.
#[test]
fn put_on_a_slope_it_levels_anew() {
    for (stands, within_s) in [(true, 0.2), (false, 1.2)] {
        for slope in [angles(0.0, 40.0, 0.0), angles(-40.0, 10.0, 0.0)] {
            let (mut filter, rest) = (filter(), at_rest(&UnitQuaternion::identity()));
            for k in 0..200 {
                filter.take_imu(seconds(k, 100.0), &rest);
            }
            let n_before = filter.counts().n_rejected;
            for k in 200..1000 {
                filter.take_imu(seconds(k, 100.0), &at_rest(&slope));
                filter.set_standing(stands);
                let t = (k - 200) as f64 / 100.0;
                let off_deg = tilt_error_deg(&filter, &slope);
                assert!(t < within_s || off_deg < 1.0, "{off_deg} degrees after {t} s");
            }
            assert!(filter.counts().n_rejected > n_before);
            let output = filter.output(seconds(1000, 100.0)).unwrap();
            assert!(rumbo_core::frames::flatten(&output.odom_from_base).rotation.angle().abs() < 0.02);
            is_sound(&filter, seconds(1000, 100.0));
        }
    }
}

#[test]
fn refused_again_and_again_the_filter_gets_less_sure_of_itself() {
    let settings =
        NavSettings { level_anew_after: rumbo_core::time::Span(60_000_000_000), ..NavSettings::default() };
    let (mut filter, rest) = (NavFilter::new(settings).unwrap(), at_rest(&UnitQuaternion::identity()));
    for k in 0..200 {
        filter.take_imu(seconds(k, 100.0), &rest);
    }
    let (n_before, p_before) = (filter.counts().n_rejected, filter.state().unwrap().1[(1, 1)]);
    for k in 200..300 {
        filter.take_imu(seconds(k, 100.0), &at_rest(&angles(0.0, 40.0, 0.0)));
    }
    assert!(filter.counts().n_rejected > n_before + 10);
    assert!(filter.state().unwrap().1[(1, 1)] > 2.0 * p_before);
    is_sound(&filter, seconds(300, 100.0));
}

/// The same for the attitude alone.
#[test]
fn put_on_a_slope_the_attitude_alone_levels_anew() {
    let mut leveler = Leveler::new(NavSettings::default());
    let slope = angles(0.0, 40.0, 0.0);
    for k in 0..600 {
        let truth = if k < 200 { UnitQuaternion::identity() } else { slope };
        assert!(leveler.take(seconds(k, 100.0), &at_rest(&truth)));
    }
    let off_rad = leveler.nav_from_body().unwrap().angle_to(&slope);
    assert!(off_rad < 0.01, "{off_rad}");
}

#[test]
fn a_robot_that_stands_finds_the_bias_of_its_rates_and_does_not_drift() {
    let mut filter = filter();
    let bias = Vector3::new(0.01, -0.015, 0.02);
    let biased = ImuSample { rates_rad_s: bias, ..at_rest(&UnitQuaternion::identity()) };
    for k in 0..6000 {
        filter.take_imu(seconds(k, 200.0), &biased);
        filter.set_standing(true);
    }
    let (state, _) = filter.state().unwrap();
    assert!((state.gyro_bias_rad_s - bias).norm() < 0.001, "{}", state.gyro_bias_rad_s);
    let output = filter.output(seconds(6000, 200.0)).unwrap();
    assert!(output.odom_from_base.translation.vector.norm() < 0.05);
}

#[test]
fn placed_elsewhere_it_is_there_with_the_attitude_that_it_had() {
    let mut filter = filter();
    let tilted = angles(5.0, -10.0, 0.0);
    for k in 0..50 {
        filter.take_imu(seconds(k, 100.0), &at_rest(&tilted));
    }
    let there = pose2(3.0, -2.0, 1.0);
    filter.place(there, Matrix3::identity() * 0.01);
    let output = filter.output(seconds(49, 100.0)).unwrap();
    let chain = FrameChain::of(&output.odom_from_base);
    assert!((chain.odom_from_footprint.inverse() * there).translation.vector.norm() < 1e-9);
    assert!((chain.odom_from_footprint.rotation.angle() - 1.0).abs() < 1e-9);
    assert!((output.covariance[(0, 0)] - 0.01).abs() < 1e-6);
    assert!(tilt_error_deg(&filter, &tilted) < 0.5);
    is_sound(&filter, seconds(49, 100.0));
}

#[test]
fn rates_and_gravity_alone_keep_an_attitude_while_the_base_sways() {
    let mut leveler = Leveler::new(NavSettings::default());
    let mut rng = rumbo_core::rng::stream(4, "sway");
    let mut normal = |std: f64| -> f64 { std * Distribution::<f64>::sample(&StandardNormal, &mut rng) };
    let (rate_hz, omega) = (100.0, std::f64::consts::PI);
    let truth_at = |t: f64| angles(20.0 * (omega * t).sin(), 20.0 * (omega * t * 0.9).sin(), 5.0 * t);
    let mut worst_deg = 0f64;
    assert!(leveler.nav_from_body().is_none());
    for k in 0..6000 {
        let t = k as f64 / rate_hz;
        let truth = truth_at(t);
        let (before, after) = (truth_at(t - 1e-4), truth_at(t + 1e-4));
        let mut sample = at_rest(&truth);
        sample.rates_rad_s = (before.inverse() * after).scaled_axis() / 2e-4
            + Vector3::from_fn(|_, _| normal(0.005))
            + Vector3::new(0.005, -0.005, 0.0);
        sample.forces_m_s2 += Vector3::from_fn(|_, _| normal(0.1));
        assert!(leveler.take(seconds(k, rate_hz), &sample));
        let up = |q: &UnitQuaternion<f64>| q.inverse() * Vector3::z();
        let off = up(&leveler.nav_from_body().unwrap()).angle(&up(&truth)).to_degrees();
        if t > 2.0 {
            worst_deg = worst_deg.max(off);
        }
    }
    assert!(worst_deg < 1.0, "{worst_deg} degrees");
    assert!(leveler.tilt_std_rad() < 0.05, "{}", leveler.tilt_std_rad());
    assert!(leveler.gyro_bias_rad_s().xy().norm() < 0.03, "{}", leveler.gyro_bias_rad_s());
    assert!(!leveler.take(Time::ZERO, &ImuSample::default()));
}

#[test]
fn settings_that_cannot_be_are_named() {
    assert!(NavSettings::default().faults().is_empty());
    let bad = NavSettings {
        gyro_noise_rad_s: 0.0,
        accel_bias_walk: -1.0,
        omega: Omega::Fixed(1.0),
        ..NavSettings::default()
    };
    let names: Vec<&str> = bad.faults().into_iter().map(|fault| fault.name).collect();
    assert_eq!(names, ["gyro_noise", "accel_bias_walk", "omega"]);
    assert!(NavFilter::new(bad).is_err());
}
