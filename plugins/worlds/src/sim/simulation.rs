//! The simulation: wheels, body and surroundings carried through time in short pieces.

use rumbo_core::frames::{Pose2, Pose3, Twist, lift};
use rumbo_core::messages::{Mark, Marks};
use rumbo_core::rng::Rng;
use rumbo_core::robot::Robot;
use rumbo_core::stages::Truth;
use rumbo_core::time::Time;

use super::base_drive::{BaseDrive, DriveLimits};
use super::beams::Eyes;
use super::body::Body;
use super::place::{Place, View};
use super::slip::{Slip, SlipDraw};
use super::solid::{Point, Ray};

/// Pieces end at multiples of this: arcs of constant velocity, and people one step further.
const PIECE_NS: i64 = 10_000_000;
/// Slip is drawn anew at multiples of this, however often sensors look.
const SLIP_NS: i64 = 50_000_000;
/// A mark on a wall is seen although the wall is there too.
const MARK_DEPTH_M: f64 = 0.02;
const GRAVITY_M_S2: f64 = 9.81;

/// Everything that changes with time.
#[derive(Debug)]
pub struct Simulation {
    /// The surroundings.
    pub place: Place,
    /// What sensors look through.
    pub eyes: Eyes,
    /// The robot's body.
    pub body: Body,
    /// The robot's wheels.
    pub drive: BaseDrive,
    /// The time it is.
    pub now: Time,
    truth: Truth,
    slip: Option<Box<dyn Slip>>,
    slip_draw: SlipDraw,
    next_slip: i64,
    rng: Rng,
    acceleration_m_s2: [f64; 2],
}

impl Simulation {
    /// Puts a robot into a place at time zero.
    pub fn new(
        mut place: Place,
        robot: &Robot,
        map_from_base: Pose2,
        slip: Option<Box<dyn Slip>>,
        rng: Rng,
    ) -> Simulation {
        place.hull = Some(robot.hull());
        place.set_time(0.0, &map_from_base);
        let body = Body::new(robot, &mut place, map_from_base);
        let truth = Truth {
            map_from_base: lift(&map_from_base),
            twist: Twist::ZERO,
            clearance_m: body.clearance_m,
            contact_episodes: Some(0),
            driven_contact_episodes: Some(0),
        };
        Simulation {
            place,
            eyes: Eyes::default(),
            body,
            drive: BaseDrive::new(robot.drive, DriveLimits::of(robot)),
            now: Time::ZERO,
            truth,
            slip,
            slip_draw: SlipDraw::NONE,
            next_slip: 0,
            rng,
            acceleration_m_s2: [0.0; 2],
        }
    }

    /// Lets time pass; `to` lies in the future.
    pub fn advance(&mut self, to: Time) {
        let mut floor_twist = self.truth.twist;
        while self.now < to {
            let end = Time((self.now.0.div_euclid(PIECE_NS) + 1) * PIECE_NS).min(to);
            floor_twist = self.piece(end);
        }
        self.body.measure(&mut self.place);
        self.truth = Truth {
            map_from_base: lift(&self.body.map_from_base),
            twist: floor_twist,
            clearance_m: self.body.clearance_m,
            contact_episodes: Some(self.body.contact_episodes),
            driven_contact_episodes: Some(self.body.driven_contact_episodes),
        };
    }

    /// One piece of time; the robot's velocity over the floor at its end.
    fn piece(&mut self, end: Time) -> Twist {
        let seconds = (end - self.now).as_secs();
        if self.now.0 >= self.next_slip {
            self.next_slip = (self.now.0.div_euclid(SLIP_NS) + 1) * SLIP_NS;
            if let Some(slip) = &self.slip {
                self.slip_draw = slip.draw(&mut self.rng);
            }
        }
        if !self.place.is_still() {
            self.place.set_time(end.as_secs(), &self.body.map_from_base);
            self.body.surroundings_changed();
        }
        let before = self.drive.twist;
        let mean = self.drive.accelerate(seconds);
        let share = self.body.drive(&mut self.place, self.slip_draw.apply(mean), seconds);
        self.drive.roll(mean, seconds * share);
        if share < 1.0 {
            self.drive.stall();
        }
        self.now = end;
        let after = self.drive.twist;
        self.acceleration_m_s2 = [
            (after.forward_m_s - before.forward_m_s) / seconds - after.left_m_s * after.turn_rad_s,
            (after.left_m_s - before.left_m_s) / seconds + after.forward_m_s * after.turn_rad_s,
        ];
        self.slip_draw.apply(after)
    }

    /// What only the world knows.
    pub fn truth(&self) -> &Truth {
        &self.truth
    }

    /// Specific force in the base frame: what an accelerometer feels.
    pub fn specific_force_m_s2(&self) -> [f64; 3] {
        [self.acceleration_m_s2[0], self.acceleration_m_s2[1], GRAVITY_M_S2]
    }

    /// A mount in the map.
    pub fn map_from_sensor(&self, base_from_sensor: &Pose3) -> Pose3 {
        self.truth.map_from_base * base_from_sensor
    }

    /// Marks in view, nearest things in front of them considered.
    pub fn marks_in_view(
        &mut self,
        map_from_sensor: &Pose3,
        field_of_view_rad: f64,
        max_range_m: f64,
        out: &mut Marks,
    ) {
        out.marks.clear();
        let z_m = map_from_sensor.translation.z;
        let number = self.place.prepare(View { z_min_m: z_m, z_max_m: z_m, with_glass: false });
        let view = View { z_min_m: z_m, z_max_m: z_m, with_glass: false };
        let eye = Point::new(map_from_sensor.translation.x, map_from_sensor.translation.y);
        for mark in &self.place.marks {
            let offset = Point::from(mark.at) - eye;
            let range_m = offset.norm();
            let seen = map_from_sensor.rotation.inverse() * offset.push(0.0);
            let bearing_rad = seen.y.atan2(seen.x);
            if range_m > max_range_m || range_m == 0.0 || bearing_rad.abs() > field_of_view_rad / 2.0 {
                continue;
            }
            let along = self.place.lattice_from_map.rotation * (offset / range_m);
            let ray = Ray::level(self.place.cells_from_map(eye), along, z_m / self.place.resolution_m);
            let reach = (range_m - MARK_DEPTH_M).max(0.0) / self.place.resolution_m;
            let hidden = self.place.lattice(number).cast(&ray, reach).is_some()
                || self.place.movers(view).any(|mover| mover.hit(&ray).is_some_and(|way| way <= reach));
            if !hidden {
                out.marks.push(Mark { identity: Some(mark.id), range_m, bearing_rad });
            }
        }
    }
}
