//! Turning to and fro: what a robot does that cannot turn in place and finds no room for the arc to its path. A turn in
//! three points, or in more: every leg turns the robot the same way, ahead and backwards by turns.
//!
//! The legs are the ones of the shortest ways with turns back (Reeds and Shepp, "Optimal paths for a car that goes both
//! forwards and backwards", 1990): arcs of the smallest radius between cusps. How long they are, and how
//! much wider, is left to the room.

use rumbo_core::frames::Point2;

/// Which way a leg leads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// Forwards.
    Ahead,
    /// Backwards.
    Back,
}

impl Direction {
    fn other(self) -> Direction {
        match self {
            Direction::Ahead => Direction::Back,
            Direction::Back => Direction::Ahead,
        }
    }
}

/// A turn to and fro.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Maneuver {
    /// 1: it turns left; -1: right.
    side: f64,
    direction: Direction,
    longest_leg_m: f64,
    moved_m: f64,
    n_legs: u32,
    last: Point2,
}

impl Maneuver {
    /// More legs do not get anywhere.
    const MOST_LEGS: u32 = 12;
    /// Less room than this is none for a leg, meters.
    const NO_ROOM_M: f64 = 0.10;
    /// Arcs that are tried, as shares of the tightest.
    const TIGHTNESS: [f64; 4] = [1.0, 0.5, 0.25, 0.0];

    /// Begins at this place with a leg in this direction; the robot turns to the side that the bearing has.
    pub fn begin(at: Point2, bearing_rad: f64, direction: Direction, longest_leg_m: f64) -> Maneuver {
        let side = 1.0_f64.copysign(bearing_rad);
        Maneuver { side, direction, longest_leg_m, moved_m: 0.0, n_legs: 0, last: at }
    }

    /// 1 where it turns left, -1 where it turns right.
    pub fn side(&self) -> f64 {
        self.side
    }

    /// How to drive on at this place: the direction, and how tightly to turn, as a share of the tightest. None where there
    /// is no room either way, or it took too many legs. `free_m` tells how far such an arc is free.
    ///
    /// A long hull beside a wall swings into it on a tight arc, and not on a wide one or straight on.
    pub fn next(&mut self, at: Point2, free_m: &dyn Fn(Direction, f64) -> f64) -> Option<(Direction, f64)> {
        self.moved_m += (at - self.last).norm();
        self.last = at;
        let tightest = |direction| {
            let has_room = |share: &f64| free_m(direction, *share) >= Self::NO_ROOM_M;
            Self::TIGHTNESS.into_iter().find(has_room).map(|share| (direction, share))
        };
        let goes_on = tightest(self.direction).filter(|_| self.moved_m < self.longest_leg_m);
        if goes_on.is_some() {
            return goes_on;
        }
        self.direction = self.direction.other();
        self.moved_m = 0.0;
        self.n_legs += 1;
        tightest(self.direction).filter(|_| self.n_legs <= Self::MOST_LEGS)
    }
}

/// Turns to and fro that were begun at one place of the path.
#[derive(Debug, Clone, Copy, Default)]
pub struct Tried {
    at_m: f64,
    n: u32,
}

impl Tried {
    /// More are not tried.
    const MOST: u32 = 3;
    /// Farther along the path is another place, meters.
    const ELSEWHERE_M: f64 = 1.0;

    /// One more here; false where that were too many.
    pub fn again_at(&mut self, come_m: f64) -> bool {
        if come_m > self.at_m + Self::ELSEWHERE_M {
            *self = Tried { at_m: come_m, n: 0 };
        }
        self.n += 1;
        self.n <= Self::MOST
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn legs_change_where_room_or_length_ends() {
        let mut maneuver = Maneuver::begin(Point2::origin(), -2.0, Direction::Back, 1.0);
        assert_eq!(maneuver.side(), -1.0);
        let roomy = |_: Direction, _: f64| 3.0;
        assert_eq!(maneuver.next(Point2::new(-0.6, 0.0), &roomy), Some((Direction::Back, 1.0)));
        assert_eq!(maneuver.next(Point2::new(-1.1, 0.0), &roomy), Some((Direction::Ahead, 1.0)));
        let nothing_ahead =
            |direction: Direction, _: f64| if direction == Direction::Ahead { 0.01 } else { 1.0 };
        assert_eq!(maneuver.next(Point2::new(-1.0, 0.0), &nothing_ahead), Some((Direction::Back, 1.0)));
        assert_eq!(maneuver.next(Point2::new(-1.1, 0.0), &|_, _| 0.0), None);
    }

    #[test]
    fn it_turns_as_tightly_as_there_is_room() {
        let mut maneuver = Maneuver::begin(Point2::origin(), 1.0, Direction::Ahead, 1.0);
        let beside_a_wall = |_: Direction, share: f64| if share > 0.3 { 0.0 } else { 1.0 };
        assert_eq!(maneuver.next(Point2::origin(), &beside_a_wall), Some((Direction::Ahead, 0.25)));
        let straight_back = |direction: Direction, share: f64| {
            if direction == Direction::Back && share == 0.0 { 1.0 } else { 0.0 }
        };
        assert_eq!(maneuver.next(Point2::origin(), &straight_back), Some((Direction::Back, 0.0)));
    }

    #[test]
    fn one_place_is_tried_three_times_and_the_next_one_anew() {
        let mut tried = Tried::default();
        let answers: Vec<bool> = (0..4).map(|_| tried.again_at(0.2)).collect();
        assert_eq!(answers, [true, true, true, false]);
        assert!(!tried.again_at(0.9) && tried.again_at(1.3));
    }

    #[test]
    fn it_ends_after_many_legs() {
        let mut maneuver = Maneuver::begin(Point2::origin(), 1.0, Direction::Ahead, 0.1);
        let n_legs = (1..100)
            .take_while(|k| maneuver.next(Point2::new(0.2 * f64::from(*k), 0.0), &|_, _| 1.0).is_some())
            .count();
        assert_eq!(n_legs, 12);
    }
}
