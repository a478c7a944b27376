//! Plugins through the binary boundary: ours, other people's, and broken ones.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, unsafe_code, missing_docs)]

mod compiler;
mod header;
mod nested;
mod rust_fixture;
mod same_answers;
mod third_party_rust;
