//! Sensors that gave nothing during a whole run: a recording without their channel, a device that was never there.

use rumbo_core::engine::{Observer, StepView};
use rumbo_core::pipeline::Pipeline;
use rumbo_core::time::Span;

/// Watches which sensors have given something.
pub struct Silent {
    names: Vec<String>,
    has_given: Vec<bool>,
    lasted: Span,
}

impl Silent {
    /// A shorter run says nothing of its sensors, seconds.
    const LEAST_S: f64 = 1.0;

    /// Nothing has come yet.
    pub fn of(pipeline: &Pipeline) -> Silent {
        let names: Vec<String> = pipeline.sensors.iter().map(|sensor| sensor.stage.name.clone()).collect();
        Silent { has_given: vec![false; names.len()], names, lasted: Span::ZERO }
    }

    /// Names of the sensors that have given nothing.
    pub fn names(&self) -> Vec<&str> {
        if self.lasted.as_secs() < Self::LEAST_S {
            return Vec::new();
        }
        let silent = self.names.iter().zip(&self.has_given).filter(|(_, has_given)| !**has_given);
        silent.map(|(name, _)| name.as_str()).collect()
    }
}

impl Observer for Silent {
    fn on_step(&mut self, view: &StepView<'_>) {
        self.lasted = view.now - view.started;
        for observation in view.observations {
            if let Some(has_given) = self.has_given.get_mut(usize::from(observation.sensor.0)) {
                *has_given = true;
            }
        }
    }
}
