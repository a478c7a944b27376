//! What a person carries or what follows a person from outside: where somebody is, late, with noise and with gaps.

mod params;
mod plugin;
mod tracker;

pub use params::PersonTrackerParams;
pub use plugin::PersonTracker;
pub use tracker::Tracker;
