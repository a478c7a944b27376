//! Where the beams of a scan point, when the log says only how many there are.

/// What the user knows better than the log.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BeamOverride {
    /// Bearing of the first beam, radians.
    pub first_bearing_rad: Option<f64>,
    /// From one beam to the next, radians.
    pub bearing_step_rad: Option<f64>,
    /// A range of this much or more means that nothing was seen, meters.
    pub max_range_m: Option<f64>,
}

/// The geometry of one scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BeamRule {
    pub first_bearing_rad: f64,
    pub bearing_step_rad: f64,
    pub max_range_m: f64,
    /// Nobody said what the spacing is.
    pub is_guess: bool,
}

impl BeamRule {
    /// SICK lasers say 81.83 and 81.91 m for "no echo"; nothing of theirs reaches 80 m, meters.
    const MAX_RANGE_M: f64 = 80.0;

    /// The rule of old laser messages: 180 or 181 beams are one degree apart, 360 or 361 half a degree, from -90 degrees
    /// on. Dividing 180 degrees by the number of gaps, as some converters do, bends the map.
    pub fn of_count(n_beams: usize) -> BeamRule {
        let (step_deg, is_guess) = match n_beams {
            180 | 181 => (1.0, false),
            360 | 361 => (0.5, false),
            n => (180.0 / n.max(1) as f64, true),
        };
        BeamRule {
            first_bearing_rad: -std::f64::consts::FRAC_PI_2,
            bearing_step_rad: f64::to_radians(step_deg),
            max_range_m: Self::MAX_RANGE_M,
            is_guess,
        }
    }

    /// The same with what the user knows better.
    pub fn with(self, known: &BeamOverride) -> BeamRule {
        BeamRule {
            first_bearing_rad: known.first_bearing_rad.unwrap_or(self.first_bearing_rad),
            bearing_step_rad: known.bearing_step_rad.unwrap_or(self.bearing_step_rad),
            max_range_m: known.max_range_m.unwrap_or(self.max_range_m),
            is_guess: self.is_guess && known.bearing_step_rad.is_none(),
        }
    }

    /// Ranges that mean "nothing seen" become infinite (REP-117).
    pub fn open(&self, ranges_m: &mut [f32]) {
        let reach_m = self.max_range_m as f32;
        for range_m in ranges_m.iter_mut().filter(|range_m| **range_m >= reach_m) {
            *range_m = f32::INFINITY;
        }
    }
}
