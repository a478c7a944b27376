use super::record::recorded;
use super::*;
use rumbo::recording::{RunRecording, header_of};
use rumbo_core::engine::{EndReason, Engine, Observer as _, Order, RunEnd, Stepped};
use rumbo_core::frames::Point2;
use rumbo_core::messages::{Data, Goal, Observation};
use rumbo_kit::recording::cdr::CdrWriter;
use rumbo_kit::recording::layout::observation_kind;
use rumbo_kit::recording::{RecordingReader, put_observation, read_observation};

fn replay(args: &[&str]) -> Given {
    give(&[&["replay", "--json"], args].concat())
}

/// Replaces the bytes of one observation in a recording by those of a changed one, which `change` makes.
fn patch(file: &str, change: impl Fn(&mut Observation) -> bool) -> Observation {
    let mut cdr = CdrWriter::default();
    let mut reader = RecordingReader::open(Path::new(file)).unwrap();
    let messages = std::iter::from_fn(|| reader.next_step()).flat_map(|step| step.messages);
    let found = messages.into_iter().find_map(|message| {
        let kind = observation_kind(&message.channel.schema)?;
        let mut observation = read_observation(kind, &message.data).unwrap();
        change(&mut observation).then_some((message.data, observation))
    });
    let (old, changed) = found.expect("an observation to change");
    put_observation(&mut cdr, &changed);
    let mut bytes = std::fs::read(file).unwrap();
    let new = cdr.bytes();
    let first = (0..old.len()).find(|idx| old[*idx] != new[*idx]).unwrap();
    // Ranges stand in the file in one block; other numbers as words, if they changed since the message before.
    let word = 4 + (first - 4) / 8 * 8;
    let places = [first.saturating_sub(64)..(first + 64).min(old.len()), word..word + 8];
    let find = |place: &std::ops::Range<usize>| {
        bytes.windows(place.len()).position(|window| *window == old[place.clone()])
    };
    let (at, place) = places.into_iter().find_map(|place| Some((find(&place)?, place))).unwrap();
    bytes[at..at + place.len()].copy_from_slice(&new[place]);
    forget_sums(&mut bytes);
    std::fs::write(file, bytes).unwrap();
    changed
}

/// Sets the check sum of every chunk to "not known": somebody who changes a file on purpose would do the same.
fn forget_sums(bytes: &mut [u8]) {
    const CHUNK: u8 = 6;
    let (mut at, head) = (8, 9);
    while at + head < bytes.len() {
        let len = u64::from_le_bytes(bytes[at + 1..at + head].try_into().unwrap()) as usize;
        if bytes[at] == CHUNK {
            bytes[at + head + 24..at + head + 28].fill(0);
        }
        at += head + len;
    }
}

#[test]
fn a_replay_says_the_same_bytes() {
    let folder = scratch("replay_same");
    for (name, args) in [
        ("office", &[OFFICE, "--set", SHORT][..]),
        ("blocked", &["pipelines/office_blocked.toml"]),
        ("unreachable", &["pipelines/office_unreachable.toml"]),
        ("timed", &[OFFICE, "--duration", "7.5"]),
        ("followed", &["pipelines/follow_person.toml"]),
    ] {
        let file = recorded(&folder, name, args);
        let given = replay(&[&file]);
        assert_eq!(given.code, 0, "{name}: {}", given.stderr);
        let report = given.json();
        assert_eq!((&report["is_same"], &report["is_changed"]), (&true.into(), &false.into()), "{report}");
        assert!(report["messages"].as_u64().unwrap() > 100 && report["damage"].is_null(), "{report}");
        assert_eq!(report["recorded_end"], report["replayed_end"]);
        assert!(given.stderr.contains("the same bytes"), "{}", given.stderr);
    }
}

#[test]
fn a_recording_that_an_older_program_made_is_still_replayed() {
    for (schema, n_steps, n_messages) in [(1, 41, 164), (2, 161, 614)] {
        let given = replay(&[&format!("tests/data/recordings/schema_{schema}.mcap")]);
        let report = given.json();
        // Every message that was recorded is understood; whether it is said again depends on today's plugins.
        assert!(given.code < 2 && report["damage"].is_null(), "{report}: {}", given.stderr);
        assert_eq!(
            (&report["steps"], &report["messages"]),
            (&n_steps.into(), &n_messages.into()),
            "{report}"
        );
        let stages = report["differences"].as_array().unwrap();
        assert!(
            stages.iter().all(|found| found["stage"] != "front_laser" && found["stage"] != "wheels"),
            "{report}"
        );
    }
}

