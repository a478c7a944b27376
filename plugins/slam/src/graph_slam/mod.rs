//! `graph_slam`: key frames in a pose graph, tied together wherever their scans overlap.
//!
//! Each scan is registered against the key frames around the robot; each new key frame against several of its neighbors,
//! of now and of earlier visits. Where the robot comes back to after a long way is found by correlative matching. What is
//! known between the key frames is a pose graph, as in Lu and Milios, "Globally consistent range scan alignment for
//! environment mapping" (1997), solved sparsely; the map is drawn from the poses that agree best with everything.

mod atlas;
mod contradiction;
mod front_end;
mod key_frames;
mod loops;
pub(crate) mod nearest;
mod params;
pub(crate) mod place_search;
mod placing;
mod plugin;
pub(crate) mod point_table;
mod predicting;
pub(crate) mod registration;
mod revisiting;
mod saved;
mod saved_look;
mod saved_reckoned;
mod sheet;
pub(crate) mod surface;
mod ties;
mod tracker;

#[cfg(test)]
mod tests;

pub use params::GraphSlamParams;
pub use plugin::GraphSlam;
