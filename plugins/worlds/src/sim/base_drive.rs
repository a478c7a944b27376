//! Wheels: a wanted velocity becomes a real one, within the limits of motors, brakes and steering.

use rumbo_core::frames::Twist;
use rumbo_core::robot::{Drive, Robot};
use rumbo_core::stages::WheelMotion;

/// What motors and brakes can do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveLimits {
    /// Fastest speed.
    pub speed_m_s: f64,
    /// Fastest turn.
    pub turn_rad_s: f64,
    /// Fastest gain of speed.
    pub accel_m_s2: f64,
    /// Fastest loss of speed.
    pub braking_m_s2: f64,
    /// Fastest change of turn.
    pub turn_accel_rad_s2: f64,
}

impl DriveLimits {
    /// The limits of a robot.
    pub fn of(robot: &Robot) -> Self {
        Self {
            speed_m_s: robot.max_speed_m_s,
            turn_rad_s: robot.max_turn_rad_s(),
            accel_m_s2: robot.max_accel_m_s2,
            braking_m_s2: robot.braking_m_s2.max(robot.max_accel_m_s2),
            turn_accel_rad_s2: robot.max_turn_accel_rad_s2(),
        }
    }
}

/// The drive's state.
#[derive(Debug, Clone)]
pub struct BaseDrive {
    drive: Drive,
    limits: DriveLimits,
    wanted: Twist,
    /// Velocity that the wheels make now.
    pub twist: Twist,
    /// Rolling since the start.
    pub wheels: WheelMotion,
}

/// Mean of a value that ramps from `now` towards `target`, and where it ends.
fn ramp(now: f64, target: f64, rate: f64, seconds: f64) -> (f64, f64) {
    let gap = target - now;
    let ramp_s = gap.abs() / rate;
    if ramp_s >= seconds {
        let end = now + gap.signum() * rate * seconds;
        return ((now + end) / 2.0, end);
    }
    (((now + target) / 2.0 * ramp_s + target * (seconds - ramp_s)) / seconds, target)
}

impl BaseDrive {
    /// A drive at rest.
    pub fn new(drive: Drive, limits: DriveLimits) -> Self {
        let wheels = WheelMotion { n_wheels: 2, ..WheelMotion::default() };
        Self { drive, limits, wanted: Twist::ZERO, twist: Twist::ZERO, wheels }
    }

    /// Takes a velocity, cut to what this drive can do.
    pub fn want(&mut self, twist: Twist) {
        let DriveLimits { speed_m_s, turn_rad_s, .. } = self.limits;
        let twist = self.drive.feasible(twist);
        // One factor for all parts keeps the curve.
        let over = (twist.speed_m_s() / speed_m_s).max(twist.turn_rad_s.abs() / turn_rad_s);
        self.wanted = twist.scaled(1.0 / over.max(1.0));
    }

    /// Speeds up or slows down for `seconds`; the mean velocity of that time.
    pub fn accelerate(&mut self, seconds: f64) -> Twist {
        let (forward, left) = self.ramped_speeds(seconds);
        let (mean_turn, turn) = if let Drive::Tricycle { .. } = self.drive {
            self.steer(forward, seconds)
        } else {
            ramp(self.twist.turn_rad_s, self.wanted.turn_rad_s, self.limits.turn_accel_rad_s2, seconds)
        };
        self.twist = Twist { forward_m_s: forward.1, left_m_s: left.1, turn_rad_s: turn };
        Twist { forward_m_s: forward.0, left_m_s: left.0, turn_rad_s: mean_turn }
    }

