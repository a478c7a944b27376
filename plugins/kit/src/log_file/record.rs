//! What the lines of a log say.

use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Pose2, Twist};
use rumbo_core::time::Time;

/// One line that was read.
#[derive(Debug, Clone, PartialEq)]
pub struct LogRecord {
    /// Number of the line, from 1.
    pub line: u64,
    /// What it says.
    pub told: Told,
}

/// What a line says.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Told {
    /// A scan, with the odometer's pose at that time.
    Scan(RecordedScan),
    /// The odometer's pose.
    Odometry(RecordedOdometry),
    /// A pose of the graph that the log was made into; the scan taken there follows.
    Vertex {
        /// Its number in the graph.
        id: i64,
        /// The corrected pose.
        map_from_base: Pose2,
    },
    /// A constraint between two poses of the graph.
    Edge(PoseEdge),
    /// A parameter of the program that wrote the log.
    Parameter {
        /// Its name.
        name: String,
        /// Its value, as text.
        value: String,
    },
    /// A mark that aligns several logs.
    Sync,
}

/// Which laser of the robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum LaserSide {
    /// `FLASER`, `ROBOTLASER1`, `L`.
    Front,
    /// `RLASER`, `ROBOTLASER2`.
    Rear,
}

/// A scan as recorded. Stamps are absolute, as the file has them.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedScan {
    /// When it was taken (`ipc_time`, the stamp that relations and pose files use).
    pub stamp: Time,
    /// By which laser.
    pub side: LaserSide,
    /// Bearing of the first beam in the laser's frame, radians.
    pub first_bearing_rad: f64,
    /// From one beam to the next, radians.
    pub bearing_step_rad: f64,
    /// Reach of the device, meters.
    pub max_range_m: f64,
    /// One range a beam, meters; infinite where nothing was seen, not-a-number where there is no reading.
    pub ranges_m: Buffer<f32>,
    /// One intensity a beam, or none at all.
    pub intensities: Buffer<f32>,
    /// The odometer's pose of the robot.
    pub odom_from_base: Pose2,
    /// Velocity of the robot where the line has it.
    pub twist: Option<Twist>,
    /// The pose that the line (or the vertex before it) gives beside the odometer's: corrected, in a corrected log.
    pub map_from_base: Pose2,
}

/// A reading of the odometer as recorded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecordedOdometry {
    /// When it was read, absolute.
    pub stamp: Time,
    /// The robot in the odometer's frame.
    pub odom_from_base: Pose2,
    /// Its velocity, where the line has it.
    pub twist: Option<Twist>,
}

/// A constraint of a pose graph.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseEdge {
    /// Number of the pose that it starts from.
    pub from: i64,
    /// Number of the pose that it leads to.
    pub to: i64,
    /// The second pose, seen from the first.
    pub from_to: Pose2,
    /// Information in TORO's order: xx, xy, yy, tt, xt, yt (1/m², 1/(m·rad), 1/rad²).
    pub information: [f64; 6],
}
