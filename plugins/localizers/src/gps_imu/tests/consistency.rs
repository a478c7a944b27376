//! Is the Kalman filter as sure as it may be? Many robots that err as their sensors say.

use nalgebra::Vector4;
use rand_distr::{Distribution as _, StandardNormal};
use rumbo_core::rng::{self, Rng};

use super::*;
use crate::gps_imu::ekf::{Ekf, EkfSettings};
use crate::gps_imu::motion::{State, antenna_m};
use crate::gps_imu::pulled::Taken;
use crate::gps_imu::seen_fix::SeenFix;

const EKF: EkfSettings = EkfSettings { bias_deviation_rad: 0.15, bias_walk_rad: 0.002, reset_after: 1000 };
/// Of the odometer: distance (m), direction and turn (rad) over a meter or radian.
const NOISE: [f64; 3] = [0.03, 0.02, 0.03];
const YAW_RAD: f64 = 0.02;
const FIX_M: f64 = 1.0;
const PERIOD_S: f64 = 0.1;
const N_ROBOTS: usize = 60;

fn normal(rng: &mut Rng) -> f64 {
    StandardNormal.sample(rng)
}

/// The robot's true state, and what its odometer says of a step.
struct Robot {
    truth: State,
    rng: Rng,
}

impl Robot {
    fn step(&mut self, twist: Twist) -> Pose2 {
        let (way_m, turn_rad) = (twist.forward_m_s * PERIOD_S, twist.turn_rad_s * PERIOD_S);
        // An error with this deviation over a meter adds up with the root of the way.
        let mut error = |deviation: f64, amount: f64| deviation * amount.abs().sqrt() * normal(&mut self.rng);
        let longer_m = error(NOISE[0], way_m);
        let bend_rad = error(NOISE[1], way_m) + error(NOISE[2], turn_rad);
        let went = Twist::new(way_m + longer_m, turn_rad + bend_rad).integrate(1.0);
        let pose = pose2(self.truth[0], self.truth[1], self.truth[2]) * went;
        let bias_rad = self.truth[3] + EKF.bias_walk_rad * PERIOD_S.sqrt() * normal(&mut self.rng);
        self.truth = Vector4::new(pose.translation.x, pose.translation.y, pose.rotation.angle(), bias_rad);
        Twist::new(way_m, turn_rad).integrate(1.0)
    }

    fn fix(&mut self, mount: &Pose3) -> SeenFix {
        let at_m = antenna_m(&self.truth, &mount.translation.vector.xy())
            + Vector2::new(normal(&mut self.rng), normal(&mut self.rng)) * FIX_M;
        let fix = PositionFix { position_m: [at_m.x, at_m.y, 0.0], deviation_m: [FIX_M; 3] };
        SeenFix::new(&fix, mount, &Pose2::identity(), None)
    }

    fn yaw_rad(&mut self) -> f64 {
        wrap_angle(self.truth[2] + self.truth[3] + YAW_RAD * normal(&mut self.rng))
    }
}

/// Normalized squares of the estimation error, for each robot at each of these seconds, and how many readings of all were
/// refused.
fn normalized_squares(seconds: &[usize]) -> (Vec<Vec<f64>>, f64) {
    let (mut squares, mut n_readings, mut n_refused) = (vec![Vec::new(); seconds.len()], 0, 0);
    let mount = Pose3::translation(0.5, 0.2, 1.0);
    for seed in 0..N_ROBOTS as u64 {
        let mut rng = rng::stream(seed, "consistency");
        let bias_rad = EKF.bias_deviation_rad * normal(&mut rng);
        let truth = Vector4::new(3.0, -2.0, wrap_angle(normal(&mut rng) * 2.0), bias_rad);
        let mut robot = Robot { truth, rng };
        let (first, yaw_rad) = (robot.fix(&mount), robot.yaw_rad());
        let mut ekf = Ekf::at_fix(EKF, &first, yaw_rad, YAW_RAD * YAW_RAD);
        for k in 1..=*seconds.last().unwrap() * 10 {
            let seconds_now = 0.1 * k as f64;
            let twist = Twist::new(0.8, 0.5 * (0.3 * seconds_now).sin());
            let step = robot.step(twist);
            ekf.advance(&step, NOISE);
            ekf.age(PERIOD_S);
            let mut taken = vec![ekf.take_yaw(robot.yaw_rad(), YAW_RAD * YAW_RAD)];
            if k % 10 == 0 {
                taken.push(ekf.take_fix(&robot.fix(&mount)));
            }
            n_readings += taken.len();
            n_refused += taken.iter().filter(|taken| **taken != Taken::Used).count();
            if let Some(slot) = seconds.iter().position(|second| second * 10 == k) {
                let mut off = ekf.mean - robot.truth;
                (off[2], off[3]) = (wrap_angle(off[2]), wrap_angle(off[3]));
                let inverse = ekf.covariance.try_inverse().unwrap();
                squares[slot].push((off.transpose() * inverse * off)[(0, 0)]);
            }
        }
    }
    (squares, f64::from(n_refused as u32) / f64::from(n_readings as u32))
}

