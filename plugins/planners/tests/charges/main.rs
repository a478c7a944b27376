//! `potential_field` and `fictitious_charges` against the published warehouse and against an exact solver.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod scene;
mod shortest;
mod warehouse;

mod acceptance;
mod limits;
mod log_lines;
mod maps;
mod odd_input;
mod office;
mod queries;
mod random_ways;
mod traps;
mod variants;
