//! Parameters of the particle filter.

use super::filter::FilterSettings;
use super::kld::KldBound;
use super::measurement::{FieldModel, MeasurementModel};
use super::motion::{MotionModel, OdometryMotion};
use super::sureness::SurenessRules;
use super::terrain::Penalties;
use super::tracker_settings::TrackerSettings;
use rumbo_core::registry::Params;
use rumbo_core::robot::Robot;
use rumbo_core::stages::BuildError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Monte-Carlo localization on a grid map: many guesses of the pose move with the odometer and are weighed by scans. It
/// finds a robot that may be anywhere, follows it, and finds it again after it was carried away.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ParticleFilterParams {
    /// Fewest particles.
    pub min_particles: usize,
    /// Most particles; a robot that may be anywhere starts with four times as many guesses. Some 20 particles for each
    /// square meter of free floor find it surely.
    pub max_particles: usize,
    /// The number of particles follows the spread of the belief (KLD-sampling); else it stays.
    pub adaptive: bool,
    /// Largest distance between the belief and its histogram, nats (epsilon of KLD-sampling).
    pub kld_epsilon: f64,
    /// Probability that this distance is exceeded (delta of KLD-sampling: a probability, not its quantile).
    pub kld_delta: f64,
    /// The filter is updated after this much way, meters.
    pub update_min_d_m: f64,
    /// Or after this much turn, radians.
    pub update_min_a_rad: f64,
    /// How motion differs from what the odometer says: `{ model = "odometry", alpha = [0.2, 0.2, 0.2, 0.2] }` (turn by
    /// turn, turn by way, way by way, way by turn; variances) or `{ model = "omni", alpha = [...] }` with a fifth
    /// number, side by way.
    #[schemars(schema_with = "model_schema")]
    pub motion: Box<dyn MotionModel>,
    /// How readings differ from the map: `{ model = "likelihood_field", likelihood_max_dist_m = 2.0, sigma_hit_m = 0.2,
    /// z_hit = 0.95, z_rand = 0.05, z_max_range_m = 30.0 }`, or `{ model = "beam", z_hit = 0.8, z_short = 0.1,
    /// z_max = 0.05, z_rand = 0.05, sigma_hit_m = 0.2, lambda_short_per_m = 0.5, z_max_range_m = 30.0 }`.
    #[schemars(schema_with = "model_schema")]
    pub measurement: Box<dyn MeasurementModel>,
    /// Beams of a scan that are looked at.
    pub max_beams: usize,
    /// Power of the likelihood, since neighboring beams are not independent: 1 believes every beam.
    pub likelihood_exponent: f64,
    /// One update leaves at least this effective share of the particles: while guesses lie far apart, one scan must not
    /// rule out all but a lucky few. 0 turns this off.
    pub least_effective_share: f64,
    /// Share of particles that take the odometer for wrong about the way since the last update: wheels slip, and some
    /// odometers count backward motion forward.
    pub slip_share: f64,
    /// Draw new particles when the effective share of them falls below this.
    pub resample_threshold: f64,
    /// At most every so many updates.
    pub resample_interval: u32,
    /// How fast the long average of the fit follows, share for each update. Both 0 turn the recovery off.
    pub alpha_slow: f64,
    /// How fast the short average follows.
    pub alpha_fast: f64,
    /// Particles that may be anywhere keep this distance from obstacles, meters.
    pub init_clearance_m: f64,
    /// While the robot is followed, a beam that ends on free floor farther than this from everything on the map is taken
    /// for a person or a thing that the map does not show, and not weighed, meters. 0 weighs all.
    pub unmapped_beyond_m: f64,
    /// What a particle in a cell that nobody has seen loses in log-weight.
    pub unknown_penalty: f64,
    /// Two readings of the odometer farther apart than this, beyond what the robot can drive in between, are a jump,
    /// meters: the particles are scattered by this deviation instead of moved.
    pub max_odom_jump_m: f64,
    /// While the best place explains less than this share of the beams, some particles are scattered over the map to
    /// search for a better one. 0 turns this off.
    pub search_below: f64,
    /// While the robot is followed and at most this share of its beams would have to pass through walls, nothing is
    /// searched: beams that end early are taken for people and things that the map does not show.
    pub doubt_above: f64,
    /// A place that explains less than this share of the beams does not fit.
    pub least_explained: f64,
    /// So many updates in a row with one tight cluster, and a robot that could be anywhere counts as found.
    pub found_after_updates: u32,
    /// So many updates in a row with a place that does not fit, and the robot is lost.
    pub lost_after_updates: u32,
    /// Ask the robot to turn and drive a little while it does not know where it is. Never on a recording.
    pub wish: bool,
}

impl Default for ParticleFilterParams {
    fn default() -> Self {
        ParticleFilterParams {
            min_particles: 200,
            max_particles: 5000,
            adaptive: true,
            kld_epsilon: 0.02,
            kld_delta: 0.01,
            update_min_d_m: 0.2,
            update_min_a_rad: 0.2,
            motion: Box::new(OdometryMotion::default()),
            measurement: Box::new(FieldModel::default()),
            max_beams: 60,
            likelihood_exponent: 0.3,
            least_effective_share: 0.01,
            slip_share: 0.05,
            resample_threshold: 0.5,
            resample_interval: 1,
            alpha_slow: 0.05,
            alpha_fast: 0.5,
            init_clearance_m: 0.2,
            unmapped_beyond_m: 0.2,
            unknown_penalty: 5.0,
            max_odom_jump_m: 1.0,
            search_below: 0.8,
            doubt_above: 0.1,
            least_explained: 0.3,
            found_after_updates: 5,
            lost_after_updates: 10,
            wish: true,
        }
    }
}

