//! A folder of depth pictures as a world of the framework.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use rumbo_core::frames::{Pose2, Pose3};
use rumbo_core::messages::Command;
use rumbo_core::stages::{Advance, Answer, BuildContext, BuildError, Drove, Probe, Truth, World, WorldError};
use rumbo_core::time::Time;
use rumbo_kit::tum_rgbd::{read_camera_track, read_folder};

use crate::log::params::LogParams;
use crate::log::rgbd::{PictureReader, RgbdChannel, RgbdPlayback};
use crate::log::truth::KnownTruth;

/// A folder of depth pictures.
#[derive(Debug)]
pub struct RgbdWorld {
    playback: RgbdPlayback,
    channels: BTreeMap<String, RgbdChannel>,
    start: Option<Pose2>,
    map_file: Option<PathBuf>,
    folder: PathBuf,
    /// The mount by which true poses of the camera became those of the robot, until a sensor was compared with it.
    mount: Option<Pose3>,
}

impl RgbdWorld {
    /// Of a folder.
    pub fn build(
        params: &LogParams,
        context: &BuildContext,
        folder: PathBuf,
        map_file: Option<PathBuf>,
    ) -> Result<RgbdWorld, BuildError> {
        let channels = params.rgbd_channels()?;
        let read = read_folder(&folder).map_err(|error| BuildError::at("file", error.to_string()))?;
        let reader = PictureReader::of(&params.camera, &read.frames).map_err(|fault| {
            let why = fault.map_or_else(String::new, |fault| format!("; the first: {fault}"));
            let message = format!("{}: none of its pictures can be read{why}", folder.display());
            BuildError::at("file", message).help("`camera.encoding` says how depth stands in them")
        })?;
        let mut playback = RgbdPlayback::new(read, reader, params.file.display().to_string());
        let (truth, sentences) = if params.truth_is_inside() {
            let (track, sentences) =
                read_camera_track(&folder).map_err(|error| BuildError::at("truth", error.to_string()))?;
            let track = params.camera.mounting().place().base_track(&track);
            (KnownTruth::of_file(&track, playback.origin()), sentences)
        } else {
            let mut sentences = Vec::new();
            let truth = params.known_truth(context, playback.origin(), &mut sentences)?;
            (truth, sentences)
        };
        sentences.iter().for_each(|sentence| playback.notify(sentence));
        playback.know(truth);
        let start = params.given_start().or_else(|| playback.true_pose());
        let mount = params.truth_is_inside().then(|| params.camera.mount.pose());
        Ok(RgbdWorld { playback, channels, start, map_file, folder, mount })
    }

    /// What an unnamed probe gets: nothing where the pipeline tells sensors apart by name.
    fn unnamed(&self, probe: &Probe<'_>) -> Option<RgbdChannel> {
        let channel = match probe {
            Probe::Depth { .. } => RgbdChannel::Depth,
            Probe::Attitude => RgbdChannel::Imu,
            _ => return None,
        };
        self.channels.values().all(|named| *named != channel).then_some(channel)
    }

    /// Says once that a sensor sits elsewhere than the true poses were made for.
    fn compare_mount(&mut self, base_from_sensor: &Pose3) {
        const ALIKE: [f64; 2] = [1e-3, 2e-3];
        let Some(mount) = self.mount.take() else { return };
        let off = mount.inverse() * base_from_sensor;
        let (off_m, off_rad) = (off.translation.vector.norm(), off.rotation.angle());
        if off_m > ALIKE[0] || off_rad > ALIKE[1] {
            self.playback.notify(&format!(
                "the sensor sits {off_m:.3} m and {:.1} degrees from `camera.mount`, by which true poses of the camera \
                 became those of the robot",
                off_rad.to_degrees()
            ));
        }
    }
}

impl World for RgbdWorld {
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
        if let Probe::Depth { base_from_sensor, .. } = probe {
            self.compare_mount(base_from_sensor);
        }
        let channel = match probe {
            Probe::Channel { name } => self.channels.get(*name).copied().or_else(|| RgbdChannel::named(name)),
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
