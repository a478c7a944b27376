//! Sensors among themselves: names, mounts on one another, and virtual ones that come after what they derive from.

use super::SensorSpec;
use super::section::Section;
use crate::document::{Fault, FaultCode, Faults, did_you_mean, join_path};
use crate::frames::Pose3;
use nalgebra::{Translation3, UnitQuaternion};

/// Names of frames that a mount may be in, beside those of sensors; all are the base where the floor is flat.
const BASE_FRAMES: [&str; 3] = ["base_link", "base_stabilized", "base_footprint"];

/// Puts the sensors in the order in which they run and says where they sit. None where a sensor is not understood.
pub(super) fn arranged(sections: &[Section], faults: &mut Faults) -> Option<Vec<SensorSpec>> {
    let n_before = faults.len();
    let inputs: Vec<Vec<usize>> = sections.iter().map(|section| inputs(section, sections, faults)).collect();
    let mounts: Vec<Pose3> = sections.iter().map(|section| mount(section, sections, faults)).collect();
    let order = order(sections, &inputs, faults);
    if faults.len() > n_before {
        return None;
    }
    let position = |idx: usize| order.iter().position(|other| *other == idx).unwrap_or_default();
    let spec = |idx: &usize| {
        let stage = sections.get(*idx)?.spec.clone()?;
        let inputs = inputs[*idx].iter().map(|input| position(*input)).collect();
        Some(SensorSpec { stage, base_from_sensor: mounts[*idx], inputs })
    };
    order.iter().map(spec).collect()
}

fn name_of(section: &Section) -> &str {
    section.reserved.name.as_deref().unwrap_or("")
}

pub(super) fn unknown_name(wanted: &str, names: &[&str]) -> String {
    match did_you_mean(wanted, names.iter().copied()) {
        Some(close) => format!("no sensor is called `{wanted}`, did you mean {close}?"),
        None if names.is_empty() => format!("no sensor is called `{wanted}`"),
        None => format!("no sensor is called `{wanted}`, expected one of {}", names.join(", ")),
    }
}

/// Positions of the sensors that this one derives from.
fn inputs(section: &Section, all: &[Section], faults: &mut Faults) -> Vec<usize> {
    let own = name_of(section);
    let names: Vec<&str> = all.iter().map(name_of).filter(|name| !name.is_empty() && *name != own).collect();
    let mut found = Vec::new();
    for (idx, wanted) in section.reserved.inputs.iter().enumerate() {
        let path = format!("inputs[{idx}]");
        let place = section.node.nearest(&path).origin;
        let path = join_path(&section.path, &path);
        if wanted == own {
            faults.push(Fault::new(FaultCode::Cycle, path, place, "a sensor cannot derive from itself"));
            continue;
        }
        match all.iter().position(|other| name_of(other) == wanted) {
            Some(other) => found.push(other),
            None => {
                faults.push(Fault::new(FaultCode::UnknownName, path, place, unknown_name(wanted, &names)));
            }
        }
    }
    if let Some(manifest) = section.manifest() {
        let given = !section.reserved.inputs.is_empty();
        if manifest.is_virtual && !given {
            let message = "derives its observations from other sensors, and `inputs` names none";
            let fault = section.fault(FaultCode::MissingKey, message);
            faults.push(fault.help("write inputs = [\"...\"] with the names of the sensors"));
        }
        if !manifest.is_virtual && given {
            let place = section.node.nearest("inputs").place();
            let message = "this plugin reads the world, not other sensors; remove the key";
            faults.push(Fault::new(FaultCode::BadValue, join_path(&section.path, "inputs"), place, message));
        }
        check_kinds(section, &found, all, faults);
    }
    found
}

