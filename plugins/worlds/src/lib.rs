//! Worlds of Rumbo: the 2.5-D simulator.
