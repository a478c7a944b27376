//! From where a camera was to where its robot was.

use nalgebra::{Matrix3, Rotation3, Translation3, UnitQuaternion};
use rumbo_core::frames::{Pose3, flatten};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::log_file::PoseTrack;
use crate::trajectory::Trajectory;

/// A place in space, as a sensor's `mount` says it.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PlaceInSpace {
    /// Forward, meters.
    pub x_m: f64,
    /// To the left, meters.
    pub y_m: f64,
    /// Up, meters.
    pub z_m: f64,
    /// Turn about the x axis, degrees.
    pub roll_deg: f64,
    /// Turn about the y axis, degrees; positive looks down.
    pub pitch_deg: f64,
    /// Turn about the z axis, degrees; positive looks left.
    pub yaw_deg: f64,
}

impl PlaceInSpace {
    /// The same as a pose: roll, pitch and yaw about fixed axes, in this order.
    pub fn pose(&self) -> Pose3 {
        let [roll, pitch, yaw] = [self.roll_deg, self.pitch_deg, self.yaw_deg].map(f64::to_radians);
        Pose3::from_parts(
            Translation3::new(self.x_m, self.y_m, self.z_m),
            UnitQuaternion::from_euler_angles(roll, pitch, yaw),
        )
    }

    /// Every number with its key.
    pub fn numbers(&self) -> [(&'static str, f64); 6] {
        [
            ("x_m", self.x_m),
            ("y_m", self.y_m),
            ("z_m", self.z_m),
            ("roll_deg", self.roll_deg),
            ("pitch_deg", self.pitch_deg),
            ("yaw_deg", self.yaw_deg),
        ]
    }
}

/// How the camera of a recording sat on its robot, and where its world lies in the map.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct CameraMounting {
    /// Where the camera sat on the robot.
    pub mount: PlaceInSpace,
    /// Where the world of the recorded poses lies in the map: turns a world that is not level.
    pub map_from_world: PlaceInSpace,
}

impl CameraMounting {
    /// The same as poses.
    pub fn place(&self) -> CameraPlace {
        CameraPlace { base_from_camera: self.mount.pose(), map_from_world: self.map_from_world.pose() }
    }

    /// Every number that is not finite, with its key.
    pub fn faults(&self) -> impl Iterator<Item = (String, f64)> + use<> {
        let both = [("mount", self.mount.numbers()), ("map_from_world", self.map_from_world.numbers())];
        both.into_iter().flat_map(|(part, numbers)| {
            let wrong = numbers.into_iter().filter(|(_, value)| !value.is_finite());
            wrong.map(move |(key, value)| (format!("{part}.{key}"), value))
        })
    }
}

/// How the world of a recording and its camera lie to a map and a robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraPlace {
    /// Where the camera sits on the robot.
    pub base_from_camera: Pose3,
    /// Where the world of the recorded poses lies in the map.
    pub map_from_world: Pose3,
}

impl CameraPlace {
    /// Where the robot is when the optical center is here.
    pub fn base_in_map(&self, world_from_optical: &Pose3) -> Pose3 {
        let world_from_camera = world_from_optical * camera_from_optical().inverse();
        self.map_from_world * world_from_camera * self.base_from_camera.inverse()
    }

    /// The same seen from above, over time.
    pub fn base_track(&self, world_from_optical: &Trajectory) -> PoseTrack {
        let mut track = PoseTrack::default();
        for pose in world_from_optical.poses() {
            track.push(pose.stamp, flatten(&self.base_in_map(&pose.world_from_body)));
        }
        track
    }
}

/// Optical frames have z ahead, x to the right and y down (REP-103); all other frames have x ahead, y left and z up.
pub fn camera_from_optical() -> Pose3 {
    let ahead_left_up = Matrix3::new(0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0);
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(ahead_left_up));
    Pose3::from_parts(Translation3::identity(), rotation)
}
