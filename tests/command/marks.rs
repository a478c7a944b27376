//! Localization by known marks, on a made-up folder of the MRCLAM kind.

use super::*;

/// The pipeline that docs/ekf-landmarks.md shows, for the folder that is here.
fn pipeline(name: &str) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = std::fs::read_to_string(root.join("docs/ekf-landmarks.md")).unwrap();
    let text = page.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let data = root.join("plugins/worlds/tests/data/mrclam");
    let text = text.replace("MRCLAM_Dataset7", data.to_str().unwrap());
    file(name, &text)
}

#[test]
fn the_pipeline_of_the_page_follows_a_robot_of_a_folder() {
    let file = pipeline("mrclam");
    let file = file.as_str();
    // The made-up robot obeys at once.
    let at_once = ["--set", "world.odometer_delay_s=0.0", "--json", "--no-report"];
    let told = give(&[&["run", file][..], &at_once].concat());
    assert_eq!(told.code, 0, "{}", told.stderr);
    let figures = told.json();
    assert_eq!(figures["reason"], "ended", "{figures}");
    let rms_m = figures["rms_error_m"].as_f64().unwrap();
    assert!(rms_m < 0.03, "{figures}");
    let anywhere = ["--set", "mission.initial_pose=unknown"];
    let figures = give(&[&["run", file][..], &at_once, &anywhere].concat()).json();
    assert!(figures["final_error_m"].as_f64().unwrap() < 0.05, "{figures}");
}

#[test]
fn a_folder_without_the_robot_is_a_fault_of_the_file() {
    let file = pipeline("mrclam_fault");
    let told = give(&["check", &file, "--set", "world.robot=4"]);
    assert_ne!(told.code, 0);
    assert!(told.stderr.contains("Robot4_Odometry.dat"), "{}", told.stderr);
}
