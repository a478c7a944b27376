//! Dead reckoning: wheel counts into a pose. The pose is summed up exactly; only counts and reports are rounded.

use rumbo_core::frames::{Pose2, Twist, pose2, wrap_angle};
use rumbo_core::robot::Drive;
use rumbo_core::stages::WheelMotion;

/// Steps of the device; 0 for a quantity that is not rounded.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Steps {
    /// Rolled distance of one encoder count, meters.
    pub wheel_m: f64,
    /// Step of the reported position, meters.
    pub position_m: f64,
    /// Step of the reported heading, radians.
    pub heading_rad: f64,
}

/// Sums up what the wheels rolled.
#[derive(Debug, Clone)]
pub struct Odometer {
    drive: Drive,
    steps: Steps,
    /// Wheels at the start and at the last update, counted in steps.
    start: Option<WheelMotion>,
    last: Counted,
    odom_from_base: Pose2,
}

/// Distances since the start, rounded to counts.
#[derive(Debug, Clone, Copy, Default)]
struct Counted {
    rolled_m: [f64; 2],
    turned_rad: f64,
}

/// The device counts full steps, as an encoder's edges do; the hair keeps a full step full despite rounding.
fn counted(value: f64, step: f64) -> f64 {
    if step > 0.0 { (value / step + 1e-9).floor() * step } else { value }
}

fn rounded(value: f64, step: f64) -> f64 {
    if step > 0.0 { (value / step).round() * step } else { value }
}

impl Odometer {
    /// An odometer that starts at its first update.
    pub fn new(drive: Drive, steps: Steps) -> Self {
        Self { drive, steps, start: None, last: Counted::default(), odom_from_base: Pose2::identity() }
    }

    /// Takes in where the wheels are; the motion since the last update, in the base frame.
    pub fn update(&mut self, wheels: &WheelMotion) -> Twist {
        let start = *self.start.get_or_insert(*wheels);
        let rolled = |idx: usize| counted(wheels.rolled_m[idx] - start.rolled_m[idx], self.steps.wheel_m);
        let now = Counted {
            rolled_m: [rolled(0), rolled(1)],
            turned_rad: counted(wheels.turned_rad - start.turned_rad, self.turn_step_rad()),
        };
        let [first_m, second_m] = [0, 1].map(|idx| now.rolled_m[idx] - self.last.rolled_m[idx]);
        let moved = match self.drive {
            Drive::Differential { track_m } | Drive::Tricycle { track_m, .. } => {
                Twist::new((first_m + second_m) / 2.0, (second_m - first_m) / track_m)
            }
            _ => Twist {
                forward_m_s: first_m,
                left_m_s: second_m,
                turn_rad_s: now.turned_rad - self.last.turned_rad,
            },
        };
        self.odom_from_base *= moved.integrate(1.0);
        self.last = now;
        moved
    }

    /// Turn of an omnidirectional base in counts: its wheels sit about a quarter meter out.
    fn turn_step_rad(&self) -> f64 {
        self.steps.wheel_m / 0.25
    }

    /// The pose as the device reports it.
    pub fn report(&self) -> Pose2 {
        let Steps { position_m, heading_rad, .. } = self.steps;
        let position = self.odom_from_base.translation.vector.map(|part| rounded(part, position_m));
        pose2(position.x, position.y, wrap_angle(rounded(self.odom_from_base.rotation.angle(), heading_rad)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DIFFERENTIAL: Drive = Drive::Differential { track_m: 0.4 };

    fn wheels(left_m: f64, right_m: f64) -> WheelMotion {
        WheelMotion { rolled_m: [left_m, right_m, 0.0, 0.0], n_wheels: 2, ..WheelMotion::default() }
    }

    #[test]
    fn the_first_update_is_the_origin_and_arcs_are_exact() {
        let mut odometer = Odometer::new(DIFFERENTIAL, Steps::default());
        assert_eq!(odometer.update(&wheels(7.0, 8.0)), Twist::ZERO);
        // A quarter circle of radius 1 to the left: the wheels at 0.8 and 1.2.
        let quarter = std::f64::consts::FRAC_PI_2;
        odometer.update(&wheels(7.0 + 0.8 * quarter, 8.0 + 1.2 * quarter));
        let pose = odometer.report();
        assert!((pose.translation.vector - nalgebra::Vector2::new(1.0, 1.0)).norm() < 1e-12);
        assert!((pose.rotation.angle() - quarter).abs() < 1e-12);
    }

    #[test]
    fn reports_are_rounded_and_the_sum_behind_them_is_not() {
        let steps = Steps { position_m: 0.00254, heading_rad: 0.1f64.to_radians(), wheel_m: 0.0 };
        let mut odometer = Odometer::new(DIFFERENTIAL, steps);
        odometer.update(&wheels(0.0, 0.0));
        for millimeter in 1..=1000 {
            let rolled = f64::from(millimeter) * 0.001;
            odometer.update(&wheels(rolled, rolled));
        }
        // 1 m is 393.7 steps: rounded once, not a thousand times.
        assert!((odometer.report().translation.x - 394.0 * 0.00254).abs() < 1e-12);
        odometer.update(&wheels(1.0, 1.0 + 0.4 * 0.0123));
        let heading_deg = odometer.report().rotation.angle().to_degrees();
        assert!((heading_deg - 0.7).abs() < 1e-9, "0.0123 rad is 0.705 degrees");
    }

    #[test]
    fn encoders_count_full_steps_forwards_and_back() {
        let mut odometer = Odometer::new(DIFFERENTIAL, Steps { wheel_m: 0.01, ..Steps::default() });
        odometer.update(&wheels(0.0, 0.0));
        let mut x = |rolled: f64| {
            odometer.update(&wheels(rolled, rolled));
            odometer.report().translation.x
        };
        assert_eq!(x(0.0099), 0.0);
        assert!((x(0.0301) - 0.03).abs() < 1e-12);
        assert!((x(-0.001) + 0.01).abs() < 1e-12);
        assert!(x(0.0).abs() < 1e-12);
    }

    #[test]
    fn an_omnidirectional_base_moves_sideways_and_turns() {
        let mut odometer = Odometer::new(Drive::Omnidirectional {}, Steps::default());
        odometer.update(&wheels(0.0, 0.0));
        let moved = odometer.update(&WheelMotion { turned_rad: 0.5, ..wheels(0.3, -0.2) });
        assert_eq!(moved, Twist { forward_m_s: 0.3, left_m_s: -0.2, turn_rad_s: 0.5 });
        assert!((odometer.report().rotation.angle() - 0.5).abs() < 1e-12);
    }
}
