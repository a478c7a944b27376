//! Map builders of Rumbo.
