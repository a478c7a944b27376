//! Plugins through the binary boundary: ours, other people's, and broken ones.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, unsafe_code, missing_docs)]

mod alone;
mod broken;
mod compiler;
mod cpp;
mod first_abi;
mod growth;
mod header;
mod kinect_live;
mod misbehaving;
mod nested;
mod runs;
mod rust_fixture;
mod same_answers;
mod text_world;
mod third_party_c;
mod third_party_rust;
