//! The copies of a run that viewers draw: thinned out, since eyes need no more.

use super::bag_writer::{BagWriter, TopicId};
use super::cdr::CdrWriter;
use super::layout::Layout;
use super::ros::{self, Stamped, layout};
use super::step_encoder::sensor_name;
use rumbo_core::engine::{EventKind, StepView};
use rumbo_core::frames::{Pose3, flatten, lift};
use rumbo_core::messages::{Data, Observation, SensorId};
use rumbo_core::time::{Span, Time};
use std::io::{self, Write};
use std::ops::Range;

/// Frames as REP-105 names them.
const MAP: &str = "map";
const ODOM: &str = "odom";
const BASE: &str = "base_footprint";

/// Writes copies for viewers.
#[derive(Debug, Default)]
pub struct ViewerCopies {
    cdr: CdrWriter,
    topics: Vec<(String, TopicId)>,
    mounts: Vec<(SensorId, Pose3)>,
    path_number: u64,
    map_version: Option<u64>,
    poses_due: Option<Time>,
    map_due: Option<Time>,
}

impl ViewerCopies {
    /// Poses are written so often at most.
    const POSES: Span = Span(200_000_000);
    /// A map that changes is written so often at most.
    const MAPS: Span = Span(10_000_000_000);

    /// Writes what is worth a look in this step.
    pub fn write<W: Write>(&mut self, to: &mut BagWriter<W>, view: &StepView<'_>) -> io::Result<()> {
        if self.poses_due.is_none_or(|due| view.now >= due) {
            self.poses_due = Some(view.now + Self::POSES);
            self.poses(to, view)?;
        }
        if view.path_number != self.path_number {
            self.path_number = view.path_number;
            ros::put_path(&mut self.cdr, Stamped { stamp: view.now, frame: MAP }, view.path);
            self.say(to, "/plan", &layout::PATH, view.now)?;
        }
        if self.map_version != Some(view.map.version) && self.map_due.is_none_or(|due| view.now >= due) {
            self.map_due = Some(view.now + Self::MAPS);
            self.map(to, view)?;
        }
        self.events(to, view)
    }

    /// The map as the run leaves it.
    pub fn map<W: Write>(&mut self, to: &mut BagWriter<W>, view: &StepView<'_>) -> io::Result<()> {
        let Some(grid) = &view.map.grid else { return Ok(()) };
        if self.map_version.replace(view.map.version) == Some(view.map.version) {
            return Ok(());
        }
        ros::put_grid(&mut self.cdr, Stamped { stamp: view.now, frame: MAP }, grid);
        self.say(to, "/map", &layout::GRID, view.now)
    }

    /// What the world said after the last step.
    pub fn events<W: Write>(&mut self, to: &mut BagWriter<W>, view: &StepView<'_>) -> io::Result<()> {
        for event in view.events {
            let is_trouble = matches!(
                event.kind,
                EventKind::StageFailed { .. }
                    | EventKind::PlanFailed { .. }
                    | EventKind::Unreachable { .. }
                    | EventKind::Guard(_)
                    | EventKind::Overflow { .. }
            );
            ros::put_log(&mut self.cdr, event.stamp, is_trouble, &event.kind.to_string());
            self.say(to, "/log", &layout::LOG, view.now)?;
        }
        Ok(())
    }

    /// Writes what a sensor saw; what was written, and where in it the readings are.
    pub fn observation<W: Write>(
        &mut self,
        to: &mut BagWriter<W>,
        now: Time,
        observation: &Observation,
        sensors: &[String],
    ) -> io::Result<Option<(&[u8], Range<usize>)>> {
        let frame = sensor_name(sensors, observation.sensor);
        let at = Stamped { stamp: observation.stamp, frame };
        if !matches!(observation.data, Data::LaserScan(_) | Data::PointCloud(_)) {
            return Ok(None);
        }
        let mount = (observation.sensor, observation.base_from_sensor);
        if !self.mounts.contains(&mount) {
            self.mounts.retain(|(sensor, _)| *sensor != mount.0);
            self.mounts.push(mount);
            ros::put_transforms(&mut self.cdr, now, &[(BASE, frame, mount.1)]);
            self.say(to, "/tf_static", &layout::TRANSFORMS, now)?;
        }
        let (layout, readings) = match &observation.data {
            Data::LaserScan(scan) => (layout::LASER_SCAN, ros::put_scan(&mut self.cdr, at, scan)),
            Data::PointCloud(cloud) => (layout::POINT_CLOUD, ros::put_cloud(&mut self.cdr, at, cloud)),
            _ => return Ok(None),
        };
        self.say(to, &format!("/sensor/{frame}"), &layout, now)?;
        Ok(Some((self.cdr.bytes(), readings)))
    }

    fn poses<W: Write>(&mut self, to: &mut BagWriter<W>, view: &StepView<'_>) -> io::Result<()> {
        let now = view.now;
        let map_from_odom = lift(&flatten(&view.estimate.map_from_odom));
        let tree = [(MAP, ODOM, map_from_odom), (ODOM, BASE, lift(&view.odom_from_base))];
        ros::put_transforms(&mut self.cdr, now, &tree);
        self.say(to, "/tf", &layout::TRANSFORMS, now)?;
        let at = Stamped { stamp: now, frame: MAP };
        ros::put_pose(&mut self.cdr, at, &lift(&view.map_from_base), &view.estimate.covariance);
        self.say(to, "/pose", &layout::POSE, now)?;
        if let Some(truth) = view.truth {
            ros::put_place(&mut self.cdr, at, &truth.map_from_base);
            self.say(to, "/truth", &layout::PLACE, now)?;
        }
        ros::put_twist(&mut self.cdr, Stamped { stamp: now, frame: BASE }, &view.command.twist);
        self.say(to, "/cmd_vel", &layout::TWIST, now)
    }

    /// Writes the message at hand; a topic is opened when it is first used.
    fn say<W: Write>(
        &mut self,
        to: &mut BagWriter<W>,
        topic: &str,
        layout: &Layout,
        now: Time,
    ) -> io::Result<()> {
        let known = self.topics.iter().find(|(known, _)| known == topic).map(|(_, id)| *id);
        let id = match known {
            Some(id) => id,
            None => {
                let id = to.topic(topic, layout)?;
                self.topics.push((topic.to_owned(), id));
                id
            }
        };
        to.write(id, now, self.cdr.bytes())
    }
}
