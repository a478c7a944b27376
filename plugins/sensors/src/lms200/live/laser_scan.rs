//! Values of the device into ranges of the framework.

use rumbo_core::boundary::Buffer;
use rumbo_core::messages::{LaserScan, Observations};

use crate::lms200::device::{Lms200Mode, Lms200Unit};
use crate::lms200::driver::DeviceScan;
use crate::lms200::protocol::{MeasuringMode, Reading};

/// What is needed to understand values.
#[derive(Debug, Clone, Copy)]
pub(in crate::lms200) struct Interpretation {
    pub mode: Lms200Mode,
    pub unit: Lms200Unit,
    pub measuring_mode: MeasuringMode,
    /// The device hangs upside down, so its values run from left to right.
    pub is_inverted: bool,
}

impl Interpretation {
    /// REP-117: infinite when nothing is within reach, not-a-number for every other code without a distance. Levels of
    /// reflectors are intensities.
    pub fn laser_scan(&self, scan: &DeviceScan, out: &mut Observations) -> LaserScan {
        let words = &scan.measured.words;
        let shape = self.mode.shape(usize::from(scan.measured.partial.unwrap_or(0)), self.unit);
        let step_m = self.unit.step_m();
        let mut ranges_m = out.buffer(words.len());
        self.fill(ranges_m.make_mut(), words, |word| match self.measuring_mode.reading(word) {
            Reading::Count(count) => {
                let range_m = f64::from(count) * step_m;
                if range_m < shape.min_range_m { f32::NAN } else { range_m as f32 }
            }
            Reading::NothingWithinReach => f32::INFINITY,
            _ => f32::NAN,
        });
        let intensities = if self.measuring_mode.has_reflector_level() {
            let mut levels = out.buffer(words.len());
            self.fill(levels.make_mut(), words, |word| f32::from(self.measuring_mode.flags(word)));
            levels
        } else {
            Buffer::empty()
        };
        let last_rad = shape.first_bearing_rad + shape.bearing_step_rad * (words.len().max(1) - 1) as f64;
        LaserScan {
            first_bearing_rad: if self.is_inverted { -last_rad } else { shape.first_bearing_rad },
            bearing_step_rad: shape.bearing_step_rad,
            // Values of finer scans are interlaced from several turns: no beam is later than all before it. The stamp is
            // the middle of the measurement.
            sweep_s: 0.0,
            min_range_m: shape.min_range_m as f32,
            max_range_m: (f64::from(self.measuring_mode.largest_count()) * step_m) as f32,
            ranges_m,
            intensities,
        }
    }

    fn fill(&self, to: &mut [f32], words: &[u16], of: impl Fn(u16) -> f32) {
        let values = words.iter().map(|word| of(*word));
        if self.is_inverted {
            to.iter_mut().rev().zip(values).for_each(|(to, value)| *to = value);
        } else {
            to.iter_mut().zip(values).for_each(|(to, value)| *to = value);
        }
    }
}