/// A virtual sensor's inputs must make what it consumes.
fn check_kinds(section: &Section, inputs: &[usize], all: &[Section], faults: &mut Faults) {
    let Some(manifest) = section.manifest().filter(|manifest| manifest.is_virtual) else { return };
    let given: Option<Vec<_>> = inputs.iter().map(|idx| all[*idx].manifest()).collect();
    let Some(given) = given.filter(|given| !given.is_empty()) else { return };
    for group in &manifest.consumes {
        let served = given.iter().any(|input| input.produces.iter().any(|kind| group.contains(kind)));
        if !served {
            let kinds: Vec<&str> = group.iter().map(|kind| kind.name()).collect();
            let message = format!("needs {}, which none of its inputs makes", kinds.join(" or "));
            faults.push(section.fault(FaultCode::MissingObservation, message));
        }
    }
}

/// Where the sensor sits on the base, also when it sits on another sensor.
fn mount(section: &Section, all: &[Section], faults: &mut Faults) -> Pose3 {
    let mut pose = own_mount(section);
    let mut frame = section.reserved.mount.frame.as_deref();
    for _ in 0..=all.len() {
        let Some(wanted) = frame.filter(|frame| !BASE_FRAMES.contains(frame)) else { return pose };
        let Some(below) = all.iter().find(|other| name_of(other) == wanted) else {
            let names: Vec<&str> = BASE_FRAMES.into_iter().chain(all.iter().map(name_of)).collect();
            let mut message =
                format!("no frame is called `{wanted}`, expected base_link or the name of a sensor");
            if let Some(close) = did_you_mean(wanted, names) {
                message = format!("no frame is called `{wanted}`, did you mean {close}?");
            }
            faults.push(mount_fault(section, FaultCode::UnknownName, message));
            return pose;
        };
        pose = own_mount(below) * pose;
        frame = below.reserved.mount.frame.as_deref();
    }
    faults.push(mount_fault(section, FaultCode::Cycle, "its mounts sit on one another in a circle".into()));
    pose
}

fn mount_fault(section: &Section, code: FaultCode, message: String) -> Fault {
    let place = section.node.nearest("mount.frame").origin;
    Fault::new(code, join_path(&section.path, "mount.frame"), place, message)
}

fn own_mount(section: &Section) -> Pose3 {
    let mount = &section.reserved.mount;
    Pose3::from_parts(
        Translation3::new(mount.x_m, mount.y_m, mount.z_m),
        UnitQuaternion::from_euler_angles(
            mount.roll_deg.to_radians(),
            mount.pitch_deg.to_radians(),
            mount.yaw_deg.to_radians(),
        ),
    )
}

/// File order, but what others derive from comes first.
fn order(sections: &[Section], inputs: &[Vec<usize>], faults: &mut Faults) -> Vec<usize> {
    let mut order: Vec<usize> = Vec::with_capacity(sections.len());
    while order.len() < sections.len() {
        let is_ready =
            |idx: &usize| !order.contains(idx) && inputs[*idx].iter().all(|input| order.contains(input));
        let Some(next) = (0..sections.len()).find(is_ready) else {
            let waiting: Vec<usize> = (0..sections.len()).filter(|idx| !order.contains(idx)).collect();
            let circle = circle(&waiting, inputs);
            let mut names: Vec<&str> = circle.iter().map(|idx| name_of(&sections[*idx])).collect();
            names.extend(names.first().copied());
            let message = format!("derives from itself in a circle: {}", names.join(" <- "));
            let at = circle.first().map_or(0, |idx| *idx);
            let place = sections[at].node.nearest("inputs").origin;
            let path = join_path(&sections[at].path, "inputs");
            faults.push(Fault::new(FaultCode::Cycle, path, place, message));
            order.extend(waiting);
            break;
        };
        order.push(next);
    }
    order
}

/// One circle among the sensors that wait for each other.
fn circle(waiting: &[usize], inputs: &[Vec<usize>]) -> Vec<usize> {
    let mut way: Vec<usize> = waiting.iter().take(1).copied().collect();
    while let Some(next) = way.last().and_then(|last| inputs[*last].iter().find(|i| waiting.contains(i))) {
        if let Some(first) = way.iter().position(|earlier| earlier == next) {
            return way.split_off(first);
        }
        way.push(*next);
    }
    way
}
