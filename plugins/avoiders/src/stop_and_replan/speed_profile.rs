//! Three speeds, up at the start of a movement and down again before its end (Hernández Alamilla 2005, figures 6.2
//! and 6.3), so that the robot never starts or stops abruptly.

/// Speeds of a movement by its progress; the same for meters and for radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeedProfile {
    /// Least, medium and greatest speed, units per second.
    pub levels: [f64; 3],
    /// Progress after which (and way to go before which) the medium and the greatest speed begin, units.
    pub ramps: [f64; 2],
}

impl SpeedProfile {
    /// The same profile for a robot that is not faster than this.
    pub fn capped(self, fastest: f64) -> SpeedProfile {
        SpeedProfile { levels: self.levels.map(|level| level.min(fastest)), ..self }
    }

    /// The speed after `progress` of a movement of length `length`.
    pub fn speed(&self, progress: f64, length: f64) -> f64 {
        let from_nearer_end = progress.min(length - progress);
        if from_nearer_end < self.ramps[0] {
            self.levels[0]
        } else if from_nearer_end < self.ramps[1] {
            self.levels[1]
        } else {
            self.levels[2]
        }
    }
}
