//! Facts of the device: variants, rates, units, error.
//!
//! Source: SICK, *LMS 200/211/221/291 Laser Measurement Systems*, technical description; the error of ±15 mm is the one
//! Hernández Alamilla (2005) gives for the LMS 200-30106.

use rand_distr::{Distribution, StandardNormal};
use rumbo_core::rng::Rng;
use serde::{Deserialize, Serialize};

use super::protocol::{CountUnit, Variant};
use crate::laser_2d::scanner::ScanShape;

/// Turns of the mirror in a second; each turn gives one scan of 1 degree steps.
const MIRROR_HZ: f64 = 75.0;
/// Largest distance a 13-bit value carries: codes from 0x1FF7 on mean something else.
const LARGEST_CODE: f64 = 8182.0;
/// The device is blind nearer than this.
const MIN_RANGE_M: f64 = 0.02;
/// No reading in millimeters is farther off than this.
const ERROR_BOUND_M: f64 = 0.015;
/// The bound taken as two standard deviations.
const ERROR_DEVIATION_M: f64 = ERROR_BOUND_M / 2.0;

/// Unit of the device's distance words.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, schemars::JsonSchema)]
pub enum Lms200Unit {
    /// Millimeters: reach 8.182 m.
    #[default]
    #[serde(rename = "mm")]
    Millimeters,
    /// Centimeters: reach 81.82 m.
    #[serde(rename = "cm")]
    Centimeters,
}

impl Lms200Unit {
    /// Meters of one count.
    pub fn step_m(self) -> f64 {
        match self {
            Self::Millimeters => 0.001,
            Self::Centimeters => 0.01,
        }
    }

    /// As telegrams say it.
    pub fn count_unit(self) -> CountUnit {
        match self {
            Self::Millimeters => CountUnit::Millimeters,
            Self::Centimeters => CountUnit::Centimeters,
        }
    }

    /// The distance in whole counts: what the device can say.
    pub fn counted(self, range_m: f64) -> f64 {
        let per_meter = match self {
            Self::Millimeters => 1000.0,
            Self::Centimeters => 100.0,
        };
        // Ranges are not negative but for noise at the transducer, and then the count is 0.
        f64::from((range_m * per_meter + 0.5) as u32) / per_meter
    }

    /// Farthest distance that can be said.
    pub fn reach_m(self) -> f64 {
        LARGEST_CODE * self.step_m()
    }
}

/// One of the device's variants.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Lms200Mode {
    /// 100 or 180.
    field_of_view_deg: u32,
    /// 100, 50 or 25 hundredths of a degree.
    resolution_centideg: u32,
}

impl Lms200Mode {
    /// The variant with this field of view and resolution, if the device can do it.
    pub fn new(field_of_view_deg: f64, resolution_deg: f64) -> Option<Self> {
        let field_of_view_deg =
            [100, 180].into_iter().find(|known| f64::from(*known) == field_of_view_deg)?;
        let resolution_centideg =
            [100, 50, 25].into_iter().find(|known| f64::from(*known) == resolution_deg * 100.0)?;
        Some(Self { field_of_view_deg, resolution_centideg })
    }

    /// Four partial scans of 1 degree steps, each a quarter degree further: the only way to 0.25 degrees over 180.
    pub fn is_partial(self) -> bool {
        (self.field_of_view_deg, self.resolution_centideg) == (180, 25)
    }

    /// What the device is switched to: partial scans have steps of 1 degree.
    pub fn variant(self) -> Variant {
        let resolution_centideg = if self.is_partial() { 100 } else { self.resolution_centideg as u16 };
        Variant { field_deg: self.field_of_view_deg as u16, resolution_centideg }
    }

    /// Scans in a second at the device's own pace; partial scans each count.
    pub fn rate_hz(self) -> f64 {
        if self.is_partial() { MIRROR_HZ } else { MIRROR_HZ * f64::from(self.resolution_centideg) / 100.0 }
    }

    /// How many different scans follow each other.
    pub fn n_partials(self) -> usize {
        if self.is_partial() { 4 } else { 1 }
    }

