//! Down an artificial potential, with or without charges: what `potential_field` and `fictitious_charges` share.
//!
//! Mora, Armesto and Tornero, "Sistema de navegación de robots móviles en entornos industriales", section 3, is "the
//! source" here; the potentials themselves are in [`rumbo_kit::potential`].

pub(crate) mod params;

pub(crate) mod planner;

mod attempts;
mod surroundings;

pub mod descent;
pub mod placement;
mod trail;

mod rounding;
pub mod straightening;

mod failure;
mod figures;
mod iso_lines;

pub use params::{AttractionForm, FieldSettings, Grouping, MapSource, StepKind};
pub(crate) use params::{check_rules, field_params};
pub use rounding::Rounded;
