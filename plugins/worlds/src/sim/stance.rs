//! How the body stands on raised floor and sways: height, roll and pitch, and what an inertial sensor feels of them.
//!
//! Four wheels stand under the corners of the base as seen from above, each a ball that rests on the floor. The body is the
//! plane through their middles that fits best (independent suspension shares what four points have too much), shifted down
//! by the radius. So the body lies exactly on a long incline, climbs a step as round wheels do, and depends on where the
//! robot is and nothing else. Wheels do not spring: at the foot of a ramp the velocity has a corner.

use nalgebra::{UnitQuaternion, Vector3};
use rumbo_core::frames::{Pose2, Pose3, Twist, lift};
use rumbo_core::robot::{Drive, Hull, Robot};

use super::hardships::{Sway, Wheels};
use super::solid::Point;
use super::terrain::Terrain;

/// Wheels stand this far out, as a share of the hull's half length and width.
const WHEEL_SHARE: f64 = 0.7;

/// Where the wheels are, seen from above.
#[derive(Debug, Clone, Copy)]
pub struct Undercarriage {
    /// From the base forward to the front wheels, and back to the rear ones, meters.
    half_length_m: f64,
    /// From the base to the wheels of a side, meters.
    half_width_m: f64,
    radius_m: f64,
}

/// Height, roll and pitch of the plane on which the body stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tilt {
    /// Of the base over the plain floor, meters.
    pub z_m: f64,
    /// Positive where the left side is higher.
    pub roll_rad: f64,
    /// Positive where the front is lower.
    pub pitch_rad: f64,
}

impl Undercarriage {
    /// That of a robot.
    pub fn of(robot: &Robot, wheels: &Wheels) -> Self {
        let [half_length_m, half_hull_m] = match robot.hull() {
            Hull::Disc { radius_m } => [radius_m; 2],
            Hull::Polygon(corners) => [0, 1].map(|axis| {
                let reach = |side: f64| corners.iter().map(|at| side * at[axis]).fold(0.0, f64::max);
                reach(1.0).min(reach(-1.0))
            }),
        };
        let half_width_m = match robot.drive {
            Drive::Differential { track_m } | Drive::Tricycle { track_m, .. } => track_m / 2.0,
            _ => WHEEL_SHARE * half_hull_m,
        };
        // A hull that ends at its axle still stands on four wheels.
        let half_length_m = (WHEEL_SHARE * half_length_m).max(half_width_m / 2.0);
        Self { half_length_m, half_width_m, radius_m: wheels.radius_m }
    }

    /// How the body stands with the base over a place.
    pub fn tilt(&self, terrain: &Terrain, map_from_base: &Pose2) -> Tilt {
        let (a, b) = (self.half_length_m, self.half_width_m);
        let [front_left, front_right, rear_left, rear_right] = [(a, b), (a, -b), (-a, b), (-a, -b)]
            .map(|(x, y)| terrain.ball_center_m(map_from_base * Point::new(x, y), self.radius_m));
        let rise_ahead = (front_left + front_right - rear_left - rear_right) / (4.0 * a);
        let rise_left = (front_left + rear_left - front_right - rear_right) / (4.0 * b);
        let stretch = (1.0 + rise_ahead * rise_ahead + rise_left * rise_left).sqrt();
        let middle_m = (front_left + front_right + rear_left + rear_right) / 4.0;
        Tilt {
            z_m: middle_m - self.radius_m * stretch,
            roll_rad: (rise_left / stretch).asin(),
            pitch_rad: -rise_ahead.atan(),
        }
    }
}

/// The body in space.
#[derive(Debug, Clone)]
pub struct Stance {
    undercarriage: Undercarriage,
    sway: Option<Sway>,
    tilt: Tilt,
    gravity_m_s2: f64,
    /// Where the body is.
    pub map_from_base: Pose3,
    /// Turning rates about the body's axes: the mean of the last piece of time.
    pub rates_rad_s: [f64; 3],
    /// What an accelerometer at the base feels, along the body's axes.
    pub specific_force_m_s2: [f64; 3],
    /// Mean velocity of the last piece of time in the map, and how long the piece was.
    before: Option<(Vector3<f64>, f64)>,
}

