//! What a laser on the robot sees of a wall (equation 3 of the source, for any mount), and where a seen line lies in the map.

use super::state::{ROBOT, wrapped};
use super::update::Row;
use crate::lines::SensedLine;
use nalgebra::{Matrix2, SMatrix, Vector2, Vector5};
use rumbo_core::frames::Pose2;

/// Where a sensor sits on the robot.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Mount {
    /// Ahead of the axle, meters (a).
    pub x_m: f64,
    /// To the left, meters (b).
    pub y_m: f64,
    /// Counter-clockwise, radians (gamma).
    pub yaw_rad: f64,
}

impl From<&Pose2> for Mount {
    fn from(base_from_sensor: &Pose2) -> Mount {
        let place = base_from_sensor.translation.vector;
        Mount { x_m: place.x, y_m: place.y, yaw_rad: base_from_sensor.rotation.angle() }
    }
}

/// A mounted sensor at the robot's place of this moment.
#[derive(Debug, Clone, Copy)]
pub(super) struct Viewpoint {
    /// Place in the map, meters (x_s, y_s).
    pub x: f64,
    pub y: f64,
    /// How that moves when the robot turns, m/rad.
    by_turn: [f64; 2],
    /// theta + gamma.
    pub yaw_rad: f64,
    sin: f64,
    cos: f64,
}

impl Viewpoint {
    pub fn new(robot: &Vector5<f64>, mount: &Mount) -> Viewpoint {
        let (sin, cos) = robot[2].sin_cos();
        let (a, b) = (mount.x_m, mount.y_m);
        let yaw_rad = robot[2] + mount.yaw_rad;
        let by_turn = [-a * sin - b * cos, a * cos - b * sin];
        let (x, y) = (robot[0] + by_turn[1], robot[1] - by_turn[0]);
        let (sin, cos) = yaw_rad.sin_cos();
        Viewpoint { x, y, by_turn, yaw_rad, sin, cos }
    }

    /// A point of the sensor's frame in the map.
    pub fn in_map(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.x + x * self.cos - y * self.sin, self.y + x * self.sin + y * self.cos]
    }
}

/// What should be seen of a wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PredictedLine {
    /// Distance from the sensor, meters; negative when the sensor is behind the wall.
    pub distance_m: f64,
    /// Normal in the sensor's frame, radians.
    pub normal_rad: f64,
    /// How both change with the robot's x, y, theta.
    pub by_robot: SMatrix<f64, 2, 3>,
    /// How both change with the wall's rho and phi.
    pub by_wall: Matrix2<f64>,
}

impl PredictedLine {
    /// What a sensor on the robot sees of the wall `[rho, phi]`.
    pub fn new(robot: &Vector5<f64>, mount: &Mount, wall: [f64; 2]) -> PredictedLine {
        PredictedLine::from(&Viewpoint::new(robot, mount), wall)
    }

    pub(super) fn from(view: &Viewpoint, [rho, phi]: [f64; 2]) -> PredictedLine {
        let (sin, cos) = phi.sin_cos();
        let by_turn = -(view.by_turn[0] * cos + view.by_turn[1] * sin);
        PredictedLine {
            distance_m: rho - view.x * cos - view.y * sin,
            normal_rad: wrapped(phi - view.yaw_rad),
            by_robot: SMatrix::<f64, 2, 3>::new(-cos, -sin, by_turn, 0.0, 0.0, -1.0),
            by_wall: Matrix2::new(1.0, view.x * sin - view.y * cos, 0.0, 1.0),
        }
    }

    /// What is seen less what should be seen.
    pub fn innovation(&self, seen: &SensedLine) -> Vector2<f64> {
        Vector2::new(seen.distance_m - self.distance_m, wrapped(seen.normal_rad - self.normal_rad))
    }

    /// The measurement of a wall whose numbers begin at this column.
    pub(super) fn rows(&self, column: usize, seen: &SensedLine) -> [Row; 2] {
        let innovation = self.innovation(seen);
        let [rho2, both, phi2] = seen.covariance;
        let (robot, wall) = (&self.by_robot, &self.by_wall);
        let distance = [
            (0, robot[(0, 0)]),
            (1, robot[(0, 1)]),
            (2, robot[(0, 2)]),
            (column, wall[(0, 0)]),
            (column + 1, wall[(0, 1)]),
        ];
        let normal = [(2, robot[(1, 2)]), (column + 1, wall[(1, 1)])];
        [Row::new(&distance, innovation[0], rho2).correlated(both), Row::new(&normal, innovation[1], phi2)]
    }
}

/// Where a seen line lies in the map: `[rho, phi]`, and how it changes with the robot (G_r) and with what is seen (G_z).
pub fn placed(
    robot: &Vector5<f64>,
    mount: &Mount,
    [distance_m, normal_rad]: [f64; 2],
) -> ([f64; 2], SMatrix<f64, 2, ROBOT>, Matrix2<f64>) {
    let view = Viewpoint::new(robot, mount);
    let phi = wrapped(normal_rad + view.yaw_rad);
    let (sin, cos) = phi.sin_cos();
    let rho = distance_m + view.x * cos + view.y * sin;
    let by_normal = -view.x * sin + view.y * cos;
    let by_turn = by_normal + view.by_turn[0] * cos + view.by_turn[1] * sin;
    let by_robot =
        SMatrix::<f64, 2, ROBOT>::from_row_slice(&[cos, sin, by_turn, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    ([rho, phi], by_robot, Matrix2::new(1.0, by_normal, 0.0, 1.0))
}
