//! Simultaneous localization and mapping for Rumbo.
