//! How the map grows: new walls, each from the last line that showed it.
//!
//! The source puts what it has averaged over several scans into the map. That would count the same information twice: the
//! hits decide whether there is a wall, and the last measurement alone says where.

use super::association::{Gates, mahalanobis2};
use super::sighting::{Mount, placed};
use super::state::{ROBOT, State, wrapped};
use super::wall::{Axes, Wall};
use crate::lines::SensedLine;
use nalgebra::{Matrix2, SMatrix};

/// When a line becomes a wall of the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Growth {
    /// Long lines of the first scan enter the map at once: the robot's pose at that time is what defines the map's frame.
    pub bootstrap: bool,
    /// How long they must be for that, meters.
    pub bootstrap_length_m: f64,
    /// Time from one test of the lines that are no walls to the next, seconds (T_tm, which the source names and does not
    /// define); zero tests them with every scan. What follows counts scans that were tested.
    pub test_period_s: f64,
    /// Scans that must show a line before it becomes a wall.
    pub confirm_hits: u32,
    /// A line that was not seen for so many scans is forgotten.
    pub forget_after_scans: u32,
    /// A line farther than this from a candidate's middle is another one, meters.
    pub offset_m: f64,
    /// And one that is turned by more than this, radians.
    pub angle_rad: f64,
    /// And one that is farther away along the line, meters (l_max).
    pub gap_m: f64,
    /// Walls that overlap and cannot be told apart become one.
    pub merge: bool,
}

impl Default for Growth {
    fn default() -> Self {
        Growth {
            bootstrap: true,
            bootstrap_length_m: 2.0,
            test_period_s: 0.0,
            confirm_hits: 3,
            forget_after_scans: 6,
            offset_m: 0.3,
            angle_rad: 15f64.to_radians(),
            gap_m: 1.0,
            merge: false,
        }
    }
}

/// A line that could become a wall, as the present state sees it.
#[derive(Debug, Clone)]
pub(super) struct NewWall {
    /// `[rho, phi]` in the map.
    pub line: [f64; 2],
    by_robot: SMatrix<f64, 2, ROBOT>,
    /// What the measurement's noise does to it.
    noise: Matrix2<f64>,
}

impl NewWall {
    pub fn new(state: &State, mount: &Mount, seen: &SensedLine) -> NewWall {
        let (line, by_robot, by_sighting) = placed(&state.robot, mount, [seen.distance_m, seen.normal_rad]);
        let [rho2, both, phi2] = seen.covariance;
        let noise = by_sighting * Matrix2::new(rho2, both, both, phi2) * by_sighting.transpose();
        NewWall { line, by_robot, noise }
    }

    /// The wall of the map that it is after all: the source's last test, with what both have in common through the robot.
    pub fn known_as(&self, state: &State, walls: &[Wall], piece: &Wall, gates: &Gates) -> Option<usize> {
        let robot = state.covariance.view().fixed_view::<ROBOT, ROBOT>(0, 0).into_owned();
        let own = self.by_robot * robot * self.by_robot.transpose() + self.noise;
        let distance2 = |(idx, (line, wall)): (usize, (&[f64; 2], &Wall))| {
            let d = [self.line[0] - line[0], wrapped(self.line[1] - line[1])];
            let is_near = d[0].abs() <= gates.distance_m && d[1].abs() <= gates.normal_rad;
            if !is_near || Axes::new(*line).gap_m(&wall.ends_m, &piece.ends_m) > gates.gap_m {
                return None;
            }
            let shared = self.by_robot * state.robot_with(idx);
            let s = own + state.between(idx, idx) - shared - shared.transpose();
            Some((idx, mahalanobis2(d, &s))).filter(|(_, distance2)| *distance2 <= gates.distance2)
        };
        let near = state.walls.iter().zip(walls).enumerate().filter_map(distance2);
        near.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(idx, _)| idx)
    }

    /// Puts it into the map.
    pub fn add(&self, state: &mut State, walls: &mut Vec<Wall>, mut piece: Wall) {
        piece.follow(&Axes::new(self.line));
        state.add_seen(self.line, &self.by_robot, &self.noise);
        walls.push(piece);
    }
}
