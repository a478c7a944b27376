//! The filter's parts against brute force, and the whole in a loop of rubble.

mod closing;
mod faults;
mod hall;
mod lineages;
mod loops;
mod proposals;
mod wheels;
