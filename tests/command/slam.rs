//! What the plugin in `[slam]` leaves for later: its trajectory and its state.

use super::*;
use rumbo_core::engine::{EndReason, Engine};
use rumbo_core::frames::Pose2;
use rumbo_core::map::Line;
use rumbo_core::saved_state::SavedState;
use std::io::Read as _;
use std::sync::atomic::AtomicBool;

const LINES: &str = "pipelines/mapping_log_lines.toml";
/// One scan a second, as in the shipped log, is too few to know the way from scans alone.
const WHEELS: &str = "odometer.prediction=wheels";

/// Walls and last pose of a run of that pipeline in this program.
fn mapped(sets: &[String]) -> (Vec<Line>, Pose2) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(LINES);
    let sets: Vec<String> = std::iter::once(WHEELS.to_owned()).chain(sets.iter().cloned()).collect();
    let ready = rumbo::load::load(&file, &sets, &rumbo::registry().unwrap()).ok().unwrap();
    let mut engine = Engine::build(&ready.pipeline).unwrap();
    assert_eq!(engine.run(&mut [], &AtomicBool::new(false)).reason, EndReason::Ended);
    let view = engine.view();
    (view.map.lines.clone().unwrap().lines.to_vec(), view.map_from_base)
}

/// The shipped log up to a stamp and from there on, as files of their own.
fn halves(folder: &Path, at_s: f64) -> [PathBuf; 2] {
    let packed = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines/logs/office_tour.clf.gz");
    let mut text = String::new();
    flate2::read::GzDecoder::new(std::fs::File::open(packed).unwrap()).read_to_string(&mut text).unwrap();
    let (head, lines): (Vec<&str>, Vec<&str>) = text.lines().partition(|line| line.starts_with(['#', 'P']));
    let stamp = |line: &&str| line.rsplit(' ').next().unwrap().parse::<f64>().unwrap() < at_s;
    let (before, after): (Vec<&str>, Vec<&str>) = lines.into_iter().partition(stamp);
    assert!(before.len() > 1000 && after.len() > 1000);
    [("before.clf", before), ("after.clf", after)].map(|(name, lines)| {
        let path = folder.join(name);
        std::fs::write(&path, [head.clone(), lines].concat().join("\n") + "\n").unwrap();
        path
    })
}

/// How far a point is from the nearest wall, meters.
fn off(point: [f64; 2], walls: &[Line]) -> f64 {
    let distance = |wall: &Line| {
        let along = [wall.to[0] - wall.from[0], wall.to[1] - wall.from[1]];
        let from = [point[0] - wall.from[0], point[1] - wall.from[1]];
        let share = (along[0] * from[0] + along[1] * from[1]) / along[0].hypot(along[1]).powi(2).max(1e-12);
        let share = share.clamp(0.0, 1.0);
        (from[0] - share * along[0]).hypot(from[1] - share * along[1])
    };
    walls.iter().map(distance).fold(f64::INFINITY, f64::min)
}

#[test]
fn a_map_that_was_saved_half_way_becomes_the_map_of_the_whole_way() {
    let folder = scratch("slam_resume");
    let [before, after] = halves(&folder, 480.0);
    let state = folder.join("deep/half.state");
    let set = |log: &Path| format!("world.file={}", log.display());
    let given = give(&[
        "run",
        LINES,
        "--set",
        WHEELS,
        "--set",
        &set(&before),
        "--save-state",
        state.to_str().unwrap(),
        "--no-report",
    ]);
    assert_eq!(given.code, 0, "{}", given.stderr);
    assert!(given.stderr.contains("half.state"), "{}", given.stderr);
    assert_eq!(std::fs::read_dir(state.parent().unwrap()).unwrap().count(), 1);
    let resume = format!("slam.resume={}", state.display());
    let checked = give(&["check", LINES, "--set", WHEELS, "--set", &resume, "--set", &set(&after)]);
    assert_eq!(checked.code, 0, "{}", checked.stderr);
    let (whole, end) = mapped(&[]);
    let (resumed, resumed_end) = mapped(&[resume, set(&after)]);
    let apart = end.inverse() * resumed_end;
    assert!(apart.translation.vector.norm() < 0.2 && apart.rotation.angle().abs() < 0.03, "{apart}");
    // What one run maps, the other has, too: middles of the walls that are longer than a meter.
    let share = |walls: &[Line], of: &[Line]| {
        let long = walls.iter().filter(|w| (w.to[0] - w.from[0]).hypot(w.to[1] - w.from[1]) > 1.0);
        let middles: Vec<_> =
            long.map(|w| [(w.from[0] + w.to[0]) / 2.0, (w.from[1] + w.to[1]) / 2.0]).collect();
        assert!(middles.len() > 10, "{}", middles.len());
        middles.iter().filter(|middle| off(**middle, of) < 0.25).count() as f64 / middles.len() as f64
    };
    let shares = [share(&whole, &resumed), share(&resumed, &whole)];
    assert!(shares.iter().all(|share| *share > 0.9), "{shares:?}");
    // Without the first half its walls are not there.
    let (alone, _) = mapped(&[set(&after)]);
    assert!(share(&whole, &alone) < 0.9, "{}", share(&whole, &alone));
}

