//! The same world seen from another side: turned by a quarter, or in the mirror.

use super::depth_picture::mirrored;
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Point2, Pose2, Twist, pose2, wrap_angle};
use rumbo_core::map::{Cell, Grid, GridFault, GridHeader};
use rumbo_core::messages::{Data, LaserScan, Observation, RangeRing};
use std::f64::consts::FRAC_PI_2;

/// How a rectangular world is seen. Its lower left corner stays at the origin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Turn {
    /// As it is.
    None,
    /// Turned left by 90 degrees.
    Quarter,
    /// Upside down, as in a mirror along the x axis.
    Mirror,
}

impl Turn {
    /// Those that change something.
    pub const BOTH: [Turn; 2] = [Turn::Quarter, Turn::Mirror];

    /// The word used in reports.
    pub fn name(self) -> &'static str {
        match self {
            Turn::None => "as it is",
            Turn::Quarter => "turned by 90 degrees",
            Turn::Mirror => "mirrored",
        }
    }

    /// A point of a world that is `height_m` high.
    pub fn point(self, point: Point2, height_m: f64) -> Point2 {
        match self {
            Turn::None => point,
            Turn::Quarter => Point2::new(height_m - point.y, point.x),
            Turn::Mirror => Point2::new(point.x, height_m - point.y),
        }
    }

    /// A heading, radians.
    pub fn yaw(self, yaw_rad: f64) -> f64 {
        match self {
            Turn::None => yaw_rad,
            Turn::Quarter => wrap_angle(yaw_rad + FRAC_PI_2),
            Turn::Mirror => -yaw_rad,
        }
    }

    /// A pose in a world that is `height_m` high.
    pub fn pose(self, pose: &Pose2, height_m: f64) -> Pose2 {
        if self == Turn::None {
            return *pose;
        }
        let position = self.point(pose.translation.vector.into(), height_m);
        pose2(position.x, position.y, self.yaw(pose.rotation.angle()))
    }

    /// What the robot itself sees of its way, since it started at the origin of its odometer: a turned world changes
    /// nothing, a mirrored one swaps left and right.
    pub fn own_pose(self, odom_from_base: &Pose2) -> Pose2 {
        match self {
            Turn::Mirror => Turn::Mirror.pose(odom_from_base, 0.0),
            _ => *odom_from_base,
        }
    }

    /// A velocity in the robot's own frame.
    pub fn twist(self, twist: Twist) -> Twist {
        match self {
            Turn::Mirror => Twist {
                forward_m_s: twist.forward_m_s,
                left_m_s: -twist.left_m_s,
                turn_rad_s: -twist.turn_rad_s,
            },
            _ => twist,
        }
    }

    /// A grid that begins at the origin.
    pub fn grid(self, grid: &Grid) -> Result<Grid, GridFault> {
        let (width, height) = (grid.width(), grid.height());
        let (new_width, new_height) = if self == Turn::Quarter { (height, width) } else { (width, height) };
        let header = GridHeader { width: new_width, height: new_height, ..*grid.header() };
        let mut cells = Vec::with_capacity(grid.cells.len());
        for row in 0..new_height {
            for col in 0..new_width {
                let from = match self {
                    Turn::None => Cell { col, row },
                    Turn::Quarter => Cell { col: row, row: height - 1 - col },
                    Turn::Mirror => Cell { col, row: height - 1 - row },
                };
                cells.push(grid.cells.get(grid.index_of(from)).copied().unwrap_or_default());
            }
        }
        Grid::new(header, Buffer::from(cells))
    }

    /// What a sensor in the middle of the robot that looks ahead says.
    pub fn observation(self, observation: &Observation) -> Observation {
        let mut turned = observation.clone();
        if self != Turn::Mirror {
            return turned;
        }
        match &mut turned.data {
            Data::Odometry(odometry) => {
                odometry.odom_from_base = self.own_pose(&odometry.odom_from_base);
                odometry.twist = self.twist(odometry.twist);
            }
            Data::LaserScan(LaserScan { first_bearing_rad, bearing_step_rad, ranges_m, .. })
            | Data::RangeRing(RangeRing { first_bearing_rad, bearing_step_rad, ranges_m, .. }) => {
                let last = ranges_m.len().saturating_sub(1) as f64;
                *first_bearing_rad = -(*first_bearing_rad + *bearing_step_rad * last);
                ranges_m.make_mut().reverse();
            }
            Data::DepthImage(image) => mirrored(image),
            Data::Marks(seen) => seen.marks.iter_mut().for_each(|mark| mark.bearing_rad *= -1.0),
            _ => {}
        }
        turned
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_turn_with_the_points_in_them() {
        let mut grid = Grid::unknown(3, 2, 0.5).unwrap();
        for (k, cell) in grid.cells.make_mut().iter_mut().enumerate() {
            *cell = k as f32;
        }
        for turn in [Turn::None, Turn::Quarter, Turn::Mirror] {
            let turned = turn.grid(&grid).unwrap();
            for index in 0..6 {
                let at = turn.point(grid.center_of(grid.cell_of(index)), 1.0);
                let cell = turned.cell_at(at).unwrap();
                assert_eq!(turned.cells[turned.index_of(cell)], index as f32, "{turn:?}");
            }
        }
    }

    #[test]
    fn steps_in_the_robots_own_frame_lead_to_the_same_place() {
        let (start, twist) = (pose2(1.0, 0.5, 0.4), Twist::new(0.5, 0.3));
        for turn in Turn::BOTH {
            let there = turn.pose(&(start * twist.integrate(2.0)), 4.0);
            let same = turn.pose(&start, 4.0) * turn.twist(twist).integrate(2.0);
            assert!((there.to_homogeneous() - same.to_homogeneous()).norm() < 1e-12, "{turn:?}");
        }
    }
}
