//! The recording as a world of the framework.

mod bag_world;
mod mrclam_world;
mod rgbd_world;

pub use bag_world::BagWorld;
pub use mrclam_world::MrclamWorld;
pub use rgbd_world::RgbdWorld;

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use rumbo_core::frames::{Pose2, pose2};
use rumbo_core::messages::Command;
use rumbo_core::registry::{Params, Plugin};
use rumbo_core::stages::{Advance, Answer, BuildContext, BuildError, Drove, Probe, Truth, World, WorldError};
use rumbo_core::time::Time;
use rumbo_kit::log_file::{Timeline, read_poses};
use rumbo_kit::recording::MAGIC;
use rumbo_kit::tum_rgbd::is_folder as is_rgbd_folder;

use super::params::{LogParams, RecordedChannel};
use super::playback::Playback;
use super::truth::KnownTruth;

rumbo_core::register_world!(
    LogParams,
    "log",
    "a recording: a run, a ROS 2 bag (MCAP), a CARMEN or Wean Hall log, of any size, an MRCLAM or TUM RGB-D folder"
);

/// A recording.
#[derive(Debug)]
pub struct LogWorld {
    playback: Playback,
    channels: BTreeMap<String, RecordedChannel>,
    start: Option<Pose2>,
    map_file: Option<PathBuf>,
    file: PathBuf,
    is_over: bool,
}

impl Plugin<dyn World> for LogParams {
    fn build(&self, context: &BuildContext) -> Result<Box<dyn World>, BuildError> {
        if let Some(fault) = self.check().into_iter().next() {
            return Err(fault);
        }
        let file = context.resolve(&self.file);
        let map_file = self.map.as_ref().map(|map| context.resolve(map));
        if let Some(map) = map_file.as_ref().filter(|map| !map.is_file()) {
            return Err(BuildError::at("map", format!("{}: there is no such file", map.display())));
        }
        if is_rgbd_folder(&file) {
            return Ok(Box::new(RgbdWorld::build(self, context, file, map_file)?));
        }
        if file.is_dir() {
            return Ok(Box::new(MrclamWorld::build(self, context, file, map_file)?));
        }
        if begins_like_a_bag(&file) {
            return Ok(Box::new(BagWorld::build(self, context, file, map_file)?));
        }
        let timeline =
            Timeline::open(&file, self.known()).map_err(|error| BuildError::at("file", error.to_string()))?;
        let channels = self.log_channels()?;
        let mut sentences = Vec::new();
        let truth = self.known_truth(context, timeline.origin(), &mut sentences)?;
        let mut playback = Playback::new(timeline, self.file.display().to_string(), truth);
        sentences.iter().for_each(|sentence| playback.notify(sentence));
        let start = self.start_pose(&playback);
        Ok(Box::new(LogWorld { playback, channels, start, map_file, file, is_over: false }))
    }
}

/// The file is MCAP, whatever its name.
fn begins_like_a_bag(file: &Path) -> bool {
    let mut first = [0; MAGIC.len()];
    let read = File::open(file).and_then(|mut file| file.read_exact(&mut first));
    read.is_ok() && first == MAGIC
}

/// A recording drives as it was recorded.
fn not_actuated(command: &Command) -> Result<Drove, WorldError> {
    if !command.twist.is_finite() {
        return Err(WorldError::NotFinite);
    }
    Ok(Drove::NotActuated)
}

impl LogParams {
    /// Where the pipeline says that the robot starts.
    pub(super) fn given_start(&self) -> Option<Pose2> {
        self.start.map(|start| pose2(start.x_m, start.y_m, start.yaw_deg.to_radians()))
    }

