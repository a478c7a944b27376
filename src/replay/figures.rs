//! How far a replay went from its recording, in numbers.

use rumbo_kit::recording::{Said, estimated_place, read_event, read_path};
use serde::Serialize;
use std::collections::BTreeMap;

use super::difference::Message;

/// How far a replay went from its recording.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Figures {
    /// Estimates at the same time that were compared.
    pub n_estimates: u64,
    /// Mean distance of those estimates, meters.
    pub position_difference_mean_m: f64,
    /// Largest distance of those estimates, meters.
    pub position_difference_max_m: f64,
    /// Length of the first path, meters: recorded, replayed.
    pub first_path_m: [Option<f64>; 2],
    /// Paths: recorded, replayed.
    pub n_paths: [u64; 2],
    /// Events by their kind: recorded, replayed.
    pub events: BTreeMap<String, [u64; 2]>,
    #[serde(skip)]
    sum_m: f64,
}

impl Figures {
    /// Counts the messages of one moment.
    pub fn count(&mut self, recorded: &[Message], replayed: &[Message]) {
        for (side, messages) in [recorded, replayed].into_iter().enumerate() {
            messages.iter().for_each(|message| self.count_one(side, message));
        }
        let place = |messages: &[Message]| {
            let estimate = messages.iter().find(|message| message.said == Said::Estimate)?;
            estimated_place(&estimate.bytes).ok()
        };
        if let (Some(first), Some(second)) = (place(recorded), place(replayed)) {
            let distance_m = (first.translation.vector - second.translation.vector).norm();
            self.n_estimates += 1;
            self.sum_m += distance_m;
            self.position_difference_mean_m = self.sum_m / self.n_estimates as f64;
            self.position_difference_max_m = self.position_difference_max_m.max(distance_m);
        }
    }

    fn count_one(&mut self, side: usize, message: &Message) {
        match message.said {
            Said::Path => {
                self.n_paths[side] += 1;
                let length = read_path(&message.bytes).ok().flatten().map(|path| path.length_m());
                self.first_path_m[side] = self.first_path_m[side].or(length);
            }
            Said::Event => {
                let kind = read_event(&message.bytes).map(|event| event.kind).unwrap_or_default();
                self.events.entry(kind).or_default()[side] += 1;
            }
            _ => {}
        }
    }
}
