//! What is in a recording's own messages, in the language of ROS 2 message files, so that every viewer that opens bags
//! opens them too. [`SCHEMA`] goes up when a field changes its meaning or place.

use rumbo_core::messages::ObservationKind;

/// The version of recordings that this program writes; it reads all up to it.
pub const SCHEMA: u32 = 2;

/// Name and fields of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layout {
    /// `package/msg/Kind`.
    pub name: &'static str,
    /// The fields, and those of the kinds that they are made of.
    pub text: &'static str,
}

/// What was run: written once, first.
pub const RUN: Layout = Layout {
    name: "rumbo_msgs/msg/Run",
    text: "uint32 schema\nstring program\nstring file\nstring pipeline\nstring[] plugins\nstring[] sensors\n\
           float64[] duration_s\nint64 started\nbool is_recording\nbool is_real_time\nfloat64[] start\n\
           string map_file\nuint64 map_file_hash\nstring recording_file\n",
};

/// The map, as a number that tells whether it is the same.
pub const MAP: Layout = Layout {
    name: "rumbo_msgs/msg/MapHash",
    text: "uint64 version\nuint64 grid\nuint64 coarse_grids\nuint64 lines\nuint64 landmarks\nuint64 voxels\n",
};

/// An estimate.
pub const ESTIMATE: Layout = Layout {
    name: "rumbo_msgs/msg/Estimate",
    text: "int64 stamp\nfloat64[7] map_from_odom\nfloat64[7] map_from_base\nfloat64[36] covariance\nuint8 status\n\
           rumbo_msgs/Candidate[] candidates\nuint8 wish\nfloat64 wish_by\n\
           ================================================================================\n\
           MSG: rumbo_msgs/Candidate\nfloat64[4] map_from_base\nfloat64 score\n",
};

/// A path, or that there is none any more.
pub const PATH: Layout = Layout {
    name: "rumbo_msgs/msg/Path",
    text: "uint64 number\nfloat64[] cost\nrumbo_msgs/PathPoint[] points\n\
           ================================================================================\n\
           MSG: rumbo_msgs/PathPoint\nfloat64[2] position\nfloat64[] yaw_rad\n",
};

/// What went to the wheels.
pub const COMMAND: Layout =
    Layout { name: "rumbo_msgs/msg/Command", text: "int64 stamp\nfloat64[3] twist\nbool is_actuated\n" };

/// Something that happened: for programs to compare, and for people.
pub const EVENT: Layout =
    Layout { name: "rumbo_msgs/msg/Event", text: "int64 stamp\nstring kind\nstring exact\nstring text\n" };

/// An order from outside.
pub const ORDER: Layout = Layout {
    name: "rumbo_msgs/msg/Order",
    text: "string kind\nrumbo_msgs/PathPoint[] goals\nfloat64[] map_from_base\nfloat64[] covariance\nuint8[] map\n\
           ================================================================================\n\
           MSG: rumbo_msgs/PathPoint\nfloat64[2] position\nfloat64[] yaw_rad\n",
};

/// Closes a step: what stands before it belongs to it.
pub const STEP: Layout = Layout {
    name: "rumbo_msgs/msg/Step",
    text: "uint64 step\nint64 now\nuint8 state\nrumbo_msgs/Truth[] truth\n\
           ================================================================================\n\
           MSG: rumbo_msgs/Truth\nfloat64[7] map_from_base\nfloat64[3] twist\nfloat64 clearance_m\n\
           uint32[] contact_episodes\n",
};

/// A step: all its messages, [packed](super::StepPacker). In recordings of schema 1 each had a topic of its own.
pub const PACKED_STEP: Layout = Layout { name: "rumbo_msgs/msg/PackedStep", text: "uint8[] packed\n" };

/// How the run ended: written once, last.
pub const END: Layout = Layout { name: "rumbo_msgs/msg/End", text: "string reason\nstring detail\n" };

/// The fields that every observation begins with.
macro_rules! observed {
    ($name:literal, $text:literal) => {
        Layout {
            name: concat!("rumbo_msgs/msg/", $name),
            text: concat!("uint16 sensor\nint64 stamp\nfloat64[7] base_from_sensor\nbool is_valid\n", $text),
        }
    };
}

/// The layout of an observation of this kind, and the number of the kind.
pub const OBSERVATIONS: [(ObservationKind, Layout); 12] = [
    (
        ObservationKind::Odometry,
        observed!("Odometry", "float64[4] odom_from_base\nfloat64[3] twist\nfloat64[3] noise\n"),
    ),
    (ObservationKind::WheelSpeeds, observed!("WheelSpeeds", "uint32 n_wheels\nfloat64[4] rim_m_s\n")),
    (ObservationKind::SteeringAngle, observed!("SteeringAngle", "float64 angle_rad\n")),
    (
        ObservationKind::LaserScan,
        observed!(
            "LaserScan",
            "float64 first_bearing_rad\nfloat64 bearing_step_rad\nfloat64 sweep_s\nfloat32 min_range_m\n\
             float32 max_range_m\nfloat32[] ranges_m\nfloat32[] intensities\n"
        ),
    ),
    (
        ObservationKind::RangeRing,
        observed!(
            "RangeRing",
            "float64 first_bearing_rad\nfloat64 bearing_step_rad\nfloat64 cone_rad\nfloat64 ring_radius_m\n\
             float32 min_range_m\nfloat32 max_range_m\nfloat32[] ranges_m\n"
        ),
    ),
    (
        ObservationKind::Bumpers,
        observed!(
            "Bumpers",
            "uint32 n_bumpers\nuint64 pressed\nfloat64 first_bearing_rad\nfloat64 bearing_step_rad\n\
             float64 ring_radius_m\n"
        ),
    ),
    (
        ObservationKind::DepthImage,
        observed!(
            "DepthImage",
            "uint32 width\nuint32 height\nfloat64[2] focal_px\nfloat64[2] center_px\nfloat32 unit_m\nuint16[] depth\n"
        ),
    ),
    (ObservationKind::PointCloud, observed!("PointCloud", "float32[] points_m\n")),
    (
        ObservationKind::Imu,
        observed!("Imu", "float64[] attitude_rad\nfloat64[3] rates_rad_s\nfloat64[3] accelerations_m_s2\n"),
    ),
    (
        ObservationKind::PositionFix,
        observed!("PositionFix", "float64[3] position_m\nfloat64[3] deviation_m\n"),
    ),
    (
        ObservationKind::Marks,
        observed!(
            "Marks",
            "float64 range_deviation_m\nfloat64 bearing_deviation_rad\nrumbo_msgs/Mark[] marks\n\
             ================================================================================\n\
             MSG: rumbo_msgs/Mark\nuint32[] identity\nfloat64 range_m\nfloat64 bearing_rad\n"
        ),
    ),
    (ObservationKind::Custom, observed!("Custom", "string schema\nuint8[] bytes\n")),
];

/// The layout of an observation of this kind.
pub fn observation_layout(kind: ObservationKind) -> Option<Layout> {
    OBSERVATIONS.iter().find(|(known, _)| *known == kind).map(|(_, layout)| *layout)
}

/// The kind of observation whose layout has this name.
pub fn observation_kind(name: &str) -> Option<ObservationKind> {
    OBSERVATIONS.iter().find(|(_, layout)| layout.name == name).map(|(kind, _)| *kind)
}
