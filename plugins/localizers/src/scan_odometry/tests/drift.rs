//! The filter of velocity and drift: known answers, and its covariance against what many random drives make.

use super::*;
use nalgebra::Vector3;

const AGILITY: Agility = Agility { speed_m_s: 0.2, turn_rad_s: 0.3, fastest: [1.0, 2.0], floor: [0.0; 2] };

fn numbers(pose: &Pose2) -> Vector3<f64> {
    Vector3::new(pose.translation.x, pose.translation.y, pose.rotation.angle())
}

fn deviation(covariance: &Matrix3<f64>) -> f64 {
    covariance[(0, 0)].sqrt()
}

#[test]
fn a_velocity_is_that_of_the_arc_and_is_carried_on_for_a_while() {
    let motion = Motion::new(Prediction::ConstantVelocity, 0.5, 0.01);
    let mut drift = Drift::new(AGILITY, &Matrix3::zeros());
    let twist = Twist { forward_m_s: 0.5, left_m_s: 0.1, turn_rad_s: 0.7 };
    let times = [0.0, 0.3, 0.6, 0.9, 1.2, 4.0].map(Time::from_secs);
    let mut key_from_base = Pose2::identity();
    let mut age = None;
    for pair in times[..5].windows(2) {
        let guess = motion.guess(pair[0], pair[1], drift.twist(), age);
        let predicted = drift.predicted(&key_from_base, &guess, 0.3);
        if age.is_none() {
            assert_eq!(guess.step, Pose2::identity());
            let deviation_m = deviation(&predicted.base_covariance());
            assert!(
                (deviation_m - 0.3f64.hypot(0.02)).abs() < 1e-9,
                "all that the robot can do: {deviation_m}"
            );
        }
        drift = predicted;
        let beside =
            numbers(&(key_from_base * twist.integrate(0.3))) - numbers(&(key_from_base * guess.step));
        drift.take(&beside, &(Matrix3::identity() * 1e8));
        key_from_base *= twist.integrate(0.3);
        age = Some(rumbo_core::time::Span::from_secs(0.0));
    }
    let said = drift.twist();
    assert!((said.forward_m_s - 0.5).abs() < 0.01 && (said.left_m_s - 0.1).abs() < 0.01, "{said:?}");
    assert!((said.turn_rad_s - 0.7).abs() < 0.01, "{said:?}");
    let long = motion.guess(times[4], times[5], twist, age);
    assert!(apart(&long.step, &twist.integrate(0.5))[0] < 1e-12, "for half a second");
    let covariance = drift.predicted(&key_from_base, &long, 2.8).base_covariance();
    assert!(deviation(&covariance) > 2.0, "and then it may have gone anywhere");
    let late = motion.guess(times[5], Time::from_secs(4.1), twist, Some(times[5] - times[4]));
    assert_eq!(late.step, Pose2::identity());
}

/// Along x nothing is ever seen: what is off there grows with time, since the velocity that is off stays the same.
#[test]
fn along_an_unobserved_direction_the_doubt_grows_with_time_and_the_velocity_stays() {
    let agility = Agility { speed_m_s: 1e-6, ..AGILITY };
    let motion = Motion::new(Prediction::ConstantVelocity, 0.5, 0.01);
    let mut drift = Drift::new(agility, &Matrix3::zeros());
    let (mut odom_from_key, mut key_from_base) = (Pose2::identity(), Pose2::identity());
    let across = Matrix3::from_diagonal(&Vector3::new(0.0, 1e6, 1e6));
    let mut deviations_m = Vec::new();
    for k in 0..40 {
        let age = (k > 0).then(|| rumbo_core::time::Span::from_secs(0.0));
        let guess = motion.guess(Time::ZERO, Time::from_secs(0.1), drift.twist(), age);
        drift = drift.predicted(&key_from_base, &guess, 0.1);
        key_from_base *= guess.step;
        drift.take(&Vector3::new(0.3, 0.0, 0.0), &across);
        deviations_m.push(deviation(&drift.covariance(&odom_from_key, &key_from_base)));
        if k % 7 == 6 {
            drift.begin_key(&odom_from_key, &key_from_base);
            odom_from_key *= std::mem::take(&mut key_from_base);
        }
    }
    assert_eq!(drift.twist().forward_m_s, 0.0, "nothing is learned where nothing is seen");
    let (half_m, whole_m) = (deviations_m[19], deviations_m[39]);
    assert!(
        (half_m - 2.0).abs() < 0.05 && (whole_m - 4.0).abs() < 0.05,
        "1 m/s for 2 and 4 s: {half_m}, {whole_m}"
    );
    // Then something shows the way: velocity and place are known from there on, and what is behind is corrected.
    let age = Some(rumbo_core::time::Span::from_secs(0.0));
    let guess = motion.guess(Time::ZERO, Time::from_secs(0.1), drift.twist(), age);
    drift = drift.predicted(&key_from_base, &guess, 0.1);
    let before = drift.covariance(&odom_from_key, &key_from_base);
    drift.take(&Vector3::new(0.3, 0.0, 0.0), &(Matrix3::identity() * 1e6));
    assert!((drift.twist().forward_m_s - 0.5).abs() < 0.05, "{:?}", drift.twist());
    let after = drift.covariance(&odom_from_key, &key_from_base);
    assert!(deviation(&after) < 0.4 * deviation(&before), "{} {}", deviation(&after), deviation(&before));
}

