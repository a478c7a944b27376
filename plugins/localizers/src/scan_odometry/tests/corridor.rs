//! A corridor whose ends are far out of reach: scans show everything but the way along it.

use super::*;

/// Two bare walls.
const BARE: Boxes = &[[-500.0, -1.1, 500.0, 1.3]];

/// Truth and what is said, after each scan, of a robot with this speed at each scan.
fn drive(boxes: Boxes, seed: u32, n: u32, speed_m_s: impl Fn(u32) -> f64) -> Vec<(Pose2, Estimate)> {
    let mut localizer = started(&ScanOdometryParams::default());
    let (mut at, mut said) = (pose2(0.0, 0.05 * f64::from(seed), 0.02 * f64::from(seed)), Vec::new());
    let (begin, corridor) = (at, Pose2::rotation(at.rotation.angle()));
    for k in 0..n {
        let seconds = 0.2 * f64::from(k);
        let mut scan = scan(boxes, &at, seconds + 1000.0 * f64::from(seed));
        scan.stamp = Time::from_secs(seconds);
        let mut estimate = update(&mut *localizer, seconds, &[scan]);
        turn_to(&corridor, &mut estimate);
        said.push((corridor * begin.inverse() * at, estimate));
        at *= Twist::new(speed_m_s(k), 0.0).integrate(0.2);
    }
    said
}

/// An estimate in the axes of the corridor, which the robot does not look along when it starts.
fn turn_to(corridor: &Pose2, estimate: &mut Estimate) {
    let turn = corridor.rotation.to_rotation_matrix().to_homogeneous();
    let covariance = turn * estimate.covariance2() * turn.transpose();
    *estimate = Estimate::planar(estimate.stamp, corridor * estimate.pose2(), Pose2::identity(), covariance);
}

/// Squared error over what the covariance says, and the error, meters and radians.
fn nees(truth: &Pose2, estimate: &Estimate) -> (f64, [f64; 3]) {
    let said = estimate.pose2();
    let error = nalgebra::Vector3::new(
        said.translation.x - truth.translation.x,
        said.translation.y - truth.translation.y,
        wrap_angle(said.rotation.angle() - truth.rotation.angle()),
    );
    let inverse = estimate.covariance2().try_inverse().unwrap();
    (error.dot(&(inverse * error)), error.into())
}

#[test]
fn a_robot_that_starts_in_a_bare_corridor_learns_no_speed_and_says_that_it_may_be_anywhere_along_it() {
    for seed in 1..=3 {
        for (truth, estimate) in drive(BARE, seed, 60, |_| 0.4).iter().skip(1) {
            let (nees, [along_m, across_m, turn_rad]) = nees(truth, estimate);
            let said_m = estimate.pose2().translation.x;
            assert!(said_m.abs() < 0.3, "seed {seed}: {said_m} m were learned from noise");
            assert!(
                along_m < 0.3 && across_m.abs() < 0.03 && turn_rad.abs() < 0.01,
                "seed {seed}: {across_m} {turn_rad}"
            );
            assert!(nees < 11.3, "seed {seed}: {nees} of 3, {along_m} m off");
            let deviation_m = estimate.covariance2()[(0, 0)].sqrt();
            assert!(deviation_m > 0.4 * truth.translation.x, "{deviation_m} m after {}", truth.translation.x);
        }
    }
}

#[test]
fn a_speed_that_a_pillar_showed_is_carried_on_and_the_covariance_holds_the_truth_when_it_changes() {
    for seed in 1..=3 {
        let constant = drive(CORRIDOR, seed, 41, |_| 0.4);
        let (truth, estimate) = &constant[40];
        let (nees_then, [along_m, ..]) = nees(truth, estimate);
        assert!(
            along_m.abs() < 0.35 && nees_then < 11.3,
            "seed {seed}: {along_m} m of {}, {nees_then}",
            truth.translation.x
        );
        let slower = drive(CORRIDOR, seed, 41, |k| if k < 20 { 0.4 } else { 0.2 });
        for (k, (truth, estimate)) in slower.iter().enumerate().skip(1) {
            let (nees_then, error) = nees(truth, estimate);
            assert!(nees_then < 11.3, "seed {seed}, scan {k}: {nees_then} of 3, {error:?}");
        }
        let (_, [along_m, ..]) = nees(&slower[40].0, &slower[40].1);
        assert!((0.2..1.2).contains(&along_m), "it goes on at 0.4 m/s: {along_m}");
    }
}
