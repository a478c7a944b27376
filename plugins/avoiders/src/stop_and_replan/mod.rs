//! `stop_and_replan`: turn in place, drive straight, stop in front of what is not on the map and ask for a new path.
//!
//! Hernández Alamilla (2005), *navigation with natural landmarks*, chapter 6: turn-then-go control with three speeds
//! up and down (6.1), the watch in front of the robot (6.2). Corrections and extensions are marked where they are: sonar
//! fused over time, which finds panes of glass, bumpers, and people who are
//! followed instead of taken for obstacles that stand.

pub mod braking;
pub mod checkpoints;
pub mod cones;
pub mod evidence;
pub mod front_watch;
pub mod lane;
pub mod meeting;
mod params;
pub mod people;
mod plugin;
pub mod sound_watch;
pub mod speed_profile;
mod straight;
pub mod touch;
pub mod tuning;
pub mod turn_then_go;

#[cfg(test)]
mod tests;

pub use params::StopAndReplanParams;
pub use people::PeopleParams;
pub use plugin::StopAndReplan;
