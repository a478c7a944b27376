//! The robot's body: where it is, how near to things, and what stops it.

use rumbo_core::frames::{Pose2, Twist, wrap_angle};
use rumbo_core::robot::{Hull, Robot};

use super::clearance::PlacedHull;
use super::place::{Place, View};
use super::solid::{Footprint, Point};

/// Hull and surroundings nearer than this touch.
const TOUCH_M: f64 = 1e-4;
/// Smallest step on the way to a contact.
const STEP_M: f64 = 1e-4;
/// A contact ends when the hull is this far away again.
const APART_M: f64 = 5e-3;
/// Touching bearings closer together than this are one contact.
const SAME_CONTACT_RAD: f64 = 10.0 * std::f64::consts::PI / 180.0;

/// The robot in the world.
#[derive(Debug)]
pub struct Body {
    /// The robot in the map.
    pub map_from_base: Pose2,
    /// Exact distance from the hull at the last measurement, meters.
    pub clearance_m: f64,
    /// How often contact began.
    pub contact_episodes: u32,
    /// In how many of them the robot's own motion was closing the distance.
    pub driven_contact_episodes: u32,
    hull: Hull,
    height_m: f64,
    view: View,
    /// What is between these heights, meters, is met; nothing where the view says so already.
    heights_m: Option<[f64; 2]>,
    placed: PlacedHull,
    /// The hull can move this far before anything may be met, meters.
    free_m: f64,
    touches: bool,
    /// The robot drove into what it touches.
    is_driven: bool,
}

impl Body {
    /// A robot that was just put down.
    pub fn new(robot: &Robot, place: &mut Place, map_from_base: Pose2) -> Self {
        let hull = robot.hull();
        let height_m = robot.height_m;
        let view = if place.terrain.is_flat() {
            View { z_min_m: 0.0, z_max_m: height_m, with_glass: true }
        } else {
            View { with_glass: true, ..View::ALL_HEIGHTS }
        };
        let placed = PlacedHull::new(&hull);
        let mut body = Self {
            map_from_base,
            clearance_m: f64::INFINITY,
            contact_episodes: 0,
            driven_contact_episodes: 0,
            hull,
            height_m,
            view,
            heights_m: None,
            placed,
            free_m: 0.0,
            touches: false,
            is_driven: false,
        };
        body.measure(place);
        body
    }

    /// Stands at another height over the plain floor: other things are in the way. The hull is taken upright.
    pub fn stand_at(&mut self, z_m: f64) {
        self.heights_m = Some([z_m, z_m + self.height_m]);
        self.surroundings_changed();
    }

    /// Is somewhere else, all of a sudden.
    pub fn put(&mut self, map_from_base: Pose2) {
        self.map_from_base = map_from_base;
        self.surroundings_changed();
    }

    /// Drives along an arc until its end or a contact; the share of it that was driven.
    pub fn drive(&mut self, place: &mut Place, twist: Twist, seconds: f64) -> f64 {
        let reach_m_s = twist.speed_m_s() + twist.turn_rad_s.abs() * self.hull.outer_radius_m();
        if reach_m_s * seconds < self.free_m - TOUCH_M {
            self.map_from_base *= twist.integrate(seconds);
            self.free_m -= reach_m_s * seconds;
            return 1.0;
        }
        if reach_m_s == 0.0 {
            self.measure(place);
            return 1.0;
        }
        let map_from_start = self.map_from_base;
        let mut clearance_m = self.clearance_at(place, map_from_start);
        let mut driven_s = 0.0;
        while driven_s < seconds {
            // A whole step short of touching, so that rounding cannot end a long leap in a contact.
            let step_s = ((clearance_m - TOUCH_M - STEP_M).max(STEP_M) / reach_m_s).min(seconds - driven_s);
            let map_from_next = map_from_start * twist.integrate(driven_s + step_s);
            let next_m = self.clearance_at(place, map_from_next);
            // Away from a thing the robot may always drive, also when somebody walked into it.
            if next_m < TOUCH_M && next_m < clearance_m {
                self.begin_contact(true);
                self.measure(place);
                return driven_s / seconds;
            }
            (self.map_from_base, clearance_m) = (map_from_next, next_m);
            driven_s += step_s;
        }
        self.note(clearance_m);
        1.0
    }

    /// Measures the clearance here and now.
    pub fn measure(&mut self, place: &mut Place) {
        let clearance_m = self.clearance_at(place, self.map_from_base);
        self.note(clearance_m);
    }