    pub(super) fn known_truth(
        &self,
        context: &BuildContext,
        origin: Time,
        sentences: &mut Vec<String>,
    ) -> Result<KnownTruth, BuildError> {
        let Some(truth) = &self.truth else { return Ok(KnownTruth::default()) };
        if self.truth_is_inside() {
            return Ok(KnownTruth::inside());
        }
        let path = context.resolve(truth);
        let poses = read_poses(&path).map_err(|error| BuildError::at("truth", error.to_string()))?;
        if let Some((last, _)) = poses.track.last().filter(|(last, _)| *last < origin) {
            let message = format!(
                "{}: the last pose is of {:.6} s, but the log begins at {:.6} s",
                path.display(),
                last.as_secs(),
                origin.as_secs()
            );
            return Err(BuildError::at("truth", message).help("stamps of poses are absolute, as in the log"));
        }
        sentences
            .extend(poses.tally.sentences().iter().map(|sentence| format!("{}: {sentence}", path.display())));
        Ok(KnownTruth::of_file(&poses.track, origin))
    }

    fn start_pose(&self, playback: &Playback) -> Option<Pose2> {
        if let Some(given) = self.given_start() {
            return Some(given);
        }
        let first =
            playback.truth().first().filter(|(time, _)| (*time - Time::ZERO).0.abs() <= KnownTruth::GAP.0);
        let begins_its_own_map = self.map.is_none();
        first.map(|(_, pose)| pose).or_else(|| playback.first_odometry().filter(|_| begins_its_own_map))
    }
}

impl LogWorld {
    /// The channel that a sensor of this name gets.
    fn channel_of(&self, sensor: &str) -> Option<RecordedChannel> {
        let own = || RecordedChannel::ALL.into_iter().find(|channel| channel.name() == sensor);
        self.channels.get(sensor).copied().or_else(own)
    }

    /// Says which channels of the pipeline never had anything.
    fn tell_silent_channels(&mut self) {
        for (sensor, channel) in &self.channels {
            if !self.playback.has_seen(*channel) {
                let name = channel.name();
                self.playback.notify(&format!("channels.{sensor} is {name}, which this log does not have"));
            }
        }
    }

    /// What a sensor gets that did not say its name: nothing where the pipeline tells sensors apart by name.
    fn unnamed(&self, probe: &Probe<'_>) -> Option<RecordedChannel> {
        let is_named =
            |is_it: fn(RecordedChannel) -> bool| self.channels.values().any(|channel| is_it(*channel));
        match probe {
            Probe::Beams { .. } if !is_named(|channel| channel != RecordedChannel::Odometry) => {
                self.playback.only_laser()
            }
            Probe::Wheels if !is_named(|channel| channel == RecordedChannel::Odometry) => {
                Some(RecordedChannel::Odometry)
            }
            _ => None,
        }
    }
}

impl World for LogWorld {
    fn now(&self) -> Time {
        self.playback.now()
    }

    fn advance(&mut self, to: Time) -> Result<Advance, WorldError> {
        let advanced = self.playback.advance(to);
        if advanced == Ok(Advance::Ended) && !std::mem::replace(&mut self.is_over, true) {
            self.tell_silent_channels();
        }
        advanced
    }

    fn drive(&mut self, command: &Command) -> Result<Drove, WorldError> {
        not_actuated(command)
    }

    fn probe<'w>(&'w mut self, probe: &Probe<'_>) -> Result<Answer<'w>, WorldError> {
        let channel = match probe {
            Probe::Channel { name } => self.channel_of(name),
            _ => self.unnamed(probe),
        };
        let channel = channel.ok_or(WorldError::Unsupported { probe: probe.name() })?;
        Ok(Answer::Recorded(self.playback.take(channel)))
    }

    fn truth(&self) -> Option<&Truth> {
        self.playback.truth().now()
    }

    fn start(&self) -> Option<Pose2> {
        self.start
    }

    fn map_file(&self) -> Option<&Path> {
        self.map_file.as_deref()
    }

    fn recording_file(&self) -> Option<&Path> {
        Some(&self.file)
    }

    fn take_notice(&mut self) -> Option<String> {
        self.playback.take_notice()
    }

    fn next_recorded(&self) -> Option<Time> {
        Some(self.playback.next())
    }
}

#[cfg(test)]
mod bag_tests;
#[cfg(test)]
mod mrclam_tests;
#[cfg(test)]
mod rgbd_tests;
#[cfg(test)]
mod tests;
