use std::io::{BufRead as _, BufReader};
use std::process::{Child, Stdio};

use super::*;

const ROBOT: &str = "pipelines/office_robot.toml";

#[test]
fn what_cannot_be_emulated_is_told_with_what_can() {
    let office = "pipelines/worlds/office-20m.yaml";
    let tableless =
        "--set=world={ plugin = \"robot\", port = \"/dev/ttyUSB9\", map = \"worlds/office-20m.yaml\" }";
    for (args, expected) in [
        (vec!["toaster", ROBOT], "expected one of robot, base, gps, imu, lms200"),
        (vec!["robot", "no_such_file.toml"], "there is no such file"),
        (vec!["robot", "pipelines/mapping_log.toml"], "nothing emulates the world `log`"),
        (vec!["robot", ROBOT, tableless], "has no table `emulate`"),
        (vec!["base", office], "choose a start in free space"),
        (vec!["base", office, "--start", "3"], "expected meters, meters and degrees"),
        (vec!["base", office, "--start", "3,4.5", "--loss", "2"], "faults.loss: is 2, expected a share"),
        (vec!["base", office, "--start", "3,4.5", "--tcp", "4001"], "has no port"),
        (vec!["base", office, "--start", "3,4.5", "--tcp", "256.0.0.1:0"], "--tcp 256.0.0.1:0: "),
        (vec!["robot", ROBOT, "--tcp", "127.0.0.1:65535"], "has no port for all devices"),
        (vec!["base", office, "--duration", "0"], "expected a finite number above zero"),
        (vec!["base", office, "--set", "seed=3"], "is no pipeline"),
    ] {
        let given = give(&[&["emulate"], &args[..]].concat());
        assert_eq!(given.code, 2, "{args:?}: {}", given.stderr);
        assert!(given.stderr.contains(expected), "{args:?}: {}", given.stderr);
    }
}

/// An emulator that lives until this is dropped.
struct Emulator {
    child: Child,
    /// Name, model and address of each device.
    lines: Vec<String>,
}

impl Emulator {
    fn start(args: &[&str], n_devices: usize) -> Emulator {
        let mut child = rumbo(&[&["emulate"], args].concat())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let out = BufReader::new(child.stdout.take().unwrap());
        let lines = out.lines().take(n_devices).map(Result::unwrap).collect();
        Emulator { child, lines }
    }

    fn address(&self, name: &str) -> &str {
        let line = self.lines.iter().find(|line| line.starts_with(&format!("{name} "))).unwrap();
        line.rsplit(' ').next().unwrap()
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn run_against(emulator: &Emulator, more: &[&str]) -> Given {
    let base = format!("world.port={}", emulator.address("base"));
    let laser = format!("sensor.front_laser.port={}", emulator.address("front_laser"));
    let sets = [
        "run",
        ROBOT,
        "--no-report",
        "--json",
        "--set",
        "world.emulate.enabled=false",
        "--set",
        &base,
        "--set",
    ];
    give(&[&sets[..], &[laser.as_str()], more].concat())
}

/// Two terminals: the robot in one, the run in the other; over TCP, and on a bad line.
#[test]
fn a_robot_emulated_by_one_process_is_driven_by_another() {
    let args = ["robot", ROBOT, "--tcp", "127.0.0.1:0", "--loss", "1e-4", "--flips", "1e-4"];
    let emulator = Emulator::start(&args, 2);
    assert!(emulator.address("base").starts_with("tcp://127.0.0.1:"), "{:?}", emulator.lines);
    let given = run_against(&emulator, &["--set", "mission.waypoints=[{ x_m = 3.0, y_m = 4.8 }]"]);
    assert_eq!(given.code, 0, "{}", given.stderr);
    assert_eq!(given.json()["reason"], "arrived");
    assert!(given.stderr.contains("the base EMULATED answers"), "{}", given.stderr);
}

#[cfg(unix)]
#[test]
fn a_plug_that_is_pulled_is_told_and_the_run_goes_on() {
    let args = ["robot", ROBOT, "--unplug-every", "6", "--unplug-for", "1.5"];
    let emulator = Emulator::start(&args, 2);
    assert!(emulator.address("base").starts_with("/dev/"), "{:?}", emulator.lines);
    let given = run_against(&emulator, &[]);
    assert_eq!(given.code, 0, "{}", given.stderr);
    assert!(given.stderr.contains("the base is lost: it has said nothing for 0.5 s"), "{}", given.stderr);
}

#[test]
fn an_emulator_ends_after_its_duration_and_tells_its_addresses_as_json() {
    let office = "pipelines/worlds/office-20m.yaml";
    let given = give(&["emulate", "robot", office, "--start", "3,4.5", "--json", "--duration", "0.1"]);
    assert_eq!(given.code, 0, "{}", given.stderr);
    let models: Vec<String> = given
        .json()
        .as_array()
        .unwrap()
        .iter()
        .map(|one| one["model"].as_str().unwrap().to_owned())
        .collect();
    assert_eq!(models, ["base", "lms200"]);
}

/// They talk by themselves: what a host hears begins with a sentence, or a record.
#[test]
fn a_receiver_and_a_board_are_emulated_alone_and_talk_by_themselves() {
    use std::io::Read as _;
    let office = "pipelines/worlds/dc_office.toml";
    for (what, first) in [("gps", "$GPGGA,12"), ("imu", "Y: ")] {
        let emulator = Emulator::start(&[what, office, "--start=-3.97,-4.0,90", "--tcp", "127.0.0.1:0"], 1);
        let address = emulator.address(what).trim_start_matches("tcp://").to_owned();
        let mut host = std::net::TcpStream::connect(address).unwrap();
        let mut heard = String::new();
        while !heard.contains(first) {
            let mut piece = [0u8; 64];
            let n_bytes = host.read(&mut piece).unwrap();
            heard.push_str(std::str::from_utf8(&piece[..n_bytes]).unwrap());
            assert!(n_bytes > 0 && heard.len() < 10_000, "{heard}");
        }
    }
}

/// In one process, and recorded: the recording gives every estimate again, to the bit.
#[test]
fn the_emulated_office_robot_arrives_in_real_time_and_its_recording_replays() {
    let recording = scratch("emulate_replay").join("run.mcap");
    let recording = recording.to_str().unwrap();
    let short = "mission.waypoints=[{ x_m = 3.0, y_m = 4.8 }]";
    let run = give(&["run", ROBOT, "--no-report", "--json", "--record", recording, "--set", short]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let figures = run.json();
    assert_eq!((&figures["reason"], &figures["contacts"]), (&"arrived".into(), &0.into()));
    let replay = give(&["replay", recording]);
    assert!(replay.stderr.contains("recorded in real time"), "{}", replay.stderr);
    let told = format!("{}{}", replay.stdout, replay.stderr);
    assert!(told.contains("position differs by 0.000 m in the mean, 0.000 m at most"), "{told}");
    assert!(told.contains("end: arrived -> arrived"), "{told}");
}

#[test]
fn a_robot_that_is_not_there_ends_the_run_with_what_to_do() {
    let sets = ["world.emulate.enabled=false", "world.port=/dev/no_such_port", "world.give_up_s=1.0"];
    let sets: Vec<&str> = sets.into_iter().flat_map(|set| ["--set", set]).collect();
    let given = give(&[&["run", ROBOT, "--no-report"], &sets[..]].concat());
    assert_eq!(given.code, 1);
    for part in ["the base at /dev/no_such_port", "is the device plugged in?"] {
        assert!(given.stderr.contains(part), "{}", given.stderr);
    }
}
