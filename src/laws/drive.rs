//! A made-up drive through the hall: what its sensors say, and where the robot is in truth.

use super::depth_picture::depth_picture;
use super::law::Trouble;
use super::text_world::TextWorld;
use super::turn::Turn;
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Point2, Pose2, Pose3, Twist, pose2};
use rumbo_core::messages::{
    Data, LaserScan, Mark, Marks, Observation, ObservationKind, Odometry, PositionFix, RangeRing, SensorId,
};
use rumbo_core::time::Time;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Between two frames, seconds.
pub const STEP_S: f64 = 0.1;
/// How the robot moves: an arc.
pub const TWIST: Twist = Twist { forward_m_s: 0.2, left_m_s: 0.0, turn_rad_s: 0.05 };
/// Frames of the drive.
pub const N_FRAMES: usize = 150;
/// Reach of the laser, meters.
pub const MAX_RANGE_M: f64 = 15.0;
/// What a drive has.
pub const KINDS: [ObservationKind; 6] = [
    ObservationKind::DepthImage,
    ObservationKind::Odometry,
    ObservationKind::LaserScan,
    ObservationKind::RangeRing,
    ObservationKind::PositionFix,
    ObservationKind::Marks,
];

/// One moment.
#[derive(Debug, Clone)]
pub struct Frame {
    /// When.
    pub now: Time,
    /// Where the robot is.
    pub map_from_base: Pose2,
    /// Where its odometer says it is, without error.
    pub odom_from_base: Pose2,
    /// What its sensors say.
    pub seen: Vec<Observation>,
}

/// All moments, and the world around.
#[derive(Debug, Clone)]
pub struct Drive {
    /// The world.
    pub world: TextWorld,
    /// One frame each 0.1 s.
    pub frames: Vec<Frame>,
}

impl Drive {
    /// The drive through the hall, seen from this side.
    pub fn seen_from(turn: Turn) -> Result<Drive, Trouble> {
        let hall = TextWorld::hall()?;
        let world = hall.turned(turn)?;
        let frames = (0..N_FRAMES).map(|k| {
            let odom_from_base = TWIST.integrate(STEP_S * k as f64);
            let map_from_base = hall.start * odom_from_base;
            let mut frame = frame_at(&hall, step_time(k), map_from_base, odom_from_base, TWIST);
            frame.map_from_base = turn.pose(&map_from_base, hall.height_m());
            frame.odom_from_base = turn.own_pose(&odom_from_base);
            for observation in &mut frame.seen {
                *observation = turn.observation(observation);
                if let Data::PositionFix(fix) = &mut observation.data {
                    let Pose2 { translation, .. } = frame.map_from_base;
                    fix.position_m = [translation.x, translation.y, 0.0];
                }
            }
            frame
        });
        Ok(Drive { frames: frames.collect(), world })
    }
}

/// The time of frame `k`.
pub fn step_time(k: usize) -> Time {
    Time(k as i64 * 100_000_000)
}

/// What the sensors say at a place.
pub fn frame_at(
    world: &TextWorld,
    now: Time,
    map_from_base: Pose2,
    odom_from_base: Pose2,
    twist: Twist,
) -> Frame {
    let Pose2 { translation, .. } = map_from_base;
    let seen = [
        Data::Odometry(Odometry { odom_from_base, twist, noise: [0.01, 0.005, 0.01] }),
        Data::LaserScan(scan(world, &map_from_base)),
        Data::RangeRing(ring(world, &map_from_base)),
        Data::PositionFix(PositionFix {
            position_m: [translation.x, translation.y, 0.0],
            deviation_m: [0.02; 3],
        }),
        Data::Marks(marks(world, &map_from_base)),
        Data::DepthImage(depth_picture(world, &map_from_base)),
    ];
    let seen = (0..).zip(seen).map(|(sensor, data)| observation(sensor, now, data)).collect();
    Frame { now, map_from_base, odom_from_base, seen }
}

/// Data with the head of an observation of a sensor in the middle of the robot.
pub fn observation(sensor: u16, stamp: Time, data: Data) -> Observation {
    Observation { sensor: SensorId(sensor), stamp, base_from_sensor: Pose3::identity(), valid: true, data }
}

/// Half a turn in steps of one degree, without noise.
fn scan(world: &TextWorld, map_from_base: &Pose2) -> LaserScan {
    let (first_bearing_rad, bearing_step_rad) = (-FRAC_PI_2, 1f64.to_radians());
    let bearing = |k: usize| first_bearing_rad + bearing_step_rad * k as f64;
    let range = |k: usize| world.range_m(&(map_from_base * pose2(0.0, 0.0, bearing(k))), MAX_RANGE_M) as f32;
    LaserScan {
        first_bearing_rad,
        bearing_step_rad,
        max_range_m: MAX_RANGE_M as f32,
        ranges_m: (0..181).map(range).collect::<Vec<f32>>().into(),
        ..LaserScan::default()
    }
}

/// The marks that nothing hides from a camera that looks ahead, without noise.
fn marks(world: &TextWorld, map_from_base: &Pose2) -> Marks {
    const HALF_VIEW_RAD: f64 = 1.0;
    let in_view = |(identity, at): &(u32, Point2)| {
        let seen = map_from_base.inverse() * at;
        let (range_m, bearing_rad) = (seen.coords.norm(), seen.y.atan2(seen.x));
        let along = map_from_base * pose2(0.0, 0.0, bearing_rad);
        let is_seen =
            bearing_rad.abs() <= HALF_VIEW_RAD && world.range_m(&along, MAX_RANGE_M) >= range_m - 0.05;
        is_seen.then_some(Mark { identity: Some(*identity), range_m, bearing_rad })
    };
    let marks = world.marks.iter().filter_map(in_view).collect();
    Marks { marks, range_deviation_m: 0.05, bearing_deviation_rad: 0.02 }
}

/// Sixteen sonars around the hull: the nearest of seven rays each.
fn ring(world: &TextWorld, map_from_base: &Pose2) -> RangeRing {
    const RADIUS_M: f64 = 0.2;
    const REACH_M: f64 = 5.0;
    let (bearing_step_rad, cone_rad) = (TAU / 16.0, 25f64.to_radians());
    let mut ranges_m = Buffer::filled(16, f32::INFINITY);
    for (k, range) in ranges_m.make_mut().iter_mut().enumerate() {
        for ray in -3..=3 {
            let bearing = bearing_step_rad * k as f64 + cone_rad / 6.0 * f64::from(ray);
            let from = map_from_base * pose2(0.0, 0.0, bearing) * pose2(RADIUS_M, 0.0, 0.0);
            *range = range.min(world.range_m(&from, REACH_M) as f32);
        }
    }
    RangeRing {
        first_bearing_rad: 0.0,
        bearing_step_rad,
        cone_rad,
        ring_radius_m: RADIUS_M,
        min_range_m: 0.0,
        max_range_m: REACH_M as f32,
        ranges_m,
    }
}
