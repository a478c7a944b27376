//! What the numbers of a device mean: Valverde Moreno (2015), equations (4.3) and (5.1).

use serde::{Deserialize, Serialize};

/// Largest value of 13 bits.
pub const RAW_MAX: u16 = 8191;

/// How a count becomes meters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum DepthScale {
    /// A share of the device's range: `Z = near plane + amplitude * raw / 8191`, or `* depth` for depths from 0 to 1.
    UnitRange,
    /// A thousandth of a meter.
    #[default]
    // The alias is the British spelling.
    #[serde(rename = "millimeter", alias = "millim\u{65}tre")]
    Millimeter,
}

/// The 13 bits of a pixel whose 5 upper bits are in the red and whose 8 lower bits are in the green channel. What the
/// channels say beyond that is no reading: 0.
pub fn channels_to_raw(red: u8, green: u8) -> u16 {
    let raw = 256 * u16::from(red) + u16::from(green);
    if raw <= RAW_MAX { raw } else { 0 }
}

impl DepthScale {
    /// Meters of a count, with the near plane and amplitude of `unit_range`, meters; none for 0, which is no reading, and
    /// for what 13 bits do not hold.
    pub fn raw_to_m(self, raw: u16, near_plane_m: f64, amplitude_m: f64) -> Option<f64> {
        let depth_m = match self {
            DepthScale::UnitRange => near_plane_m + amplitude_m * f64::from(raw) / f64::from(RAW_MAX),
            DepthScale::Millimeter => f64::from(raw) / 1000.0,
        };
        (raw > 0 && raw <= RAW_MAX).then_some(depth_m)
    }

    /// Meters of a row of counts; not-a-number where there is no reading or it lies beyond `max_m`. What is nearer than
    /// the near plane is kept, at the near plane: dropped, the nearest obstacles would be invisible.
    pub fn raw_to_meters(
        self,
        raw: &[u16],
        near_plane_m: f64,
        amplitude_m: f64,
        max_m: f64,
        depths_m: &mut Vec<f32>,
    ) {
        depths_m.clear();
        depths_m.extend(raw.iter().map(|raw| {
            let depth_m = self.raw_to_m(*raw, near_plane_m, amplitude_m).filter(|depth_m| *depth_m <= max_m);
            depth_m.map_or(f32::NAN, |depth_m| depth_m.max(near_plane_m) as f32)
        }));
    }

    /// Meters of a buffer of depths from 0 to 1, row by row from the top: `Z = near plane + amplitude * depth`. What lies
    /// outside of 0 to 1 is nearer than the near plane, and kept there, or no reading.
    pub fn unit_to_meters(
        depths: &[f32],
        near_plane_m: f64,
        amplitude_m: f64,
        max_m: f64,
        depths_m: &mut Vec<f32>,
    ) {
        depths_m.clear();
        depths_m.extend(depths.iter().map(|depth| {
            let depth_m = near_plane_m + amplitude_m * f64::from(*depth);
            let is_read = *depth <= 1.0 && *depth > f32::NEG_INFINITY && depth_m <= max_m;
            if is_read { depth_m.max(near_plane_m) as f32 } else { f32::NAN }
        }));
    }
}
