//! `fictitious_charges`: down the artificial potential, and out of local minima by charges that stand for nothing.

mod params;
pub mod plugin;

pub use params::{ChargeForceKind, ChargeParams, ChargePlacement, ChargeSide, FictitiousChargesParams};
