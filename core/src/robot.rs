//! The robot as every stage sees it: drive, hull, limits.

use crate::frames::{Point2, Twist};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the robot moves.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum Drive {
    /// Two driven wheels on one axle; turns in place.
    Differential {
        /// Distance between the wheels, meters.
        track_m: f64,
    },
    /// One steered, driven wheel before or behind a fixed axle; the base frame is at the middle of the axle.
    Tricycle {
        /// From the axle to the steered wheel, meters.
        wheelbase_m: f64,
        /// Distance between the wheels of the axle, meters.
        track_m: f64,
        /// Largest steering angle, degrees.
        max_steer_deg: f64,
        /// Fastest change of the steering angle, degrees per second.
        max_steer_rate_deg_s: f64,
        /// Where the steered wheel is.
        #[serde(default)]
        steered: SteeredWheel,
    },
    /// Moves in every direction and turns at the same time.
    Omnidirectional {},
}

/// Where the steered wheel of a tricycle is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SteeredWheel {
    /// Before the axle, as on a child's tricycle.
    #[default]
    Front,
    /// Behind the axle, as on a forklift.
    Rear,
}

/// The kind of a [`Drive`], which plugins declare they can steer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum DriveKind {
    /// See [`Drive::Differential`].
    Differential,
    /// See [`Drive::Tricycle`].
    Tricycle,
    /// See [`Drive::Omnidirectional`].
    Omnidirectional,
}

impl DriveKind {
    /// All of them.
    pub const ALL: &'static [DriveKind] =
        &[DriveKind::Differential, DriveKind::Tricycle, DriveKind::Omnidirectional];

    /// The word used in messages and files.
    pub fn name(self) -> &'static str {
        match self {
            DriveKind::Differential => "differential",
            DriveKind::Tricycle => "tricycle",
            DriveKind::Omnidirectional => "omnidirectional",
        }
    }
}

impl Drive {
    /// Its kind.
    pub fn kind(&self) -> DriveKind {
        match self {
            Drive::Differential { .. } => DriveKind::Differential,
            Drive::Tricycle { .. } => DriveKind::Tricycle,
            Drive::Omnidirectional {} => DriveKind::Omnidirectional,
        }
    }

    /// Smallest radius that the base frame can turn on, meters; zero where the robot turns in place.
    pub fn turning_radius_m(&self) -> f64 {
        match *self {
            Drive::Tricycle { wheelbase_m, max_steer_deg, .. } => {
                (wheelbase_m / max_steer_deg.to_radians().tan()).max(0.0)
            }
            _ => 0.0,
        }
    }

    /// Where the steered wheel of a tricycle is, meters ahead of the axle: negative behind it. Steering to `angle` turns the
    /// base by `forward_m_s * angle.tan()` over this.
    pub fn steered_ahead_m(&self) -> Option<f64> {
        match *self {
            Drive::Tricycle { wheelbase_m, steered: SteeredWheel::Front, .. } => Some(wheelbase_m),
            Drive::Tricycle { wheelbase_m, steered: SteeredWheel::Rear, .. } => Some(-wheelbase_m),
            _ => None,
        }
    }

    /// The nearest twist that this drive can do: no sideways part unless it is omnidirectional, and for a tricycle no
    /// tighter curve than its steering allows (the turn is cut, the speed kept).
    pub fn feasible(&self, twist: Twist) -> Twist {
        match self {
            Drive::Differential { .. } => Twist { left_m_s: 0.0, ..twist },
            Drive::Omnidirectional {} => twist,
            Drive::Tricycle { .. } => {
                let most = twist.forward_m_s.abs() / self.turning_radius_m().max(1e-9);
                Twist::new(twist.forward_m_s, twist.turn_rad_s.clamp(-most, most))
            }
        }
    }
}

/// The outline of the robot on the floor.
#[doc(alias = "footprint")]
#[derive(Debug, Clone, PartialEq)]
pub enum Hull {
    /// A disc around the base frame.
    Disc {
        /// Its radius, meters.
        radius_m: f64,
    },
    /// A polygon in the base frame, counter-clockwise.
    Polygon(Vec<Point2>),
}

impl Hull {
    /// Radius of the smallest disc around the base frame that contains the hull, meters.
    pub fn outer_radius_m(&self) -> f64 {
        match self {
            Hull::Disc { radius_m } => *radius_m,
            Hull::Polygon(corners) => corners.iter().map(|c| c.coords.norm()).fold(0.0, f64::max),
        }
    }

    /// Radius of the largest disc around the base frame inside the hull, meters.
    pub fn inner_radius_m(&self) -> f64 {
        match self {
            Hull::Disc { radius_m } => *radius_m,
            Hull::Polygon(_) => (-self.distance_m(Point2::origin())).max(0.0),
        }
    }

