//! `known_marks`: the marks that a robot can recognize, from a file, which nothing that it sees ever changes.

mod load;
mod params;
mod plugin;

pub use load::{load_marks_at, load_world_marks};
pub use params::KnownMarksParams;
pub use plugin::KnownMarks;
