//! Localizers of Rumbo.
