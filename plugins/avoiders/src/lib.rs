//! Avoiders of Rumbo.