#[test]
fn a_state_that_is_missing_damaged_or_of_another_plugin_is_a_fault_at_its_line() {
    let folder = scratch("slam_bad_state");
    let path = folder.join("half.state");
    let resume = format!("slam.resume={}", path.display());
    let checked = || give(&["check", LINES, "--set", &resume]);
    let missing = checked();
    assert!(missing.code == 2 && missing.stderr.contains("cannot read"), "{}", missing.stderr);
    assert!(missing.stderr.contains("slam.resume"), "{}", missing.stderr);
    let bytes = b"RUMBOSLM".repeat(9);
    std::fs::write(&path, &bytes).unwrap();
    assert!(checked().stderr.contains("reads version 1"));
    let state = SavedState {
        plugin: "graph".into(),
        version: "1.0".into(),
        map_from_base: Pose2::identity(),
        covariance: nalgebra::Matrix3::identity(),
        is_lost: false,
        bytes: b"RUMBOEKF".to_vec(),
    };
    state.write(&path).unwrap();
    let other = checked();
    assert!(other.stderr.contains("was saved by `graph`, and [slam] is `ekf_line_slam`"), "{}", other.stderr);
    SavedState { plugin: "ekf_line_slam".into(), ..state }.write(&path).unwrap();
    let damaged = checked();
    assert!(damaged.code == 2 && damaged.stderr.contains("saved by version 1.0"), "{}", damaged.stderr);
    let elsewhere = give(&["check", OFFICE, "--set", "localizer.resume=a.state"]);
    assert!(elsewhere.stderr.contains("means nothing in [localizer]"), "{}", elsewhere.stderr);
}

#[test]
fn what_only_a_slam_can_leave_is_refused_where_there_is_none() {
    let folder = scratch("no_slam");
    let file = folder.join("x.txt");
    for (option, advice) in [("--trajectory", "--poses"), ("--save-state", "mission.initial_pose")] {
        let given = give(&["run", OFFICE, option, file.to_str().unwrap(), "--no-report"]);
        assert_eq!(given.code, 2, "{}", given.stderr);
        assert!(given.stderr.contains("[slam]") && given.stderr.contains(advice), "{}", given.stderr);
    }
    assert!(!file.exists());
    // This plugin keeps no trajectory; everything else of the run is written.
    let poses = folder.join("poses.txt");
    let [poses, trajectory] = [&poses, &file].map(|path| path.to_str().unwrap().to_owned());
    let words =
        ["run", LINES, "--duration", "20", "--no-report", "--poses", &poses, "--trajectory", &trajectory];
    let given = give(&words);
    assert_eq!(given.code, 2, "{}", given.stderr);
    assert!(given.stderr.contains("no trajectory: the plugin in [slam] keeps none"), "{}", given.stderr);
    assert!(Path::new(&poses).exists() && !file.exists());
}

#[test]
#[cfg(unix)]
fn an_interrupted_run_saves_its_state_too() {
    let folder = scratch("slam_interrupt");
    let state = folder.join("cut.state");
    let words = ["run", LINES, "--speed", "20", "--no-report", "--save-state", state.to_str().unwrap()];
    let mut command = rumbo(&words);
    command.stdout(std::process::Stdio::piped()).stderr(std::process::Stdio::piped());
    let mut child = command.spawn().unwrap();
    let pid = child.id().to_string();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        std::thread::sleep(std::time::Duration::from_millis(1500));
        Command::new("kill").args(["-INT", &pid]).status().unwrap();
    };
    assert_eq!(status.code(), Some(130));
    let saved = SavedState::read(&state, "ekf_line_slam").unwrap();
    assert!(!saved.is_lost && saved.bytes.len() > 200);
}

/// The shipped log has the true poses; the pipeline of lines starts at the origin and never sees them.
#[test]
fn the_way_of_the_shipped_log_is_the_recorded_one_to_a_decimeter_and_a_half() {
    let folder = scratch("slam_way");
    let poses = ["pipelines/mapping_log.toml", LINES].map(|pipeline| {
        let poses = folder.join(Path::new(pipeline).file_stem().unwrap()).with_extension("txt");
        let given = give(&["run", pipeline, "--no-report", "--poses", poses.to_str().unwrap()]);
        assert_eq!(given.code, 0, "{}", given.stderr);
        poses.to_str().unwrap().to_owned()
    });
    let [truth, estimated] = &poses;
    let given = give(&["eval", "trajectory", estimated, truth, "--json"]);
    assert_eq!(given.code, 0, "{}", given.stderr);
    let rmse_m = given.json()["ate_m"]["rmse"].as_f64().unwrap();
    assert!(rmse_m < 0.15, "{rmse_m} m over 152 m");
}

