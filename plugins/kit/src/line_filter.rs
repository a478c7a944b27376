//! One Kalman filter for the robot and the walls around it: wheels and steering at a fast rate, lines of laser scans at a
//! slow one.
//!
//! Mora, Armesto, Tornero, *Sistema de navegación de robots móviles en entornos industriales*, sections 2.1 to 2.7. Beyond
//! the source: midpoint step, arctangent of the steering angle, walls whose normal points from where the robot saw them
//! into the wall, a map frame that the first scan defines, a test for slipping wheels, Joseph's form.
//!
//! The state is `[x, y, theta, v, omega, rho_1, phi_1, ...]`. With n walls, of which m/2 are seen, one scan costs
//! O(n + pairs within the gates) to associate, O(m² n + m³) for the gain and O(m n²) for the covariance, which is dense; a
//! prediction O(n). With a known map the covariance of the walls never changes, and a scan costs O(m n).

mod association;
mod clock;
mod consistency;
mod covariance;
mod filter;
mod growth;
mod joint;
mod mapping;
mod merging;
mod motion;
mod noise_params;
mod odometer_errors;
mod odometer_noise;
mod odometer_params;
mod params;
mod running;
mod saved;
mod schedule;
mod sighting;
mod state;
mod steering;
mod tentative;
mod tracker;
mod update;
mod wall;
mod wheel_readings;
mod wheels;

#[cfg(test)]
mod tests;

pub use association::{Gates, Match};
pub use clock::{Clock, Instant, Source, Steps};
pub use consistency::{Consistency, NisBand};
pub use covariance::Covariance;
pub use filter::{LineFilter, MapUse, Reading, ScanReport, WallMap};
pub use growth::Growth;
pub use motion::{Integration, MotionModel};
pub use noise_params::{OdometerNoiseParams, SensorNoiseParams};
pub use odometer_errors::{OdometerError, OdometerModel, reading, truth};
pub use odometer_noise::OdometerNoise;
pub use odometer_params::OdometerErrorParams;
pub use params::{ExtractionParams, KeyFault, PeriodParams, SharedParams};
pub use running::LeftOut;
pub use saved::{SavedFault, SavedFilter};
pub use schedule::{Schedule, ScheduleFault};
pub use sighting::{Mount, PredictedLine, placed};
pub use state::{ROBOT, State};
pub use steering::{Steering, SteeringModel};
pub use tracker::{LineTracker, TrackFault, TrackerSettings};
pub use update::{NotPositiveDefinite, Row, Update};
pub use wall::Wall;
pub use wheels::Wheels;

/// All that can be set.
#[derive(Debug, Clone, PartialEq)]
pub struct FilterSettings {
    /// How the robot may move.
    pub motion: MotionModel,
    /// The axle with the encoders.
    pub wheels: Wheels,
    /// What wheels and odometers do wrong all the time.
    pub odometer: OdometerModel,
    /// The steered wheel.
    pub steering: Steering,
    /// When a line is a wall of the map.
    pub gates: Gates,
    /// When a line becomes a wall of the map.
    pub growth: Growth,
}

impl Default for FilterSettings {
    /// The forklift of the experiment.
    fn default() -> Self {
        FilterSettings {
            motion: MotionModel::default(),
            wheels: Wheels::default(),
            odometer: OdometerModel::default(),
            steering: Steering::default(),
            gates: Gates::default(),
            growth: Growth::default(),
        }
    }
}
