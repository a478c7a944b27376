//! A world that has an answer to everything, and maps and observations with everything in them.

use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Pose2, Pose3, Twist, lift, pose2};
use rumbo_core::map::{Grid, GridHeader, Landmark, Landmarks, Line, Lines, Map, VoxelChunk, Voxels};
use rumbo_core::messages::*;
use rumbo_core::robot::{Drive, Robot, SteeredWheel};
use rumbo_core::stages::{Advance, Answer, Attitude, Drove, Probe, WheelMotion, World, WorldError};
use rumbo_core::time::Time;

pub struct Rich {
    ranges: Vec<f32>,
    marks: Marks,
    pub recorded: Vec<Observation>,
}

impl Rich {
    pub fn new() -> Rich {
        Rich { ranges: vec![1.5, f32::INFINITY, 0.25], marks: marks(), recorded: everything() }
    }
}

impl World for Rich {
    fn now(&self) -> Time {
        Time(123_456_789)
    }
    fn advance(&mut self, to: Time) -> Result<Advance, WorldError> {
        Ok(Advance::Reached(to))
    }
    fn drive(&mut self, _: &Command) -> Result<Drove, WorldError> {
        Ok(Drove::Drove)
    }
    fn is_real_time(&self) -> bool {
        true
    }
    fn probe<'w>(&'w mut self, probe: &Probe<'_>) -> Result<Answer<'w>, WorldError> {
        Ok(match probe {
            Probe::Beams { n_beams: 3, .. } | Probe::Cones { .. } => Answer::Ranges(&self.ranges),
            Probe::Depth { intrinsics, .. } if intrinsics.width == 4 => Answer::Ranges(&self.ranges[..1]),
            Probe::Wheels => Answer::Wheels(WheelMotion {
                rolled_m: [1.0, 2.0, 3.0, 4.0],
                n_wheels: 2,
                turned_rad: 0.5,
                steering_rad: -0.25,
                twist: Twist::new(0.3, -0.1),
            }),
            Probe::Attitude => Answer::Attitude(Attitude {
                attitude_rad: [0.1, 0.2, 0.3],
                rates_rad_s: [1.0, 2.0, 3.0],
                accelerations_m_s2: [0.0, 0.0, 9.81],
            }),
            Probe::Position => Answer::Position([1.0, 2.0, 3.0]),
            Probe::Contacts => Answer::Contacts(&[0.5, -0.5]),
            Probe::Marks { .. } => Answer::Marks(&self.marks),
            Probe::Person { name: "anna" } => Answer::Position([4.0, 5.0, 0.0]),
            Probe::Channel { name: "front" } => Answer::Recorded(&self.recorded),
            Probe::Channel { name: "live" } => Answer::Live,
            Probe::Channel { name: "broken" } => {
                return Err(WorldError::Recording { path: "x.log".into(), reason: "line 3".into() });
            }
            _ => return Err(WorldError::Unsupported { probe: probe.name() }),
        })
    }
}