impl Stance {
    /// A body put down at a place at time zero, at rest.
    pub fn new(
        undercarriage: Undercarriage,
        sway: Option<Sway>,
        gravity_m_s2: f64,
        terrain: &Terrain,
        map_from_base: &Pose2,
    ) -> Self {
        let tilt = Tilt { z_m: 0.0, roll_rad: 0.0, pitch_rad: 0.0 };
        let mut stance = Self {
            undercarriage,
            sway,
            tilt,
            gravity_m_s2,
            map_from_base: Pose3::identity(),
            rates_rad_s: [0.0; 3],
            specific_force_m_s2: [0.0; 3],
            before: None,
        };
        stance.put(terrain, map_from_base, 0.0);
        stance
    }

    /// Puts the body somewhere else, at rest.
    pub fn put(&mut self, terrain: &Terrain, map_from_base: &Pose2, time_s: f64) {
        self.map_from_base = self.pose(terrain, map_from_base, time_s);
        self.before = None;
        self.rates_rad_s = [0.0; 3];
        self.feel(Vector3::zeros());
    }

    /// Follows the base to where it is after a piece of time.
    pub fn follow(&mut self, terrain: &Terrain, map_from_base: &Pose2, time_s: f64, seconds: f64) {
        let from = self.map_from_base;
        self.map_from_base = self.pose(terrain, map_from_base, time_s);
        let turned = from.rotation.inverse() * self.map_from_base.rotation;
        self.rates_rad_s = (turned.scaled_axis() / seconds).into();
        let velocity = (self.map_from_base.translation.vector - from.translation.vector) / seconds;
        // Both velocities are means, so they belong to the middles of their pieces.
        let (last_velocity, last_seconds) = self.before.unwrap_or((Vector3::zeros(), seconds));
        self.feel((velocity - last_velocity) * (2.0 / (seconds + last_seconds)));
        self.before = Some((velocity, seconds));
    }

    /// Height of the base over the plain floor.
    pub fn z_m(&self) -> f64 {
        self.tilt.z_m
    }

    /// Height that the base would have over another place.
    pub fn z_over_m(&self, terrain: &Terrain, map_from_base: &Pose2) -> f64 {
        self.undercarriage.tilt(terrain, map_from_base).z_m
    }

    /// What of a motion along the floor is seen from above: the base's axes, without the sway of the body on its wheels,
    /// projected to the plane.
    pub fn seen_from_above(&self, twist: Twist) -> Twist {
        let (sin_roll, cos_roll) = self.tilt.roll_rad.sin_cos();
        let (sin_pitch, cos_pitch) = self.tilt.pitch_rad.sin_cos();
        Twist {
            forward_m_s: twist.forward_m_s * cos_pitch + twist.left_m_s * sin_roll * sin_pitch,
            left_m_s: twist.left_m_s * cos_roll,
            // The turn is about the body's own axis; this is what it does to the yaw of the three angles.
            turn_rad_s: twist.turn_rad_s * cos_roll / cos_pitch,
        }
    }

    fn pose(&mut self, terrain: &Terrain, map_from_base: &Pose2, time_s: f64) -> Pose3 {
        self.tilt = self.undercarriage.tilt(terrain, map_from_base);
        let on_floor = UnitQuaternion::from_euler_angles(self.tilt.roll_rad, self.tilt.pitch_rad, 0.0);
        let (roll_rad, pitch_rad) = self.sway.map_or((0.0, 0.0), |sway| sway.at(time_s));
        let swaying = UnitQuaternion::from_euler_angles(roll_rad, pitch_rad, 0.0);
        let mut map_from_body = lift(map_from_base);
        map_from_body.translation.z = self.tilt.z_m;
        map_from_body.rotation *= on_floor * swaying;
        map_from_body
    }

    fn feel(&mut self, acceleration: Vector3<f64>) {
        let up = Vector3::new(0.0, 0.0, self.gravity_m_s2);
        self.specific_force_m_s2 = (self.map_from_base.rotation.inverse() * (acceleration + up)).into();
    }
}

#[cfg(test)]
mod tests;
