//! Where the robot is: a simulation, a recording, or the real thing.

use crate::frames::{Pose2, Pose3, Twist};
use crate::messages::{Command, Intrinsics, Marks, Observation};
use crate::time::Time;

/// Keeps the clock, takes drive commands, and answers sensors' probes.
#[doc(alias = "simulator")]
#[doc(alias = "hardware_interface")]
pub trait World: Send {
    /// The time it is.
    fn now(&self) -> Time;

    /// Lets time pass until `to`, or until the world ends.
    fn advance(&mut self, to: Time) -> Result<Advance, WorldError>;

    /// Takes a velocity, which holds until the next one.
    fn drive(&mut self, command: &Command) -> Result<Drove, WorldError>;

    /// Answers what a sensor asks.
    fn probe<'w>(&'w mut self, probe: &Probe<'_>) -> Result<Answer<'w>, WorldError>;

    /// Where a sensor finds its own device, after [`Answer::Live`]: a world that emulates devices starts one and says its
    /// address. Absent: where the sensor's own parameters say.
    fn emulated_device(&mut self, device: &OwnDevice<'_>) -> Result<Option<String>, WorldError> {
        let _ = device;
        Ok(None)
    }

    /// Where the robot really is, where the world knows.
    fn truth(&self) -> Option<&Truth> {
        None
    }

    /// Where an operator would say that the robot stands at the start.
    fn start(&self) -> Option<Pose2> {
        None
    }

    /// The map that belongs to this world, as a path that `static_map` reads when it has no `file` of its own.
    fn map_file(&self) -> Option<&std::path::Path> {
        None
    }

    /// The recording that this world plays, as a path that plugins read when they have no `file` of their own.
    fn recording_file(&self) -> Option<&std::path::Path> {
        None
    }

    /// What people should know about this world (damage in a recording, say), each thing once; asked after every
    /// [`advance`](Self::advance) until there is nothing more.
    fn take_notice(&mut self) -> Option<String> {
        None
    }

    /// Time passes by itself here: slow work must run on threads of its own.
    fn is_real_time(&self) -> bool {
        false
    }

    /// When the recording has the next observation, for worlds whose sensors are due at recorded stamps.
    fn next_recorded(&self) -> Option<Time> {
        None
    }
}

/// How far time got.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Advance {
    /// To this time.
    Reached(Time),
    /// The world is over: the recording ended.
    Ended,
}

/// What became of a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Drove {
    /// The wheels obey.
    Drove,
    /// There are no wheels to obey: a recording.
    NotActuated,
}

/// What carries a beam.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Medium {
    /// Passes glass.
    Light,
    /// Echoes from glass that it meets squarely, and bounces off it otherwise.
    Sound,
}

/// What a sensor asks the world. Sensors sit at `base_from_sensor`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Probe<'a> {
    /// Exact distance along beams in the sensor's x-y plane; the answer is [`Answer::Ranges`].
    Beams {
        /// The mount.
        base_from_sensor: &'a Pose3,
        /// Bearing of the first beam, radians.
        first_bearing_rad: f64,
        /// From one beam to the next, radians.
        bearing_step_rad: f64,
        /// How many.
        n_beams: usize,
        /// Beyond this nothing is seen, meters.
        max_range_m: f64,
    },
    /// Nearest echo in each of a ring of cones; the answer is [`Answer::Ranges`].
    Cones {
        /// The mount.
        base_from_sensor: &'a Pose3,
        /// Bearing of each cone's axis, radians.
        bearings_rad: &'a [f64],
        /// Full opening of a cone, radians.
        cone_rad: f64,
        /// Transducers sit this far from the mount, meters; ranges are from the transducer.
        ring_radius_m: f64,
        /// Beyond this nothing is heard, meters.
        max_range_m: f64,
    },
    /// A depth picture, meters along the optical axis; the answer is [`Answer::Ranges`], row by row from the top.
    Depth {
        /// The mount: x along the optical axis, y left, z up.
        base_from_sensor: &'a Pose3,
        /// The camera.
        intrinsics: &'a Intrinsics,
        /// Beyond this nothing is seen, meters.
        max_range_m: f64,
    },
    /// How far the wheels have turned; the answer is [`Answer::Wheels`].
    Wheels,
    /// Roll, pitch, yaw, rates and accelerations; the answer is [`Answer::Attitude`].
    Attitude,
    /// The position in the map's frame; the answer is [`Answer::Position`].
    Position,
    /// Bearings (base frame) at which the hull touches something; the answer is [`Answer::Contacts`].
    Contacts,
    /// Marks in view with their identity; the answer is [`Answer::Marks`].
    Marks {
        /// The mount.
        base_from_sensor: &'a Pose3,
        /// Full field of view around the mount's x axis, radians.
        field_of_view_rad: f64,
        /// Beyond this nothing is recognized, meters.
        max_range_m: f64,
    },
    /// Where the person of this name is in the map's frame; the answer is [`Answer::Position`]. For sensors that stand for
    /// what the person carries.
    Person {
        /// The person's name in the world.
        name: &'a str,
    },
    /// What was recorded under this name since the last probe for it; the answer is [`Answer::Recorded`].
    Channel {
        /// Name of the channel; the sensor's own name by default.
        name: &'a str,
    },
}

