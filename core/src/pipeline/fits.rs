//! Do the parts of a pipeline fit together? What each plugin declares is enough to tell.

use super::draft::Draft;
use super::followed::followed;
use super::section::Section;
use super::{InitialPose, Rate, Seat, WellKnownPose};
use crate::document::{Fault, FaultCode, Faults, join_path};
use crate::map::Layer;
use crate::messages::ObservationKind;
use crate::registry::{Manifest, Registry, Stage};

/// Reports everything that does not fit.
pub(super) fn check(draft: &Draft, registry: &Registry, faults: &mut Faults) {
    seats(draft, registry, faults);
    odometry_owner(draft, faults);
    layer_owners(draft, faults);
    layers(draft, registry, faults);
    observations(draft, registry, faults);
    ages(draft, faults);
    start_pose(draft, faults);
    drives(draft, faults);
    mission(draft, faults);
}

fn missing(message: &str, help: String) -> Fault {
    Fault::new(FaultCode::MissingPart, "", None, message).help(help)
}

/// `plugin = "a"` or `plugin = "b"`: who could sit in a section.
fn candidates(registry: &Registry, stage: Stage, suits: impl Fn(&Manifest) -> bool) -> Vec<String> {
    let manifest = |entry: &crate::registry::Entry| {
        entry.source.parse(toml::Table::new()).ok().map(|configured| configured.manifest())
    };
    registry
        .of_stage(stage)
        .filter(|entry| manifest(entry).is_some_and(|manifest| suits(&manifest)))
        .map(|entry| entry.name.clone())
        .collect()
}

fn seats(draft: &Draft, registry: &Registry, faults: &mut Faults) {
    let names = |stage| candidates(registry, stage, |_| true).join(", ");
    if draft.single(Seat::World).is_none() {
        let help = format!("write [world] with one of the plugins {}", names(Stage::World));
        faults.push(missing("the pipeline has no [world], so the robot is nowhere", help));
    }
    match (draft.single(Seat::Localizer), draft.single(Seat::Slam)) {
        (None, None) => {
            let help = format!("write [localizer] with one of the plugins {}", names(Stage::Localizer));
            faults.push(missing(
                "the pipeline has no [localizer] and no [slam], so nobody finds the robot",
                help,
            ));
        }
        (Some(localizer), Some(slam)) => {
            let message = "the plugin in [slam] finds the robot too, and only one may; remove one of them";
            let fault = localizer.fault(FaultCode::TwoOwners, message);
            faults.push(fault.note("[slam] is here", slam.node.place()));
        }
        _ => {}
    }
    if let (Some(fallback), None) = (draft.single(Seat::PlannerFallback), draft.single(Seat::Planner)) {
        let message = "is asked when [planner] has no answer, but there is no [planner]";
        faults.push(fallback.fault(FaultCode::MissingPart, message));
    }
}

/// Only one part may move odom -> base.
fn odometry_owner(draft: &Draft, faults: &mut Faults) {
    if draft.single(Seat::Odometer).is_some() {
        return;
    }
    let mut makers = draft
        .sensors
        .iter()
        .filter(|sensor| sensor.manifest().is_some_and(|m| m.produces.contains(&ObservationKind::Odometry)));
    let Some(first) = makers.next() else { return };
    for second in makers {
        let message = format!("says where the base went, and so does {}; only one may", first.path);
        let fault = second.fault(FaultCode::TwoOwners, message);
        let fault = fault.note("the other is here", first.node.place());
        faults.push(fault.help("remove one, or name a plugin in [odometer] that merges them"));
    }
}

