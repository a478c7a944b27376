//! Starts, outages, late and early readings, mounts, and parameters.

use rumbo_core::registry::{Params as _, Registry, Stage};

use super::*;
use crate::gps_imu::heading::base_yaw_rad;

const ALL: [Fusion; 3] = [Fusion::Odometry, Fusion::Mean3, Fusion::Ekf];

fn with(fusion: Fusion) -> GpsImuParams {
    GpsImuParams { fusion, ..GpsImuParams::default() }
}

#[test]
fn the_first_fix_with_a_measured_yaw_is_where_a_robot_is_that_may_be_anywhere() {
    for fusion in ALL {
        let mut localizer = started(&with(fusion), &Prior::Unknown);
        let estimate = update(localizer.as_mut(), 0.0, &[odometry(0.0, pose2(3.0, 1.0, 1.0))]).unwrap();
        assert_eq!(estimate.status, Status::Lost, "{fusion:?}");
        // A fix alone says nothing of the yaw, and a yaw nothing of the place.
        let estimate = update(localizer.as_mut(), 0.1, &[imu(0.1, 0.5)]).unwrap();
        assert_eq!(estimate.status, Status::Lost, "{fusion:?}");
        let at_m = Vector2::new(20.0, -7.0);
        let estimate = update(localizer.as_mut(), 0.2, &[fix(0.2, at_m, 5.0)]).unwrap();
        assert_eq!(estimate.status, Status::Tracking, "{fusion:?}");
        assert!(apart_m(&estimate, &pose2(20.0, -7.0, 0.5)) < 1e-9);
        assert!((estimate.pose2().rotation.angle() - 0.5).abs() < 1e-9);
        let covariance = estimate.covariance2();
        assert!((covariance[(0, 0)] - 25.0 / 3.0).abs() < 0.1, "{covariance}");
    }
}

#[test]
fn a_start_that_somebody_names_holds_until_fixes_say_otherwise() {
    for fusion in ALL {
        let mut localizer = started(&with(fusion), &at(pose2(1.0, 2.0, 0.3), 0.1));
        let estimate = update(localizer.as_mut(), 0.0, &[]).unwrap();
        assert_eq!(estimate.status, Status::Tracking);
        assert!(apart_m(&estimate, &pose2(1.0, 2.0, 0.3)) < 1e-12);
        let estimate =
            update(localizer.as_mut(), 0.1, &[imu(0.1, 0.3), fix(0.1, Vector2::new(3.0, 2.0), 5.0)]).unwrap();
        let x_m = estimate.pose2().translation.x;
        match fusion {
            // Three hundred times as sure as the fix.
            Fusion::Odometry | Fusion::Ekf => assert!((x_m - 1.0).abs() < 0.01 && x_m > 1.0, "{x_m}"),
            Fusion::Mean3 => assert_eq!(x_m, 3.0),
        }
    }
}

/// Twenty seconds with fixes, sixty without.
#[test]
fn without_fixes_the_wheels_go_on_and_the_position_gets_less_sure() {
    for fusion in ALL {
        let mut localizer = started(&with(fusion), &at(Pose2::identity(), 0.1));
        let (mut variances_m2, mut last) = (Vec::new(), None);
        for k in 0..800 {
            let seconds = 0.1 * f64::from(k);
            let odom_from_base = Twist::new(0.3, 0.02).integrate(seconds);
            let mut seen =
                vec![odometry(seconds, odom_from_base), imu(seconds, odom_from_base.rotation.angle())];
            if k < 200 {
                seen.push(fix(seconds, odom_from_base.translation.vector, 5.0));
            } else {
                // The receiver goes on to say where it was: it has no fix.
                let mut old = fix(seconds, Vector2::zeros(), 5.0);
                old.valid = false;
                seen.push(old);
            }
            let estimate = update(localizer.as_mut(), seconds, &seen).unwrap();
            variances_m2.push(estimate.covariance2()[(0, 0)]);
            last = Some((estimate, odom_from_base));
        }
        let (estimate, truth) = last.unwrap();
        if fusion == Fusion::Mean3 {
            // Nothing moves it: it stays behind, and says so.
            assert!(apart_m(&estimate, &truth) > 5.0 && estimate.status == Status::Converging);
        } else {
            assert!(apart_m(&estimate, &truth) < 1e-6, "{fusion:?}");
            assert_eq!(estimate.status, Status::Tracking);
        }
        assert!(variances_m2[200..].windows(2).all(|pair| pair[1] > pair[0]), "{fusion:?}");
    }
}

