//! A log on its way: what is read ahead, what has become due, and how late it is.

use std::collections::VecDeque;

use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Pose2, Pose3, Twist};
use rumbo_core::messages::{Data, LaserScan, Observation, SensorId};
use rumbo_core::stages::{Advance, WorldError};
use rumbo_core::time::Time;
use rumbo_kit::log_file::{LaserSide, Moment, MomentData, RecordedScan, Timeline};

use super::channel::{Channel, Lent};
use super::odometer::Odometer;
use super::params::RecordedChannel;
use super::truth::KnownTruth;

/// A log on its way.
#[derive(Debug)]
pub struct Playback {
    timeline: Timeline,
    name: String,
    now: Time,
    ahead: VecDeque<Moment>,
    is_read: bool,
    channels: [Channel; 3],
    lent: Lent,
    odometer: Odometer,
    truth: KnownTruth,
    notices: VecDeque<String>,
}

impl Playback {
    /// A log at its first stamp; `name` stands in what it tells.
    pub fn new(timeline: Timeline, name: String, truth: KnownTruth) -> Playback {
        let mut playback = Playback {
            timeline,
            name,
            now: Time::ZERO,
            ahead: VecDeque::new(),
            is_read: false,
            channels: Default::default(),
            lent: Lent::default(),
            odometer: Odometer::default(),
            truth,
            notices: VecDeque::new(),
        };
        playback.read_ahead();
        playback.truth.advance(Time::ZERO);
        playback
    }

    /// The time it is, since the first stamp.
    pub fn now(&self) -> Time {
        self.now
    }

    /// When the next record is due; at the end of the log now, so that the end is met at once.
    pub fn next(&self) -> Time {
        self.ahead.front().map_or(self.now, |moment| self.time_of(moment).max(self.now))
    }

    /// Where the robot really is.
    pub fn truth(&self) -> &KnownTruth {
        &self.truth
    }

    /// The odometer's pose in the first record.
    pub fn first_odometry(&self) -> Option<Pose2> {
        self.ahead.front().map(|moment| match &moment.data {
            MomentData::Scan(scan) => scan.odom_from_base,
            MomentData::Odometry(odometry) => odometry.odom_from_base,
        })
    }

    /// The only laser of the log so far; none where there are two.
    pub fn only_laser(&self) -> Option<RecordedChannel> {
        let is_ahead = |side: LaserSide| {
            let is_it = |moment: &Moment| matches!(&moment.data, MomentData::Scan(scan) if scan.side == side);
            self.ahead.iter().any(is_it)
        };
        let [front, rear, _] = &self.channels;
        let has_front = front.n_seen > 0 || is_ahead(LaserSide::Front);
        let has_rear = rear.n_seen > 0 || is_ahead(LaserSide::Rear);
        match (has_front, has_rear) {
            (true, true) => None,
            (false, true) => Some(RecordedChannel::RearLaser),
            _ => Some(RecordedChannel::FrontLaser),
        }
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
        while let Some(moment) =
            self.ahead.pop_front_if(|moment| moment.stamp <= absolute(&self.timeline, to))
        {
            self.deliver(moment);
            self.read_ahead();
        }
        self.now = to;
        self.truth.advance(to);
        Ok(Advance::Reached(to))
    }

    /// What a channel has recorded since it was asked last.
    pub fn take(&mut self, channel: RecordedChannel) -> &[Observation] {
        let [front, rear, odometry] = &mut self.channels;
        let channel = match channel {
            RecordedChannel::FrontLaser => front,
            RecordedChannel::RearLaser => rear,
            RecordedChannel::Odometry => odometry,
        };
        channel.take(&mut self.lent)
    }

    /// This channel had anything so far.
    pub fn has_seen(&self, channel: RecordedChannel) -> bool {
        let found = RecordedChannel::ALL.into_iter().zip(&self.channels).find(|(other, _)| *other == channel);
        found.is_some_and(|(_, channel)| channel.n_seen > 0)
    }

    /// What people should know, each thing once.
    pub fn take_notice(&mut self) -> Option<String> {
        self.notices.pop_front()
    }

    /// Adds something that people should know.
    pub fn notify(&mut self, sentence: &str) {
        self.notices.push_back(format!("{}: {sentence}", self.name));
    }

    fn time_of(&self, moment: &Moment) -> Time {
        Time::ZERO + (moment.stamp - self.timeline.origin())
    }

    /// True poses lie on both sides of the present: so much of the log is read ahead.
    fn read_ahead(&mut self) {
        while !self.is_read {
            let span =
                self.ahead.front().zip(self.ahead.back()).map(|(first, last)| last.stamp - first.stamp);
            if span.is_some_and(|span| span > KnownTruth::GAP) {
                return;
            }
            while let Some(buffer) = self.lent.free() {
                self.timeline.recycle(buffer);
            }
            match self.timeline.next() {
                Some(moment) => {
                    if let MomentData::Scan(scan) = &moment.data {
                        self.truth.read(self.time_of(&moment), scan.map_from_base);
                    }
                    self.ahead.push_back(moment);
                }
                None => self.end(),
            }
        }
    }

    fn end(&mut self) {
        self.is_read = true;
        let sentences =
            self.timeline.tally().sentences().into_iter().chain(self.timeline.order().sentences());
        for sentence in sentences.collect::<Vec<String>>() {
            self.notify(&sentence);
        }
        if self.truth.is_useless() {
            self.notify(
                "no true pose is near any stamp of the log; stamps of `truth` are absolute, as in the log",
            );
        }
    }

    fn deliver(&mut self, moment: Moment) {
        let stamp = self.time_of(&moment);
        let (pose, twist, scan) = match moment.data {
            MomentData::Odometry(odometry) => (odometry.odom_from_base, odometry.twist, None),
            MomentData::Scan(scan) => (scan.odom_from_base, scan.twist, Some(scan)),
        };
        self.deliver_odometry(stamp, pose, twist);
        let [front, rear, _] = &mut self.channels;
        if let Some(scan) = scan {
            let channel = if scan.side == LaserSide::Front { front } else { rear };
            channel.push(observation(stamp, Data::LaserScan(laser_scan(scan))));
        }
    }

    fn deliver_odometry(&mut self, stamp: Time, odom_from_base: Pose2, twist: Option<Twist>) {
        let [.., channel] = &mut self.channels;
        if let Some(odometry) = self.odometer.read(stamp, odom_from_base, twist) {
            channel.push(observation(stamp, Data::Odometry(odometry)));
        }
    }
}

fn absolute(timeline: &Timeline, time: Time) -> Time {
    timeline.origin() + (time - Time::ZERO)
}

/// As the sensor that asks will pass it on, under its own name and mount.
fn observation(stamp: Time, data: Data) -> Observation {
    Observation { sensor: SensorId(0), stamp, base_from_sensor: Pose3::identity(), valid: true, data }
}

fn laser_scan(scan: RecordedScan) -> LaserScan {
    let intensities =
        if scan.intensities.len() == scan.ranges_m.len() { scan.intensities } else { Buffer::empty() };
    LaserScan {
        first_bearing_rad: scan.first_bearing_rad,
        bearing_step_rad: scan.bearing_step_rad,
        // No log says how long a sweep takes.
        sweep_s: 0.0,
        min_range_m: 0.0,
        max_range_m: scan.max_range_m as f32,
        ranges_m: scan.ranges_m,
        intensities,
    }
}