/// A layer is written by one part, unless another says that it writes on top.
fn layer_owners(draft: &Draft, faults: &mut Faults) {
    let mut owners: Vec<(Vec<Layer>, &Section)> = Vec::new();
    for section in draft.single(Seat::Slam).into_iter().chain(&draft.builders) {
        let Some(manifest) = section.manifest().filter(|manifest| !manifest.overlays) else { continue };
        for (layers, first) in &owners {
            let shared: Vec<&str> = layers
                .iter()
                .filter(|layer| manifest.gives_layers.contains(layer))
                .map(|layer| layer.name())
                .collect();
            if shared.is_empty() {
                continue;
            }
            let message = format!(
                "writes the map layer {}, and so does {}; only one may",
                shared.join(" and "),
                first.path
            );
            let fault = section.fault(FaultCode::TwoOwners, message);
            faults.push(fault.note("the other is here", first.node.place()));
        }
        owners.push((manifest.gives_layers, section));
    }
}

/// Every layer that a stage reads is given by somebody; a builder reads only what was given before it.
fn layers(draft: &Draft, registry: &Registry, faults: &mut Faults) {
    let slam = draft.single(Seat::Slam);
    let givers: Vec<&Section> = slam.into_iter().chain(&draft.builders).collect();
    // Who is not understood might give anything.
    if givers.iter().any(|giver| giver.spec.is_none()) {
        return;
    }
    let gives = |sections: &[&Section], layer: Layer| {
        sections.iter().any(|giver| giver.manifest().is_some_and(|m| m.gives_layers.contains(&layer)))
    };
    for section in draft.sections() {
        let Some(manifest) = section.manifest() else { continue };
        let before = givers.iter().position(|giver| giver.path == section.path);
        let visible = match (section.seat, before) {
            (Seat::MapBuilder, Some(before)) => &givers[..before],
            _ => &givers[..],
        };
        for layer in manifest.needs_layers.iter().filter(|layer| !gives(visible, **layer)) {
            // A builder may read what it writes itself; one that writes on top needs something to be on top of.
            if manifest.gives_layers.contains(layer) && !manifest.overlays {
                continue;
            }
            let name = layer.name();
            if gives(&givers, *layer) {
                let message =
                    format!("needs the map layer {name}, which a later map builder gives; put that first");
                faults.push(section.fault(FaultCode::MissingLayer, message));
                continue;
            }
            let message = format!("needs the map layer {name}, which nothing in this pipeline gives");
            let fault = section.fault(FaultCode::MissingLayer, message);
            let builders =
                candidates(registry, Stage::MapBuilder, |m| m.gives_layers.contains(layer) && !m.overlays);
            let slams = candidates(registry, Stage::Slam, |m| m.gives_layers.contains(layer));
            faults.push(match (builders.is_empty(), slams.is_empty()) {
                (true, true) => fault,
                (false, _) => fault.help(format!("[map_builder] could be {}", builders.join(", "))),
                (true, false) => fault.help(format!("[slam] could be {}", slams.join(", "))),
            });
        }
    }
}

/// Every observation that a stage cannot do without is made by some sensor.
fn observations(draft: &Draft, registry: &Registry, faults: &mut Faults) {
    if draft.sensors.iter().any(|sensor| sensor.spec.is_none()) {
        return;
    }
    let made: Vec<ObservationKind> =
        draft.sensors.iter().filter_map(Section::manifest).flat_map(|manifest| manifest.produces).collect();
    for section in draft.sections().filter(|section| section.seat != Seat::Sensor) {
        let Some(manifest) = section.manifest() else { continue };
        let has_odometer = section.seat != Seat::Odometer && draft.single(Seat::Odometer).is_some();
        for group in &manifest.consumes {
            let by_odometer = has_odometer && group.contains(&ObservationKind::Odometry);
            if by_odometer || group.iter().any(|kind| made.contains(kind)) {
                continue;
            }
            let kinds: Vec<&str> = group.iter().map(|kind| kind.name()).collect();
            let message = format!("needs {}, which no sensor makes", kinds.join(" or "));
            let fault = section.fault(FaultCode::MissingObservation, message);
            let sensors = candidates(registry, Stage::Sensor, |m| {
                !m.is_virtual && m.produces.iter().any(|kind| group.contains(kind))
            });
            faults.push(match sensors.is_empty() {
                true => fault,
                false => fault.help(format!("a [[sensor]] could be {}", sensors.join(", "))),
            });
        }
    }
}

