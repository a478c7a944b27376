//! Global localization by natural landmarks: trials on the office maps, and robots that are led by what the plugin wishes.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

#[path = "relocalization/courses.rs"]
mod courses;
#[path = "../benches/relocalization_work/mod.rs"]
mod relocalization_work;
#[path = "relocalization/robot.rs"]
mod robot;
#[path = "relocalization/robots.rs"]
mod robots;
#[path = "relocalization/trials.rs"]
mod trials;
