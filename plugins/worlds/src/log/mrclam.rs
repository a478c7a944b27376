//! A robot of an MRCLAM folder on its way. Its tables are small enough to be read at once.

use std::collections::VecDeque;

use rumbo_core::frames::{Pose2, Pose3, Twist};
use rumbo_core::messages::{Data, Mark, Marks, Observation, Odometry, SensorId};
use rumbo_core::stages::{Advance, WorldError};
use rumbo_core::time::{Span, Time};
use rumbo_kit::mrclam::{RobotLog, Sighting, Velocity};

use super::channel::{Channel, Lent};
use super::truth::KnownTruth;

/// Errors of the odometer: m/m, rad/m, rad/rad. Measured on data set 7: what is left of windows of one second against
/// the motion capture, after the constant errors of the scales (0.87 to 0.91 of the way, 0.94 of the turn) are taken off.
const ODOMETER_NOISE: [f64; 3] = [0.05, 0.05, 0.1];
/// Standard deviations of range (m) and bearing (rad), measured likewise for its robots 1 to 3: 0.07 to 0.18 m, which grows
/// with the range, and 0.007 to 0.018 rad.
const MARK_DEVIATIONS: [f64; 2] = [0.15, 0.01];

/// What an MRCLAM folder has recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MrclamChannel {
    /// Velocities, added up.
    Odometry,
    /// Landmarks that were recognized.
    Marks,
}

impl MrclamChannel {
    /// Both.
    pub const ALL: [MrclamChannel; 2] = [MrclamChannel::Odometry, MrclamChannel::Marks];

    /// Its name in a pipeline.
    pub fn name(self) -> &'static str {
        match self {
            MrclamChannel::Odometry => "odometry",
            MrclamChannel::Marks => "marks",
        }
    }

    /// The channel of this name.
    pub fn named(name: &str) -> Option<MrclamChannel> {
        MrclamChannel::ALL.into_iter().find(|channel| channel.name() == name)
    }
}

/// A robot of an MRCLAM folder on its way.
#[derive(Debug)]
pub struct MrclamPlayback {
    name: String,
    origin: Time,
    now: Time,
    ahead: VecDeque<Observation>,
    channels: [Channel; 2],
    lent: Lent,
    truth: KnownTruth,
    notices: VecDeque<String>,
}

impl MrclamPlayback {
    /// What a robot wrote down, at its first stamp; `name` stands in what is told.
    pub fn new(log: &RobotLog, odometer_delay: Span, name: String) -> MrclamPlayback {
        let mut ahead = odometry(&log.velocities, odometer_delay);
        ahead.extend(marks(&log.sightings));
        // Of what is of one time, the odometer comes first: the sort keeps their order.
        ahead.sort_by_key(|observation| observation.stamp);
        let origin = ahead.first().map_or(Time::ZERO, |observation| observation.stamp);
        for observation in &mut ahead {
            observation.stamp = Time::ZERO + (observation.stamp - origin);
        }
        let mut playback = MrclamPlayback {
            name,
            origin,
            now: Time::ZERO,
            ahead: ahead.into(),
            channels: Default::default(),
            lent: Lent::default(),
            truth: KnownTruth::default(),
            notices: VecDeque::new(),
        };
        log.sentences.iter().for_each(|sentence| playback.notify(sentence));
        playback
    }

    /// The first stamp, absolute: where the time of a run begins.
    pub fn origin(&self) -> Time {
        self.origin
    }

    /// Where the robot was, over the time of the run.
    pub fn know(&mut self, truth: KnownTruth) {
        self.truth = truth;
        self.truth.advance(self.now);
    }

    /// The time it is, since the first stamp.
    pub fn now(&self) -> Time {
        self.now
    }

    /// When the next observation is due; at the end now, so that the end is met at once.
    pub fn next(&self) -> Time {
        self.ahead.front().map_or(self.now, |observation| observation.stamp.max(self.now))
    }

    /// Where the robot really is.
    pub fn truth(&self) -> &KnownTruth {
        &self.truth
    }

    /// Where the robot really is now, or was first if that is about now.
    pub fn true_pose(&self) -> Option<Pose2> {
        self.truth.pose_about(self.now)
    }

    /// Lets time pass; what was recorded up to `to` becomes due.
    ///
    /// # Errors
    /// [`WorldError::Backwards`] when `to` is over already.
    pub fn advance(&mut self, to: Time) -> Result<Advance, WorldError> {
        if to < self.now {
            return Err(WorldError::Backwards { now: self.now, to });
        }
        if self.ahead.is_empty() {
            return Ok(Advance::Ended);
        }
        self.now = to;
        while let Some(observation) = self.ahead.pop_front_if(|observation| observation.stamp <= to) {
            let [odometry, marks] = &mut self.channels;
            let is_marks = matches!(observation.data, Data::Marks(_));
            (if is_marks { marks } else { odometry }).push(observation);
        }
        self.truth.advance(to);
        if self.ahead.is_empty() && self.truth.is_useless() {
            self.notify("no true pose is near any stamp; stamps of `truth` are absolute, as in the tables");
        }
        Ok(Advance::Reached(to))
    }

    /// What a channel has recorded since it was asked last.
    pub fn take(&mut self, channel: MrclamChannel) -> &[Observation] {
        let [odometry, marks] = &mut self.channels;
        match channel {
            MrclamChannel::Odometry => odometry.take(&mut self.lent),
            MrclamChannel::Marks => marks.take(&mut self.lent),
        }
    }

    /// What people should know, each thing once.
    pub fn take_notice(&mut self) -> Option<String> {
        self.notices.pop_front()
    }

    /// Adds something that people should know.
    pub fn notify(&mut self, sentence: &str) {
        self.notices.push_back(format!("{}: {sentence}", self.name));
    }
}

/// As the sensor that asks will pass it on, under its own name and mount.
fn observation(stamp: Time, data: Data) -> Observation {
    Observation { sensor: SensorId(0), stamp, base_from_sensor: Pose3::identity(), valid: true, data }
}

/// Velocities hold until the next one, and are added up from where the first one was told.
fn odometry(velocities: &[Velocity], delay: Span) -> Vec<Observation> {
    let (mut odom_from_base, mut last) = (Pose2::identity(), None);
    let mut readings = Vec::with_capacity(velocities.len());
    for Velocity { stamp, forward_m_s, turn_rad_s } in velocities {
        let twist = Twist::new(*forward_m_s, *turn_rad_s);
        if let Some((since, before)) = last.replace((*stamp, twist)) {
            odom_from_base *= Twist::integrate(before, (*stamp - since).as_secs());
        }
        let reading = Odometry { odom_from_base, twist, noise: ODOMETER_NOISE };
        readings.push(observation(*stamp + delay, Data::Odometry(reading)));
    }
    readings
}

/// Marks of one stamp were seen in one picture.
fn marks(sightings: &[Sighting]) -> Vec<Observation> {
    let picture = |of_one_stamp: &[Sighting]| {
        let stamp = of_one_stamp.first()?.stamp;
        let mark = |sighting: &Sighting| Mark {
            identity: Some(sighting.subject),
            range_m: sighting.range_m,
            bearing_rad: sighting.bearing_rad,
        };
        let [range_deviation_m, bearing_deviation_rad] = MARK_DEVIATIONS;
        let marks = of_one_stamp.iter().map(mark).collect();
        let seen = Marks { marks, range_deviation_m, bearing_deviation_rad };
        Some(observation(stamp, Data::Marks(seen)))
    };
    sightings.chunk_by(|a, b| a.stamp == b.stamp).filter_map(picture).collect()
}
