//! Folders of the MRCLAM data sets: robots in an indoor space with bar-coded tubes, and where they were in truth.
//!
//! Source: K. Leung, Y. Halpern, T. Barfoot, H. Liu, *The UTIAS multi-robot cooperative localization and mapping
//! dataset*, International Journal of Robotics Research 30 (2011). One robot has three tables, `RobotN_Odometry.dat`
//! (time, forward and angular velocity), `RobotN_Measurement.dat` (time, bar code, range, bearing) and
//! `RobotN_Groundtruth.dat` (time, x, y, heading); all share `Barcodes.dat` (subject, bar code) and
//! `Landmark_Groundtruth.dat` (subject, x, y and their deviations). Each may be plain or gzip, with `.gz` behind its name.
//!
//! The tables of a robot are long and may be damaged: lines that cannot be read are skipped and told, and a file that is
//! cut off is read up to the cut. The tables that all share are short and must be whole.

mod error;
pub(crate) mod order;
mod robot_log;
mod shared;
pub(crate) mod table;

pub use error::MrclamError;
pub use robot_log::{RobotLog, RobotTruth, Sighting, Velocity, read_robot, read_truth};
pub use shared::{LandmarkPlace, read_landmarks};

#[cfg(test)]
mod tests;