    /// Mean and final speeds, forward and to the left; both ramp along a straight line in the plane of velocities.
    fn ramped_speeds(&self, seconds: f64) -> ((f64, f64), (f64, f64)) {
        let (now, wanted) = (self.twist, self.wanted);
        let gap = (wanted.forward_m_s - now.forward_m_s).hypot(wanted.left_m_s - now.left_m_s);
        let slows = wanted.speed_m_s() < now.speed_m_s() || wanted.forward_m_s * now.forward_m_s < 0.0;
        let rate = if slows { self.limits.braking_m_s2 } else { self.limits.accel_m_s2 };
        let part = |now: f64, wanted: f64| {
            let share = if gap > 0.0 { (wanted - now).abs() / gap } else { 1.0 };
            if share == 0.0 { (wanted, wanted) } else { ramp(now, wanted, rate * share, seconds) }
        };
        (part(now.forward_m_s, wanted.forward_m_s), part(now.left_m_s, wanted.left_m_s))
    }

    /// Turns the steered wheel towards the wanted curve; mean and final turn of the base.
    fn steer(&mut self, forward: (f64, f64), seconds: f64) -> (f64, f64) {
        let Drive::Tricycle { max_steer_deg, max_steer_rate_deg_s, .. } = self.drive else {
            return (0.0, 0.0);
        };
        let Some(ahead_m) = self.drive.steered_ahead_m() else { return (0.0, 0.0) };
        let most = max_steer_deg.to_radians();
        // At rest the wheel stays where it is: no angle turns a standing tricycle.
        let target = if self.wanted.forward_m_s.abs() < 1e-9 {
            self.wheels.steering_rad
        } else {
            (self.wanted.turn_rad_s * ahead_m / self.wanted.forward_m_s).atan().clamp(-most, most)
        };
        let rate = max_steer_rate_deg_s.to_radians();
        let (mean, end) = ramp(self.wheels.steering_rad, target, rate, seconds);
        self.wheels.steering_rad = end;
        (forward.0 * mean.tan() / ahead_m, forward.1 * end.tan() / ahead_m)
    }

    /// Counts what the wheels rolled in `seconds` at this velocity.
    pub fn roll(&mut self, twist: Twist, seconds: f64) {
        match self.drive {
            Drive::Omnidirectional {} => {
                self.wheels.rolled_m[0] += twist.forward_m_s * seconds;
                self.wheels.rolled_m[1] += twist.left_m_s * seconds;
            }
            Drive::Differential { track_m } | Drive::Tricycle { track_m, .. } => {
                let half = twist.turn_rad_s * track_m / 2.0;
                self.wheels.rolled_m[0] += (twist.forward_m_s - half) * seconds;
                self.wheels.rolled_m[1] += (twist.forward_m_s + half) * seconds;
            }
            _ => {}
        }
        self.wheels.turned_rad += twist.turn_rad_s * seconds;
        self.wheels.twist = self.twist;
    }

