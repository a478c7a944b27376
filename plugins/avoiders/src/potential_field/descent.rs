//! From the field to a direction and a strength: Valverde Moreno (2015), section 4.2.3.

use super::aim::Aim;
use super::classical::Classical;
use super::field::{Attraction, direction};
use super::push::{PushFrom, PushLaw, push};
use super::turn::turn_error_rad;
use crate::near_points::NearPoint;
use rumbo_core::frames::Point2;

/// The field of one robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Descent {
    /// The pull of the gradient form.
    pub attraction: Attraction,
    /// The push.
    pub push: PushLaw,
    /// What pushes.
    pub push_from: PushFrom,
}

/// Where the robot is, and where to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// The robot, in the map.
    pub position: Point2,
    /// Its heading, radians.
    pub yaw_rad: f64,
    /// What draws it.
    pub aim: Aim,
    /// The end of the path counts as reached within this, meters.
    pub arrival_radius_m: f64,
}

impl Descent {
    /// The arrival radius must exceed the distance at which the pull ends by so much.
    const ARRIVES: f64 = 1.1;
    /// A shorter field has no direction.
    const NO_FIELD: f64 = 1e-12;

    /// Strength of the field, multiples of the full speed, and the turn from the heading to it, radians.
    pub fn pull(&self, place: &Place, points: &[NearPoint]) -> (f64, f64) {
        let toward = place.aim.target - place.position;
        let angle_rad = toward.y.atan2(toward.x);
        let attraction = match self.push {
            PushLaw::Gradient(_) => {
                let r_m = self.attraction.r_m.min(place.arrival_radius_m / Self::ARRIVES);
                Attraction { r_m, ..self.attraction }.at(place.aim.left_m, angle_rad)
            }
            PushLaw::Classical(Classical { xi, .. }) => direction(angle_rad) * (xi * place.aim.left_m),
        };
        let field = attraction + push(&self.push, self.push_from, points, place.yaw_rad);
        let strength = field.norm();
        if strength < Self::NO_FIELD {
            return (0.0, 0.0);
        }
        (strength, turn_error_rad(place.yaw_rad, field.y.atan2(field.x)))
    }
}
