//! A body that rolls and pitches by 20 degrees on its wheels, every two seconds, with attitudes that are off by half a degree.

use super::watch::{Walls, at_95, drive};
use rumbo_core::engine::EndReason;

const PIPELINE: &str = "finder_swaying.toml";

#[test]
fn leveled_scans_are_matched_as_those_of_a_level_robot() {
    let walls = Walls::load();
    for seed in 1..=3 {
        let drive = drive(PIPELINE, &[&format!("seed={seed}")], &[]);
        assert_eq!(drive.reason, EndReason::Finished);
        assert!(drive.errors_m.len() > 300 && drive.n_unsure == 0, "{} not sure", drive.n_unsure);
        assert!(drive.worst_m() <= 0.15, "seed {seed}: {} m", drive.worst_m());
        let errors_m = walls.errors_m(&drive.maps[0]);
        assert!(errors_m.len() > 500 && at_95(&errors_m) <= 0.15, "walls: {}", at_95(&errors_m));
    }
}
