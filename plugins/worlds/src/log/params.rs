//! What `[world] plugin = "log"` takes.

use std::collections::BTreeMap;
use std::path::PathBuf;

use rumbo_core::registry::Params;
use rumbo_core::stages::BuildError;
use rumbo_kit::log_file::BeamOverride;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::mrclam::MrclamChannel;
use super::rgbd::{RecordedCamera, RgbdChannel};

/// The word that stands for the poses inside the log.
pub const TRUTH_INSIDE: &str = "log";

/// A recording of any size: a run of `rumbo run --record`, a ROS 2 bag (MCAP), a robot log of CARMEN (`.log`, `.clf`)
/// or Wean Hall, plain or gzip, one robot of an MRCLAM folder, or a folder of depth pictures of the TUM RGB-D kind.
///
/// Bags have `sensor_msgs/msg/LaserScan`, `nav_msgs/msg/Odometry`, `sensor_msgs/msg/Imu`, and `tf2_msgs/msg/TFMessage`
/// for an odometer that speaks in transforms from `odom`. A run of ours brings its start, its map and its true poses
/// along; its observations come when they arrived.
///
/// An MRCLAM folder (Leung et al. 2011) has tables `RobotN_Odometry.dat`, `RobotN_Measurement.dat`,
/// `RobotN_Groundtruth.dat`, `Landmark_Groundtruth.dat` and `Barcodes.dat`, plain or gzip. Its channels are `odometry`
/// (the commanded velocities, added up) and `marks`; the identity of a mark is the landmark's subject number. Other
/// robots, which move, are left out. The errors that it claims were measured on its data set 7: 5 cm and 0.05 rad over
/// one meter, 0.1 rad over one radian, 0.15 m of range and 0.01 rad of bearing.
///
/// A TUM RGB-D folder (Sturm et al. 2012) has the list `depth.txt`, where its camera was in `groundtruth.txt`, and maybe
/// `accelerometer.txt`, plain or gzip. Its channels are `depth` (pictures, read when a sensor asks) and `imu` (accelerations
/// along the camera's axes: x left, y up, z ahead in the file; there is no gyroscope, so rates are zero and there is no
/// attitude). The colors are not read. Pictures that are not there, or cannot be read, are left out and told.
///
/// Time begins at the first stamp of the log. Records that are up to 2 s out of order are sorted by their stamps; what is
/// farther out of order, or has the stamp of the record before it in its channel, is left out and counted. Lines that
/// cannot be read are skipped and told at the end.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct LogParams {
    /// The log, or the folder of an MRCLAM or TUM RGB-D data set, relative to the pipeline's folder.
    pub file: PathBuf,
    /// Which robot of an MRCLAM folder.
    pub robot: u32,
    /// The odometer of an MRCLAM folder tells of the time this much after its stamps, seconds: its velocities are
    /// commands, and a robot takes a while to obey. In data set 7 that is 0.2 s.
    pub odometer_delay_s: f64,
    /// The camera of a TUM RGB-D folder.
    pub camera: RecordedCamera,
    /// The map that belongs to the log: a map_server YAML file or a TOML world file, for plugins without a file of their
    /// own.
    pub map: Option<PathBuf>,
    /// Which recorded channel a sensor gets, by the sensor's name: `front_laser`, `rear_laser` or `odometry` of a text
    /// log, the name of a recorded sensor of a run, a topic such as `/scan` of a ROS 2 bag. A sensor that is not listed
    /// gets the channel of its own name. Without any entry for a laser, and with one laser in the log, every laser
    /// sensor gets that one; the same goes for odometry.
    pub channels: BTreeMap<String, String>,
    /// Where an operator would say that the robot stands at the first stamp. Without it: the first true pose if it is
    /// within 2 s of the first stamp; else, if there is no `map`, the odometer's first pose. MRCLAM and TUM RGB-D folders
    /// have no such pose: without `start` and `truth` their robot may be anywhere.
    pub start: Option<LogStart>,
    /// True poses: a file of `t x y theta` lines (absolute stamps in seconds as in the log, meters, radians; plain or
    /// gzip), or the word `log` for the poses inside the log: those of `VERTEX2` lines, else the first pose of each
    /// laser message; of an MRCLAM folder the robot's `Groundtruth` table; of a TUM RGB-D folder its
    /// `groundtruth.txt`, as poses of the robot that carried the camera at `camera.mount`.
    pub truth: Option<PathBuf>,
    /// A range of this much or more means that nothing was seen, meters. Without it: what the log says, else 80.
    pub max_range_m: Option<f64>,
    /// Bearing of the first beam, degrees. Without it: what the log says, else -90.
    pub first_bearing_deg: Option<f64>,
    /// From one beam to the next, degrees. Without it: what the log says, else 1 for 180 or 181 beams, 0.5 for 360 or
    /// 361, and 180 in all for other numbers of beams.
    pub bearing_step_deg: Option<f64>,
}

impl Default for LogParams {
    fn default() -> Self {
        LogParams {
            file: PathBuf::new(),
            robot: 1,
            odometer_delay_s: 0.0,
            camera: RecordedCamera::default(),
            map: None,
            channels: BTreeMap::new(),
            start: None,
            truth: None,
            max_range_m: None,
            first_bearing_deg: None,
            bearing_step_deg: None,
        }
    }
}