/// What a world says to every kind of probe, as text to the bit.
pub fn ask_everything(world: &mut dyn World) -> Vec<String> {
    let mount = lift(&pose2(0.1, 0.2, 0.3));
    let intrinsics = Intrinsics { width: 4, height: 3, focal_px: [5.0, 6.0], center_px: [1.5, 1.0] };
    let probes = [
        Probe::Beams {
            base_from_sensor: &mount,
            first_bearing_rad: -1.0,
            bearing_step_rad: 0.5,
            n_beams: 3,
            max_range_m: 8.0,
        },
        Probe::Beams {
            base_from_sensor: &mount,
            first_bearing_rad: -1.0,
            bearing_step_rad: 0.5,
            n_beams: 4,
            max_range_m: 8.0,
        },
        Probe::Cones {
            base_from_sensor: &mount,
            bearings_rad: &[0.0, 1.0],
            cone_rad: 0.4,
            ring_radius_m: 0.2,
            max_range_m: 5.0,
        },
        Probe::Depth { base_from_sensor: &mount, intrinsics: &intrinsics, max_range_m: 4.0 },
        Probe::Wheels,
        Probe::Attitude,
        Probe::Position,
        Probe::Contacts,
        Probe::Marks { base_from_sensor: &mount, field_of_view_rad: 1.0, max_range_m: 9.0 },
        Probe::Person { name: "anna" },
        Probe::Person { name: "nobody" },
        Probe::Channel { name: "front" },
        Probe::Channel { name: "live" },
        Probe::Channel { name: "broken" },
    ];
    let now = format!("{:?} {}", world.now(), world.is_real_time());
    let mut answers = vec![now];
    answers.extend(probes.iter().map(|probe| match world.probe(probe) {
        Ok(answer) => format!("{answer:?}"),
        Err(error) => format!("{error}"),
    }));
    answers
}

fn marks() -> Marks {
    let mark = |identity, range_m| Mark { identity, range_m, bearing_rad: -0.5 };
    Marks {
        marks: vec![mark(Some(7), 2.0), mark(None, 3.0)],
        range_deviation_m: 0.1,
        bearing_deviation_rad: 0.02,
    }
}

/// One observation of each kind, with odd numbers in them.
pub fn everything() -> Vec<Observation> {
    let data = vec![
        Data::Odometry(Odometry {
            odom_from_base: pose2(1.0, -2.0, 3.0),
            twist: Twist { forward_m_s: 0.1, left_m_s: 0.2, turn_rad_s: 0.3 },
            noise: [0.01, 0.02, 0.03],
        }),
        Data::WheelSpeeds(WheelSpeeds { n_wheels: 2, rim_m_s: [0.5, 0.6, 0.0, 0.0] }),
        Data::SteeringAngle(SteeringAngle { angle_rad: -0.4 }),
        Data::LaserScan(LaserScan {
            first_bearing_rad: -1.5,
            bearing_step_rad: 0.01,
            sweep_s: 0.02,
            min_range_m: 0.05,
            max_range_m: 30.0,
            ranges_m: Buffer::from(vec![1.0, 2.0, f32::INFINITY, 0.5]),
            intensities: Buffer::from(vec![9.0, 8.0, 7.0, 6.0]),
        }),
        Data::RangeRing(RangeRing {
            first_bearing_rad: 0.1,
            bearing_step_rad: 0.2,
            cone_rad: 0.3,
            ring_radius_m: 0.4,
            min_range_m: 0.5,
            max_range_m: 6.0,
            ranges_m: Buffer::from(vec![1.25; 16]),
        }),
        Data::Bumpers(Bumpers {
            n_bumpers: 6,
            pressed: 0b101,
            first_bearing_rad: 0.1,
            bearing_step_rad: 0.2,
            ring_radius_m: 0.3,
        }),
        Data::DepthImage(DepthImage {
            intrinsics: Intrinsics { width: 2, height: 2, focal_px: [5.0, 6.0], center_px: [1.0, 1.0] },
            unit_m: 0.001,
            depth: Buffer::from(vec![0u16, 500, 600, 65535]),
        }),
        Data::PointCloud(PointCloud { points_m: Buffer::from(vec![[1.0f32, 2.0, 3.0], [4.0, 5.0, 6.0]]) }),
        Data::Imu(Imu {
            attitude_rad: None,
            rates_rad_s: [0.1, 0.2, 0.3],
            accelerations_m_s2: [0.0, 0.1, 9.8],
        }),
        Data::PositionFix(PositionFix { position_m: [1.0, 2.0, 3.0], deviation_m: [5.0, 5.0, 9.0] }),
        Data::Marks(marks()),
        Data::Custom(Custom { schema: "acme/Smell".into(), bytes: Buffer::from(vec![1u8, 2, 3]) }),
    ];
    let seen = |(idx, data): (usize, Data)| Observation {
        sensor: SensorId(idx as u16),
        stamp: Time(1_000_000_007 * idx as i64),
        base_from_sensor: mount(idx),
        valid: idx % 3 != 0,
        data,
    };
    data.into_iter().enumerate().map(seen).collect()
}