    /// Signed distance from a point of the base frame to the hull, meters; negative inside.
    pub fn distance_m(&self, point: Point2) -> f64 {
        match self {
            Hull::Disc { radius_m } => point.coords.norm() - radius_m,
            Hull::Polygon(corners) => polygon_distance_m(corners, point),
        }
    }
}

/// Signed distance to a simple polygon: even-odd rule for the sign, nearest edge for the size.
fn polygon_distance_m(corners: &[Point2], point: Point2) -> f64 {
    let (mut nearest, mut inside) = (f64::INFINITY, false);
    for (a, b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        let (edge, to_point) = (b - a, point - a);
        let along = (to_point.dot(&edge) / edge.norm_squared().max(1e-18)).clamp(0.0, 1.0);
        nearest = nearest.min((to_point - edge * along).norm());
        if (a.y > point.y) != (b.y > point.y) && point.x < a.x + (point.y - a.y) / (b.y - a.y) * edge.x {
            inside = !inside;
        }
    }
    if inside { -nearest } else { nearest }
}

/// The last line of defense before the wheels.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct GuardParams {
    /// Free space that stays between hull and obstacle after a full stop, meters.
    pub margin_m: f64,
    /// Time from a reading to the brakes, seconds.
    pub latency_s: f64,
    /// A range sensor or an estimate older than this stops the robot, seconds.
    pub stale_after_s: f64,
    /// Obstacles are watched; switch off only where no sensor can see any.
    pub stop_zone: bool,
}

impl Default for GuardParams {
    fn default() -> Self {
        GuardParams { margin_m: 0.03, latency_s: 0.1, stale_after_s: 1.0, stop_zone: true }
    }
}

/// The table `[robot]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Robot {
    /// How it moves.
    pub drive: Drive,
    /// Radius of a round robot, meters; used where `footprint_m` is empty.
    pub radius_m: f64,
    /// Corners of the hull in the base frame, counter-clockwise, `[x, y]` in meters; empty for a round robot.
    pub footprint_m: Vec<[f64; 2]>,
    /// Height of the robot, meters: what hangs higher is no obstacle.
    pub height_m: f64,
    /// Fastest speed, m/s.
    pub max_speed_m_s: f64,
    /// Fastest turn, degrees per second.
    pub max_turn_deg_s: f64,
    /// Fastest change of speed, m/s².
    pub max_accel_m_s2: f64,
    /// Fastest change of turn, degrees per second squared.
    pub max_turn_accel_deg_s2: f64,
    /// Deceleration that the brakes surely reach, m/s².
    pub braking_m_s2: f64,
    /// The last line of defense before the wheels.
    pub guard: GuardParams,
}

impl Default for Robot {
    fn default() -> Self {
        Robot {
            drive: Drive::Differential { track_m: 0.36 },
            radius_m: 0.20,
            footprint_m: Vec::new(),
            height_m: 0.5,
            max_speed_m_s: 0.5,
            max_turn_deg_s: 60.0,
            max_accel_m_s2: 0.5,
            max_turn_accel_deg_s2: 120.0,
            braking_m_s2: 0.5,
            guard: GuardParams::default(),
        }
    }
}

impl Robot {
    /// The outline.
    pub fn hull(&self) -> Hull {
        if self.footprint_m.len() < 3 {
            return Hull::Disc { radius_m: self.radius_m };
        }
        Hull::Polygon(self.footprint_m.iter().map(|[x, y]| Point2::new(*x, *y)).collect())
    }

    /// Fastest turn, rad/s.
    pub fn max_turn_rad_s(&self) -> f64 {
        self.max_turn_deg_s.to_radians()
    }

    /// Fastest change of turn, rad/s².
    pub fn max_turn_accel_rad_s2(&self) -> f64 {
        self.max_turn_accel_deg_s2.to_radians()
    }

    /// From the reading that says so to a standstill, meters: the way of a reaction and of the brakes.
    pub fn stopping_m(&self, speed_m_s: f64) -> f64 {
        speed_m_s.powi(2) / (2.0 * self.braking_m_s2) + speed_m_s * self.guard.latency_s
    }

    /// The fastest speed that stops within `free_m`, 0 or more: the inverse of [`stopping_m`](Self::stopping_m).
    pub fn stops_within_m_s(&self, free_m: f64) -> f64 {
        let (b, latency_s) = (self.braking_m_s2, self.guard.latency_s);
        b * ((latency_s.powi(2) + 2.0 * free_m / b).sqrt() - latency_s)
    }