#[test]
fn between_attitudes_the_wheels_turn_the_yaw_and_without_them_it_gets_less_sure() {
    for fusion in [Fusion::Odometry, Fusion::Ekf] {
        let mut localizer = started(&with(fusion), &at(Pose2::identity(), 0.01));
        let mut last_deviation = 0.0;
        for k in 0..200 {
            let seconds = 0.1 * f64::from(k);
            let odom_from_base = Twist::new(0.3, 0.1).integrate(seconds);
            let mut seen = vec![odometry(seconds, odom_from_base)];
            if k < 100 && k % 5 == 0 {
                seen.push(imu(seconds, odom_from_base.rotation.angle()));
            }
            let estimate = update(localizer.as_mut(), seconds, &seen).unwrap();
            let off_rad = wrap_angle(estimate.pose2().rotation.angle() - odom_from_base.rotation.angle());
            assert!(off_rad.abs() < 1e-9 && apart_m(&estimate, &odom_from_base) < 1e-9, "{fusion:?} {k}");
            let deviation = estimate.covariance2()[(2, 2)];
            assert!(k <= 100 || deviation > last_deviation, "{fusion:?} {k}");
            last_deviation = deviation;
        }
    }
}

/// Readings of one moment come in any order of sensors, fixes 0.3 s late, and the antenna sits in front.
#[test]
fn late_fixes_are_of_where_the_antenna_was_then() {
    let mount = Pose3::translation(0.8, -0.3, 1.2);
    for fusion in [Fusion::Odometry, Fusion::Ekf] {
        let mut localizer = started(&with(fusion), &at(pose2(2.0, 1.0, 0.7), 3.0));
        let start = pose2(2.5, 0.5, 0.7);
        let truth_at = |seconds: f64| start * Twist::new(1.0, 0.4).integrate(seconds);
        for k in 0..400 {
            let seconds = 0.1 * f64::from(k);
            let truth = truth_at(seconds);
            let mut seen = vec![
                imu(seconds, truth.rotation.angle()),
                odometry(seconds, Twist::new(1.0, 0.4).integrate(seconds)),
            ];
            if k >= 10 && k % 5 == 0 {
                let then_s = seconds - 0.3;
                let antenna = truth_at(then_s) * nalgebra::Point2::new(0.8, -0.3);
                let late = fix(then_s, antenna.coords, 0.5);
                seen.insert(0, Observation { base_from_sensor: mount, ..late });
            }
            let estimate = update(localizer.as_mut(), seconds, &seen).unwrap();
            if k == 399 {
                assert!(apart_m(&estimate, &truth) < 0.03, "{fusion:?}: {}", apart_m(&estimate, &truth));
            }
        }
    }
}

#[test]
fn a_robot_that_was_carried_away_is_where_the_fixes_are_after_so_many() {
    for fusion in ALL {
        let mut localizer = started(&with(fusion), &at(Pose2::identity(), 0.1));
        for k in 0..40 {
            let seconds = f64::from(k);
            let at_m = if k < 20 { Vector2::zeros() } else { Vector2::new(60.0, 0.0) };
            let seen = [odometry(seconds, Pose2::identity()), imu(seconds, 0.0), fix(seconds, at_m, 2.0)];
            let estimate = update(localizer.as_mut(), seconds, &seen).unwrap();
            let x_m = estimate.pose2().translation.x;
            match (fusion, k) {
                (_, ..20) => assert!(x_m.abs() < 1e-9),
                (Fusion::Mean3, 22..) => assert!((x_m - 60.0).abs() < 1e-9),
                (Fusion::Mean3, _) => {}
                (_, ..30) => assert!(x_m.abs() < 1e-9, "{fusion:?} {k}: {x_m}"),
                _ => assert!((x_m - 60.0).abs() < 1.0, "{fusion:?} {k}: {x_m}"),
            }
        }
    }
}

#[test]
fn an_odometer_that_is_restarted_leaves_the_pose_and_makes_it_less_sure() {
    for fusion in [Fusion::Odometry, Fusion::Ekf] {
        let mut localizer = started(&with(fusion), &at(pose2(5.0, 5.0, 0.0), 0.1));
        let mut estimates = Vec::new();
        for (k, x_m) in [0.0, 0.1, 0.2, 30.0, 30.1].into_iter().enumerate() {
            let seconds = 0.1 * k as f64;
            estimates.push(
                update(localizer.as_mut(), seconds, &[odometry(seconds, pose2(x_m, 0.0, 0.0))]).unwrap(),
            );
        }
        let x_m = |k: usize| estimates[k].pose2().translation.x;
        assert!((x_m(2) - 5.2).abs() < 1e-9 && (x_m(3) - 5.2).abs() < 1e-9 && (x_m(4) - 5.3).abs() < 1e-9);
        assert!(estimates[3].covariance2()[(0, 0)] > estimates[2].covariance2()[(0, 0)] + 1e-4, "{fusion:?}");
    }
}

#[test]
fn an_attitude_is_turned_back_by_the_mount() {
    use nalgebra::Vector3;
    let left = Pose3::new(Vector3::zeros(), Vector3::z() * std::f64::consts::FRAC_PI_2);
    assert!((base_yaw_rad([0.0, 0.0, 2.0], &left) - (2.0 - std::f64::consts::FRAC_PI_2)).abs() < 1e-12);
    // Upside down: roll by half a turn.
    let hanging = Pose3::new(Vector3::zeros(), Vector3::x() * std::f64::consts::PI);
    assert!((base_yaw_rad([std::f64::consts::PI, 0.0, 2.0], &hanging) - 2.0).abs() < 1e-12);
    assert!((base_yaw_rad([0.1, -0.2, 2.0], &Pose3::identity()) - 2.0).abs() < 1e-12);
}

