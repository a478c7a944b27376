//! The copies of a run that viewers draw: thinned out, since eyes need no more.

use super::bag_writer::{BagWriter, TopicId};
use super::cdr::CdrWriter;
use super::layout::Layout;
use super::packed_step::ViewerCopy;
use super::pose::{upright, upright2};
use super::ros::{self, Stamped, layout};
use super::step_encoder::sensor_name;
use crate::nav_filter::FrameChain;
use nalgebra::Translation3;
use rumbo_core::engine::{EventKind, StepView};
use rumbo_core::frames::Pose3;
use rumbo_core::messages::{Data, Observation, ObservationKind, SensorId};
use rumbo_core::time::{Span, Time};
use std::io::{self, Write};

/// Frames as REP-105 names them.
const MAP: &str = "map";
const ODOM: &str = "odom";
const FOOTPRINT: &str = "base_footprint";
const STABILIZED: &str = "base_stabilized";
const BASE: &str = "base_link";

/// Topics that are no sensor's.
const TOPICS: [(&str, Layout); 8] = [
    ("/tf", layout::TRANSFORMS),
    ("/tf_static", layout::TRANSFORMS),
    ("/pose", layout::POSE),
    ("/truth", layout::PLACE),
    ("/cmd_vel", layout::TWIST),
    ("/plan", layout::PATH),
    ("/map", layout::GRID),
    ("/log", layout::LOG),
];

/// Each in [`TOPICS`].
#[derive(Debug, Clone, Copy)]
enum Topic {
    Tree,
    Mounts,
    Pose,
    Truth,
    Velocity,
    Plan,
    Map,
    Log,
}

/// Writes copies for viewers.
#[derive(Debug, Default)]
pub struct ViewerCopies {
    topics: [Option<TopicId>; TOPICS.len()],
    sensors: Vec<(SensorId, ObservationKind, TopicId)>,
    mounts: Vec<(SensorId, Pose3)>,
    is_rooted: bool,
    copies: Vec<Option<ViewerCopy>>,
    path_number: u64,
    map_version: Option<u64>,
    tree_due: Option<Time>,
    poses_due: Option<Time>,
    map_due: Option<Time>,
}

impl ViewerCopies {
    /// Frames are written so often at most: scans are drawn where the robot was at their time.
    const TREE: Span = Span(200_000_000);
    /// Poses and velocities are written so often at most: each step has them to the bit.
    const POSES: Span = Span(500_000_000);
    /// A map that changes is written so often at most.
    const MAPS: Span = Span(10_000_000_000);

    /// Writes what is worth a look in this step.
    pub fn write<W: Write>(&mut self, to: &mut BagWriter<W>, view: &StepView<'_>) -> io::Result<()> {
        if is_due(&mut self.tree_due, view.now, Self::TREE) {
            self.tree(to, view)?;
        }
        if is_due(&mut self.poses_due, view.now, Self::POSES) {
            self.poses(to, view)?;
        }
        if view.path_number != self.path_number {
            self.path_number = view.path_number;
            let at = Stamped { stamp: view.now, frame: MAP };
            self.say(to, Topic::Plan, view.now, |cdr| ros::put_path(cdr, at, view.path))?;
        }
        if self.map_version != Some(view.map.version) && is_due(&mut self.map_due, view.now, Self::MAPS) {
            self.map(to, view)?;
        }
        self.events(to, view)
    }

    /// The frames up to the body. Where nobody says how it leans, it stands upright once and for all.
    fn tree<W: Write>(&mut self, to: &mut BagWriter<W>, view: &StepView<'_>) -> io::Result<()> {
        let [height, lean] = body_of(&view.footprint_from_base.unwrap_or_else(Pose3::identity));
        let links = [
            (MAP, ODOM, upright(&view.estimate.map_from_odom)),
            (ODOM, FOOTPRINT, upright2(&view.odom_from_base)),
            height,
            lean,
        ];
        let (moving, fixed) = links.split_at(if view.footprint_from_base.is_some() { 4 } else { 2 });
        if !fixed.is_empty() && !std::mem::replace(&mut self.is_rooted, true) {
            self.say(to, Topic::Mounts, view.now, |cdr| ros::put_transforms(cdr, view.now, fixed))?;
        }
        self.say(to, Topic::Tree, view.now, |cdr| ros::put_transforms(cdr, view.now, moving))
    }