    /// Every impossible number: the key below `[robot]`, and what is wrong.
    pub fn faults(&self) -> Vec<(String, String)> {
        let mut faults = Vec::new();
        let mut above = |key: &str, value: f64, least: f64| {
            let fine = value.is_finite() && if least > 0.0 { value >= least } else { value > 0.0 };
            if !fine {
                let more = if least > 0.0 { format!("at least {least}") } else { "above zero".into() };
                faults.push((key.to_owned(), format!("is {value}, expected a finite number {more}")));
            }
        };
        above("radius_m", self.radius_m, 0.0);
        above("height_m", self.height_m, 0.0);
        above("max_speed_m_s", self.max_speed_m_s, 0.0);
        above("max_turn_deg_s", self.max_turn_deg_s, 0.0);
        above("max_accel_m_s2", self.max_accel_m_s2, 0.0);
        above("max_turn_accel_deg_s2", self.max_turn_accel_deg_s2, 0.0);
        above("braking_m_s2", self.braking_m_s2, 0.0);
        above("guard.stale_after_s", self.guard.stale_after_s, 0.0);
        match self.drive {
            Drive::Differential { track_m } => above("drive.track_m", track_m, 0.0),
            Drive::Tricycle { wheelbase_m, track_m, max_steer_deg, max_steer_rate_deg_s, .. } => {
                above("drive.wheelbase_m", wheelbase_m, 0.0);
                above("drive.track_m", track_m, 0.0);
                above("drive.max_steer_deg", max_steer_deg, 0.0);
                above("drive.max_steer_rate_deg_s", max_steer_rate_deg_s, 0.0);
                if max_steer_deg >= 90.0 {
                    let wrong = format!("is {max_steer_deg}, expected less than 90");
                    faults.push(("drive.max_steer_deg".into(), wrong));
                }
            }
            Drive::Omnidirectional {} => {}
        }
        for (key, value) in
            [("guard.margin_m", self.guard.margin_m), ("guard.latency_s", self.guard.latency_s)]
        {
            if !(value.is_finite() && value >= 0.0) {
                faults.push((key.into(), format!("is {value}, expected a finite number of at least zero")));
            }
        }
        self.footprint_faults(&mut faults);
        faults
    }

    fn footprint_faults(&self, faults: &mut Vec<(String, String)>) {
        let n_corners = self.footprint_m.len();
        if n_corners == 0 {
            return;
        }
        let mut wrong = |what: String| faults.push(("footprint_m".into(), what));
        if n_corners < 3 {
            return wrong(format!("has {n_corners} corners, expected at least 3, or none for a round robot"));
        }
        if self.footprint_m.iter().flatten().any(|v| !v.is_finite()) {
            return wrong("has a number that is not finite".into());
        }
        if self.hull().distance_m(Point2::origin()) >= 0.0 {
            wrong("does not contain the base frame's origin, expected corners around (0, 0)".into());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distance_to_a_square_hull_is_signed() {
        let square = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let hull = Robot { footprint_m: square.to_vec(), ..Robot::default() }.hull();
        for (x, y, expected) in [(0.0, 0.0, -1.0), (2.0, 0.0, 1.0), (4.0, 5.0, 5.0), (0.9, 0.0, -0.1)] {
            assert!((hull.distance_m(Point2::new(x, y)) - expected).abs() < 1e-12, "{x} {y}");
        }
        assert!((hull.outer_radius_m() - 2f64.sqrt()).abs() < 1e-12);
        assert!((hull.inner_radius_m() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_tricycle_keeps_its_speed_and_cuts_its_turn() {
        let drive = Drive::Tricycle {
            wheelbase_m: 1.0,
            track_m: 0.8,
            max_steer_deg: 45.0,
            max_steer_rate_deg_s: 60.0,
            steered: SteeredWheel::Rear,
        };
        assert!((drive.turning_radius_m() - 1.0).abs() < 1e-12);
        let twist = drive.feasible(Twist::new(-0.5, 2.0));
        assert!(twist.forward_m_s == -0.5 && (twist.turn_rad_s - 0.5).abs() < 1e-12);
        assert_eq!(drive.feasible(Twist::new(0.0, 1.0)).turn_rad_s, 0.0);
        assert_eq!(drive.steered_ahead_m(), Some(-1.0));
    }

    #[test]
    fn every_impossible_number_is_reported_at_once() {
        let robot = Robot {
            radius_m: -1.0,
            max_speed_m_s: f64::NAN,
            footprint_m: vec![[1.0, 1.0]],
            ..Robot::default()
        };
        let keys: Vec<String> = robot.faults().into_iter().map(|(key, _)| key).collect();
        assert_eq!(keys, ["radius_m", "max_speed_m_s", "footprint_m"]);
        assert!(Robot::default().faults().is_empty());
    }
}
