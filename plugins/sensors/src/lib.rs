//! Sensors of Rumbo.
