//! What a bag has for sensors, one observation after the other, each with the time at which it is due.

use std::collections::{BTreeMap, VecDeque};
use std::path::Path;

use rumbo_core::frames::{Pose2, Pose3};
use rumbo_core::messages::{Data, Observation, SensorId};
use rumbo_core::stages::Truth;
use rumbo_core::time::Time;
use rumbo_kit::log_file::BeamOverride;
use rumbo_kit::recording::ros::{RosData, read_ros, readable_schemas};
use rumbo_kit::recording::{
    BagEnd, BagError, BagReader, RecordingError, RecordingReader, RunHeader, layout::RUN, sensor_name,
};

use crate::log::odometer::Odometer;

/// Why a bag cannot be played.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SourceError {
    /// It cannot be read.
    #[error(transparent)]
    Bag(#[from] BagError),
    /// It is a recording of ours that cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// A topic that the pipeline names is not there, or is nothing that a sensor reads.
    #[error("{found}")]
    Topic {
        /// The sensor that was to get it.
        sensor: String,
        /// What was found.
        found: String,
    },
    /// There is nothing for sensors in it.
    #[error("{path}: nothing in this bag is for sensors; it has {topics}")]
    Nothing {
        /// The file.
        path: String,
        /// The topics, in words.
        topics: String,
    },
}

/// One moment of a bag.
#[derive(Debug, Clone)]
pub struct BagMoment {
    /// When it is due.
    pub stamp: Time,
    /// Topic, or name of the sensor that recorded it; none where only the truth is new.
    pub channel: String,
    /// What was seen.
    pub observation: Option<Observation>,
    /// Where the robot really was.
    pub truth: Option<Truth>,
}

/// A bag on its way.
#[derive(Debug)]
pub enum BagSource {
    /// A run of ours, due when the observations arrived.
    Run(Box<RecordingReader>, VecDeque<BagMoment>),
    /// A bag of ROS 2, due at the stamps of its messages.
    Ros(Box<RosStream>),
}

/// A bag of ROS 2 and what was learned of it.
#[derive(Debug)]
pub struct RosStream {
    bag: BagReader,
    origin: Time,
    known: BeamOverride,
    odometers: BTreeMap<String, Odometer>,
    n_unreadable: u64,
}

impl BagSource {
    /// Opens a bag, and makes sure that it has the topics that sensors are to get.
    pub fn open(
        path: &Path,
        channels: &BTreeMap<String, String>,
        known: BeamOverride,
    ) -> Result<BagSource, SourceError> {
        let first = BagReader::open(path)?.next();
        if first.is_some_and(|message| message.channel.schema == RUN.name) {
            let reader = RecordingReader::open(path)?;
            if let Some((sensor, channel)) =
                channels.iter().find(|(_, channel)| !reader.header().sensors.contains(channel))
            {
                let names = reader.header().sensors.join(", ");
                let found = format!("is `{channel}`, but this run was recorded with the sensors {names}");
                return Err(SourceError::Topic { sensor: sensor.clone(), found });
            }
            return Ok(BagSource::Run(Box::new(reader), VecDeque::new()));
        }
        let origin = Self::look_through(path, channels)?;
        let (bag, odometers) = (BagReader::open(path)?, BTreeMap::new());
        Ok(BagSource::Ros(Box::new(RosStream { bag, origin, known, odometers, n_unreadable: 0 })))
    }

    /// The first stamp; reads no further than it must to see every topic that is asked for.
    fn look_through(path: &Path, channels: &BTreeMap<String, String>) -> Result<Time, SourceError> {
        let (mut topics, mut origin) = (BTreeMap::new(), None);
        for message in BagReader::open(path)? {
            let channel = &message.channel;
            if origin.is_none() && channel.encoding == "cdr" {
                let read = read_ros(&channel.schema, &message.data).ok().flatten();
                origin = read.filter(|read| is_for_sensors(&read.data)).map(|read| read.stamp);
            }
            if topics.insert(channel.topic.clone(), channel.clone()).is_none()
                && let Some(found) = unreadable(&channel.schema, &channel.encoding)
                && let Some((sensor, _)) = channels.iter().find(|(_, topic)| **topic == channel.topic)
            {
                let found = format!("is `{}`, {found}", channel.topic);
                return Err(SourceError::Topic { sensor: sensor.clone(), found });
            }
            if origin.is_some() && channels.values().all(|topic| topics.contains_key(topic)) {
                break;
            }
        }
        let shown = |(topic, channel): (&String, &std::sync::Arc<rumbo_kit::recording::BagChannel>)| {
            format!("{topic} ({})", channel.schema)
        };
        let words = || topics.iter().map(shown).collect::<Vec<String>>().join(", ");
        if let Some((sensor, topic)) = channels.iter().find(|(_, topic)| !topics.contains_key(*topic)) {
            let found = format!("is `{topic}`, which this bag does not have; it has {}", words());
            return Err(SourceError::Topic { sensor: sensor.clone(), found });
        }
        let path = || path.display().to_string();
        origin.ok_or_else(|| SourceError::Nothing { path: path(), topics: words() })
    }

