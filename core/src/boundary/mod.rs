//! What will cross the binary plugin boundary: plain C layouts, and the only `unsafe` code of this crate.

mod buffer;

pub use buffer::{Buffer, BufferPool, Plain};