#[test]
fn one_flipped_bit_of_a_range_is_traced_to_the_first_stage_that_it_moves() {
    // The filter looks at a few beams only; the avoider at all of them.
    let file = recorded(&scratch("replay_range"), "a.mcap", &[OFFICE, "--set", "localizer.plugin=odometry"]);
    let changed = patch(&file, |observation| {
        let after = observation.stamp.as_secs() > 20.0;
        let Data::LaserScan(scan) = &mut observation.data else { return false };
        let middle = scan.ranges_m.len() / 2;
        let near = |range: f32| (0.2..0.28).contains(&range);
        let flip = |bit: u32, range: f32| f32::from_bits(range.to_bits() ^ (1 << bit));
        let range = scan.ranges_m[middle];
        let Some(bit) = (0..32).find(|bit| near(flip(*bit, range))).filter(|_| after) else { return false };
        scan.ranges_m.make_mut()[middle] = flip(bit, range);
        true
    });
    let given = replay(&[&file]);
    assert_eq!(given.code, 1, "{}", given.stderr);
    let report = given.json();
    let first = &report["differences"][0];
    let time_s = first["time_s"].as_f64().unwrap();
    let late_s = time_s - changed.stamp.as_secs();
    assert!((0.0..0.2).contains(&late_s), "{first} of a scan of {} s", changed.stamp);
    assert!(["avoider", "events"].contains(&first["stage"].as_str().unwrap()), "{first}");
    assert_ne!(first["recorded"], first["replayed"]);
    assert!(given.stderr.contains("first: ") && given.stderr.contains(" was "), "{}", given.stderr);
}

#[test]
fn the_lowest_bit_of_an_odometry_is_found_in_the_estimate() {
    // Dead reckoning keeps every bit; a filter need not.
    let follow = "localizer.plugin=odometry";
    let file = recorded(&scratch("replay_odometry"), "a.mcap", &[OFFICE, "--set", SHORT, "--set", follow]);
    let changed = patch(&file, |observation| {
        let moved = observation.stamp.as_secs() > 5.0;
        let Data::Odometry(odometry) = &mut observation.data else { return false };
        let x = &mut odometry.odom_from_base.translation.x;
        *x = f64::from_bits(x.to_bits() ^ 1);
        moved
    });
    let report = replay(&[&file]).json();
    let first = &report["differences"][0];
    assert_eq!(first["stage"], "localizer", "{report}");
    assert_eq!(first["time_s"].as_f64(), Some(changed.stamp.as_secs()));
    assert!(first["field"].as_str().unwrap().starts_with("map_from_"), "{first}");
}

#[test]
fn a_recording_that_is_cut_anywhere_is_replayed_up_to_the_cut() {
    let folder = scratch("replay_cut");
    let whole = std::fs::read(recorded(&folder, "a.mcap", &[OFFICE, "--duration", "60"])).unwrap();
    let file = folder.join("cut.mcap");
    let steps = |len: usize| {
        std::fs::write(&file, &whole[..len]).unwrap();
        let mut reader = RecordingReader::open(&file).ok()?;
        let mut n_steps = 0;
        while reader.next_step().is_some_and(|step| step.mark.is_some()) {
            n_steps += 1;
        }
        Some((n_steps, reader.damage()))
    };
    let n_all = steps(whole.len()).unwrap().0;
    let mut random = 12345u64;
    for _ in 0..100 {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        let len = (random >> 33) as usize % whole.len();
        let Some((n_steps, damage)) = steps(len) else {
            assert!(len < 20_000, "cut at {len} cannot be opened");
            continue;
        };
        assert!(n_steps <= n_all && (damage.is_some() || n_steps == n_all), "cut at {len}: {damage:?}");
    }
    std::fs::write(&file, &whole[..whole.len() / 2]).unwrap();
    let given = replay(&[file.to_str().unwrap()]);
    assert_eq!(given.code, 0, "{}", given.stderr);
    let report = given.json();
    assert_eq!(report["damage"], "the file is cut off");
    assert!(report["steps"].as_u64().unwrap() > 20, "{report}");
}

