//! How fast the robot may go along an arc: it stops in front of everything that it sees or remembers.
//!
//! The rule of the guard with more room, so that the guard has nothing to do, and with what left the view: the guard knows
//! what sensors see now.

use crate::near_points::NearPoint;
use crate::wheels::Wheels;
use rumbo_core::frames::{Point2, Pose2, Twist};
use rumbo_core::robot::{Hull, Robot};

/// The hull and the room around it.
#[derive(Debug, Clone)]
pub struct ClearWay {
    hull: Hull,
    outer_m: f64,
    clearance_m: f64,
}

impl ClearWay {
    /// Places along the arc are this far apart, meters (or radians times the hull's radius).
    const STEP_M: f64 = 0.03;
    /// A point that comes nearer by less than this is not approached, meters.
    const CLOSING_M: f64 = 1e-4;
    /// Shares of the wanted speed, and of the wanted turn, that are tried one after the other.
    const SPEEDS: [f64; 8] = [1.0, 0.8, 0.6, 0.45, 0.3, 0.2, 0.1, 0.05];
    const TURNS: [f64; 3] = [1.0, 0.5, 0.0];
    /// A curve that costs more of the speed than this is not the first choice.
    const GOOD_SPEED: f64 = 0.3;
    /// Slower than this is standing, m/s: a turn in place leads out sooner than a crawl.
    const CRAWL_M_S: f64 = 0.03;

    /// A hull with room around it.
    pub fn new(hull: Hull, clearance_m: f64) -> ClearWay {
        ClearWay { outer_m: hull.outer_radius_m(), hull, clearance_m }
    }

    /// The fastest motion that stops in time, like the wanted one: slower first, then with less turn, since beside
    /// something a robot goes on before it turns. None where every one of them meets something.
    ///
    /// What counts is what wheels make of it that have done `last` until now: one that is told to turn away still rolls on.
    pub fn allowed(&self, wanted: Twist, wheels: &Wheels<'_>, near: &[NearPoint]) -> Option<Twist> {
        if wanted.forward_m_s.abs() < 1e-9 {
            return self.reached(wanted, wheels, near);
        }
        let mut best: Option<(f64, Twist)> = None;
        for turn in Self::TURNS {
            let is_crawl = |speed: f64| speed < 1.0 && wanted.forward_m_s.abs() * speed < Self::CRAWL_M_S;
            let first = Self::SPEEDS.iter().filter(|speed| !is_crawl(**speed)).find_map(|speed| {
                let twist = Twist::new(wanted.forward_m_s * speed, wanted.turn_rad_s * turn);
                self.reached(twist, wheels, near).map(|twist| (*speed, twist))
            });
            let Some((speed, twist)) = first else { continue };
            if speed >= Self::GOOD_SPEED {
                return Some(twist);
            }
            if best.is_none_or(|(other, _)| speed > other) {
                best = Some((speed, twist));
            }
        }
        best.map(|(_, twist)| twist)
    }

    /// What the wheels make of it, where both stop in time: the first step of a motion that leads nowhere is short, too.
    fn reached(&self, wanted: Twist, wheels: &Wheels<'_>, near: &[NearPoint]) -> Option<Twist> {
        let reached = wheels.reach(wanted);
        let stop_in_time = |twist: Twist| self.stops_in_time(twist, wheels.robot, near);
        (stop_in_time(reached) && stop_in_time(wanted)).then_some(reached)
    }

    /// A turn in place as wanted, or else the other way around.
    pub fn either_way(&self, spin: Twist, wheels: &Wheels<'_>, near: &[NearPoint]) -> Option<Twist> {
        [spin, spin.scaled(-1.0)].into_iter().find_map(|spin| self.reached(spin, wheels, near))
    }

    /// The first point that the room around the hull meets along a motion.
    pub fn first_met(&self, twist: Twist, robot: &Robot, near: &[NearPoint]) -> Option<Point2> {
        self.places(twist, robot).find_map(|then_from_base| {
            let met = near.iter().find(|point| self.meets(point.in_base, then_from_base * point.in_base));
            met.map(|point| point.in_base)
        })
    }

    /// The hull, with its room, meets nothing until it stands.
    pub fn stops_in_time(&self, twist: Twist, robot: &Robot, near: &[NearPoint]) -> bool {
        self.first_met(twist, robot, near).is_none()
    }

    /// Places of the base until it stands, from which the base of now is seen.
    fn places(&self, twist: Twist, robot: &Robot) -> impl Iterator<Item = Pose2> + use<> {
        let hull_m_s = twist.speed_m_s() + twist.turn_rad_s.abs() * self.swing_m(twist);
        let needed_m = robot.stopping_m(hull_m_s).max(Self::STEP_M);
        let n_steps = if hull_m_s < 1e-9 { 0 } else { (needed_m / Self::STEP_M).ceil().min(400.0) as usize };
        (1..=n_steps).map(move |step| {
            let travel_m = needed_m * step as f64 / n_steps as f64;
            twist.integrate(travel_m / hull_m_s).inverse()
        })
    }

