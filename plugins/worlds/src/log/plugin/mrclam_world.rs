//! A robot of an MRCLAM folder as a world of the framework.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use rumbo_core::frames::Pose2;
use rumbo_core::messages::Command;
use rumbo_core::stages::{Advance, Answer, BuildContext, BuildError, Drove, Probe, Truth, World, WorldError};
use rumbo_core::time::{Span, Time};
use rumbo_kit::mrclam::{MrclamError, read_robot, read_truth};

use crate::log::mrclam::{MrclamChannel, MrclamPlayback};
use crate::log::params::LogParams;
use crate::log::truth::KnownTruth;

/// A robot of an MRCLAM folder.
#[derive(Debug)]
pub struct MrclamWorld {
    playback: MrclamPlayback,
    channels: BTreeMap<String, MrclamChannel>,
    start: Option<Pose2>,
    map_file: Option<PathBuf>,
    folder: PathBuf,
}

impl MrclamWorld {
    /// Of a folder.
    pub fn build(
        params: &LogParams,
        context: &BuildContext,
        folder: PathBuf,
        map_file: Option<PathBuf>,
    ) -> Result<MrclamWorld, BuildError> {
        let at = |key: &str, error: MrclamError| {
            let fault = BuildError::at(key, error.to_string());
            fault.help("a folder with depth.txt is played as TUM RGB-D, any other one as an MRCLAM data set")
        };
        let channels = params.mrclam_channels()?;
        let log = read_robot(&folder, params.robot).map_err(|error| at("file", error))?;
        let delay = Span::from_secs(params.odometer_delay_s);
        let mut playback = MrclamPlayback::new(&log, delay, params.file.display().to_string());
        let (truth, sentences) = if params.truth_is_inside() {
            let truth = read_truth(&folder, params.robot).map_err(|error| at("truth", error))?;
            (KnownTruth::of_file(&truth.track, playback.origin()), truth.sentences)
        } else {
            let mut sentences = Vec::new();
            let truth = params.known_truth(context, playback.origin(), &mut sentences)?;
            (truth, sentences)
        };
        sentences.iter().for_each(|sentence| playback.notify(sentence));
        playback.know(truth);
        let start = params.given_start().or_else(|| playback.true_pose());
        Ok(MrclamWorld { playback, channels, start, map_file, folder })
    }

    /// What an unnamed probe gets: nothing where the pipeline tells sensors apart by name.
    fn unnamed(&self, probe: &Probe<'_>) -> Option<MrclamChannel> {
        let channel = match probe {
            Probe::Wheels => MrclamChannel::Odometry,
            Probe::Marks { .. } => MrclamChannel::Marks,
            _ => return None,
        };
        self.channels.values().all(|named| *named != channel).then_some(channel)
    }
}

impl World for MrclamWorld {
    fn now(&self) -> Time {
        self.playback.now()
    }

    fn advance(&mut self, to: Time) -> Result<Advance, WorldError> {
        self.playback.advance(to)
    }

    fn drive(&mut self, command: &Command) -> Result<Drove, WorldError> {
        super::not_actuated(command)
    }

    fn probe<'w>(&'w mut self, probe: &Probe<'_>) -> Result<Answer<'w>, WorldError> {
        let channel = match probe {
            Probe::Channel { name } => {
                self.channels.get(*name).copied().or_else(|| MrclamChannel::named(name))
            }
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
        Some(&self.folder)
    }

    fn take_notice(&mut self) -> Option<String> {
        self.playback.take_notice()
    }

    fn next_recorded(&self) -> Option<Time> {
        Some(self.playback.next())
    }
}