/// A sensor whose readings are always too old for the guard would keep the robot from ever driving.
fn ages(draft: &Draft, faults: &mut Faults) {
    let (stale_after_s, has_odometer) =
        (draft.robot.guard.stale_after_s, draft.single(Seat::Odometer).is_some());
    if draft.single(Seat::Avoider).is_none() {
        return;
    }
    for sensor in &draft.sensors {
        let Some(manifest) = sensor.manifest().filter(|manifest| manifest.is_watched(has_odometer)) else {
            continue;
        };
        let Some(rate) = sensor.reserved.rate().or(manifest.default_rate_hz.map(Rate::Hz)) else { continue };
        let period_s = rate.period().as_secs();
        if period_s > stale_after_s {
            let message = format!(
                "gives a reading every {period_s} s, but the guard stops the robot when one is older than \
                 {stale_after_s} s"
            );
            let help = "make the sensor faster, or raise robot.guard.stale_after_s";
            faults.push(sensor.rate_fault(message).help(help));
        }
    }
}

fn drives(draft: &Draft, faults: &mut Faults) {
    let kind = draft.robot.drive.kind();
    for section in draft.sections() {
        let Some(manifest) = section.manifest().filter(|m| !m.drives.contains(&kind)) else { continue };
        let able: Vec<&str> = manifest.drives.iter().map(|kind| kind.name()).collect();
        let message = format!("cannot steer the drive {} of [robot], only {}", kind.name(), able.join(", "));
        faults.push(section.fault(FaultCode::Drive, message));
    }
}

/// A localizer that only follows a robot must be told where it starts.
fn start_pose(draft: &Draft, faults: &mut Faults) {
    let unknown = InitialPose::WellKnown(WellKnownPose::Unknown);
    let is_told = draft.mission.initial_pose != unknown || draft.single(Seat::Relocalizer).is_some();
    let Some(localizer) = draft.single(Seat::Localizer).filter(|_| !is_told) else { return };
    if localizer.manifest().is_some_and(|manifest| manifest.needs_start_pose)
        && let Some(node) = &draft.mission_node
    {
        let message = "is \"unknown\", but this localizer must be told where the robot starts";
        let place = node.nearest("initial_pose").place();
        let fault = Fault::new(FaultCode::MissingPart, "mission.initial_pose", place, message);
        faults.push(
            fault
                .note("the localizer is here", localizer.node.place())
                .help("name a localizer that finds the robot, such as particle_filter, or a [relocalizer]"),
        );
    }
}

fn mission(draft: &Draft, faults: &mut Faults) {
    let has_waypoints = !draft.mission.waypoints.is_empty();
    let key = if has_waypoints { "waypoints" } else { "follow" };
    if let Some(node) = draft.mission_node.as_ref().filter(|_| draft.mission.has_goals())
        && draft.single(Seat::Avoider).is_none()
    {
        let message = "the robot has somewhere to go, but without [avoider] it never drives";
        let place = node.nearest(key).place();
        let fault = Fault::new(FaultCode::MissingPart, join_path("mission", key), place, message);
        faults.push(fault.help("name a plugin in [avoider]"));
    }
    followed(draft, faults);
    for (idx, node) in draft.test_nodes.iter().enumerate() {
        let Some(key) = node.nearest("expect").get("arrives_within_s").filter(|_| !has_waypoints) else {
            continue;
        };
        // With faults in the mission nobody knows whether it has waypoints.
        if faults.any_below("mission") {
            continue;
        }
        let path = join_path(&format!("test[{idx}]"), "expect.arrives_within_s");
        let message = "expects the robot to arrive, but [mission] has no waypoints";
        faults.push(Fault::new(FaultCode::MissingPart, path, key.place(), message));
    }
}
