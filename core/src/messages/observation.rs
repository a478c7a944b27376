//! An observation: what one sensor saw at one time, and the two ends of the ring that carries observations.

use super::check::{Check, Checker, MessageFault};
use super::{
    Bumpers, Custom, DepthImage, Imu, LaserScan, Marks, Odometry, PointCloud, PositionFix, RangeRing,
    SteeringAngle, WheelSpeeds,
};
use crate::boundary::export::HostLender;
use crate::boundary::{Buffer, BufferPool};
use crate::frames::Pose3;
use crate::time::Time;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Which sensor of the pipeline, counted in the order of the file.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
pub struct SensorId(pub u16);

impl SensorId {
    /// The odometer seat, which speaks like a sensor.
    pub const ODOMETER: SensorId = SensorId(u16::MAX);
}

/// One reading of one sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct Observation {
    /// Who saw it.
    pub sensor: SensorId,
    /// When it was seen, not when it arrived.
    #[doc(alias = "header.stamp")]
    pub stamp: Time,
    /// Where the sensor sat on the robot at that time.
    pub base_from_sensor: Pose3,
    /// The device stands by this reading.
    pub valid: bool,
    /// The reading.
    pub data: Data,
}

macro_rules! kinds {
    ($($(#[$doc:meta])* $kind:ident),* $(,)?) => {
        /// The reading of an [`Observation`].
        #[derive(Debug, Clone, PartialEq)]
        #[non_exhaustive]
        pub enum Data { $($(#[$doc])* $kind($kind)),* }

        /// The kinds of observation that stages consume and sensors produce.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema)]
        #[serde(rename_all = "snake_case")]
        #[non_exhaustive]
        pub enum ObservationKind { $($(#[$doc])* $kind),* }

        impl Data {
            /// Which kind this is.
            pub fn kind(&self) -> ObservationKind {
                match self { $(Data::$kind(_) => ObservationKind::$kind),* }
            }
        }

        impl Check for Data {
            fn check(&self) -> Result<(), MessageFault> {
                match self { $(Data::$kind(data) => data.check()),* }
            }
        }
    };
}
kinds! {
    /// Where the wheels say the base went.
    Odometry,
    /// Turning rates of the wheels.
    WheelSpeeds,
    /// Angle of a steered wheel.
    SteeringAngle,
    /// A planar scan.
    LaserScan,
    /// Single ranges around the hull.
    RangeRing,
    /// Touch sensors around the hull.
    Bumpers,
    /// A depth picture.
    DepthImage,
    /// Points in space.
    PointCloud,
    /// Attitude, rates and accelerations.
    Imu,
    /// A position from outside, as GPS gives.
    PositionFix,
    /// Ranges and bearings to marks, with identity where it is known.
    Marks,
    /// A third party's own kind.
    Custom,
}

impl ObservationKind {
    /// The word used in messages and files.
    pub fn name(self) -> &'static str {
        match self {
            ObservationKind::Odometry => "odometry",
            ObservationKind::WheelSpeeds => "wheel_speeds",
            ObservationKind::SteeringAngle => "steering_angle",
            ObservationKind::LaserScan => "laser_scan",
            ObservationKind::RangeRing => "range_ring",
            ObservationKind::Bumpers => "bumpers",
            ObservationKind::DepthImage => "depth_image",
            ObservationKind::PointCloud => "point_cloud",
            ObservationKind::Imu => "imu",
            ObservationKind::PositionFix => "position_fix",
            ObservationKind::Marks => "marks",
            ObservationKind::Custom => "custom",
        }
    }
}

impl Check for Observation {
    fn check(&self) -> Result<(), MessageFault> {
        Checker("observation").pose3("base_from_sensor", &self.base_from_sensor)?;
        self.data.check()
    }
}

/// Where sensors put what they see, and where they get buffers for it.
#[derive(Debug, Default)]
pub struct Observations {
    items: VecDeque<Observation>,
    f32_pool: BufferPool<f32>,
    u16_pool: BufferPool<u16>,
    point_pool: BufferPool<[f32; 3]>,
    lender: Option<HostLender>,
}

impl Observations {
    /// Buffers come from the pools of the program that loaded this plugin, or from here again.
    pub(crate) fn lend_from(&mut self, lender: Option<HostLender>) {
        self.lender = lender;
    }

    /// Adds one observation.
    pub fn push(&mut self, observation: Observation) {
        self.items.push_back(observation);
    }

    /// Takes out the oldest.
    pub fn pop_front(&mut self) -> Option<Observation> {
        self.items.pop_front()
    }

    /// What is here, oldest first.
    pub fn iter(&self) -> impl Iterator<Item = &Observation> {
        self.items.iter()
    }

    /// A buffer for ranges and other `f32` rows, all zero.
    #[doc(alias = "Observations::buffer")]
    pub fn buffer(&mut self, len: usize) -> Buffer<f32> {
        self.lender.map_or_else(|| self.f32_pool.take(len), |lender| lender.f32(len))
    }

    /// A buffer for depth pictures, all zero.
    pub fn depth_buffer(&mut self, len: usize) -> Buffer<u16> {
        self.lender.map_or_else(|| self.u16_pool.take(len), |lender| lender.u16(len))
    }

    /// A buffer for points, all zero.
    pub fn point_buffer(&mut self, len: usize) -> Buffer<[f32; 3]> {
        self.lender.map_or_else(|| self.point_pool.take(len), |lender| lender.point3(len))
    }

    /// Takes the buffers of an observation that nobody needs any more.
    pub fn recycle(&mut self, observation: Observation) {
        match observation.data {
            Data::LaserScan(scan) => {
                self.f32_pool.recycle(scan.ranges_m);
                self.f32_pool.recycle(scan.intensities);
            }
            Data::RangeRing(ring) => self.f32_pool.recycle(ring.ranges_m),
            Data::DepthImage(image) => self.u16_pool.recycle(image.depth),
            Data::PointCloud(cloud) => self.point_pool.recycle(cloud.points_m),
            _ => {}
        }
    }
}

/// Everything that came in since this stage last ran, sorted by stamp and then by sensor; several per sensor, each with
/// its own stamp, late ones included.
#[derive(Debug, Clone, Copy)]
pub struct Seen<'a> {
    head: &'a [Observation],
    tail: &'a [Observation],
    order: Option<&'a [u32]>,
}

impl<'a> Seen<'a> {
    /// Nothing.
    pub const NOTHING: Seen<'static> = Seen { head: &[], tail: &[], order: None };

    /// Observations that are already in order, for tests and for replaying.
    pub fn sorted(observations: &'a [Observation]) -> Seen<'a> {
        Seen { head: observations, tail: &[], order: None }
    }

    pub(crate) fn of_ring(ring: &'a VecDeque<Observation>, order: &'a [u32]) -> Seen<'a> {
        let (head, tail) = ring.as_slices();
        Seen { head, tail, order: Some(order) }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.order.map_or(self.head.len() + self.tail.len(), <[u32]>::len)
    }

    /// There is nothing new.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// One by one, oldest stamp first.
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = &'a Observation> + Clone + use<'a> {
        let seen = *self;
        (0..self.len()).filter_map(move |idx| seen.get(idx))
    }

    fn get(&self, idx: usize) -> Option<&'a Observation> {
        let at = self.order.map_or(Some(idx), |order| order.get(idx).map(|i| *i as usize))?;
        self.head.get(at).or_else(|| self.tail.get(at - self.head.len()))
    }

    /// The laser scans among them.
    pub fn laser_scans(&self) -> impl DoubleEndedIterator<Item = (&'a Observation, &'a LaserScan)> + use<'a> {
        self.iter().filter_map(|o| match &o.data {
            Data::LaserScan(scan) => Some((o, scan)),
            _ => None,
        })
    }

    /// The odometry readings among them.
    pub fn odometry(&self) -> impl DoubleEndedIterator<Item = (&'a Observation, &'a Odometry)> + use<'a> {
        self.iter().filter_map(|o| match &o.data {
            Data::Odometry(odometry) => Some((o, odometry)),
            _ => None,
        })
    }

    /// The range rings among them.
    pub fn range_rings(&self) -> impl DoubleEndedIterator<Item = (&'a Observation, &'a RangeRing)> + use<'a> {
        self.iter().filter_map(|o| match &o.data {
            Data::RangeRing(ring) => Some((o, ring)),
            _ => None,
        })
    }
}
