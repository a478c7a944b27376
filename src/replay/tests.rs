use super::*;
use crate::recording::{RunRecording, header_of};
use rumbo_core::engine::{Metrics, Summary};
use std::sync::atomic::AtomicBool;

/// Somebody walks into the robot while it stands; later it drives into a step that no sensor sees, and backs out.
const TOUCHED: &str = r#"
name = "touched"
seed = 1

[world]
plugin = "sim"

[world.add]
box = [{ name = "step", center = [2.0, 0.0], size = [0.4, 0.4], z_max_m = 0.1 }]
person = [{ name = "anna", route = [[0.0, -3.0], [0.0, 9.0]], speed_m_s = 1.0 }]

[[sensor]]
name = "wheels"
plugin = "wheel_encoders"

[localizer]
plugin = "odometry"

[mission]
commands = "drive.csv"
"#;
const DRIVE: &str = "t_s,forward_m_s,turn_deg_s\n0,0,0\n5,0.3,0\n13,-0.3,0\n15,0,0\n";

fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("rumbo-replay-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// Drives the pipeline into a recording; its figures.
fn record(folder: &Path, path: &Path) -> Summary {
    let file = folder.join("touched.toml");
    std::fs::write(&file, TOUCHED).unwrap();
    std::fs::write(folder.join("drive.csv"), DRIVE).unwrap();
    let ready = load::load(&file, &[], &load::registry().ok().unwrap()).ok().unwrap();
    let mut engine = Engine::build(&ready.pipeline).unwrap();
    let header = header_of(&ready, &file, None, &engine);
    let mut recording = RunRecording::create(path, &header).ok().unwrap();
    let mut metrics = Metrics::new();
    let end = engine.run(&mut [&mut metrics, &mut recording], &AtomicBool::new(false));
    recording.finish(&end, &engine.view()).ok().unwrap();
    metrics.summary(end.reason, end.detail)
}

/// The figures of a replay.
fn replayed(path: &Path) -> Summary {
    let reader = RecordingReader::open(path).unwrap();
    let header = reader.header().clone();
    let registry = load::registry().ok().unwrap();
    let ready = load::from_text(Path::new(&header.file), &header.pipeline, &[], &registry).ok().unwrap();
    let inbox = Inbox::default();
    let world = ReplayWorld::new(reader, Follow::Steps, vec![true], inbox.clone());
    let mut engine = Engine::build_in(&ready.pipeline, Box::new(world)).unwrap();
    engine.listen(inbox);
    let mut metrics = Metrics::new();
    let end = engine.run(&mut [&mut metrics], &AtomicBool::new(false));
    metrics.summary(end.reason, end.detail)
}

#[test]
fn a_replay_tells_contacts_by_driving_from_others_as_the_run_did() {
    let folder = folder("contacts");
    let path = folder.join("touched.mcap");
    let run = record(&folder, &path);
    assert_eq!((run.reason, run.contacts, run.driven_contacts), (EndReason::Finished, Some(2), Some(1)));
    let again = replayed(&path);
    assert_eq!(again, run, "every figure, those of contacts among them");
    std::fs::remove_dir_all(folder).unwrap();
}
