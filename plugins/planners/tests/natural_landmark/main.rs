//! The `dp` planner against the published example and the reference figures of its source, Hernández Alamilla (2005).
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod example;
mod maps;
mod source_grid;
