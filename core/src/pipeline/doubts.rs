//! What a pipeline may say, but hardly means.

use super::draft::Draft;
use crate::document::{Fault, FaultCode, Faults};
use crate::registry::Surroundings;

/// The doubts that plugins have about their parameters. What the pipeline leaves at its default is the plugin's own affair.
pub(super) fn doubts(draft: &Draft) -> Faults {
    let views = draft.sensors.iter().filter_map(|sensor| sensor.manifest()?.field_of_view_rad);
    let surroundings = Surroundings { narrowest_view_rad: views.min_by(f64::total_cmp) };
    let mut doubts = Faults::default();
    for section in draft.sections() {
        let Some(spec) = &section.spec else { continue };
        for doubt in spec.configured.doubts(&surroundings) {
            let key = doubt.path.split(['.', '[']).next().unwrap_or_default();
            if section.node.get(key).is_some() {
                doubts.push(Fault { code: FaultCode::Doubtful, ..section.plugin_fault(&doubt) });
            }
        }
    }
    doubts.sort();
    doubts
}