#[test]
fn errors_are_as_large_as_the_covariance_says() {
    let (squares, refused) = normalized_squares(&[1, 5, 20, 60, 120]);
    for of_second in &squares {
        let mean = of_second.iter().sum::<f64>() / N_ROBOTS as f64;
        // 99.9 % of the means of 60 chi-squares with 4 degrees of freedom lie between these.
        assert!((2.89..5.33).contains(&mean), "{mean}");
    }
    let all = squares.iter().flatten();
    let mean = all.clone().sum::<f64>() / all.count() as f64;
    assert!((mean - 4.0).abs() < 0.6, "{mean}");
    // One in a thousand is beyond the gate by chance.
    assert!(refused < 0.003, "{refused}");
}

/// What the unit is off by, and what it drifts by, comes out on the way.
#[test]
fn the_bias_of_the_measured_yaw_is_found_by_motion_between_fixes_and_followed() {
    let params = GpsImuParams {
        fusion: Fusion::Ekf,
        yaw_bias_deviation_deg: 15.0,
        yaw_bias_walk_deg: 4.0,
        ..GpsImuParams::default()
    };
    let pulled = GpsImuParams { fusion: Fusion::Odometry, ..params.clone() };
    let mut rng = rng::stream(1, "bias");
    let (mut ekf, mut other) = (started(&params, &Prior::Unknown), started(&pulled, &Prior::Unknown));
    let (start, mut worst_deg, mut worst_other_deg) = (pose2(0.0, 0.0, 0.5), 0f64, 0f64);
    for k in 0..3000 {
        let seconds = 0.1 * f64::from(k);
        let odom_from_base = Twist::new(1.0, 0.05).integrate(seconds);
        let truth = start * odom_from_base;
        // Ten degrees at the start, and two more each minute.
        let off_deg = 10.0 + seconds / 30.0;
        let yaw_rad = truth.rotation.angle() + off_deg.to_radians() + 0.01 * normal(&mut rng);
        let mut seen = vec![odometry(seconds, odom_from_base), imu(seconds, yaw_rad)];
        if k % 10 == 0 {
            let error_m = Vector2::new(normal(&mut rng), normal(&mut rng)) * 0.5;
            seen.push(fix(seconds, truth.translation.vector + error_m, 0.5 * 3f64.sqrt()));
        }
        let yaw_error_deg = |estimate: &Estimate| {
            wrap_angle(estimate.pose2().rotation.angle() - truth.rotation.angle()).abs().to_degrees()
        };
        let estimate = update(ekf.as_mut(), seconds, &seen).unwrap();
        let beside = update(other.as_mut(), seconds, &seen).unwrap();
        if seconds > 60.0 {
            worst_deg = worst_deg.max(yaw_error_deg(&estimate));
            worst_other_deg = worst_other_deg.max(yaw_error_deg(&beside));
        }
    }
    // What measures as it is, is off by all of it.
    assert!(worst_deg < 4.0 && worst_other_deg > 18.0, "{worst_deg} {worst_other_deg}");
}
