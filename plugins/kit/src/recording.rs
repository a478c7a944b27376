//! Recordings: MCAP files (<https://mcap.dev>) with CDR messages, which ROS 2 bags are too.
//!
//! A run of ours has two kinds of topics: those below `/rumbo/`, to the bit, from which a run can be repeated, and
//! copies in ROS 2's own messages, which every viewer of bags draws. [`RecordingReader`] gives the first kind step by
//! step, [`BagReader`] every message of any bag. `docs/recording.md` lists the topics.

mod bag;
mod bag_index;
mod bag_piece;
mod bag_writer;
pub mod cdr;
mod cdr_writer;
mod difference;
mod header;
pub mod layout;
mod map_code;
mod mcap_records;
mod observation;
mod order_code;
mod outputs;
mod packed_step;
mod packed_words;
pub mod pose;
mod reader;
mod room;
pub mod ros;
mod step_encoder;
mod viewer;
mod word_hash;

pub use bag::{BagChannel, BagEnd, BagError, BagMessage, BagReader, MAGIC};
pub use bag_writer::{BagWriter, TopicId};
pub use difference::{FieldDifference, first_difference};
pub use header::{HeaderError, RunHeader, put_end, put_header, read_header};
pub use map_code::{put_map, put_map_hash, read_map};
pub use observation::{put_observation, read_observation};
pub use order_code::{put_order, read_order};
pub use outputs::{
    RecordedEvent, StepMark, estimated_place, put_command, put_estimate, put_event, put_path, put_step,
    read_command, read_event, read_path, read_step,
};
pub use packed_step::{StepPacker, StepUnpacker, ViewerCopy};
pub use reader::{RecordedStep, RecordingError, RecordingReader, is_of};
pub use step_encoder::{Said, StepEncoder, sensor_name};
pub use viewer::ViewerCopies;
pub use word_hash::hash_of;

#[cfg(test)]
mod tests;