/// Models are open families: their names and keys are known to the program that links them.
fn model_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
    schemars::json_schema!({
        "type": "object",
        "properties": { "model": { "type": "string" } },
        "required": ["model"]
    })
}

/// More particles than this do not fit into memory together with everything else.
const MOST_PARTICLES: usize = 10_000_000;

/// An occupied cell costs a particle this much log-weight: next to impossible, but not out of the world.
const OCCUPIED_PENALTY: f64 = 50.0;

impl Params for ParticleFilterParams {
    fn check(&self) -> Vec<BuildError> {
        let mut faults = Vec::new();
        let mut expect = |fine: bool, key: &str, value: &dyn std::fmt::Display, expected: &str| {
            if !fine {
                faults.push(BuildError::at(key, format!("is {value}, expected {expected}")));
            }
        };
        expect(self.min_particles >= 1, "min_particles", &self.min_particles, "1 or more");
        let most = self.max_particles;
        let most_fits = most >= self.min_particles && most <= MOST_PARTICLES;
        expect(most_fits, "max_particles", &most, "min_particles or more, and at most 10000000");
        expect(self.max_beams >= 1, "max_beams", &self.max_beams, "1 or more");
        let positive = |value: f64| value > 0.0 && value.is_finite();
        let not_negative = |value: f64| value >= 0.0 && value.is_finite();
        for (key, value) in [
            ("kld_epsilon", self.kld_epsilon),
            ("update_min_d_m", self.update_min_d_m),
            ("update_min_a_rad", self.update_min_a_rad),
            ("likelihood_exponent", self.likelihood_exponent),
            ("max_odom_jump_m", self.max_odom_jump_m),
        ] {
            expect(positive(value), key, &value, "a finite number above 0");
        }
        for (key, value) in [
            ("init_clearance_m", self.init_clearance_m),
            ("unmapped_beyond_m", self.unmapped_beyond_m),
            ("unknown_penalty", self.unknown_penalty),
        ] {
            expect(not_negative(value), key, &value, "a finite number, 0 or more");
        }
        let delta_fits = self.kld_delta > 0.0 && self.kld_delta < 1.0;
        expect(delta_fits, "kld_delta", &self.kld_delta, "a probability between 0 and 1, without both");
        for (key, value) in [
            ("least_effective_share", self.least_effective_share),
            ("slip_share", self.slip_share),
            ("resample_threshold", self.resample_threshold),
            ("search_below", self.search_below),
            ("doubt_above", self.doubt_above),
            ("least_explained", self.least_explained),
        ] {
            expect((0.0..=1.0).contains(&value), key, &value, "a share from 0 to 1");
        }
        expect(self.found_after_updates >= 1, "found_after_updates", &self.found_after_updates, "1 or more");
        expect(self.lost_after_updates >= 1, "lost_after_updates", &self.lost_after_updates, "1 or more");
        faults.extend(self.recovery_faults());
        let at = |family: &'static str| {
            move |(key, message): (&str, String)| BuildError::at(format!("{family}.{key}"), message)
        };
        faults.extend(self.motion.faults().into_iter().map(at("motion")));
        faults.extend(self.measurement.faults().into_iter().map(at("measurement")));
        faults
    }
}

impl ParticleFilterParams {
    fn recovery_faults(&self) -> Option<BuildError> {
        let (slow, fast) = (self.alpha_slow, self.alpha_fast);
        let is_share = |value: f64| (0.0..=1.0).contains(&value);
        if !is_share(slow) {
            return Some(BuildError::at("alpha_slow", format!("is {slow}, expected a share from 0 to 1")));
        }
        if !is_share(fast) {
            return Some(BuildError::at("alpha_fast", format!("is {fast}, expected a share from 0 to 1")));
        }
        let message = format!("is {slow}, expected less than alpha_fast, which is {fast}, or both 0");
        let is_off = slow == 0.0 && fast == 0.0;
        (slow >= fast && !is_off).then(|| BuildError::at("alpha_slow", message))
    }

    /// The filter's numbers; none when `kld_delta` is no probability.
    pub(super) fn filter_settings(&self) -> Option<FilterSettings> {
        let (least, most) = (self.min_particles, self.max_particles);
        Some(FilterSettings {
            bound: KldBound::new(self.kld_epsilon, self.kld_delta, least, most)?,
            is_adaptive: self.adaptive,
            likelihood_exponent: self.likelihood_exponent,
            least_effective_share: self.least_effective_share,
            slip_share: self.slip_share,
            resample_threshold: self.resample_threshold,
            resample_interval: self.resample_interval,
        })
    }

    /// The numbers around the filter, for this robot.
    pub(super) fn tracker_settings(&self, robot: &Robot, is_recorded: bool) -> TrackerSettings {
        TrackerSettings {
            update_min_d_m: self.update_min_d_m,
            update_min_a_rad: self.update_min_a_rad,
            max_beams: self.max_beams,
            init_clearance_m: self.init_clearance_m,
            unmapped_beyond_m: self.unmapped_beyond_m,
            max_odom_jump_m: self.max_odom_jump_m,
            penalties: Penalties { occupied: OCCUPIED_PENALTY, unknown: self.unknown_penalty },
            search_below: self.search_below,
            doubt_above: self.doubt_above,
            rules: SurenessRules {
                least_explained: self.least_explained,
                found_after_updates: self.found_after_updates,
                lost_after_updates: self.lost_after_updates,
            },
            may_wish: self.wish && !is_recorded,
            radius_m: robot.radius_m,
            max_speed: [robot.max_speed_m_s, robot.max_turn_rad_s()],
        }
    }
}
