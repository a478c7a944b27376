//! The binary plugin boundary, and the only `unsafe` code of this crate.
//!
//! A library exports one C function, which returns a record of its entries ([`abi`]). The host side ([`host`]) turns
//! them into registry entries and stages like any other; the plugin side ([`export`]) turns registered Rust plugins into
//! such a record. Only plain C layouts cross: views with lengths, the shared [`Buffer`], status codes with messages.

pub mod abi;
mod buffer;
mod convert;
pub mod export;
pub mod host;
mod says_other;
mod status;
mod words;

pub use buffer::{Buffer, BufferPool, Plain};
