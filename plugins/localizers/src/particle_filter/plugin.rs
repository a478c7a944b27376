//! The particle filter as a localizer.

use super::filter::ParticleFilter;
use super::monte_carlo::MonteCarlo;
use super::params::ParticleFilterParams;
use super::recovery::Recovery;
use super::streams::Streams;
use rumbo_core::frames::Point2;
use rumbo_core::map::{Layer, Map};
use rumbo_core::messages::{Estimate, ObservationKind, Prior, Seen};
use rumbo_core::registry::{Manifest, Plugin};
use rumbo_core::stages::{BuildContext, BuildError, Cx, LocalizeError, Localizer};
use rumbo_core::trace::Drawing;

/// Particles that are drawn at most.
const DRAWN: usize = 2000;

impl Localizer for MonteCarlo {
    fn start(&mut self, prior: &Prior, map: &Map) -> Result<(), LocalizeError> {
        MonteCarlo::start(self, prior, map)
    }

    fn update(&mut self, cx: &mut Cx<'_>, seen: Seen<'_>, map: &Map) -> Result<Estimate, LocalizeError> {
        let estimate = MonteCarlo::update(self, cx.now, seen, map)?;
        if cx.trace.is_counting() {
            show(self, cx);
        }
        Ok(estimate)
    }
}

fn show(tracker: &MonteCarlo, cx: &Cx<'_>) {
    let (particles, counters) = (tracker.filter().particles(), tracker.counters());
    cx.trace.count("particles", particles.len() as f64);
    cx.trace.count("updates", counters.updates as f64);
    cx.trace.count("scans dropped", tracker.scans_dropped() as f64);
    cx.trace.count("odometry dropped", counters.odometry_dropped as f64);
    cx.trace.count("odometry jumps", counters.odometry_jumps as f64);
    cx.trace.count("updates without beams", counters.without_beams as f64);
    cx.trace.count("updates without weight", counters.degenerate as f64);
    if let Some(share) = tracker.explained() {
        cx.trace.count("share of beams explained", share);
    }
    if let Some([slow, fast]) = tracker.filter().recovery().averages() {
        cx.trace.count("fit, long average", slow);
        cx.trace.count("fit, short average", fast);
    }
    cx.trace.draw(|| {
        let step = particles.len().div_ceil(DRAWN).max(1);
        let points = particles.iter().step_by(step).map(|[x, y, _]| Point2::new(x, y)).collect();
        Drawing::Points { name: "particles", points }
    });
}

impl Plugin<dyn Localizer> for ParticleFilterParams {
    fn manifest(&self) -> Manifest {
        Manifest {
            needs_layers: vec![Layer::Grid],
            consumes: vec![vec![ObservationKind::LaserScan], vec![ObservationKind::Odometry]],
            wishes_motion: self.wish,
            ..Manifest::default()
        }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Localizer>, BuildError> {
        let no_probability = || BuildError::at("kld_delta", "is no probability");
        let filter = ParticleFilter::new(
            self.filter_settings().ok_or_else(no_probability)?,
            self.motion.clone(),
            Recovery::new(self.alpha_slow, self.alpha_fast),
            Streams::new(context.rng()),
        );
        let settings = self.tracker_settings(&context.robot, context.world_recording.is_some());
        Ok(Box::new(MonteCarlo::new(settings, self.measurement.clone(), filter)))
    }
}

rumbo_core::register_localizer!(
    ParticleFilterParams,
    "particle_filter",
    "Monte-Carlo localization on a grid map: finds, follows and recovers a robot with many weighed guesses"
);
