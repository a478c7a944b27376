//! A library that was built for the first ABI, with a plugin of each stage: every host of major 1 runs it.

use crate::compiler::{self, Language};
use crate::runs;
use rumbo_core::engine::EndReason;
use rumbo_core::map::Map;
use rumbo_core::messages::Prior;
use rumbo_core::registry::{Built, Stage};
use rumbo_core::stages::{BuildContext, Slam, SlamError};
use std::path::PathBuf;

fn library(name: &str, flags: &[&str]) -> PathBuf {
    // The header that lies beside the source comes first.
    compiler::library(&compiler::root().join("tests/boundary/abi_1_0/plugin.c"), Language::C, flags, name)
}

const SENSOR: (&str, &str) = ("sensor", "plugin = \"frozen_beams\"");
const PLANNER: (&str, &str) = ("planner", "plugin = \"frozen_straight\"");
const AVOIDER: (&str, &str) = ("avoider", "plugin = \"frozen_ahead\"");

#[test]
fn plugins_of_the_first_abi_drive_a_robot() {
    let registry = runs::registry(&[&library("frozen", &[])]);
    let localizer = ("localizer", "plugin = \"frozen_odometry\"");
    let builder = ("map_builder", "plugin = \"frozen_floor\"");
    let text = runs::floor(&[SENSOR, PLANNER, AVOIDER, localizer, builder]);
    let (told, end) = runs::run(&text, &registry, 60.0).unwrap();
    assert_eq!(end.reason, EndReason::Arrived, "{:?}", told.events);
    assert!(told.failures.is_empty(), "{:?}", told.failures);
    assert!(told.n_ranges.len() > 20 && told.n_ranges.iter().all(|n| *n == 181), "{:?}", told.n_ranges);
    assert!(told.first_cell.unwrap() > 10.0, "the map builder counts its calls: {:?}", told.first_cell);
}

#[test]
fn slam_of_the_first_abi_drives_a_robot() {
    let registry = runs::registry(&[&library("frozen_slam", &[])]);
    let text = runs::floor(&[SENSOR, PLANNER, AVOIDER]);
    let (before, after) = text.split_once("[map_builder]").unwrap();
    let (_, after) = after.split_once("[planner]").unwrap();
    let text = format!("{before}[slam]\nplugin = \"frozen_both\"\n\n[planner]{after}");
    let (told, end) = runs::run(&text, &registry, 60.0).unwrap();
    assert_eq!(end.reason, EndReason::Arrived, "{:?}", told.events);
    assert!(told.first_cell.unwrap() > 10.0, "{:?}", told.first_cell);
}

fn saved(name: &str, flags: &[&str]) -> Result<Vec<u8>, SlamError> {
    slam(name, flags).save()
}

fn slam(name: &str, flags: &[&str]) -> Box<dyn Slam> {
    let registry = runs::registry(&[&library(name, flags)]);
    let entry = registry.get(Stage::Slam, "frozen_both").unwrap();
    let configured = entry.source.parse(toml::Table::new()).unwrap();
    match configured.build(&BuildContext::bare("slam")).unwrap() {
        Built::Slam(slam) => slam,
        _ => panic!("no SLAM"),
    }
}

#[test]
fn a_function_that_the_table_has_is_called_and_one_behind_its_end_is_absent() {
    assert_eq!(saved("frozen_saves", &[]).unwrap(), b"0 updates");
    let without = ["-DSLAM_SIZE=offsetof(rumbo_slam_table,save)"];
    assert_eq!(saved("frozen_saves_not", &without), Err(SlamError::CannotSave));
    let mut slam = slam("frozen_keeps_not", &[]);
    assert_eq!(slam.trajectory(), Ok(Vec::new()));
    assert_eq!(slam.relocate(&Prior::Unknown, &mut Map::default()), Err(SlamError::CannotRelocate));
}
