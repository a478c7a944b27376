//! From the shade of a pixel to the occupancy of a cell.

use super::{MapMode, UNKNOWN};

/// The keys of a map file that say what a shade means.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShadeReading {
    /// How gray becomes occupancy.
    pub mode: MapMode,
    /// Whether white means occupied; without effect in [`MapMode::Raw`].
    pub negate: bool,
    /// Occupation probability above which a cell is occupied.
    pub occupied_thresh: f64,
    /// Occupation probability below which a cell is free.
    pub free_thresh: f64,
}

/// Steps of a 16-bit gray; one of an 8-bit gray is 257 of them, so that both are exact.
const WHITE: f64 = 65535.0;

impl ShadeReading {
    /// What most tools write: black is occupied, thresholds of 65 and 19.6 percent.
    pub fn usual(mode: MapMode) -> ShadeReading {
        ShadeReading { mode, negate: false, occupied_thresh: 0.65, free_thresh: 0.196 }
    }

    /// Occupancy in percent of a shade from 0 (black) to 1 (white), by the formula of `map_server` (ROS 1). In mode
    /// [`MapMode::Scale`] Nav2 spreads the shades between the thresholds over 0 to 100 rather than 1 to 99, and so
    /// reads up to one percent off.
    pub fn occupancy(&self, shade: f32) -> i8 {
        // Whole steps divide as map_server divides them, so that a shade exactly at a threshold is seen to be there.
        let steps = (f64::from(shade) * WHITE).round();
        let probability = if self.negate { steps } else { WHITE - steps } / WHITE;
        match self.mode {
            MapMode::Raw => {
                let percent = (f64::from(shade) * 255.0).round();
                if percent <= 100.0 { percent as i8 } else { UNKNOWN }
            }
            _ if probability > self.occupied_thresh => 100,
            _ if probability < self.free_thresh => 0,
            MapMode::Trinary => UNKNOWN,
            MapMode::Scale => {
                let share = (probability - self.free_thresh) / (self.occupied_thresh - self.free_thresh);
                (1.0 + 98.0 * share) as i8
            }
        }
    }
}
