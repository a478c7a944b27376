//! What a depth camera on a simulated robot sees on its way, as a folder of the TUM RGB-D kind.

use std::path::{Path, PathBuf};

use rumbo_core::frames::Twist;
use rumbo_core::messages::{Command, Intrinsics};
use rumbo_core::registry::Plugin;
use rumbo_core::stages::{Answer, BuildContext, Probe, World};
use rumbo_core::time::Time;
use rumbo_kit::depth_file::{DepthEncoding, DepthPicture};
use rumbo_kit::tum_rgbd::{FolderWriter, PlaceInSpace, camera_from_optical};
use rumbo_worlds::sim::{SimParams, Start};

/// A robot, its camera and its way.
#[derive(Debug, Clone)]
pub struct Recorder {
    /// A world file.
    pub world: PathBuf,
    /// Where the robot starts.
    pub start: Start,
    /// Velocities, and for how long each, seconds.
    pub way: Vec<(Twist, f64)>,
    /// Where the camera sits.
    pub mount: PlaceInSpace,
    /// The camera.
    pub intrinsics: Intrinsics,
    /// How depth is written.
    pub encoding: DepthEncoding,
    /// Meters of one count.
    pub unit_m: f64,
    /// Beyond this nothing is seen, meters.
    pub max_range_m: f64,
    /// From one picture to the next, seconds.
    pub interval_s: f64,
    /// The stamp of the first picture, seconds.
    pub begins_s: f64,
}

impl Recorder {
    /// Drives and writes; the number of pictures.
    pub fn record(&self, folder: &Path) -> Result<usize, Box<dyn std::error::Error>> {
        let params = SimParams { map: Some(self.world.clone()), start: self.start, ..SimParams::default() };
        let mut world = params.build(&BuildContext::bare("world"))?;
        let mut writer = FolderWriter::create(folder, self.encoding)?;
        let (mut n_pictures, mut ends_s) = (0, 0.0);
        for (twist, seconds) in &self.way {
            ends_s += seconds;
            let command = Command { twist: *twist, ..Command::default() };
            while n_pictures as f64 * self.interval_s < ends_s {
                world.drive(&command)?;
                world.advance(Time::from_secs(n_pictures as f64 * self.interval_s))?;
                self.write(world.as_mut(), &mut writer)?;
                n_pictures += 1;
            }
            world.drive(&command)?;
            world.advance(Time::from_secs(ends_s))?;
        }
        writer.finish()?;
        Ok(n_pictures)
    }

    fn write(
        &self,
        world: &mut dyn World,
        writer: &mut FolderWriter,
    ) -> Result<(), Box<dyn std::error::Error>> {
        let base_from_camera = self.mount.pose();
        let stamp = Time::from_secs(self.begins_s + world.now().as_secs());
        let probe = Probe::Depth {
            base_from_sensor: &base_from_camera,
            intrinsics: &self.intrinsics,
            max_range_m: self.max_range_m,
        };
        let Answer::Ranges(depths_m) = world.probe(&probe)? else { return Err("no depth picture".into()) };
        let counts = depths_m.iter().map(|depth_m| self.count(*depth_m)).collect();
        let Intrinsics { width, height, .. } = self.intrinsics;
        writer.picture(stamp, &DepthPicture { width, height, counts })?;
        let truth = world.truth().ok_or("the world does not know where the robot is")?;
        if truth.contact_episodes.is_some_and(|n| n > 0) {
            return Err(format!("the robot ran into something before {:.1} s", world.now().as_secs()).into());
        }
        let map_from_base = truth.map_from_base;
        writer.pose(stamp, &(map_from_base * base_from_camera * camera_from_optical()))?;
        let Answer::Attitude(attitude) = world.probe(&Probe::Attitude)? else {
            return Err("no attitude".into());
        };
        let force = nalgebra::Vector3::from(attitude.accelerations_m_s2);
        let [ahead, left, up]: [f64; 3] = (base_from_camera.rotation.inverse() * force).into();
        Ok(writer.acceleration(stamp, [left, up, ahead])?)
    }

    /// The nearest count; 0 where nothing is seen or the encoding does not reach.
    fn count(&self, depth_m: f32) -> u16 {
        let most = if self.encoding == DepthEncoding::TwoChannel { 8191.0 } else { 65_535.0 };
        let count = (f64::from(depth_m) / self.unit_m).round();
        if (1.0..=most).contains(&count) { count as u16 } else { 0 }
    }
}