/// A base whose speed wanders as the filter expects, seen along both axes now and then only: errors are as large as it says.
#[test]
fn the_covariance_is_that_of_many_random_drives() {
    let motion = Motion::new(Prediction::ConstantVelocity, 0.5, 0.01);
    let (mut sum, mut n) = (0.0, 0);
    for seed in 0..300 {
        let mut rng = rng::stream(seed, "drives");
        let mut normal = |deviation: f64| -> f64 {
            let sample: f64 = StandardNormal.sample(&mut rng);
            deviation * sample
        };
        let agility = Agility { fastest: [30.0, 40.0], ..AGILITY };
        let mut drift = Drift::new(agility, &Matrix3::zeros());
        let mut twist = Twist { forward_m_s: 0.4, left_m_s: 0.0, turn_rad_s: 0.2 };
        let (mut odom_from_key, mut key_from_base) = (Pose2::identity(), Pose2::identity());
        let (mut map_from_key, mut truth) = (Pose2::identity(), Pose2::identity());
        for k in 0..60 {
            let root = 0.1f64.sqrt();
            twist.forward_m_s += normal(0.2 * root);
            twist.left_m_s += normal(0.2 * root);
            twist.turn_rad_s += normal(0.3 * root);
            truth *= twist.integrate(0.1) * pose2(normal(0.02), normal(0.02), normal(0.02));
            let age = (k > 0).then(|| rumbo_core::time::Span::from_secs(0.0));
            let guess = motion.guess(Time::ZERO, Time::from_secs(0.1), drift.twist(), age);
            drift = drift.predicted(&key_from_base, &guess, 0.1);
            let predicted = key_from_base * guess.step;
            let along = if k % 20 < 12 { 1e4 } else { 0.0 };
            let information = Matrix3::from_diagonal(&Vector3::new(along, 1e4, 1e4));
            let noise = Vector3::new(normal(0.01), normal(0.01), normal(0.01));
            let beside = numbers(&(map_from_key.inverse() * truth)) + noise - numbers(&predicted);
            let correction = drift.take(&beside, &information);
            let at = numbers(&predicted) + correction.base;
            key_from_base = pose2(at.x, at.y, at.z);
            let at = numbers(&odom_from_key) + correction.key;
            odom_from_key = pose2(at.x, at.y, at.z);
            if k % 5 == 4 {
                drift.begin_key(&odom_from_key, &key_from_base);
                odom_from_key *= std::mem::take(&mut key_from_base);
                map_from_key = truth;
            }
        }
        let mut error = numbers(&truth) - numbers(&(odom_from_key * key_from_base));
        error.z = wrap_angle(error.z);
        let covariance = drift.covariance(&odom_from_key, &key_from_base);
        sum += error.dot(&(covariance.try_inverse().unwrap() * error));
        n += 1;
    }
    let mean_nees = sum / f64::from(n);
    assert!((2.4..3.9).contains(&mean_nees), "{mean_nees}, 3 is right");
}
