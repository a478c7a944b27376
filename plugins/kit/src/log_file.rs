//! Text logs of robots, read as a stream: CARMEN logs and the logs of Wean Hall, plain or gzip, of any size.
//!
//! Formats: the headers of CARMEN logs (`# message formats defined`), Carnegie Mellon Robot Navigation Toolkit, and the
//! `instruct.txt` that comes with the Wean Hall logs. Real logs are damaged: every line that cannot be read is skipped
//! and told with its number and field, and a file that is cut off is read up to the cut.
//!
//! [`LogReader`] gives records in the order of the file, [`Timeline`] in the order of their stamps.

mod beam_rule;
mod carmen;
mod error;
pub(crate) mod lines;
mod number;
mod order_tally;
mod pose_file;
mod pose_track;
mod reader;
mod record;
mod tally;
mod timeline;
mod wean_hall;
pub(crate) mod words;

pub use beam_rule::BeamOverride;
pub use error::{Damage, FaultKind, LineFault, LogError};
pub use order_tally::{OrderTally, Steps};
pub use pose_file::{RecordedPoses, read_poses};
pub use pose_track::{PoseTrack, mean_twist};
pub use reader::LogReader;
pub use record::{LaserSide, LogRecord, PoseEdge, RecordedOdometry, RecordedScan, Told};
pub use tally::{Count, Tally};
pub use timeline::{Moment, MomentData, Timeline};

#[cfg(test)]
mod tests;
