//! One recorded channel: what has become due, and what was handed out last.

use std::collections::VecDeque;

use rumbo_core::boundary::Buffer;
use rumbo_core::messages::{Data, Observation};

/// One recorded channel.
#[derive(Debug, Default)]
pub(super) struct Channel {
    due: VecDeque<Observation>,
    given: Vec<Observation>,
    /// How many observations it had so far.
    pub n_seen: u64,
}

impl Channel {
    /// A channel that nobody asks for keeps its newest so many observations.
    const MOST_DUE: usize = 1024;

    /// An observation becomes due; the oldest goes where nobody asks.
    pub fn push(&mut self, observation: Observation) {
        self.n_seen += 1;
        if self.due.len() >= Self::MOST_DUE {
            self.due.pop_front();
        }
        self.due.push_back(observation);
    }

    /// Everything since the last time, oldest first. The ranges handed out before go to `back`.
    pub fn take(&mut self, back: &mut Lent) -> &[Observation] {
        for observation in self.given.drain(..) {
            if let Data::LaserScan(scan) = observation.data {
                back.keep(scan.ranges_m);
            }
        }
        self.given.extend(self.due.drain(..));
        &self.given
    }
}

/// Ranges that were handed out: others may still hold them for a step or two.
#[derive(Debug, Default)]
pub(super) struct Lent {
    buffers: VecDeque<Buffer<f32>>,
}

impl Lent {
    const MOST: usize = 64;

    fn keep(&mut self, buffer: Buffer<f32>) {
        if self.buffers.len() >= Self::MOST {
            self.buffers.pop_front();
        }
        self.buffers.push_back(buffer);
    }

    /// The oldest, once nobody else holds it.
    pub fn free(&mut self) -> Option<Buffer<f32>> {
        if self.buffers.front()?.is_unique() { self.buffers.pop_front() } else { None }
    }
}