#[test]
fn a_swap_reports_figures_and_is_no_failure() {
    let file = recorded(&scratch("replay_swap"), "a.mcap", &[OFFICE, "--set", SHORT]);
    let given = replay(&[&file, "--swap", "planner=a_star"]);
    assert_eq!(given.code, 0, "{}", given.stderr);
    let report = given.json();
    assert_eq!((&report["is_changed"], &report["is_same"]), (&true.into(), &false.into()));
    assert_eq!(report["differences"][0]["stage"], "planner", "{report}");
    let [first, second] = [0, 1].map(|side| report["figures"]["first_path_m"][side].as_f64().unwrap());
    assert!(first > 0.0 && second > 0.0, "{report}");
    let sensor = replay(&[&file, "--swap", "sensor.front_laser=laser_2d"]);
    assert_eq!((sensor.code, &sensor.json()["is_same"]), (0, &true.into()), "{}", sensor.stderr);
    let set = replay(&[&file, "--set", "avoider.rate_hz=7"]);
    assert_eq!(set.code, 0, "{}", set.stderr);
    assert_eq!(set.json()["differences"][0]["stage"], "avoider");
}

#[test]
fn what_cannot_be_replayed_is_bad_input_and_says_why() {
    let folder = scratch("replay_bad");
    let file = recorded(&folder, "a.mcap", &[OFFICE, "--set", SHORT]);
    let text = folder.join("text.mcap");
    std::fs::write(&text, "name = \"no recording\"").unwrap();
    let empty = folder.join("empty.mcap");
    std::fs::write(&empty, "").unwrap();
    for (args, words) in [
        (&[text.to_str().unwrap()][..], "this is no MCAP file"),
        (&[empty.to_str().unwrap()], "begins with nothing"),
        (&["nowhere.mcap"], "cannot read the recording"),
        (&[&file, "--swap", "planner"], "expected SECTION=PLUGIN"),
        (&[&file, "--swap", "planner=a_sta"], "did you mean a_star?"),
        (&[&file, "--swap", "world=log"], "the world of a replay is the recording"),
        (&[&file, "--set", "planner.nothing=1"], "unknown key"),
    ] {
        let given = replay(args);
        assert_eq!(given.code, 2, "{args:?}: {}", given.stderr);
        assert!(given.stderr.contains(words), "{args:?}: {}", given.stderr);
    }
}

#[test]
fn orders_from_outside_are_given_again_in_the_same_step() {
    let folder = scratch("replay_orders");
    let registry = rumbo::registry().ok().unwrap();
    let office = Path::new(env!("CARGO_MANIFEST_DIR")).join(OFFICE);
    let ready = rumbo::load::load(&office, &[], &registry).ok().unwrap();
    let mut engine = Engine::build(&ready.pipeline).unwrap();
    let path = folder.join("a.mcap");
    let header = header_of(&ready, &office, None, &engine);
    let mut recording = RunRecording::create(&path, &header).ok().unwrap();
    let goal = Goal { position: Point2::new(3.0, 6.0), yaw_rad: None };
    for step in 0..400 {
        match step {
            100 => engine.command(Order::Cancel),
            150 => engine.command(Order::GoTo(vec![goal])),
            200 => engine.command(Order::Localize),
            _ => {}
        }
        assert_eq!(engine.step(), Stepped::Went);
        recording.on_step(&engine.view());
    }
    let end = RunEnd { reason: EndReason::Interrupted, detail: None };
    recording.finish(&end, &engine.view()).ok().unwrap();
    let given = replay(&[path.to_str().unwrap()]);
    assert_eq!(given.code, 0, "{}", given.stderr);
    let report = given.json();
    assert_eq!(report["is_same"], true, "{report}");
    assert_eq!(report["figures"]["events"]["Refused"], serde_json::json!([1, 1]), "{report}");
    assert_eq!(report["figures"]["events"]["GoalAccepted"], serde_json::json!([2, 2]), "{report}");
}
