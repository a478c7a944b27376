//! Somebody on a walk: by the clock, or with an eye on the robot.

use rumbo_core::frames::Pose2;
use rumbo_core::robot::Hull;
use rumbo_kit::world_file::Person;

use super::person;
use super::solid::Point;

/// A person, and how far the walk has come.
#[derive(Debug)]
pub struct Walker {
    person: Person,
    walked_m: f64,
    /// 1 along the route's own order, -1 after turning back for the robot.
    side: f64,
    time_s: f64,
    waited_s: f64,
}

impl Walker {
    /// Before the first step.
    pub fn new(person: Person) -> Walker {
        Walker { person, walked_m: 0.0, side: 1.0, time_s: 0.0, waited_s: 0.0 }
    }

    /// Height, meters.
    pub fn height_m(&self) -> f64 {
        self.person.height_m
    }

    /// Whose walk it is.
    pub fn name(&self) -> &str {
        &self.person.name
    }

    /// The middle of the body, in the map.
    pub fn center(&self) -> Point {
        person::place(&self.person, self.walked_m).0
    }

    /// The body as discs on the floor: center and radius in meters.
    pub fn discs(&self) -> impl Iterator<Item = (Point, f64)> + use<> {
        person::discs(&self.person, self.walked_m)
    }

    /// Walks on; `robot` is where its hull stands. Who sees no robot goes by the clock alone, so that no rounding of many
    /// small steps adds up.
    pub fn walk_until(&mut self, time_s: f64, robot: Option<(&Pose2, &Hull)>) {
        let (Some(personal_space_m), Some((map_from_base, hull))) = (self.person.personal_space_m, robot)
        else {
            self.walked_m = person::walked_m(&self.person, time_s);
            return;
        };
        let seconds = time_s - self.time_s.max(self.person.start_s);
        self.time_s = time_s;
        if seconds <= 0.0 {
            return;
        }
        let next_m = self.walked_m + self.side * self.person.speed_m_s * seconds;
        let base_from_map = map_from_base.inverse();
        let off_m = |walked_m: f64| {
            hull.distance_m(base_from_map * person::place(&self.person, walked_m).0) - self.person.radius_m
        };
        let then_m = off_m(next_m);
        if then_m >= personal_space_m || then_m >= off_m(self.walked_m) {
            (self.walked_m, self.waited_s) = (next_m, 0.0);
            return;
        }
        self.waited_s += seconds;
        if self.person.turn_back_after_s.is_some_and(|limit_s| self.waited_s >= limit_s) {
            (self.side, self.waited_s) = (-self.side, 0.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_core::frames::pose2;

    /// Walks along x from 0 to 6 and back at 1 m/s.
    fn walker(personal_space_m: Option<f64>, turn_back_after_s: Option<f64>) -> Walker {
        Walker::new(Person {
            name: "walker".into(),
            route: vec![[0.0, 0.0], [6.0, 0.0]],
            speed_m_s: 1.0,
            start_s: 1.0,
            circular: false,
            legs: false,
            radius_m: 0.25,
            height_m: 1.8,
            personal_space_m,
            turn_back_after_s,
        })
    }

    /// Where it is at each tenth of a second, with a robot of 0.2 m that stands at `robot(time)`.
    fn walk(mut walker: Walker, robot: impl Fn(f64) -> Pose2) -> Vec<f64> {
        let step = |k: i32| {
            let time_s = 0.1 * f64::from(k);
            walker.walk_until(time_s, Some((&robot(time_s), &Hull::Disc { radius_m: 0.2 })));
            walker.discs().next().map_or(f64::NAN, |(center, _)| center.x)
        };
        (0..=300).map(step).collect()
    }

    #[test]
    fn who_sees_nobody_goes_by_the_clock() {
        for (k, x) in walk(walker(None, None), |_| pose2(3.0, 0.0, 0.0)).into_iter().enumerate() {
            let phase = (0.1 * k as f64 - 1.0).max(0.0) % 12.0;
            let expected = if phase <= 6.0 { phase } else { 12.0 - phase };
            assert!((x - expected).abs() < 1e-9, "{k}");
        }
    }

    #[test]
    fn who_is_careful_stops_before_the_hull_and_goes_on_when_it_has_gone() {
        let robot = |time_s: f64| if time_s < 10.0 { pose2(3.0, 0.0, 0.0) } else { pose2(3.0, 4.0, 0.0) };
        let places = walk(walker(Some(0.5), None), robot);
        let nearest = 3.0 - 0.2 - 0.25 - 0.5;
        assert!((places[30] - 2.0).abs() < 1e-9 && places[99] <= nearest + 1e-9, "{}", places[99]);
        assert!(places[99] > nearest - 0.11, "{}", places[99]);
        assert!((places[110] - places[99] - 1.1).abs() < 1e-9, "on its way again");
    }

    #[test]
    fn who_is_careful_walks_away_from_a_robot_that_came_too_near() {
        let places = walk(walker(Some(0.5), None), |_| pose2(-0.3, 0.0, 0.0));
        assert!((places[40] - 3.0).abs() < 1e-9);
        // Coming back to the first corner it stops 0.65 m from it.
        assert!((places[130] - 0.65).abs() < 0.11, "{}", places[130]);
    }

    #[test]
    fn who_has_waited_long_enough_walks_back() {
        let places = walk(walker(Some(0.5), Some(3.0)), |_| pose2(3.0, 0.0, 0.0));
        let (nearest, waited_s) = (3.0 - 0.2 - 0.25 - 0.5, 3.0);
        let comes = (1.0 + nearest + waited_s) * 10.0;
        assert!((places[comes as usize] - nearest).abs() < 0.11);
        assert!((places[comes as usize + 10] - (nearest - 1.0)).abs() < 0.21);
        assert!(places.iter().all(|x| *x <= nearest + 1e-9 && *x >= 0.0));
        assert!(places[200..].iter().any(|x| *x > 1.8), "and comes again");
    }
}
