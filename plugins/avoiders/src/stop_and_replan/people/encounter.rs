//! Robot and people in time: who will be where, and what the robot does about it.
//!
//! People are predicted to go on as they go; the robot follows its path, more slowly, waits, or backs off. The first of
//! these that keeps enough room is taken. A slow robot cannot escape from somebody who walks straight at it; then it
//! stands, so that the contact is none that it made.

use nalgebra::Vector2;
use rumbo_core::frames::Point2;

/// Rules of meeting somebody, meters and seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Encounter {
    /// So much of the future counts.
    pub horizon_s: f64,
    /// Room between the hull and the body.
    pub keep_m: f64,
    /// Radius of a body with its stride.
    pub body_radius_m: f64,
    /// Radius of the hull.
    pub hull_radius_m: f64,
}

/// Somebody in the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Person {
    /// Where.
    pub position: Point2,
    /// Velocity, m/s.
    pub velocity: Vector2<f64>,
}

/// Where the robot would be after each [`Encounter::STEP_S`], in the map.
#[derive(Debug, Clone, Copy)]
pub struct Ways<'a> {
    /// Along its path.
    pub go: &'a [Point2],
    /// Along its path at half the speed.
    pub slow: &'a [Point2],
    /// Back along the straight piece that it came; empty where it must not.
    pub back: &'a [Point2],
}

/// What the robot does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Manner {
    /// Goes on.
    Go,
    /// Goes on slowly.
    Slow,
    /// Stands.
    Wait,
    /// Backs off.
    Back,
}

impl Encounter {
    /// From one pose of a way to the next, seconds.
    pub const STEP_S: f64 = 0.2;
    /// Speed of [`Manner::Slow`], as a part of the usual one.
    pub const SLOW: f64 = 0.5;
    /// The room grows with what is not known of the future, m/s.
    const GROWTH_M_S: f64 = 0.08;
    /// A robot that waits goes on only with this much more room: it would start and stop with every scan else, meters.
    const MORE_M: f64 = 0.08;
    /// Who is nearer than the room already may not come nearer by more than this, meters.
    const NEARER_M: f64 = 0.02;
    /// Evading must gain this much, meters.
    const GAIN_M: f64 = 0.10;

    /// What to do from `here`; a robot that `is_waiting` needs a little more room to go on.
    pub fn choose(&self, persons: &[Person], ways: &Ways<'_>, here: Point2, is_waiting: bool) -> Manner {
        let keep_m = self.keep_m + if is_waiting { Self::MORE_M } else { 0.0 };
        if self.keeps_room(persons, ways.go, here, keep_m) {
            return Manner::Go;
        }
        if self.keeps_room(persons, ways.slow, here, keep_m) {
            return Manner::Slow;
        }
        let wait_m = self.nearest_m(persons, &[], here);
        if wait_m >= 0.0 {
            return Manner::Wait;
        }
        // Somebody will walk into a robot that stands: out of the way, where that is possible.
        let options = [(Manner::Go, ways.go), (Manner::Back, ways.back)];
        let others = options.into_iter().filter(|(_, way)| !way.is_empty());
        let best = others
            .map(|(manner, way)| (manner, self.nearest_m(persons, way, here)))
            .filter(|(_, nearest_m)| *nearest_m >= 0.0 && *nearest_m >= wait_m + Self::GAIN_M)
            .max_by(|a, b| a.1.total_cmp(&b.1));
        best.map_or(Manner::Wait, |(manner, _)| manner)
    }

    /// Nobody comes too near on this way.
    fn keeps_room(&self, persons: &[Person], way: &[Point2], here: Point2, keep_m: f64) -> bool {
        persons.iter().all(|person| {
            let now_m = self.gap_m(here, person.position);
            self.gaps_m(person, way, here).all(|(seconds, gap_m)| {
                gap_m >= (keep_m + Self::GROWTH_M_S * seconds).min(now_m - Self::NEARER_M)
            })
        })
    }

