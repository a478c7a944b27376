//! Where people are after so much of their way: a function of the way alone.

use rumbo_kit::world_file::Person;

use super::solid::{Point, Vector};

/// Length of a double step.
const STRIDE_M: f64 = 1.4;

/// Where a person is who has walked so far, and which way the walk goes.
pub fn place(person: &Person, walked_m: f64) -> (Point, Vector) {
    let corner = |idx: usize| Point::from(person.route[idx]);
    let n_corners = person.route.len();
    let n_legs = if person.circular { n_corners } else { n_corners - 1 };
    let leg = |idx: usize| (corner(idx), corner((idx + 1) % n_corners));
    let length_m: f64 = (0..n_legs).map(|idx| (leg(idx).1 - leg(idx).0).norm()).sum();
    if length_m == 0.0 {
        return (corner(0), Vector::x());
    }
    let round_m = if person.circular { length_m } else { 2.0 * length_m };
    let phase_m = walked_m.rem_euclid(round_m);
    let (mut along_m, forth) = if phase_m <= length_m { (phase_m, 1.0) } else { (round_m - phase_m, -1.0) };
    for idx in 0..n_legs {
        let (from, to) = leg(idx);
        let leg_m = (to - from).norm();
        if along_m <= leg_m || idx + 1 == n_legs {
            let direction = (to - from) / leg_m.max(f64::MIN_POSITIVE);
            return (from + direction * along_m.min(leg_m), direction * forth);
        }
        along_m -= leg_m;
    }
    (corner(0), Vector::x())
}

/// The way of somebody who stops for nobody, meters.
pub fn walked_m(person: &Person, time_s: f64) -> f64 {
    person.speed_m_s * (time_s - person.start_s).max(0.0)
}

/// The body of a person who has walked so far, as discs on the floor: center and radius in meters.
pub fn discs(person: &Person, walked_m: f64) -> impl Iterator<Item = (Point, f64)> + use<> {
    let (center, direction) = place(person, walked_m);
    let radius_m = person.radius_m;
    let (bodies, n_bodies) = if person.legs {
        let left = Vector::new(-direction.y, direction.x) * (radius_m / 2.0);
        let swing = (std::f64::consts::TAU * walked_m / STRIDE_M).sin() * STRIDE_M / 4.0;
        let step = direction * swing;
        ([(center + left + step, radius_m / 4.0), (center - left - step, radius_m / 4.0)], 2)
    } else {
        ([(center, radius_m); 2], 1)
    };
    bodies.into_iter().take(n_bodies)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn walker(circular: bool) -> Person {
        Person {
            name: "walker".into(),
            route: vec![[0.0, 0.0], [4.0, 0.0], [4.0, 3.0]],
            speed_m_s: 2.0,
            start_s: 1.0,
            circular,
            legs: false,
            radius_m: 0.25,
            height_m: 1.8,
            personal_space_m: None,
            turn_back_after_s: None,
        }
    }

    fn at(person: &Person, time_s: f64) -> (Point, Vector) {
        place(person, walked_m(person, time_s))
    }

    #[test]
    fn a_walk_goes_back_along_the_route_or_round() {
        for (time_s, forth, round) in [
            (0.5, [0.0, 0.0], [0.0, 0.0]),
            (2.0, [2.0, 0.0], [2.0, 0.0]),
            (4.0, [4.0, 2.0], [4.0, 2.0]),
            (5.0, [4.0, 2.0], [3.2, 2.4]),
            (7.0, [2.0, 0.0], [0.0, 0.0]),
            (9.0, [2.0, 0.0], [4.0, 0.0]),
        ] {
            assert!((at(&walker(false), time_s).0 - Point::from(forth)).norm() < 1e-12, "back at {time_s}");
            assert!((at(&walker(true), time_s).0 - Point::from(round)).norm() < 1e-12, "round at {time_s}");
        }
        assert_eq!(at(&walker(false), 7.0).1, Vector::new(-1.0, 0.0));
        // Somebody who turned back before the first corner comes from it again.
        assert!((place(&walker(false), -1.0).0 - Point::new(1.0, 0.0)).norm() < 1e-12);
        assert!((place(&walker(true), -1.0).0 - Point::new(0.8, 0.6)).norm() < 1e-12);
    }

    #[test]
    fn legs_step_on_both_sides_of_the_way() {
        let legs: Vec<_> = discs(&Person { legs: true, ..walker(false) }, 0.35).collect();
        assert_eq!(legs.len(), 2);
        // 0.35 m walked is a quarter stride: the legs are farthest apart.
        assert!((legs[0].0 - Point::new(0.70, 0.125)).norm() < 1e-12, "{:?}", legs[0]);
        assert!((legs[1].0 - Point::new(0.0, -0.125)).norm() < 1e-12);
        assert_eq!(legs[0].1, 0.0625);
    }

    #[test]
    fn somebody_may_just_stand() {
        let standing = Person { route: vec![[1.0, 2.0]], speed_m_s: 0.0, ..walker(false) };
        assert_eq!(at(&standing, 100.0).0, Point::new(1.0, 2.0));
    }
}
