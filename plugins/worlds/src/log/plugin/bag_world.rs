//! A bag as a world of the framework.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use rumbo_core::frames::Pose2;
use rumbo_core::messages::{Command, ObservationKind};
use rumbo_core::stages::{Advance, Answer, BuildContext, BuildError, Drove, Probe, Truth, World, WorldError};
use rumbo_core::time::Time;

use crate::log::bag::{BagPlayback, BagSource, SourceError};
use crate::log::params::LogParams;
use crate::log::truth::KnownTruth;

/// A bag that plays.
#[derive(Debug)]
pub struct BagWorld {
    playback: BagPlayback,
    channels: BTreeMap<String, String>,
    asked: BTreeSet<String>,
    start: Option<Pose2>,
    map_file: Option<PathBuf>,
    file: PathBuf,
}

impl BagWorld {
    /// Of a bag at `file`.
    pub fn build(
        params: &LogParams,
        context: &BuildContext,
        file: PathBuf,
        map_file: Option<PathBuf>,
    ) -> Result<BagWorld, BuildError> {
        let source =
            BagSource::open(&file, &params.channels, params.known()).map_err(|error| match &error {
                SourceError::Topic { sensor, .. } => {
                    BuildError::at(format!("channels.{sensor}"), error.to_string())
                }
                _ => BuildError::at("file", error.to_string()),
            })?;
        let mut sentences = Vec::new();
        let is_run = source.header().is_some();
        // A run of ours knows its own truth; the word for that changes nothing there.
        let known = match params.truth_is_inside() {
            true if is_run => KnownTruth::default(),
            true => {
                let message = "is \"log\", but a bag of ROS 2 holds no true poses";
                return Err(BuildError::at("truth", message).help("name a file of `t x y theta` lines"));
            }
            false => params.known_truth(context, source.origin(), &mut sentences)?,
        };
        let recorded_start = source.header().and_then(|header| header.start);
        let recorded_map = source.header().and_then(|header| header.map_file.clone());
        let mut playback = BagPlayback::new(source, params.file.display().to_string(), known);
        sentences.iter().for_each(|sentence| playback.notify(sentence));
        let first =
            playback.first_truth().filter(|(time, _)| (*time - Time::ZERO).0.abs() <= KnownTruth::GAP.0);
        let map_file = map_file.or(recorded_map.filter(|map| map.is_file()));
        let odometry = playback.first_odometry().filter(|_| map_file.is_none());
        let start = params.given_start().or(first.map(|(_, pose)| pose)).or(recorded_start).or(odometry);
        Ok(BagWorld {
            playback,
            channels: params.channels.clone(),
            asked: BTreeSet::new(),
            start,
            map_file,
            file,
        })
    }

    /// The channel of a sensor: the one that the pipeline names, else the one of its own name, which topics of ROS
    /// begin with a slash.
    fn channel_of(&self, sensor: &str) -> String {
        let is_run = self.playback.source().header().is_some();
        let own = || if is_run { sensor.to_owned() } else { format!("/{}", sensor.trim_start_matches('/')) };
        self.channels.get(sensor).cloned().unwrap_or_else(own)
    }

    /// The channel of a sensor that did not say its name: nothing where the pipeline tells sensors apart by name.
    fn unnamed(&self, probe: &Probe<'_>) -> Option<String> {
        let kind = match probe {
            Probe::Beams { .. } => ObservationKind::LaserScan,
            Probe::Wheels => ObservationKind::Odometry,
            Probe::Attitude => ObservationKind::Imu,
            _ => return None,
        };
        self.playback.only(kind).filter(|only| !self.channels.values().any(|channel| channel == only))
    }

    /// Says who asked for what the bag never had.
    fn tell_silent_channels(&mut self) {
        for channel in std::mem::take(&mut self.asked) {
            if !self.playback.has_seen(&channel) {
                self.playback.notify(&format!("a sensor asked for {channel}, of which this bag has nothing"));
            }
        }
    }
}

impl World for BagWorld {
    fn now(&self) -> Time {
        self.playback.now()
    }

    fn advance(&mut self, to: Time) -> Result<Advance, WorldError> {
        let advanced = self.playback.advance(to);
        if advanced == Ok(Advance::Ended) {
            self.tell_silent_channels();
        }
        advanced
    }

    fn drive(&mut self, command: &Command) -> Result<Drove, WorldError> {
        super::not_actuated(command)
    }

    fn probe<'w>(&'w mut self, probe: &Probe<'_>) -> Result<Answer<'w>, WorldError> {
        let channel = match probe {
            Probe::Channel { name } => Some(self.channel_of(name)),
            _ => self.unnamed(probe),
        };
        let sensors = self.playback.source().header().map(|header| &header.sensors);
        let is_there = |channel: &String| sensors.is_none_or(|sensors| sensors.contains(channel));
        let channel = channel.filter(is_there).ok_or(WorldError::Unsupported { probe: probe.name() })?;
        if !self.asked.contains(&channel) {
            self.asked.insert(channel.clone());
        }
        Ok(Answer::Recorded(self.playback.take(&channel)))
    }

    fn truth(&self) -> Option<&Truth> {
        self.playback.truth()
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