    /// What was run, in a recording of ours.
    pub fn header(&self) -> Option<&RunHeader> {
        match self {
            BagSource::Run(reader, _) => Some(reader.header()),
            BagSource::Ros(_) => None,
        }
    }

    /// The stamp at which time begins.
    pub fn origin(&self) -> Time {
        match self {
            BagSource::Run(reader, _) => reader.header().started,
            BagSource::Ros(stream) => stream.origin,
        }
    }

    /// The next moment, in the order of the file.
    pub fn read_on(&mut self) -> Option<BagMoment> {
        match self {
            BagSource::Run(reader, ahead) => {
                while ahead.is_empty() {
                    let step = reader.next_step()?;
                    let Some(mark) = step.mark else { continue };
                    let stamp = Time::ZERO + (mark.now - reader.header().started);
                    let sensors = &reader.header().sensors;
                    let moment = |observation: Observation| BagMoment {
                        stamp,
                        channel: sensor_name(sensors, observation.sensor).to_owned(),
                        observation: Some(observation),
                        truth: mark.truth,
                    };
                    ahead.extend(step.observations.into_iter().map(moment));
                    if ahead.is_empty() {
                        let channel = String::new();
                        ahead.push_back(BagMoment { stamp, channel, observation: None, truth: mark.truth });
                    }
                }
                ahead.pop_front()
            }
            BagSource::Ros(stream) => stream.read_on(),
        }
    }

    /// What people should know once the bag is read.
    pub fn sentences(&self) -> Vec<String> {
        match self {
            BagSource::Run(reader, _) => reader.damage().into_iter().collect(),
            BagSource::Ros(stream) => {
                let damage = match stream.bag.end() {
                    Some(BagEnd::Cut) => Some("the file is cut off".to_owned()),
                    Some(BagEnd::Damaged(reason)) => Some(format!("the file is damaged: {reason}")),
                    _ => None,
                };
                let n = stream.n_unreadable;
                let unreadable = (n > 0).then(|| format!("skipped {n} messages that could not be read"));
                damage.into_iter().chain(unreadable).collect()
            }
        }
    }
}

/// Why a topic is nothing that a sensor reads; none where it is.
fn unreadable(schema: &str, encoding: &str) -> Option<String> {
    if !readable_schemas().contains(&schema) {
        let readable = readable_schemas().join(", ");
        return Some(format!("a {schema}, expected one of {readable}"));
    }
    (encoding != "cdr").then(|| format!("encoded as `{encoding}`, expected cdr"))
}

/// The frame that an odometer's transform starts from.
const ODOM: &str = "odom";

fn is_for_sensors(data: &RosData) -> bool {
    match data {
        RosData::Transforms(all) => all.iter().any(|(parent, ..)| parent == ODOM),
        _ => true,
    }
}

impl RosStream {
    fn read_on(&mut self) -> Option<BagMoment> {
        loop {
            let message = self.bag.next()?;
            let channel = &message.channel;
            if channel.encoding != "cdr" {
                continue;
            }
            let read = match read_ros(&channel.schema, &message.data) {
                Ok(Some(read)) => read,
                Ok(None) => continue,
                Err(_) => {
                    self.n_unreadable += 1;
                    continue;
                }
            };
            let stamp = Time::ZERO + (read.stamp - self.origin);
            if let Some(data) = self.data(&channel.topic, stamp, read.data) {
                let (sensor, base_from_sensor) = (SensorId(0), Pose3::identity());
                let observation = Observation { sensor, stamp, base_from_sensor, valid: true, data };
                let channel = channel.topic.clone();
                return Some(BagMoment { stamp, channel, observation: Some(observation), truth: None });
            }
        }
    }

    fn data(&mut self, topic: &str, stamp: Time, data: RosData) -> Option<Data> {
        let (pose, twist) = match data {
            RosData::Scan(mut scan) => {
                let known = &self.known;
                scan.first_bearing_rad = known.first_bearing_rad.unwrap_or(scan.first_bearing_rad);
                scan.bearing_step_rad = known.bearing_step_rad.unwrap_or(scan.bearing_step_rad);
                scan.max_range_m = known.max_range_m.map_or(scan.max_range_m, |range_m| range_m as f32);
                return Some(Data::LaserScan(scan));
            }
            RosData::Imu(imu) => return Some(Data::Imu(imu)),
            RosData::Odometry(pose, twist) => (pose, Some(twist)),
            RosData::Transforms(all) => {
                let (_, _, place) = all.into_iter().find(|(parent, ..)| parent == ODOM)?;
                (rumbo_core::frames::flatten(&place), None)
            }
        };
        self.odometers.entry(topic.to_owned()).or_default().read(stamp, pose, twist).map(Data::Odometry)
    }
}

/// The odometer's pose in an observation.
pub fn odometry_in(moment: &BagMoment) -> Option<Pose2> {
    match &moment.observation.as_ref()?.data {
        Data::Odometry(odometry) => Some(odometry.odom_from_base),
        _ => None,
    }
}
