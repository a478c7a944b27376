//! Does the sensor fit that says where the person is whom a mission follows?

use super::draft::Draft;
use super::section::Section;
use super::sensors::unknown_name;
use crate::document::{Fault, FaultCode, Faults};
use crate::messages::ObservationKind;

/// The sensor that says where a person is must be there, and be one that can.
pub(super) fn followed(draft: &Draft, faults: &mut Faults) {
    let wanted = draft.mission.follow.as_ref().and_then(|follow| follow.sensor.as_deref());
    let (Some(wanted), Some(node)) = (wanted, &draft.mission_node) else { return };
    let path = "mission.follow.sensor";
    let place = node.nearest("follow.sensor").place();
    let name = |sensor: &Section| sensor.reserved.name.clone().unwrap_or_default();
    let Some(sensor) = draft.sensors.iter().find(|sensor| name(sensor) == wanted) else {
        let names: Vec<String> = draft.sensors.iter().map(name).filter(|name| !name.is_empty()).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let fault = Fault::new(FaultCode::UnknownName, path, place, unknown_name(wanted, &names));
        return faults.push(fault);
    };
    // Its own faults are told elsewhere.
    let Some(manifest) = sensor.manifest() else { return };
    if !manifest.produces.contains(&ObservationKind::Custom) {
        let message = format!("is \"{wanted}\", a sensor that does not say where a person is");
        let fault = Fault::new(FaultCode::MissingObservation, path, place, message);
        faults.push(
            fault
                .note("the sensor is here", sensor.node.place())
                .help("name one with plugin = \"person_tracker\""),
        );
    }
}