    /// The map as the run leaves it.
    pub fn map<W: Write>(&mut self, to: &mut BagWriter<W>, view: &StepView<'_>) -> io::Result<()> {
        let Some(grid) = &view.map.grid else { return Ok(()) };
        if self.map_version.replace(view.map.version) == Some(view.map.version) {
            return Ok(());
        }
        let at = Stamped { stamp: view.now, frame: MAP };
        self.say(to, Topic::Map, view.now, |cdr| ros::put_grid(cdr, at, grid))
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
            let text = event.kind.to_string();
            self.say(to, Topic::Log, view.now, |cdr| ros::put_log(cdr, event.stamp, is_trouble, &text))?;
        }
        Ok(())
    }

    /// Writes what sensors saw in a new step.
    pub fn observations<W: Write>(
        &mut self,
        to: &mut BagWriter<W>,
        view: &StepView<'_>,
        sensors: &[String],
    ) -> io::Result<()> {
        self.copies.clear();
        let mut n_copies = 0;
        for observation in view.observations {
            let readings = self.observation(to, view, observation, sensors)?;
            // Readings beyond the last copy that can be named are written once more with their step.
            let copy = readings.zip(u8::try_from(n_copies).ok());
            n_copies += usize::from(readings.is_some());
            self.copies.push(copy.map(|((start, len), number)| ViewerCopy { number, start, len }));
        }
        Ok(())
    }

    /// Where the readings of the last observations stand, one after the other.
    pub fn copies(&self) -> &[Option<ViewerCopy>] {
        &self.copies
    }

    /// Writes what a sensor saw; where in the message the readings begin, and how many bytes they are.
    fn observation<W: Write>(
        &mut self,
        to: &mut BagWriter<W>,
        view: &StepView<'_>,
        observation: &Observation,
        sensors: &[String],
    ) -> io::Result<Option<(usize, usize)>> {
        let (now, sensor, kind) = (view.now, observation.sensor, observation.data.kind());
        let layout = match kind {
            ObservationKind::LaserScan => layout::LASER_SCAN,
            ObservationKind::PointCloud => layout::POINT_CLOUD,
            _ => return Ok(None),
        };
        let frame = sensor_name(sensors, sensor);
        let at = Stamped { stamp: observation.stamp, frame };
        let mount = (sensor, observation.base_from_sensor);
        if !self.mounts.contains(&mount) {
            self.mounts.retain(|(known, _)| *known != sensor);
            self.mounts.push(mount);
            // What was turned level has the body's lean in its own pose.
            let is_derived = view.derived.get(usize::from(sensor.0)) == Some(&true);
            let mount = [(if is_derived { STABILIZED } else { BASE }, frame, mount.1)];
            self.say(to, Topic::Mounts, now, |cdr| ros::put_transforms(cdr, now, &mount))?;
        }
        let known = self.sensors.iter().find(|known| (known.0, known.1) == (sensor, kind));
        let topic = match known {
            Some((_, _, topic)) => *topic,
            None => {
                let topic = to.topic(&format!("/sensor/{frame}"), &layout)?;
                self.sensors.push((sensor, kind, topic));
                topic
            }
        };
        let mut readings = 0..0;
        to.write_with(topic, now, |cdr| match &observation.data {
            Data::LaserScan(scan) => readings = ros::put_scan(cdr, at, scan),
            Data::PointCloud(cloud) => readings = ros::put_cloud(cdr, at, cloud),
            _ => {}
        })?;
        Ok(Some((readings.start, readings.len())))
    }

    fn poses<W: Write>(&mut self, to: &mut BagWriter<W>, view: &StepView<'_>) -> io::Result<()> {
        let (now, at) = (view.now, Stamped { stamp: view.now, frame: MAP });
        let (pose, covariance) = (upright2(&view.map_from_base), &view.estimate.covariance);
        self.say(to, Topic::Pose, now, |cdr| ros::put_pose(cdr, at, &pose, covariance))?;
        if let Some(truth) = view.truth {
            self.say(to, Topic::Truth, now, |cdr| ros::put_place(cdr, at, &truth.map_from_base))?;
        }
        let at = Stamped { stamp: now, frame: FOOTPRINT };
        self.say(to, Topic::Velocity, now, |cdr| ros::put_twist(cdr, at, &view.command.twist))
    }

    /// Writes a message; a topic is opened when it is first used.
    fn say<W: Write>(
        &mut self,
        to: &mut BagWriter<W>,
        topic: Topic,
        now: Time,
        put: impl FnOnce(&mut CdrWriter),
    ) -> io::Result<()> {
        let (known, (name, layout)) = (&mut self.topics[topic as usize], &TOPICS[topic as usize]);
        let id = match known {
            Some(id) => *id,
            None => *known.insert(to.topic(name, layout)?),
        };
        to.write_with(id, now, put)
    }
}

/// Height, then roll and pitch.
fn body_of(footprint_from_base: &Pose3) -> [(&'static str, &'static str, Pose3); 2] {
    let chain = FrameChain::of(footprint_from_base);
    let height = Pose3::translation(0.0, 0.0, chain.height_m);
    let lean = Pose3::from_parts(Translation3::identity(), chain.stabilized_from_base);
    [(FOOTPRINT, STABILIZED, height), (STABILIZED, BASE, lean)]
}

/// Whether it is time again, and if so, when the next time is.
fn is_due(due: &mut Option<Time>, now: Time, period: Span) -> bool {
    let is_due = due.is_none_or(|due| now >= due);
    if is_due {
        *due = Some(now + period);
    }
    is_due
}
