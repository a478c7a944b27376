//! What several Rumbo plugins share: ray casting, distance fields, grid search.
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

pub mod map_file;
pub mod world_file;
