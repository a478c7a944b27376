//! `steering_encoder`: the angle of a tricycle's steered wheel.

mod params;
mod plugin;

pub use params::SteeringEncoderParams;
