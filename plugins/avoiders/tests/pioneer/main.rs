//! A Pioneer P3-DX with one depth camera in the two worlds of the specification: the closed loop that its figures are from,
//! written again: control period 0.05 s, a camera of 64 columns and 57 degrees, walls as vertical planes.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stdout)]

mod arena;
mod camera;
mod office;
mod place;
mod robot;
