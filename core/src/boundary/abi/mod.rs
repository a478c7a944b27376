//! The plugin ABI, major 1: every type and function that crosses between the host and a plugin's library.
//!
//! Names are those of `rumbo_plugin.h`, which is generated from these files. Leaf structs without a `size` (poses,
//! points, strings, arrays) never change in this major. Every other struct starts with its `size` and only grows at its
//! end: whoever reads a field first checks that the writer's `size` reaches it, and no such struct lies inside of another
//! or in an array without a stride. Pointers in an input are valid until the call returns, unless something else is said.
#![allow(non_camel_case_types)]

mod basic;
mod host;
mod inputs;
mod map;
mod module;
mod observation;
mod tables;

pub use basic::*;
pub use host::*;
pub use inputs::*;
pub use map::*;
pub use module::*;
pub use observation::*;
pub use tables::*;
