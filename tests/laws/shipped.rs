//! The plugins that are shipped.

use super::alone::passes_alone;
use super::*;
use rumbo::laws::laws_of;
use std::collections::BTreeSet;

/// Set where a test has the process for itself.
const ALONE: &str = "RUMBO_TEST_ALONE";

/// All plugins of one stage keep all laws. One law is about the memory of the process, so each stage gets one of its own, and
/// they need not take turns.
fn keep_their_laws(test: &str, stage: Stage) {
    if std::env::var_os(ALONE).is_none() {
        return passes_alone(&format!("shipped::{test}"), ALONE, "1");
    }
    let registry = registry();
    let report = verify(registry.of_stage(stage));
    assert!(!report.plugins.is_empty(), "no {} in the registry", stage.section());
    for plugin in &report.plugins {
        assert!(broken(plugin).is_empty(), "{}.{}:\n{}", plugin.stage, plugin.name, told(plugin.broken()));
        let laws: Vec<&str> = laws_of(stage).map(|law| law.name).collect();
        let asked: Vec<&str> = plugin.findings.iter().map(|finding| finding.law).collect();
        assert_eq!(asked, laws, "{}.{}", plugin.stage, plugin.name);
        for finding in &plugin.findings {
            let is_asked = !matches!(finding.outcome, Outcome::NotApplicable { .. });
            let may_be_silent = NOT_APPLICABLE.iter().any(|(law, names)| {
                *law == finding.law && (names.is_empty() || names.contains(&plugin.name.as_str()))
            });
            let has_none = NEEDS_A_DEVICE.contains(&plugin.name.as_str());
            assert!(is_asked || may_be_silent || has_none, "{}: {:?}", plugin.name, finding);
        }
    }
}

/// Laws that say nothing of plugins that are shipped, and of which; all where no names are given.
const NOT_APPLICABLE: [(&str, &[&str]); 10] = [
    ("values outside the ranges of its schema are refused", &[]),
    // Where their search ends by itself before it can be told to.
    ("a give_up raised during the search ends it", &["fictitious_charges", "potential_field"]),
    (
        "a world turned or mirrored gives the ranges of the same walls",
        &[
            "attitude_filter",
            "bumper_ring",
            "gps",
            "imu",
            "mark_camera",
            "person_tracker",
            "steering_encoder",
            "wheel_encoders",
        ],
    ),
    // It wanders.
    ("it brings the robot to the end of the path", &["braitenberg"]),
    (
        "a recording is passed on as it is",
        &[
            "attitude_filter",
            "bumper_ring",
            "depth_to_scan",
            "gps",
            "imu",
            "kinect",
            "mark_camera",
            "person_tracker",
            "sonar_ring",
            "stabilized_scan",
            "steering_encoder",
        ],
    ),
    // Virtual sensors ask no world.
    (
        "it survives a world that answers nonsense, and goes on",
        &["attitude_filter", "depth_to_scan", "stabilized_scan"],
    ),
    ("a world turned or mirrored turns the map with it", &["known_marks", "static_map"]),
    ("a world turned or mirrored turns the estimate with it", &["recorded_pose"]),
    // A filter knows where the robot is, not where it was.
    (
        "its trajectory is finite, in order, and of moments at which it was given something",
        &["ekf_line_slam"],
    ),
    (
        "an empty map is named where the map is needed",
        &["gps_imu", "nav_filter", "odometry", "recorded_pose", "scan_odometry"],
    ),
];

/// Plugins that cannot be without a device, which is not here. `robot` is asked by the tests of its own crate, with an
/// emulated one.
const NEEDS_A_DEVICE: [&str; 1] = ["robot"];

#[test]
fn worlds_keep_their_laws() {
    keep_their_laws("worlds_keep_their_laws", Stage::World);
}

#[test]
fn sensors_keep_their_laws() {
    keep_their_laws("sensors_keep_their_laws", Stage::Sensor);
}

#[test]
fn map_builders_keep_their_laws() {
    keep_their_laws("map_builders_keep_their_laws", Stage::MapBuilder);
}

#[test]
fn localizers_keep_their_laws() {
    keep_their_laws("localizers_keep_their_laws", Stage::Localizer);
}

#[test]
fn planners_keep_their_laws() {
    keep_their_laws("planners_keep_their_laws", Stage::Planner);
}

#[test]
fn avoiders_keep_their_laws() {
    keep_their_laws("avoiders_keep_their_laws", Stage::Avoider);
}

#[test]
fn slam_plugins_keep_their_laws() {
    keep_their_laws("slam_plugins_keep_their_laws", Stage::Slam);
}

#[test]
fn every_law_has_one_name_and_is_explained() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/verify.md");
    let page = std::fs::read_to_string(path).unwrap_or_default();
    let words = page.split_whitespace().collect::<Vec<_>>().join(" ");
    for stage in Stage::ALL {
        let names: Vec<&str> = laws_of(stage).map(|law| law.name).collect();
        assert_eq!(names.iter().collect::<BTreeSet<_>>().len(), names.len(), "{}", stage.section());
        for law in laws_of(stage) {
            assert!(words.contains(law.name), "docs/verify.md does not explain \"{}\"", law.name);
            assert!(words.contains(law.tolerance), "docs/verify.md does not say \"{}\"", law.tolerance);
        }
    }
}