    /// Lever of the turn: a disc that turns in place sweeps nothing.
    fn swing_m(&self, twist: Twist) -> f64 {
        match self.hull {
            Hull::Disc { .. } if twist.speed_m_s() < 1e-9 => 0.0,
            _ => self.outer_m,
        }
    }

    /// The point comes into the room around the hull.
    fn meets(&self, now: Point2, then: Point2) -> bool {
        // Far from the disc around the hull is far from the hull.
        then.coords.norm() < self.outer_m + self.clearance_m && {
            let (now_m, then_m) = (self.hull.distance_m(now), self.hull.distance_m(then));
            then_m < self.clearance_m && then_m < now_m - Self::CLOSING_M
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_core::time::Time;

    fn at(x: f64, y: f64) -> NearPoint {
        NearPoint { in_base: Point2::new(x, y), stamp: Time::ZERO, is_remembered: false }
    }

    fn robot() -> Robot {
        Robot {
            radius_m: 0.25,
            braking_m_s2: 0.6,
            max_accel_m_s2: 0.6,
            max_speed_m_s: 1.2,
            max_turn_accel_deg_s2: 120.0,
            ..Robot::default()
        }
    }

    /// Wheels that already do what they are told.
    fn allowed(way: &ClearWay, twist: Twist, robot: &Robot, near: &[NearPoint]) -> Option<Twist> {
        let at_once = Robot { max_accel_m_s2: 1e6, max_turn_accel_deg_s2: 1e9, ..robot.clone() };
        // Brakes are those of the robot: only what is wanted is there at once.
        let wheels = Wheels {
            robot: &Robot { braking_m_s2: robot.braking_m_s2, ..at_once },
            last: twist,
            period_s: 10.0,
        };
        way.allowed(twist, &wheels, near)
    }

    /// A hull of 0.25 m with 0.05 m around it has `x - 0.3` to stop: the answer comes from the brakes' own formula.
    #[test]
    fn in_front_of_a_wall_the_robot_is_as_fast_as_its_brakes() {
        let (robot, way) = (robot(), ClearWay::new(robot().hull(), 0.05));
        for x in [0.5, 0.8, 1.2, 1.6] {
            let found = allowed(&way, Twist::new(1.2, 0.0), &robot, &[at(x, 0.0)]).unwrap();
            let most_m_s = robot.stops_within_m_s(x - 0.3);
            assert!(found.forward_m_s <= most_m_s + 1e-9, "{x} {found:?}");
            assert!(found.forward_m_s >= 0.6 * most_m_s.min(1.2), "{x} {found:?} {most_m_s}");
        }
        assert_eq!(allowed(&way, Twist::new(1.2, 0.0), &robot, &[at(0.31, 0.0)]), None);
        assert_eq!(allowed(&way, Twist::new(1.2, 0.0), &robot, &[at(0.31, 0.4)]), Some(Twist::new(1.2, 0.0)));
        assert_eq!(
            allowed(&way, Twist::new(1.2, 0.0), &robot, &[at(-0.31, 0.0)]),
            Some(Twist::new(1.2, 0.0))
        );
    }

    #[test]
    fn beside_something_the_robot_goes_on_before_it_turns_toward_it() {
        let (robot, way) = (robot(), ClearWay::new(robot().hull(), 0.05));
        let wanted = Twist::new(0.2, 1.0);
        let found = allowed(&way, wanted, &robot, &[at(0.0, 0.301)]).unwrap();
        assert!(found.forward_m_s > 0.0 && found.turn_rad_s < 1.0, "{found:?}");
        assert_eq!(
            allowed(&way, Twist::new(0.2, -1.0), &robot, &[at(0.0, 0.301)]),
            Some(Twist::new(0.2, -1.0))
        );
    }

    #[test]
    fn a_long_hull_does_not_turn_its_tail_into_what_it_remembers() {
        let corners = [[-0.4, -0.15], [0.2, -0.15], [0.2, 0.15], [-0.4, 0.15]];
        let robot = Robot { footprint_m: corners.to_vec(), ..robot() };
        let way = ClearWay::new(robot.hull(), 0.02);
        // The tail of a robot that turns left goes right.
        let beside = NearPoint { is_remembered: true, ..at(-0.38, -0.2) };
        let left = Twist::new(0.0, 0.5);
        assert_eq!(allowed(&way, left, &robot, &[beside]), None);
        assert_eq!(allowed(&way, left.scaled(-1.0), &robot, &[beside]), Some(left.scaled(-1.0)));
        assert_eq!(allowed(&way, left, &robot, &[at(0.7, 0.0)]), Some(left));
    }

    /// The wheels still roll at 0.8 m/s: told to turn in place they need 0.61 m.
    #[test]
    fn a_robot_that_rolls_on_while_it_turns_brakes_before_the_wall() {
        let (robot, way) = (robot(), ClearWay::new(robot().hull(), 0.05));
        let wheels = Wheels { robot: &robot, last: Twist::new(0.8, 0.0), period_s: 0.05 };
        let spin = Twist::new(0.0, 2.0);
        assert_eq!(way.either_way(spin, &wheels, &[at(0.8, 0.0)]), None);
        assert!(way.either_way(spin, &wheels, &[at(1.0, 0.0)]).is_some());
    }
}