/// A pose on the floor.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LogStart {
    /// Meters along the map's x axis.
    pub x_m: f64,
    /// Meters along the map's y axis.
    pub y_m: f64,
    /// Heading, counter-clockwise from the x axis, degrees.
    #[serde(default)]
    pub yaw_deg: f64,
}

/// What a log can have recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RecordedChannel {
    /// Scans of the front laser.
    FrontLaser,
    /// Scans of the rear laser.
    RearLaser,
    /// Poses of the odometer.
    Odometry,
}

impl RecordedChannel {
    /// All of them.
    pub const ALL: [RecordedChannel; 3] =
        [RecordedChannel::FrontLaser, RecordedChannel::RearLaser, RecordedChannel::Odometry];

    /// Its name in a pipeline.
    pub fn name(self) -> &'static str {
        match self {
            RecordedChannel::FrontLaser => "front_laser",
            RecordedChannel::RearLaser => "rear_laser",
            RecordedChannel::Odometry => "odometry",
        }
    }
}

impl LogParams {
    /// True poses are those of the recording itself.
    pub fn truth_is_inside(&self) -> bool {
        self.truth.as_ref().is_some_and(|truth| truth.as_os_str() == TRUTH_INSIDE)
    }

    /// The channels of a text log.
    pub fn log_channels(&self) -> Result<BTreeMap<String, RecordedChannel>, BuildError> {
        let channel = |(sensor, name): (&String, &String)| {
            let known = RecordedChannel::ALL.into_iter().find(|channel| channel.name() == name);
            let names = RecordedChannel::ALL.map(RecordedChannel::name).join(", ");
            let wrong = || {
                let message = format!("is `{name}`, expected one of {names}: this is a text log");
                BuildError::at(format!("channels.{sensor}"), message)
            };
            known.map(|known| (sensor.clone(), known)).ok_or_else(wrong)
        };
        self.channels.iter().map(channel).collect()
    }

    /// The channels of an MRCLAM folder.
    pub fn mrclam_channels(&self) -> Result<BTreeMap<String, MrclamChannel>, BuildError> {
        let channel = |(sensor, name): (&String, &String)| {
            let wrong = || {
                let message = format!("is `{name}`, expected odometry or marks: this is an MRCLAM folder");
                BuildError::at(format!("channels.{sensor}"), message)
            };
            MrclamChannel::named(name).map(|known| (sensor.clone(), known)).ok_or_else(wrong)
        };
        self.channels.iter().map(channel).collect()
    }

    /// The channels of a TUM RGB-D folder.
    pub fn rgbd_channels(&self) -> Result<BTreeMap<String, RgbdChannel>, BuildError> {
        let channel = |(sensor, name): (&String, &String)| {
            let wrong = || {
                let message = format!("is `{name}`, expected depth or imu: this is a TUM RGB-D folder");
                BuildError::at(format!("channels.{sensor}"), message)
            };
            RgbdChannel::named(name).map(|known| (sensor.clone(), known)).ok_or_else(wrong)
        };
        self.channels.iter().map(channel).collect()
    }

    fn mrclam_faults(&self) -> Vec<BuildError> {
        let mut faults = Vec::new();
        if self.robot == 0 {
            faults.push(BuildError::at("robot", "is 0, expected 1 or more: robots are counted from 1"));
        }
        if !(-60.0..=60.0).contains(&self.odometer_delay_s) {
            let message = format!("is {}, expected seconds from -60 to 60", self.odometer_delay_s);
            faults.push(BuildError::at("odometer_delay_s", message));
        }
        faults
    }

    /// What the user knows of the beams.
    pub fn known(&self) -> BeamOverride {
        BeamOverride {
            first_bearing_rad: self.first_bearing_deg.map(f64::to_radians),
            bearing_step_rad: self.bearing_step_deg.map(f64::to_radians),
            max_range_m: self.max_range_m,
        }
    }
}

impl Params for LogParams {
    fn check(&self) -> Vec<BuildError> {
        let mut faults = Vec::new();
        if self.file.as_os_str().is_empty() {
            let fault = BuildError::at("file", "is missing, expected the path of a recording");
            faults.push(fault.help(
                "runs (.mcap), ROS 2 bags (.mcap), CARMEN logs (.log, .clf), Wean Hall logs, MRCLAM and TUM RGB-D \
                 folders are read",
            ));
        }
        let start = self.start.iter().flat_map(|start| {
            [("start.x_m", start.x_m), ("start.y_m", start.y_m), ("start.yaw_deg", start.yaw_deg)]
        });
        for (key, value) in start.filter(|(_, value)| !value.is_finite()) {
            faults.push(BuildError::at(key, format!("is {value}, expected a finite number")));
        }
        if let Some(value) = self.max_range_m.filter(|value| !(*value > 0.0 && value.is_finite())) {
            let message = format!("is {value}, expected a finite number above zero");
            faults.push(BuildError::at("max_range_m", message));
        }
        let bearings = [
            ("first_bearing_deg", self.first_bearing_deg, 0.0),
            ("bearing_step_deg", self.bearing_step_deg, 1e-6),
        ];
        for (key, value, least) in bearings {
            if let Some(value) = value.filter(|value| !(least..=360.0).contains(&value.abs())) {
                let message =
                    format!("is {value}, expected an angle of at most 360 degrees, and a step not of zero");
                faults.push(BuildError::at(key, message));
            }
        }
        faults.extend(self.mrclam_faults());
        faults.extend(self.camera.faults("camera"));
        faults
    }
}