#[test]
fn a_yaw_that_nobody_measures_must_be_named_unless_fixes_can_tell_it() {
    for fusion in ALL {
        let params = GpsImuParams { heading: HeadingSource::Odometry, ..with(fusion) };
        let outcome = localizer(&params).start(&Prior::Unknown, &Map::default());
        assert_eq!(outcome.is_ok(), fusion == Fusion::Ekf, "{fusion:?}");
        assert_eq!(params.manifest().needs_start_pose, fusion != Fusion::Ekf);
        // What is measured besides is not looked at.
        let mut localizer = started(&params, &at(pose2(0.0, 0.0, 1.0), 0.1));
        let estimate =
            update(localizer.as_mut(), 0.1, &[odometry(0.1, Pose2::identity()), imu(0.1, -2.0)]).unwrap();
        assert_eq!(estimate.pose2().rotation.angle(), 1.0);
    }
    let needed = |params: GpsImuParams| params.manifest().consumes.len();
    assert_eq!((needed(with(Fusion::Odometry)), needed(with(Fusion::Mean3))), (3, 2));
}

#[test]
fn an_update_with_a_number_that_is_none_changes_nothing() {
    for fusion in ALL {
        let mut localizer = started(&with(fusion), &at(Pose2::identity(), 0.1));
        let good =
            update(localizer.as_mut(), 0.0, &[odometry(0.0, Pose2::identity()), imu(0.0, 0.0)]).unwrap();
        let seen = [fix(0.1, Vector2::new(1.0, 1.0), 5.0), fix(0.1, Vector2::new(f64::NAN, 1.0), 5.0)];
        assert!(matches!(update(localizer.as_mut(), 0.0, &seen), Err(LocalizeError::Message(_))));
        assert_eq!(update(localizer.as_mut(), 0.0, &[]).unwrap(), good);
    }
    let unstarted = update(localizer(&GpsImuParams::default()).as_mut(), 0.0, &[]);
    assert!(matches!(unstarted, Err(LocalizeError::NotStarted)));
}

/// Huge numbers, and claims to be exact or to know nothing.
#[test]
fn a_first_fix_that_claims_nothing_sensible_is_no_harm_for_ever() {
    for fusion in ALL {
        for (at_m, error_m) in [(1.0, 0.0), (1.0, 1e300), (1e300, 1.0), (-1e300, 1e300)] {
            let mut localizer = started(&with(fusion), &Prior::Unknown);
            let odd = [imu(0.0, 0.5), fix(0.0, Vector2::new(at_m, at_m), error_m)];
            // It may be said, or be an error.
            let _ = update(localizer.as_mut(), 0.0, &odd);
            let mut last = None;
            for k in 1..30 {
                let seconds = f64::from(k);
                let seen = [imu(seconds, 0.5), fix(seconds, Vector2::new(3.0, 4.0), 1.0)];
                last = Some(update(localizer.as_mut(), seconds, &seen).unwrap());
            }
            let off_m = apart_m(&last.unwrap(), &pose2(3.0, 4.0, 0.5));
            // Who claimed to be exact is believed longer.
            assert!(off_m < if error_m == 0.0 { 4.0 } else { 0.1 }, "{fusion:?} {at_m} {error_m}: {off_m}");
        }
    }
}

#[test]
fn every_bad_value_is_named() {
    let bad = GpsImuParams {
        error_m: Some(0.0),
        step_noise: -1.0,
        gate: 0.0,
        reset_after: 0,
        outage_s: f64::NAN,
        yaw_deviation_deg: 0.0,
        yaw_bias_deviation_deg: -1.0,
        yaw_bias_walk_deg: f64::INFINITY,
        distance_noise: Some(-1.0),
        direction_noise_deg_m: Some(-1.0),
        turn_noise: Some(-1.0),
        sure_deviation_m: 0.0,
        sure_deviation_deg: 0.0,
        jump_m: -1.0,
        ..GpsImuParams::default()
    };
    let keys: Vec<String> = bad.check().into_iter().map(|fault| fault.path).collect();
    let expected = [
        "distance_noise",
        "direction_noise_deg_m",
        "turn_noise",
        "step_noise",
        "yaw_bias_deviation_deg",
        "yaw_bias_walk_deg",
        "error_m",
        "gate",
        "outage_s",
        "yaw_deviation_deg",
        "sure_deviation_m",
        "sure_deviation_deg",
        "jump_m",
        "reset_after",
    ];
    assert_eq!(keys, expected);
    assert!(GpsImuParams::default().check().is_empty());
    assert!(Registry::linked().unwrap().get(Stage::Localizer, "gps_imu").is_some());
}