    /// Geometry of the partial scan of this number, or of the whole scan for number 0 of a variant without partials.
    pub(crate) fn shape(self, partial: usize, unit: Lms200Unit) -> ScanShape {
        let step_deg = if self.is_partial() { 1.0 } else { f64::from(self.resolution_centideg) / 100.0 };
        let field_deg = f64::from(self.field_of_view_deg);
        // A shifted partial scan has no room for the last beam.
        let n_beams = (field_deg / step_deg) as usize + usize::from(partial == 0);
        ScanShape {
            first_bearing_rad: (0.25 * partial as f64 - field_deg / 2.0).to_radians(),
            bearing_step_rad: step_deg.to_radians(),
            n_beams,
            min_range_m: MIN_RANGE_M,
            max_range_m: unit.reach_m(),
        }
    }
}

/// A reading of an exact range: an error within ±15 mm, then whole counts.
pub fn read(exact_m: f64, unit: Lms200Unit, rng: &mut Rng) -> f64 {
    unit.counted(exact_m + error_m(rng))
}

/// An error of the device, within ±15 mm.
pub fn error_m(rng: &mut Rng) -> f64 {
    loop {
        let normal: f64 = StandardNormal.sample(rng);
        if normal.abs() * ERROR_DEVIATION_M <= ERROR_BOUND_M {
            return normal * ERROR_DEVIATION_M;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variants_have_the_counts_and_rates_of_the_device_table() {
        for (field_deg, resolution_deg, n_beams, rate_hz) in [
            (100.0, 1.0, 101, 75.0),
            (100.0, 0.5, 201, 37.5),
            (100.0, 0.25, 401, 18.75),
            (180.0, 1.0, 181, 75.0),
            (180.0, 0.5, 361, 37.5),
        ] {
            let mode = Lms200Mode::new(field_deg, resolution_deg).unwrap();
            let shape = mode.shape(0, Lms200Unit::Millimeters);
            assert_eq!((shape.n_beams, mode.rate_hz(), mode.n_partials()), (n_beams, rate_hz, 1));
            let last_rad = shape.first_bearing_rad + shape.bearing_step_rad * (n_beams - 1) as f64;
            assert!((shape.first_bearing_rad + (field_deg / 2.0).to_radians()).abs() < 1e-12);
            assert!((last_rad - (field_deg / 2.0).to_radians()).abs() < 1e-12);
        }
        for (field_deg, resolution_deg) in [(90.0, 1.0), (180.0, 0.2), (180.0, f64::NAN), (360.0, 1.0)] {
            assert_eq!(Lms200Mode::new(field_deg, resolution_deg), None);
        }
    }

    /// 721 different bearings, a quarter degree apart, come in four scans of 181, 180, 180 and 180 values.
    #[test]
    fn four_partial_scans_interlace_to_a_quarter_degree_over_180() {
        let mode = Lms200Mode::new(180.0, 0.25).unwrap();
        assert_eq!((mode.rate_hz(), mode.n_partials()), (75.0, 4));
        let mut bearings_deg: Vec<f64> = (0..4)
            .map(|partial| mode.shape(partial, Lms200Unit::Millimeters))
            .flat_map(|s| {
                (0..s.n_beams)
                    .map(move |i| (s.first_bearing_rad + s.bearing_step_rad * i as f64).to_degrees())
            })
            .collect();
        bearings_deg.sort_by(f64::total_cmp);
        assert_eq!(bearings_deg.len(), 721);
        for (idx, bearing_deg) in bearings_deg.iter().enumerate() {
            assert!((bearing_deg - (-90.0 + 0.25 * idx as f64)).abs() < 1e-9);
        }
    }

    #[test]
    fn readings_are_whole_counts_within_15_mm() {
        let mut rng = rumbo_core::rng::stream(2, "lms200");
        let readings: Vec<f64> =
            (0..20_000).map(|_| read(3.0004, Lms200Unit::Millimeters, &mut rng)).collect();
        for reading in &readings {
            assert!((reading * 1000.0 - (reading * 1000.0).round()).abs() < 1e-9);
            assert!((reading - 3.0004).abs() <= 0.0155);
        }
        let mean = readings.iter().sum::<f64>() / 20_000.0;
        // Deviation of a normal cut at two deviations: 0.8796 of it.
        let spread = (readings.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / 20_000.0).sqrt();
        assert!((mean - 3.0004).abs() < 5.0 * 0.0066 / 20_000f64.sqrt(), "{mean}");
        assert!((spread / (0.8796 * 0.0075) - 1.0).abs() < 0.03, "{spread}");
        let coarse = read(7.004, Lms200Unit::Centimeters, &mut rng);
        assert!((coarse * 100.0 - (coarse * 100.0).round()).abs() < 1e-9);
    }
}