fn mount(idx: usize) -> Pose3 {
    Pose3::new(nalgebra::Vector3::new(0.1, 0.2, 0.3), nalgebra::Vector3::new(0.3, -0.2, 0.1 * idx as f64))
}

/// A map with every layer.
pub fn full_map() -> Map {
    let header = GridHeader {
        width: 4,
        height: 3,
        resolution_m: 0.25,
        origin: [1.0, -2.0, 0.3],
        occupied_above: 0.7,
        free_below: -1.3,
    };
    let coarse = |n: u32| Grid::unknown(n, n, 0.5).unwrap();
    let line = Line { from: [0.0, 1.0], to: [2.0, 3.0], covariance: [0.1, 0.2, 0.3] };
    let landmark = Landmark { identity: 3, kind: 4, position: [5.0, 6.0], covariance: [0.1, 0.0, 0.2] };
    let chunk = |k: i32| VoxelChunk { index: [k, -k, 2], log_odds: Buffer::filled(4096, k as f32) };
    Map {
        version: 41,
        grid: Some(Grid::new(header, Buffer::from((0..12).map(|k| k as f32).collect::<Vec<_>>())).unwrap()),
        coarse_grids: vec![coarse(2), coarse(3), coarse(5)],
        lines: Some(Lines { lines: Buffer::from(vec![line; 3]) }),
        landmarks: Some(Landmarks { landmarks: Buffer::from(vec![landmark; 2]) }),
        voxels: Some(Voxels {
            resolution_m: 0.1,
            origin: [1.0, 2.0, 3.0],
            chunks: vec![chunk(1), chunk(2), chunk(3)],
        }),
    }
}

/// An estimate with everything in it.
pub fn full_estimate() -> Estimate {
    let mut estimate = Estimate::planar(
        Time(77),
        pose2(1.0, 2.0, 0.7),
        pose2(0.5, 0.5, -0.1),
        nalgebra::Matrix3::identity(),
    );
    estimate.covariance[(0, 5)] = 0.125;
    estimate.status = Status::Ambiguous;
    estimate.candidates = vec![
        Candidate { map_from_base: pose2(1.0, 2.0, 3.0), score: 0.75 },
        Candidate { map_from_base: pose2(4.0, 5.0, -3.0), score: 0.25 },
    ];
    estimate.wish = Some(Wish::TurnBy(-1.5));
    estimate
}

/// A robot with nothing at its default.
pub fn odd_robot() -> Robot {
    Robot {
        drive: Drive::Tricycle {
            wheelbase_m: 1.0,
            track_m: 0.8,
            max_steer_deg: 70.0,
            max_steer_rate_deg_s: 45.0,
            steered: SteeredWheel::Rear,
        },
        radius_m: 0.9,
        footprint_m: vec![[-0.5, -0.4], [1.2, -0.4], [1.2, 0.4], [-0.5, 0.4]],
        height_m: 2.0,
        max_speed_m_s: 1.5,
        max_turn_deg_s: 33.0,
        max_accel_m_s2: 0.7,
        max_turn_accel_deg_s2: 99.0,
        braking_m_s2: 1.1,
        guard: rumbo_core::robot::GuardParams {
            margin_m: 0.07,
            latency_s: 0.2,
            stale_after_s: 0.8,
            stop_zone: false,
        },
    }
}

/// A pose whose cosine and sine would not survive a way through an angle.
pub fn odd_pose() -> Pose2 {
    (0..100).fold(Pose2::identity(), |pose, _| pose * pose2(0.1, -0.01, 0.0373))
}