#[test]
fn several_logs_and_pipelines_are_one_table_with_the_errors_of_their_relations() {
    let folder = scratch("eval_slam");
    let log = folder.join("tour-of-it.clf.gz");
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines/logs/office_tour.clf.gz");
    std::fs::copy(shipped, &log).unwrap();
    let words = ["eval", "slam", LINES, "--log", log.to_str().unwrap(), "--json"];
    let missing = give(&words);
    assert!(missing.code == 2 && missing.stderr.contains("tour-of-it.relations.gz"), "{}", missing.stderr);
    // Relations that are the run's own poses, but one is 0.3 m and one 0.2 rad off.
    let poses = folder.join("poses.txt");
    let set = format!("world.file={}", log.display());
    give(&["run", LINES, "--set", &set, "--no-report", "--poses", poses.to_str().unwrap()]);
    let text = std::fs::read_to_string(&poses).unwrap();
    let poses: Vec<Vec<f64>> =
        text.lines().map(|line| line.split(' ').map(|word| word.parse().unwrap()).collect()).collect();
    let timeline = rumbo_kit::log_file::Timeline::open(&log, Default::default()).unwrap();
    let origin_s = timeline.origin().as_secs();
    let relation = |from: usize, to: usize, off_m: f64, off_rad: f64| {
        let at = |k: usize| rumbo_core::frames::pose2(poses[k][1], poses[k][2], poses[k][3]);
        let way = at(from).inverse() * at(to);
        let stamp = |k: usize| origin_s + poses[k][0];
        let (x, y, yaw) = (way.translation.x + off_m, way.translation.y, way.rotation.angle() + off_rad);
        format!("{:.6} {:.6} {x} {y} 0 0 0 {yaw}\n", stamp(from), stamp(to))
    };
    let off_the_log = format!("{} {} 1 0 0 0 0 0\n", origin_s - 9.0, origin_s - 8.0);
    let relations =
        [relation(10, 20, 0.0, 0.0), relation(5, 500, 0.3, 0.0), relation(700, 90, 0.0, 0.2), off_the_log];
    std::fs::write(folder.join("tour.relations"), relations.concat()).unwrap();
    let given = give(&words);
    assert_eq!(given.code, 0, "{}", given.stderr);
    let rows = given.json();
    let row = &rows[0];
    assert_eq!((&row["log"], &row["plugin"]), (&"tour-of-it".into(), &"ekf_line_slam".into()));
    assert_eq!((&row["n_relations"], &row["at_the_time"]["n_used"]), (&4.into(), &3.into()));
    let mean = |kind: &str| row["at_the_time"][kind]["mean"].as_f64().unwrap();
    assert!((mean("translation_m") - 0.1).abs() < 1e-4, "{row}");
    assert!((mean("rotation_rad") - 0.2 / 3.0).abs() < 1e-4, "{row}");
    let tracked = row["tracked_share"].as_f64().unwrap();
    assert!(tracked > 0.9 && tracked <= 1.0, "{row}");
    assert!(row["at_the_end"].is_null() && row["log_s"].as_f64().unwrap() > 900.0, "{row}");
    let pictures = folder.join("pictures");
    let drawn =
        ["eval", "slam", LINES, "--log", log.to_str().unwrap(), "--pictures", pictures.to_str().unwrap()];
    let table = give(&drawn);
    let picture = image::open(pictures.join("tour-of-it-mapping_log_lines.png")).unwrap();
    assert!(picture.width() > 600, "{} pixels wide", picture.width());
    let twice = give(&[&drawn[..], &["--log", log.to_str().unwrap()]].concat());
    assert!(twice.code == 2 && twice.stderr.contains("two rows would write"), "{}", twice.stderr);
    assert!(table.stderr.contains("3 of 4") && table.stderr.contains("0.1000 +- "), "{}", table.stderr);
    assert!(table.stderr.contains(&format!("{:.1} %", 100.0 * tracked)), "{}", table.stderr);
    let no_slam = give(&["eval", "slam", OFFICE, "--log", log.to_str().unwrap()]);
    assert_eq!(no_slam.code, 2, "{}", no_slam.stderr);
}

#[test]
fn a_log_without_scans_is_played_and_says_what_is_missing() {
    let folder = scratch("no_scans");
    let [before, _] = halves(&folder, 480.0);
    let text = std::fs::read_to_string(&before).unwrap();
    let log = folder.join("no_scans.clf");
    let lines: Vec<&str> = text.lines().filter(|line| !line.starts_with("FLASER")).collect();
    std::fs::write(&log, lines.join("\n") + "\n").unwrap();
    let (set, poses) = (format!("world.file={}", log.display()), folder.join("poses.txt"));
    let words = ["run", LINES, "--set", &set, "--no-report", "--poses", poses.to_str().unwrap()];
    let given = give(&words);
    assert_eq!(given.code, 0, "{}", given.stderr);
    assert!(given.stderr.contains("`front_laser` gave nothing during the whole run"), "{}", given.stderr);
    assert!(!given.stderr.contains("`odometry` gave nothing"), "{}", given.stderr);
    assert!(given.stderr.contains("no poses: no laser scan came"), "{}", given.stderr);
    let whole = give(&["run", LINES, "--duration", "20", "--no-report"]);
    assert!(!whole.stderr.contains("gave nothing"), "{}", whole.stderr);
    let quiet = give(&[&words[..], &["--quiet"]].concat());
    assert_eq!(quiet.stderr, "");
}
