//! What `[[sensor]] plugin = "laser_2d"` takes.

use rumbo_core::registry::Params;
use rumbo_core::stages::BuildError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::scanner::ScanShape;
use super::{GaussianNoise, ScanFaultParams, ScanNoise};

/// A planar range finder. Beams run counter-clockwise; the middle of the field of view is the mount's x axis.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Laser2dParams {
    /// Angle between the first and the last beam, degrees; 360 is a full turn without a doubled beam.
    pub field_of_view_deg: f64,
    /// From one beam to the next, degrees.
    pub step_deg: f64,
    /// Shorter ranges are no readings, meters.
    pub min_range_m: f64,
    /// Reach, meters.
    pub max_range_m: f64,
    /// How readings differ from exact ranges: `{ model = "gaussian", range_m = 0.01, range_share = 0.0,
    /// bearing_deg = 0.0, dropout = 0.0 }`.
    #[schemars(schema_with = "noise_schema")]
    pub noise: Box<dyn ScanNoise>,
    /// What befalls whole scans of a simulated device: `{ silent_from_s = 10.0, silent_for_s = 30.0, corrupt = 0.1 }`.
    pub faults: ScanFaultParams,
}

impl Default for Laser2dParams {
    fn default() -> Self {
        let noise = Box::new(GaussianNoise { range_m: 0.01, ..GaussianNoise::default() });
        Self {
            field_of_view_deg: 270.0,
            step_deg: 0.5,
            min_range_m: 0.05,
            max_range_m: 10.0,
            noise,
            faults: ScanFaultParams::default(),
        }
    }
}

/// Noise models are an open family: their names and keys are known to the program that links them.
fn noise_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
    schemars::json_schema!({
        "type": "object",
        "properties": { "model": { "type": "string" } },
        "required": ["model"]
    })
}

/// More beams than this are a mistake in the step.
const MOST_BEAMS: f64 = 100_000.0;

impl Params for Laser2dParams {
    fn check(&self) -> Vec<BuildError> {
        let Self { field_of_view_deg, step_deg, min_range_m, max_range_m, noise, faults: scan_faults } = self;
        let mut faults = Vec::new();
        let mut expect = |fine: bool, key: &str, value: f64, expected: &str| {
            if !fine {
                faults.push(BuildError::at(key, format!("is {value}, expected {expected}")));
            }
        };
        let field_fits = *field_of_view_deg >= 0.0 && *field_of_view_deg <= 360.0;
        expect(field_fits, "field_of_view_deg", *field_of_view_deg, "an angle from 0 to 360");
        let step_fits = step_deg.is_finite() && *step_deg > 0.0 && field_of_view_deg / step_deg < MOST_BEAMS;
        expect(step_fits, "step_deg", *step_deg, "an angle above 0 that gives fewer than 100000 beams");
        expect(min_range_m.is_finite() && *min_range_m >= 0.0, "min_range_m", *min_range_m, "0 or more");
        let reach_fits = max_range_m.is_finite() && max_range_m > min_range_m;
        expect(reach_fits, "max_range_m", *max_range_m, "a finite range above min_range_m");
        faults.extend(
            noise.faults().into_iter().map(|(key, message)| BuildError::at(format!("noise.{key}"), message)),
        );
        let scan_faults = scan_faults.faults().into_iter();
        faults.extend(scan_faults.map(|(key, message)| BuildError::at(format!("faults.{key}"), message)));
        faults
    }
}

impl Laser2dParams {
    /// Geometry of the scans.
    pub(crate) fn shape(&self) -> ScanShape {
        let n_steps = (self.field_of_view_deg / self.step_deg + 1e-9).floor();
        // A full turn ends where it began.
        let is_closed = (n_steps * self.step_deg - 360.0).abs() < 1e-9;
        let n_beams = n_steps as usize + usize::from(!is_closed);
        ScanShape {
            first_bearing_rad: -(n_steps * self.step_deg / 2.0).to_radians(),
            bearing_step_rad: self.step_deg.to_radians(),
            n_beams,
            min_range_m: self.min_range_m,
            max_range_m: self.max_range_m,
        }
    }
}