impl Probe<'_> {
    /// The word used in messages.
    pub fn name(&self) -> &'static str {
        match self {
            Probe::Beams { .. } => "beams",
            Probe::Cones { .. } => "sound cones",
            Probe::Depth { .. } => "a depth picture",
            Probe::Wheels => "wheel motion",
            Probe::Attitude => "attitude",
            Probe::Position => "a position fix",
            Probe::Contacts => "contacts",
            Probe::Marks { .. } => "marks",
            Probe::Person { .. } => "person of this name",
            Probe::Channel { .. } => "a recorded channel",
        }
    }
}

/// What the world answers.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Answer<'w> {
    /// One distance each, meters; infinite where nothing is within reach.
    Ranges(&'w [f32]),
    /// Turning of the wheels.
    Wheels(WheelMotion),
    /// Attitude.
    Attitude(Attitude),
    /// x, y, z in the map's frame, meters.
    Position([f64; 3]),
    /// Bearings in the base frame, radians.
    Contacts(&'w [f64]),
    /// Marks, exact.
    Marks(&'w Marks),
    /// Recorded observations, oldest first.
    Recorded(&'w [Observation]),
    /// Read your own device.
    Live,
}

impl Answer<'_> {
    /// The word used in messages.
    pub fn name(&self) -> &'static str {
        match self {
            Answer::Ranges(_) => "ranges",
            Answer::Wheels(_) => "wheel motion",
            Answer::Attitude(_) => "attitude",
            Answer::Position(_) => "a position fix",
            Answer::Contacts(_) => "contacts",
            Answer::Marks(_) => "marks",
            Answer::Recorded(_) => "recorded observations",
            Answer::Live => "\"read your own device\"",
        }
    }
}

/// A device that a sensor reads by itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OwnDevice<'a> {
    /// Name of the model, such as `lms200`.
    pub model: &'a str,
    /// Name of the sensor.
    pub name: &'a str,
    /// The mount.
    pub base_from_sensor: &'a Pose3,
}

/// Rolling of the wheels since the start: what perfect encoders would count.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WheelMotion {
    /// Distance rolled by each wheel (or along each axis of an omnidirectional base: x, y), meters, with sign; left
    /// before right. For a tricycle the wheels of the fixed axle.
    pub rolled_m: [f64; 4],
    /// How many of those are used.
    pub n_wheels: u32,
    /// Turn of an omnidirectional base that its wheels add up to, radians.
    pub turned_rad: f64,
    /// Steering angle of a tricycle, radians.
    pub steering_rad: f64,
    /// Velocity of the base as its wheels have it.
    pub twist: Twist,
}

/// Attitude and inertia of the base.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Attitude {
    /// Roll, pitch, yaw, radians.
    pub attitude_rad: [f64; 3],
    /// Turning rates about x, y, z, rad/s.
    pub rates_rad_s: [f64; 3],
    /// Specific force, m/s²; +9.81 along z at rest.
    pub accelerations_m_s2: [f64; 3],
}

/// What only a simulation or a reference system knows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Truth {
    /// The robot in the map.
    pub map_from_base: Pose3,
    /// Its velocity in its own frame.
    pub twist: Twist,
    /// From the hull to the nearest thing it could bump into, meters; negative inside; infinite where nothing is.
    pub clearance_m: f64,
    /// How often contact began; absent where the world does not feel it.
    pub contact_episodes: Option<u32>,
    /// In how many of these the robot's own motion was closing the distance; absent where nobody knows. Somebody who walks
    /// into a robot that stands does not count.
    pub driven_contact_episodes: Option<u32>,
}

/// Why a world does not answer.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WorldError {
    /// It has no such thing.
    #[error("this world has no {probe} to give")]
    Unsupported {
        /// What was asked.
        probe: &'static str,
    },
    /// Time was to run backwards.
    #[error("asked to advance to {to} but it is {now} already")]
    Backwards {
        /// The time it is.
        now: Time,
        /// The time asked for.
        to: Time,
    },
    /// A command that is not finite.
    #[error("the drive command is not finite")]
    NotFinite,
    /// The recording is damaged.
    #[error("{path}: {reason}")]
    Recording {
        /// The file.
        path: String,
        /// Where and what.
        reason: String,
    },
    /// Anything else.
    #[error("{0}")]
    Other(String),
}