    /// Something stopped the robot.
    pub fn stall(&mut self) {
        self.twist = Twist::ZERO;
        self.wheels.twist = Twist::ZERO;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_core::robot::SteeredWheel;

    const LIMITS: DriveLimits = DriveLimits {
        speed_m_s: 1.0,
        turn_rad_s: 2.0,
        accel_m_s2: 0.5,
        braking_m_s2: 1.0,
        turn_accel_rad_s2: 4.0,
    };

    fn distance_m(drive: &mut BaseDrive, seconds: f64, n_pieces: usize) -> f64 {
        let piece_s = seconds / n_pieces as f64;
        (0..n_pieces).map(|_| drive.accelerate(piece_s).forward_m_s * piece_s).sum()
    }

    /// From rest to 1 m/s at 0.5 m/s²: 1 m in 2 s; then 1 m a second; then 0.5 m of braking.
    #[test]
    fn ramps_cover_the_exact_distance_in_any_number_of_pieces() {
        for n_pieces in [1, 7, 300] {
            let mut drive = BaseDrive::new(Drive::Differential { track_m: 0.4 }, LIMITS);
            drive.want(Twist::new(5.0, 0.0));
            assert!((distance_m(&mut drive, 3.0, n_pieces) - 2.0).abs() < 1e-12);
            assert_eq!(drive.twist.forward_m_s, 1.0, "cut to the limit");
            drive.want(Twist::ZERO);
            assert!((distance_m(&mut drive, 2.0, n_pieces) - 0.5).abs() < 1e-12);
            assert_eq!(drive.twist, Twist::ZERO);
        }
    }

    #[test]
    fn a_twist_over_the_limits_keeps_its_curve() {
        let mut drive = BaseDrive::new(Drive::Differential { track_m: 0.4 }, LIMITS);
        drive.want(Twist { forward_m_s: 0.5, left_m_s: 3.0, turn_rad_s: -4.0 });
        assert_eq!(drive.wanted, Twist::new(0.25, -2.0));
    }

    #[test]
    fn wheels_roll_what_the_axle_geometry_says() {
        let mut drive = BaseDrive::new(Drive::Differential { track_m: 0.4 }, LIMITS);
        drive.roll(Twist::new(1.0, 0.5), 2.0);
        assert!(
            (drive.wheels.rolled_m[0] - 1.8).abs() < 1e-12 && (drive.wheels.rolled_m[1] - 2.2).abs() < 1e-12
        );
        let mut omni = BaseDrive::new(Drive::Omnidirectional {}, LIMITS);
        omni.roll(Twist { forward_m_s: 0.1, left_m_s: -0.2, turn_rad_s: 0.3 }, 10.0);
        assert_eq!((omni.wheels.rolled_m[..2].to_vec(), omni.wheels.turned_rad), (vec![1.0, -2.0], 3.0));
    }

    #[test]
    fn a_tricycle_turns_as_its_wheel_points_and_the_wheel_takes_its_time() {
        let tricycle = Drive::Tricycle {
            wheelbase_m: 1.0,
            track_m: 0.8,
            max_steer_deg: 60.0,
            max_steer_rate_deg_s: 30.0,
            steered: SteeredWheel::Front,
        };
        let mut drive = BaseDrive::new(tricycle, LIMITS);
        drive.want(Twist::new(0.5, 0.5));
        drive.accelerate(1.0);
        assert!((drive.wheels.steering_rad - 30f64.to_radians()).abs() < 1e-12, "45 degrees take 1.5 s");
        assert!((drive.twist.turn_rad_s - 0.5 * 30f64.to_radians().tan()).abs() < 1e-12);
        drive.accelerate(1.0);
        assert!((drive.twist.turn_rad_s - 0.5).abs() < 1e-12);
        drive.want(Twist::new(0.0, 1.0));
        drive.accelerate(1.0);
        assert_eq!(drive.twist.turn_rad_s, 0.0, "a standing tricycle does not turn");
    }

    /// The other way about, a wheel behind the axle points to the outside of the curve.
    #[test]
    fn a_forklift_steers_with_its_rear_wheel() {
        let forklift = Drive::Tricycle {
            wheelbase_m: 1.3,
            track_m: 0.9,
            max_steer_deg: 60.0,
            max_steer_rate_deg_s: 90.0,
            steered: SteeredWheel::Rear,
        };
        let mut drive = BaseDrive::new(forklift, LIMITS);
        drive.want(Twist::new(0.5, 0.2));
        drive.accelerate(2.0);
        assert!((drive.wheels.steering_rad - (-1.3f64 * 0.2 / 0.5).atan()).abs() < 1e-12);
        assert!((drive.twist.turn_rad_s - 0.2).abs() < 1e-12);
        drive.want(Twist::new(-0.5, 0.2));
        drive.accelerate(4.0);
        assert!((drive.wheels.steering_rad - (1.3f64 * 0.2 / 0.5).atan()).abs() < 1e-12, "backwards");
        assert!((drive.twist.turn_rad_s - 0.2).abs() < 1e-12);
    }

    #[test]
    fn an_omnidirectional_base_changes_direction_along_a_straight_line() {
        let mut drive = BaseDrive::new(Drive::Omnidirectional {}, LIMITS);
        drive.want(Twist { forward_m_s: 0.3, left_m_s: 0.4, turn_rad_s: 0.0 });
        drive.accelerate(0.5);
        assert!((drive.twist.forward_m_s - 0.15).abs() < 1e-12 && (drive.twist.left_m_s - 0.2).abs() < 1e-12);
    }
}
