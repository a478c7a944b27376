//! Planners of Rumbo.