    /// The smallest gap on a way.
    fn nearest_m(&self, persons: &[Person], way: &[Point2], here: Point2) -> f64 {
        let gaps = persons.iter().flat_map(|person| self.gaps_m(person, way, here));
        gaps.map(|(_, gap_m)| gap_m).fold(f64::INFINITY, f64::min)
    }

    /// Times and gaps on a way; a robot whose way is at an end stands.
    fn gaps_m(&self, person: &Person, way: &[Point2], here: Point2) -> impl Iterator<Item = (f64, f64)> {
        let n_steps = (self.horizon_s / Self::STEP_S).ceil() as usize;
        let end = way.last().copied().unwrap_or(here);
        (0..n_steps).map(move |step| {
            let seconds = Self::STEP_S * (step + 1) as f64;
            let robot = way.get(step).copied().unwrap_or(end);
            (seconds, self.gap_m(robot, person.position + person.velocity * seconds))
        })
    }

    fn gap_m(&self, robot: Point2, person: Point2) -> f64 {
        (robot - person).norm() - self.hull_radius_m - self.body_radius_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ENCOUNTER: Encounter =
        Encounter { horizon_s: 4.0, keep_m: 0.2, body_radius_m: 0.3, hull_radius_m: 0.2 };

    fn way(speed_m_s: f64) -> Vec<Point2> {
        (1..=20).map(|k| Point2::new(speed_m_s * Encounter::STEP_S * f64::from(k), 0.0)).collect()
    }

    fn manner(position: [f64; 2], velocity: [f64; 2]) -> Manner {
        let person = Person { position: position.into(), velocity: velocity.into() };
        let (go, slow, back) = (way(0.2), way(0.1), way(-0.15));
        ENCOUNTER.choose(&[person], &Ways { go: &go, slow: &slow, back: &back }, Point2::origin(), false)
    }

    #[test]
    fn who_walks_elsewhere_or_away_is_no_reason_to_stop() {
        assert_eq!(manner([2.0, 2.0], [1.0, 0.0]), Manner::Go);
        assert_eq!(manner([0.8, 0.0], [0.8, 0.0]), Manner::Go, "he leaves faster than the robot comes");
        assert_eq!(manner([0.5, 0.4], [0.0, 1.0]), Manner::Go, "near, but leaving");
        assert_eq!(manner([6.0, 0.0], [-0.5, 0.0]), Manner::Go, "beyond the horizon");
    }

    #[test]
    fn who_crosses_is_let_through_and_who_comes_behind_the_robot_is_not_waited_for() {
        assert_eq!(manner([1.0, 1.2], [0.0, -0.7]), Manner::Wait);
        assert_eq!(manner([1.3, 2.2], [0.0, -0.8]), Manner::Slow, "slow is enough to let him pass");
        assert_eq!(manner([-0.9, 2.0], [0.0, -1.0]), Manner::Go);
    }

    #[test]
    fn the_robot_leaves_the_line_of_who_would_walk_into_it_where_it_can() {
        assert_eq!(manner([0.25, 3.4], [0.0, -1.0]), Manner::Back);
        assert_eq!(manner([-0.25, 3.4], [0.0, -1.0]), Manner::Go);
        assert_eq!(manner([3.0, 0.0], [-1.0, 0.0]), Manner::Wait, "straight at it: no way out");
        let blind = Person { position: Point2::new(0.25, 3.4), velocity: Vector2::new(0.0, -1.0) };
        let (go, slow) = (way(0.2), way(0.1));
        let cornered = Ways { go: &go, slow: &slow, back: &[] };
        assert_eq!(ENCOUNTER.choose(&[blind], &cornered, Point2::origin(), false), Manner::Wait);
    }

    #[test]
    fn who_is_already_near_may_be_left_but_not_approached() {
        assert_eq!(manner([0.6, 0.0], [0.0, 0.3]), Manner::Wait);
        assert_eq!(manner([-0.6, 0.0], [0.0, 0.3]), Manner::Go);
    }
}