    /// Clearance that it would have at another place, standing at a height over the plain floor.
    pub fn room_at_m(&mut self, place: &mut Place, map_from_base: Pose2, z_m: Option<f64>) -> f64 {
        let here = self.heights_m;
        self.heights_m = z_m.map(|z_m| [z_m, z_m + self.height_m]);
        let room_m = self.clearance_at(place, map_from_base);
        self.heights_m = here;
        room_m
    }

    fn note(&mut self, clearance_m: f64) {
        (self.clearance_m, self.free_m) = (clearance_m, clearance_m);
        if clearance_m <= 0.0 {
            self.begin_contact(false);
        } else if clearance_m > APART_M {
            (self.touches, self.is_driven) = (false, false);
        }
    }

    fn begin_contact(&mut self, is_driven: bool) {
        self.contact_episodes += u32::from(!self.touches);
        self.driven_contact_episodes += u32::from(is_driven && !self.is_driven);
        self.touches = true;
        self.is_driven |= is_driven;
    }

    /// Things moved by themselves: nothing is known about the surroundings until the next measurement.
    pub fn surroundings_changed(&mut self) {
        self.free_m = 0.0;
    }

    fn clearance_at(&mut self, place: &mut Place, map_from_base: Pose2) -> f64 {
        let mut nearest = f64::INFINITY;
        self.each_near(place, map_from_base, |placed, footprint| {
            nearest = nearest.min(placed.to(footprint).distance);
            nearest
        });
        nearest * place.resolution_m
    }

    /// Calls `visit` for everything that may be nearer than the distance (in cells) it last returned.
    fn each_near(
        &mut self,
        place: &mut Place,
        map_from_base: Pose2,
        mut visit: impl FnMut(&PlacedHull, &Footprint) -> f64,
    ) {
        let number = place.prepare(self.view);
        let cells = |point: Point| place.cells_from_map(map_from_base * point);
        self.placed.put(&self.hull, 1.0 / place.resolution_m, cells);
        let heights = self.heights_m.map(|heights_m| heights_m.map(|z_m| z_m / place.resolution_m));
        let meets = |z_min: f64, z_max: f64| heights.is_none_or(|[low, high]| z_min <= high && z_max >= low);
        for mover in place.movers(self.view).filter(|mover| meets(mover.z_min, mover.z_max)) {
            visit(&self.placed, &mover.footprint);
        }
        for barrier in &place.barriers {
            visit(&self.placed, barrier);
        }
        let mut nearest = f64::INFINITY;
        place.lattice(number).around(&self.placed, |footprint, [z_min, z_max]| {
            if meets(z_min, z_max) {
                nearest = visit(&self.placed, footprint);
            }
            nearest
        });
    }

    /// Bearings in the base frame at which the hull touches something.
    pub fn contacts(&mut self, place: &mut Place, bearings_rad: &mut Vec<f64>) {
        bearings_rad.clear();
        if !self.touches {
            return;
        }
        let within = 2.0 * (TOUCH_M + STEP_M) / place.resolution_m;
        let (map_from_base, base_from_map) = (self.map_from_base, self.map_from_base.inverse());
        let lattice_from_map = place.lattice_from_map;
        let resolution_m = place.resolution_m;
        self.each_near(place, map_from_base, |placed, footprint| {
            let nearest = placed.to(footprint);
            if nearest.distance <= within {
                let at = base_from_map * (lattice_from_map.inverse() * (nearest.at * resolution_m));
                let bearing_rad = at.y.atan2(at.x);
                let known = |other: &f64| wrap_angle(bearing_rad - other).abs() < SAME_CONTACT_RAD;
                if !bearings_rad.iter().any(known) {
                    bearings_rad.push(bearing_rad);
                }
            }
            within
        });
    }
}

#[cfg(test)]
mod tests {
    use rumbo_core::frames::pose2;
    use rumbo_kit::world_file::parse_world;

    use super::*;

    fn hall(more: &str) -> Place {
        let text = format!("[[wall]]\nfrom = [2, -3]\nto = [2, 3]\n{more}");
        Place::new(&parse_world(&text, std::path::Path::new("hall.toml")).unwrap(), None)
    }

    fn body(place: &mut Place, robot: &Robot) -> Body {
        Body::new(robot, place, pose2(0.0, 0.0, 0.0))
    }

