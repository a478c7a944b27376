//! Which of the things nearby push: the nearest, or the nearest of every sector.

use super::classical::Classical;
use super::field::{Repulsion, direction};
use crate::near_points::NearPoint;
use crate::nearest::closest;
use nalgebra::Vector2;
use rumbo_core::frames::Point2;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// What pushes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PushFrom {
    /// The nearest point of all, as published: it jumps from side to side in narrow places.
    #[default]
    Closest,
    /// The nearest point of each sector of 10 degrees; the mean of those that push.
    Sectors,
}

/// The law of one push.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PushLaw {
    /// See [`Repulsion`].
    Gradient(Repulsion),
    /// See [`Classical`].
    Classical(Classical),
}

impl PushLaw {
    /// Farther things do not push, meters.
    pub fn reach_m(&self) -> f64 {
        match self {
            PushLaw::Gradient(repulsion) => repulsion.reach_m(),
            PushLaw::Classical(classical) => classical.reach_m,
        }
    }

    /// The push in the map's frame of a point of the base frame.
    fn of(&self, point: Point2, yaw_rad: f64) -> Vector2<f64> {
        let angle_rad = yaw_rad + point.y.atan2(point.x);
        match self {
            PushLaw::Gradient(repulsion) => repulsion.at(point.coords.norm(), angle_rad),
            PushLaw::Classical(classical) => {
                let toward = direction(angle_rad);
                let obstacle = Point2::from(toward * point.coords.norm());
                classical.repulsion(Point2::origin(), obstacle, -toward)
            }
        }
    }
}

/// Sectors of 10 degrees around the robot.
const N_SECTORS: usize = 36;

/// The push of all of them, in the map's frame, on a robot that looks along `yaw_rad`.
pub fn push(law: &PushLaw, from: PushFrom, points: &[NearPoint], yaw_rad: f64) -> Vector2<f64> {
    if from == PushFrom::Closest {
        return closest(points).map_or(Vector2::zeros(), |point| law.of(point, yaw_rad));
    }
    let mut nearest: [Option<Point2>; N_SECTORS] = [None; N_SECTORS];
    let in_reach = points.iter().map(|near| near.in_base).filter(|point| point.coords.norm() < law.reach_m());
    for point in in_reach {
        let turns = point.y.atan2(point.x).rem_euclid(TAU) / TAU;
        // A tiny negative angle rounds up to the full turn.
        let at = ((turns * N_SECTORS as f64) as usize).min(N_SECTORS - 1);
        if let Some(sector) = nearest.get_mut(at) {
            let is_nearer = sector.is_none_or(|other| point.coords.norm() < other.coords.norm());
            *sector = if is_nearer { Some(point) } else { *sector };
        }
    }
    let (mut sum, mut n_active) = (Vector2::zeros(), 0);
    for point in nearest.into_iter().flatten() {
        sum += law.of(point, yaw_rad);
        n_active += 1;
    }
    sum / f64::from(n_active.max(1))
}
