//! The simulation: wheels, body and surroundings carried through time in short pieces.

use rumbo_core::frames::{Pose2, Pose3, Twist, lift};
use rumbo_core::messages::{Mark, Marks};
use rumbo_core::rng::Rng;
use rumbo_core::robot::Robot;
use rumbo_core::stages::{Attitude, Truth};
use rumbo_core::time::Time;

use super::base_drive::{BaseDrive, DriveLimits};
use super::beams::Eyes;
use super::body::Body;
use super::hardships::{Kidnap, Spin, Sway, Wheels};
use super::place::Place;
use super::slip::{Slip, SlipDraw};
use super::solid::{Point, Ray};
use super::stance::{Stance, Undercarriage};

/// Pieces end at multiples of this: arcs of constant velocity, and people one step further.
const PIECE_NS: i64 = 10_000_000;
/// Slip is drawn anew at multiples of this, however often sensors look.
const SLIP_NS: i64 = 50_000_000;
/// A mark on a wall is seen although the wall is there too.
const MARK_DEPTH_M: f64 = 0.02;
const GRAVITY_M_S2: f64 = 9.81;

/// What makes the drive hard.
#[derive(Debug, Clone, Default)]
pub struct Hardships {
    /// Between wheels and floor.
    pub slip: Option<Box<dyn Slip>>,
    /// How the wheels take raised floor.
    pub wheels: Wheels,
    /// Of the body on its wheels.
    pub sway: Option<Sway>,
    /// Hands that carry the robot away.
    pub kidnap: Option<Kidnap>,
    /// When and where wheels spin in place.
    pub spins: Vec<Spin>,
}

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
    /// How the body stands, where the floor is not level or the body sways.
    stance: Option<Stance>,
    slip: Option<Box<dyn Slip>>,
    kidnap: Option<Kidnap>,
    spins: Vec<Spin>,
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
        hardships: Hardships,
        rng: Rng,
    ) -> Simulation {
        let Hardships { slip, wheels, sway, kidnap, spins } = hardships;
        place.hull = Some(robot.hull());
        place.bar(&wheels);
        place.set_time(0.0, &map_from_base);
        let mut body = Body::new(robot, &mut place, map_from_base);
        let stance = (!place.terrain.is_flat() || sway.is_some()).then(|| {
            let undercarriage = Undercarriage::of(robot, &wheels);
            Stance::new(undercarriage, sway, GRAVITY_M_S2, &place.terrain, &map_from_base)
        });
        if let Some(stance) = &stance {
            body.stand_at(stance.z_m());
            body.measure(&mut place);
        }
        let truth = Truth {
            map_from_base: stance.as_ref().map_or(lift(&map_from_base), |stance| stance.map_from_base),
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
            stance,
            slip,
            kidnap,
            spins,
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
            map_from_base: match &self.stance {
                Some(stance) => stance.map_from_base,
                None => lift(&self.body.map_from_base),
            },
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
        self.carry_away();
        let before = self.drive.twist;
        let mean = self.drive.accelerate(seconds);
        let over_floor = self.over_floor(mean);
        let over_map = self.stance.as_ref().map_or(over_floor, |stance| stance.seen_from_above(over_floor));
        let share = self.body.drive(&mut self.place, over_map, seconds);
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
        if let Some(stance) = &mut self.stance {
            stance.follow(&self.place.terrain, &self.body.map_from_base, end.as_secs(), seconds);
            if !self.place.terrain.is_flat() {
                self.body.stand_at(stance.z_m());
            }
        }
        self.over_floor(after)
    }

    /// What the floor gets of the motion that the wheels make.
    fn over_floor(&self, wheels: Twist) -> Twist {
        let at = self.body.map_from_base.translation;
        if self.spins.iter().any(|spin| spin.holds(self.now.as_secs(), at.x, at.y)) {
            return Twist::ZERO;
        }
        self.slip_draw.apply(wheels)
    }

    /// Moves the robot when its time has come.
    fn carry_away(&mut self) {
        let Some(kidnap) = self.kidnap.take_if(|kidnap| self.now.as_secs() >= kidnap.at_s) else { return };
        let map_from_base = kidnap.to.map_from_base();
        self.body.put(map_from_base);
        if let Some(stance) = &mut self.stance {
            stance.put(&self.place.terrain, &map_from_base, self.now.as_secs());
            self.body.stand_at(stance.z_m());
        }
    }

    /// What only the world knows.
    pub fn truth(&self) -> &Truth {
        &self.truth
    }

    /// How much room the robot would have somewhere else.
    pub fn room_at_m(&mut self, map_from_base: Pose2) -> f64 {
        let z_m = self.stance.as_ref().map(|stance| stance.z_over_m(&self.place.terrain, &map_from_base));
        self.body.room_at_m(&mut self.place, map_from_base, z_m)
    }

    /// Roll, pitch, yaw, turning rates, and what an accelerometer feels.
    pub fn attitude(&self) -> Attitude {
        if let Some(stance) = &self.stance {
            return Attitude {
                attitude_rad: stance.map_from_base.rotation.euler_angles().into(),
                rates_rad_s: stance.rates_rad_s,
                accelerations_m_s2: stance.specific_force_m_s2,
            };
        }
        Attitude {
            attitude_rad: [0.0, 0.0, self.body.map_from_base.rotation.angle()],
            rates_rad_s: [0.0, 0.0, self.truth.twist.turn_rad_s],
            accelerations_m_s2: [self.acceleration_m_s2[0], self.acceleration_m_s2[1], GRAVITY_M_S2],
        }
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
        let view = self.place.view_at(z_m, false);
        let number = self.place.prepare(view);
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