    #[test]
    fn a_wall_stops_the_robot_at_its_hull_and_counts_once() {
        let mut place = hall("");
        let mut body = body(&mut place, &Robot::default());
        assert!((body.clearance_m - 1.8).abs() < 1e-9);
        let share = body.drive(&mut place, Twist::new(1.0, 0.0), 3.0);
        assert!((body.map_from_base.translation.x - 1.8).abs() < 3e-4 && body.clearance_m > 0.0);
        assert!((share - 0.6).abs() < 1e-3, "{share}");
        for _ in 0..5 {
            assert_eq!(body.drive(&mut place, Twist::new(1.0, 0.0), 0.1), 0.0);
        }
        assert_eq!((body.contact_episodes, body.driven_contact_episodes), (1, 1));
        let mut bearings = Vec::new();
        body.contacts(&mut place, &mut bearings);
        assert!(bearings.len() == 1 && bearings[0].abs() < 1e-6, "{bearings:?}");
        assert_eq!(body.drive(&mut place, Twist::new(-1.0, 0.0), 0.5), 1.0, "away is free");
        body.contacts(&mut place, &mut bearings);
        assert!(bearings.is_empty());
        body.drive(&mut place, Twist::new(1.0, 0.0), 3.0);
        assert_eq!(body.contact_episodes, 2);
    }

    #[test]
    fn sliding_along_a_wall_is_allowed_and_turning_in_place_too() {
        let mut place = hall("");
        let mut body = body(&mut place, &Robot::default());
        body.drive(&mut place, Twist::new(1.0, 0.0), 3.0);
        let along = Twist { forward_m_s: 0.0, left_m_s: 0.5, turn_rad_s: 0.0 };
        assert_eq!(body.drive(&mut place, along, 1.0), 1.0);
        assert_eq!(body.drive(&mut place, Twist::new(0.0, 1.0), 1.0), 1.0);
    }

    #[test]
    fn a_bar_hits_with_its_end_when_it_turns() {
        let mut place = hall("");
        let footprint_m = vec![[-0.2, -0.1], [2.2, -0.1], [2.2, 0.1], [-0.2, 0.1]];
        let mut body =
            Body::new(&Robot { footprint_m, ..Robot::default() }, &mut place, pose2(0.0, 0.0, 1.5));
        assert!(body.clearance_m > 0.0);
        let share = body.drive(&mut place, Twist::new(0.0, -1.0), 1.5);
        // The corner (2.2, -0.1) is 2.2023 away; it reaches x = 2 at yaw acos(2 / 2.2023) + atan(0.1 / 2.2).
        let expected = (2.0 / 2.2f64.hypot(0.1)).acos() + (0.1f64 / 2.2).atan();
        assert!((1.5 - 1.5 * share - expected).abs() < 1e-3, "{share} {expected}");
        assert_eq!(body.contact_episodes, 1);
    }

    #[test]
    fn what_hangs_higher_than_the_robot_is_no_obstacle() {
        let table = "[[box]]\ncenter = [1, 0]\nsize = [0.5, 0.5]\nz_min_m = 0.7\nz_max_m = 0.75\n";
        let mut place = hall(table);
        let mut low = body(&mut place, &Robot::default());
        assert_eq!(low.drive(&mut place, Twist::new(1.0, 0.0), 1.0), 1.0);
        let mut tall = body(&mut place, &Robot { height_m: 1.0, ..Robot::default() });
        assert!(tall.drive(&mut place, Twist::new(1.0, 0.0), 1.0) < 0.6);
    }

    #[test]
    fn glass_stops_the_robot_and_a_person_may_walk_into_it() {
        let person = "[[wall]]\nfrom = [1, -3]\nto = [1, 3]\nmaterial = 'glass'\n\
                      [[person]]\nroute = [[-5, 0], [5, 0]]\nspeed_m_s = 1.0\n";
        let mut place = hall(person);
        let mut body = body(&mut place, &Robot::default());
        body.drive(&mut place, Twist::new(1.0, 0.0), 2.0);
        let x = body.map_from_base.translation.x;
        assert!((x - 0.8).abs() < 3e-4, "{x}");
        assert_eq!(body.contact_episodes, 1);
        body.drive(&mut place, Twist::new(-1.0, 0.0), 0.5);
        place.set_time(5.0, &Pose2::identity());
        body.surroundings_changed();
        assert_eq!(body.drive(&mut place, Twist::ZERO, 0.1), 1.0);
        assert_eq!(body.contact_episodes, 2, "the person stands at x = 0, the robot at 0.3");
        assert!(body.clearance_m < 0.0);
        assert_eq!(body.drive(&mut place, Twist::new(0.1, 0.0), 0.1), 1.0, "away from the person");
        assert_eq!(
            body.driven_contact_episodes, 1,
            "who walks into a robot that stands or leaves was not driven into"
        );
        assert_eq!(body.drive(&mut place, Twist::new(-0.1, 0.0), 0.1), 0.0, "towards the person");
        assert_eq!((body.contact_episodes, body.driven_contact_episodes), (2, 2));
    }
}
