//! A robot that does what the localizer wishes, as the engine lets it.

use super::relocalization_work::{CELL_M, Laser, Office};
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Pose2, lift, pose2, wrap_angle};
use rumbo_core::map::Map;
use rumbo_core::messages::{
    Data, Estimate, LaserScan, Observation, Odometry, Prior, Seen, SensorId, Status, Wish,
};
use rumbo_core::registry::Plugin;
use rumbo_core::rng::{Rng, stream};
use rumbo_core::stages::{BuildContext, Cx, Localizer};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;
use rumbo_localizers::landmark_relaxation::LandmarkRelaxationParams;

/// Seconds between updates.
const STEP_S: f64 = 0.2;
/// What a wish moves in one of them: meters, and radians.
const STEP: [f64; 2] = [0.02, 0.08];
/// Nearer than this is done, as in the engine.
const DONE: f64 = 0.01;

/// A robot with its localizer.
pub struct Robot<'o> {
    office: &'o Office,
    laser: Laser,
    map: Map,
    localizer: Box<dyn Localizer>,
    /// Where it truly is.
    pub map_from_base: Pose2,
    /// Where it was at the last scan.
    looked_from: Pose2,
    odom_from_base: Pose2,
    wish: Option<Wish>,
    left: f64,
    /// Does nothing that is wished.
    pub is_stuck: bool,
    rng: Rng,
    n_steps: i32,
    /// What the localizer counted last.
    pub counters: Vec<(&'static str, f64)>,
    /// Way that it drove, meters.
    pub driven_m: f64,
}

impl<'o> Robot<'o> {
    pub fn new(
        office: &'o Office,
        params: &LandmarkRelaxationParams,
        laser: Laser,
        map_from_base: Pose2,
    ) -> Robot<'o> {
        let context = BuildContext::bare("relocalizer");
        let map = Map { version: 1, grid: Some(office.grid.clone()), ..Map::default() };
        let mut localizer = params.build(&context).unwrap();
        localizer.start(&Prior::Unknown, &map).unwrap();
        Robot {
            office,
            laser,
            map,
            localizer,
            map_from_base,
            looked_from: map_from_base,
            odom_from_base: pose2(5.0, 6.0, 2.0),
            wish: None,
            left: 0.0,
            is_stuck: false,
            rng: stream(9, "robot"),
            n_steps: 0,
            counters: Vec::new(),
            driven_m: 0.0,
        }
    }

    /// One update, and the motion that follows from it.
    pub fn step(&mut self) -> Estimate {
        let now = Time::from_secs(STEP_S * f64::from(self.n_steps));
        self.n_steps += 1;
        self.looked_from = self.map_from_base;
        let ranges = self.laser.ranges_m(self.office, &self.map_from_base, &[], &mut self.rng);
        let scan = LaserScan {
            first_bearing_rad: self.laser.fan.first_bearing_rad,
            bearing_step_rad: self.laser.fan.bearing_step_rad,
            min_range_m: 0.05,
            max_range_m: self.laser.fan.max_range_m as f32,
            ranges_m: Buffer::from(ranges.iter().map(|range| *range as f32).collect::<Vec<f32>>()),
            ..LaserScan::default()
        };
        let odometry =
            Odometry { odom_from_base: self.odom_from_base, noise: [0.02; 3], ..Odometry::default() };
        let mount = lift(&self.laser.base_from_sensor);
        let seen = [
            observation(0, now, Pose2::identity(), Data::Odometry(odometry)),
            Observation {
                base_from_sensor: mount,
                ..observation(1, now, Pose2::identity(), Data::LaserScan(scan))
            },
        ];
        let trace = Trace::watched();
        let mut cx = Cx { now, trace: &trace };
        let estimate = self.localizer.update(&mut cx, Seen::sorted(&seen), &self.map).unwrap();
        let counters = trace.take().1;
        if !counters.is_empty() {
            self.counters = counters;
        }
        self.obey(estimate.wish);
        estimate
    }

    /// Steps until it is found or nothing more is wished; at most an hour.
    pub fn search(&mut self) -> Estimate {
        for _ in 0..18_000 {
            let estimate = self.step();
            if estimate.status == Status::Tracking
                || matches!(estimate.status, Status::Lost | Status::Ambiguous) && estimate.wish.is_none()
            {
                return estimate;
            }
        }
        panic!("the search has no end");
    }

    /// Error of the last estimate: meters, and degrees.
    pub fn off(&self, estimate: &Estimate) -> [f64; 2] {
        let way = estimate.pose2().translation.vector - self.looked_from.translation.vector;
        let turn = wrap_angle(estimate.pose2().rotation.angle() - self.looked_from.rotation.angle());
        [way.norm(), turn.abs().to_degrees()]
    }

    pub fn counter(&self, name: &str) -> f64 {
        self.counters.iter().find(|(known, _)| *known == name).expect(name).1
    }

    /// A wish is taken on when none is under way, and carried out step by step.
    fn obey(&mut self, wish: Option<Wish>) {
        if self.wish.is_none()
            && let Some(Wish::TurnBy(left) | Wish::MoveBy(left)) = wish
        {
            (self.wish, self.left) = (wish, left);
        }
        let Some(wish) = self.wish else { return };
        if self.left.abs() <= DONE {
            self.wish = None;
            return;
        }
        let [way_m, turn_rad] = match wish {
            Wish::TurnBy(_) => [0.0, STEP[1]],
            _ => [STEP[0], 0.0],
        }
        .map(|most| self.left.abs().min(most) * self.left.signum());
        let next = self.map_from_base * pose2(way_m, 0.0, turn_rad);
        let is_open =
            self.office.is_open(next.translation.x / CELL_M, next.translation.y / CELL_M, 0.2 / CELL_M);
        if self.is_stuck || !is_open && way_m != 0.0 {
            return;
        }
        self.left -= way_m + turn_rad;
        self.driven_m += way_m.abs();
        self.map_from_base = next;
        // The odometer turns a hundredth too far.
        self.odom_from_base *= pose2(way_m, 0.0, 1.01 * turn_rad);
    }
}

fn observation(sensor: u16, stamp: Time, base_from_sensor: Pose2, data: Data) -> Observation {
    let base_from_sensor = lift(&base_from_sensor);
    Observation { sensor: SensorId(sensor), stamp, base_from_sensor, valid: true, data }
}
