//! A folder of depth pictures on its way. Its lists are small enough to be read at once; a picture is read when a sensor
//! asks for it.

use std::collections::VecDeque;

use rumbo_core::frames::{Pose2, Pose3};
use rumbo_core::messages::{Data, Imu, Observation, SensorId};
use rumbo_core::stages::{Advance, WorldError};
use rumbo_core::time::Time;
use rumbo_kit::tum_rgbd::{DepthFrame, RgbdFolder};

use super::pictures::{PictureFault, PictureReader};
use crate::log::channel::{Channel, Lent};
use crate::log::truth::KnownTruth;

/// What a folder of depth pictures has recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RgbdChannel {
    /// The pictures.
    Depth,
    /// The accelerometer.
    Imu,
}

impl RgbdChannel {
    /// Both.
    pub const ALL: [RgbdChannel; 2] = [RgbdChannel::Depth, RgbdChannel::Imu];

    /// Its name in a pipeline.
    pub fn name(self) -> &'static str {
        match self {
            RgbdChannel::Depth => "depth",
            RgbdChannel::Imu => "imu",
        }
    }

    /// The channel of this name.
    pub fn named(name: &str) -> Option<RgbdChannel> {
        RgbdChannel::ALL.into_iter().find(|channel| channel.name() == name)
    }
}

/// A folder of depth pictures on its way.
#[derive(Debug)]
pub struct RgbdPlayback {
    name: String,
    origin: Time,
    now: Time,
    ahead: VecDeque<DepthFrame>,
    due: VecDeque<DepthFrame>,
    shown: Vec<Observation>,
    reader: PictureReader,
    accelerations: VecDeque<(Time, [f64; 3])>,
    imu: Channel,
    lent: Lent,
    truth: KnownTruth,
    n_unreadable: u64,
    first_fault: Option<PictureFault>,
    n_late: u64,
    is_over: bool,
    notices: VecDeque<String>,
}

impl RgbdPlayback {
    /// Pictures that nobody asks for are dropped, but for the newest so many: as many as a second has.
    const MOST_DUE: usize = 32;

    /// What a folder has, at its first stamp; `name` stands in what is told.
    pub fn new(folder: RgbdFolder, reader: PictureReader, name: String) -> RgbdPlayback {
        let origin = folder.origin();
        let since = |stamp: Time| Time::ZERO + (stamp - origin);
        let frame = |frame: DepthFrame| DepthFrame { stamp: since(frame.stamp), ..frame };
        let row = |(stamp, axes): (Time, [f64; 3])| (since(stamp), axes);
        let mut playback = RgbdPlayback {
            name,
            origin,
            now: Time::ZERO,
            ahead: folder.frames.into_iter().map(frame).collect(),
            due: VecDeque::new(),
            shown: Vec::new(),
            reader,
            accelerations: folder.accelerations_m_s2.into_iter().map(row).collect(),
            imu: Channel::default(),
            lent: Lent::default(),
            truth: KnownTruth::default(),
            n_unreadable: 0,
            first_fault: None,
            n_late: 0,
            is_over: false,
            notices: VecDeque::new(),
        };
        folder.sentences.iter().for_each(|sentence| playback.notify(sentence));
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

    /// When the next record is due; at the end now, so that the end is met at once.
    pub fn next(&self) -> Time {
        let picture = self.ahead.front().map(|frame| frame.stamp);
        let acceleration = self.accelerations.front().map(|(stamp, _)| *stamp);
        picture.into_iter().chain(acceleration).min().map_or(self.now, |stamp| stamp.max(self.now))
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
        if self.ahead.is_empty() && self.accelerations.is_empty() {
            self.end();
            return Ok(Advance::Ended);
        }
        self.now = to;
        while let Some(frame) = self.ahead.pop_front_if(|frame| frame.stamp <= to) {
            if self.due.len() >= Self::MOST_DUE {
                self.due.pop_front();
                self.n_late += 1;
            }
            self.due.push_back(frame);
        }
        while let Some((stamp, axes)) = self.accelerations.pop_front_if(|(stamp, _)| *stamp <= to) {
            self.imu.push(observation(stamp, Data::Imu(imu(axes))));
        }
        self.truth.advance(to);
        Ok(Advance::Reached(to))
    }

    /// What a channel has recorded since it was asked last. Pictures that cannot be read are left out and counted.
    pub fn take(&mut self, channel: RgbdChannel) -> &[Observation] {
        if channel == RgbdChannel::Imu {
            return self.imu.take(&mut self.lent);
        }
        self.shown.clear();
        for frame in self.due.drain(..) {
            match self.reader.read(&frame.path) {
                Ok(image) => self.shown.push(observation(frame.stamp, Data::DepthImage(image))),
                Err(fault) => {
                    self.n_unreadable += 1;
                    self.first_fault.get_or_insert(fault);
                }
            }
        }
        &self.shown
    }

    /// What people should know, each thing once.
    pub fn take_notice(&mut self) -> Option<String> {
        self.notices.pop_front()
    }

    /// Adds something that people should know.
    pub fn notify(&mut self, sentence: &str) {
        self.notices.push_back(format!("{}: {sentence}", self.name));
    }

    fn end(&mut self) {
        if std::mem::replace(&mut self.is_over, true) {
            return;
        }
        if let Some(fault) = self.first_fault.take() {
            self.notify(&format!("skipped {} pictures, the first: {fault}", self.n_unreadable));
        }
        if self.n_late > 0 {
            self.notify(&format!("{} pictures were dropped because no sensor asked for them", self.n_late));
        }
        if self.truth.is_useless() {
            self.notify("no true pose is near any stamp; stamps of `truth` are absolute, as in the lists");
        }
    }
}

/// As the sensor that asks will pass it on, under its own name and mount.
fn observation(stamp: Time, data: Data) -> Observation {
    Observation { sensor: SensorId(0), stamp, base_from_sensor: Pose3::identity(), valid: true, data }
}

/// The accelerometer has x left, y up and z ahead. It has no gyroscope beside it, and the message must have rates.
fn imu([left, up, ahead]: [f64; 3]) -> Imu {
    Imu { attitude_rad: None, rates_rad_s: [0.0; 3], accelerations_m_s2: [ahead, left, up] }
}
