//! What a planner answers, and the obstacles that it was told of.

use super::check::{Check, Checker, MessageFault};
use crate::frames::Point2;
use crate::time::Time;

/// One point of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathPoint {
    /// Where, in the map's frame.
    pub position: Point2,
    /// Which way the robot shall look there, radians; free where absent.
    pub yaw_rad: Option<f64>,
}

/// A way from start to goal: straight pieces between at least one point.
#[doc(alias = "nav_msgs/Path")]
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    points: Vec<PathPoint>,
    /// What the planner minimized, in its own unit.
    pub cost: f64,
}

impl Path {
    /// A path through `points`; none where there are no points.
    pub fn new(points: Vec<PathPoint>, cost: f64) -> Option<Path> {
        (!points.is_empty()).then_some(Path { points, cost })
    }

    /// A path through bare positions.
    pub fn through(positions: impl IntoIterator<Item = Point2>, cost: f64) -> Option<Path> {
        Path::new(positions.into_iter().map(|position| PathPoint { position, yaw_rad: None }).collect(), cost)
    }

    /// The points, at least one.
    pub fn points(&self) -> &[PathPoint] {
        &self.points
    }

    /// The last point.
    pub fn end(&self) -> PathPoint {
        self.points.last().copied().unwrap_or(PathPoint { position: Point2::origin(), yaw_rad: None })
    }

    /// Length of all pieces, meters.
    pub fn length_m(&self) -> f64 {
        self.points.windows(2).map(|w| (w[1].position - w[0].position).norm()).sum()
    }
}

impl Check for Path {
    fn check(&self) -> Result<(), MessageFault> {
        let c = Checker("path");
        c.finite("cost", &[self.cost])?;
        self.points.iter().try_for_each(|p| {
            c.finite("points.position", &[p.position.x, p.position.y])?;
            p.yaw_rad.map_or(Ok(()), |yaw| c.finite("points.yaw_rad", &[yaw]))
        })
    }
}

/// Something in the way that the map does not show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Obstacle {
    /// Its middle in the map's frame.
    pub position: Point2,
    /// Its radius, meters; zero for a single point, which fills the cell that it lies in.
    pub radius_m: f64,
    /// When it was last seen.
    pub stamp: Time,
}

impl Check for Obstacle {
    fn check(&self) -> Result<(), MessageFault> {
        let c = Checker("obstacle");
        c.finite("position", &[self.position.x, self.position.y])?;
        c.not_negative("radius_m", self.radius_m)
    }
}
