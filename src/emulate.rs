//! `rumbo emulate`: a robot that is not there, behind lines as real ones have them.

mod source;

use crate::exit::{Exit, Failure};
use crate::run::on_interrupt;
use crate::terminal::Terminal;
use rumbo_core::stages::{BuildError, OwnDevice};
use rumbo_kit::emulation::{LineFaultParams, Outlet, models};
use rumbo_worlds::robot::emulated::EmulatedRobot;
use rumbo_worlds::sim::Start;
use serde::Serialize;
use source::{Device, Source};
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::Duration;

const EXAMPLES: &str = "\
Examples:
  rumbo emulate robot pipelines/office_robot.toml
  rumbo emulate lms200 pipelines/office_robot.toml --tcp 127.0.0.1:4001
  rumbo emulate base pipelines/worlds/office-20m.yaml --start 3.0,4.5,90 --loss 1e-4 --unplug-every 30

The addresses go to standard output, one device a line: name, model, address. Interrupt it (Ctrl-C) to end it.";

/// Emulate a robot or one of its devices in real time, for the world `robot` to drive
///
/// Base and devices are at pseudo-terminals, or with --tcp at ports; all see the same simulated robot. A pipeline with
/// the world `robot` and a table `emulate` says where the robot stands and what its sensors are; so does one with the
/// world `sim`. A world file or map stands for a robot with an LMS 200 in it.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// `robot` for all of it, `base`, or the model of a device such as `lms200`
    what: String,
    /// A pipeline, a world file or a map
    file: PathBuf,
    /// Change a value of the pipeline, for example --set world.emulate.sonars=0
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
    /// Where the robot stands: meters, meters, degrees; instead of what the pipeline says
    #[arg(long, value_name = "X,Y,YAW", value_parser = start_of, allow_hyphen_values = true)]
    start: Option<Start>,
    /// Ports of TCP instead of pseudo-terminals: the first device gets this one, the next ones those that follow; with
    /// port 0 all get one that is free
    #[arg(long, value_name = "HOST:PORT")]
    tcp: Option<String>,
    /// Pseudo-terminals: what is used where there are such
    #[arg(long, conflicts_with = "tcp")]
    pty: bool,
    /// Share of bytes that get lost on the lines
    #[arg(long, value_name = "SHARE")]
    loss: Option<f64>,
    /// Share of bytes in which one bit flips
    #[arg(long, value_name = "SHARE")]
    flips: Option<f64>,
    /// The plugs are pulled once in so many seconds
    #[arg(long, value_name = "SECONDS")]
    unplug_every: Option<f64>,
    /// They stay pulled so long
    #[arg(long, value_name = "SECONDS")]
    unplug_for: Option<f64>,
    /// Seed of slip, errors and faults, instead of the pipeline's
    #[arg(long)]
    seed: Option<u64>,
    /// End after so many seconds
    #[arg(long, value_name = "SECONDS", value_parser = seconds_of)]
    duration: Option<f64>,
    /// Print the addresses as JSON
    #[arg(long)]
    json: bool,
}

/// The word for everything, and that for the base.
const ROBOT: &str = "robot";
const BASE: &str = "base";

fn start_of(text: &str) -> Result<Start, String> {
    let wrong = || format!("`{text}` is no place, expected meters, meters and degrees such as 3.0,4.5,90");
    let numbers: Vec<f64> =
        text.split(',').map(|part| part.trim().parse()).collect::<Result<_, _>>().map_err(|_| wrong())?;
    match *numbers.as_slice() {
        [x_m, y_m] => Ok(Start { x_m, y_m, yaw_deg: 0.0 }),
        [x_m, y_m, yaw_deg] => Ok(Start { x_m, y_m, yaw_deg }),
        _ => Err(wrong()),
    }
}

fn seconds_of(text: &str) -> Result<f64, String> {
    let seconds: f64 = text.parse().map_err(|_| format!("`{text}` is not a number"))?;
    let fits = seconds > 0.0 && seconds.is_finite();
    if fits { Ok(seconds) } else { Err(format!("is {text}, expected a finite number above zero")) }
}

/// One line of the output.
#[derive(Debug, Serialize)]
struct Served {
    name: String,
    model: String,
    address: String,
}

/// Does it.
pub fn run(args: &Args, terminal: &Terminal) -> Result<Exit, Failure> {
    args.check_what()?;
    let mut source = source::read(&args.file, &args.sets, args.json, terminal)?;
    args.change(&mut source);
    if let Some(fault) = source.emulate.check().into_iter().next() {
        return Err(refused(&fault));
    }
    let interrupt = on_interrupt()?;
    let place = source.emulate.place(&source.context).map_err(|fault| refused(&fault))?;
    let mut robot = EmulatedRobot::new(place, &source.emulate, &source.context);
    let served = args.serve(&mut robot, &source)?;
    if args.json {
        terminal.json(&served)?;
    } else {
        let line = |one: &Served| format!("{} {} {}", one.name, one.model, one.address);
        let lines: String = served.iter().map(|one| line(one) + "\n").collect();
        terminal.data(&lines)?;
    }
    if source.is_robot {
        terminal.say(format!("drive it from another terminal:\n  {}", command_line(args, &served)));
    }
    terminal.say("Ctrl-C ends it");
    wait(args.duration, || interrupt.load(Ordering::Relaxed) || !robot.is_alive());
    if robot.is_alive() {
        return Ok(Exit::Success);
    }
    Err(Failure::Internal("an emulated device has panicked; this is a bug".to_owned()))
}

fn refused(fault: &BuildError) -> Failure {
    // What stands in the table `emulate` of a pipeline may come from the command line here.
    let help = fault.help.as_ref().map(|help| format!("\n  help: {help}")).unwrap_or_default();
    Failure::Usage(format!("{}: {}{help}", fault.path.trim_start_matches("emulate."), fault.message))
}

/// Until it is over. Counted in short sleeps: nothing here needs to be exact.
fn wait(duration_s: Option<f64>, is_over: impl Fn() -> bool) {
    const LOOK: Duration = Duration::from_millis(50);
    let n_looks = duration_s.map(|seconds| (seconds / LOOK.as_secs_f64()).ceil() as u64);
    let mut n_looked = 0;
    while !is_over() && n_looks.is_none_or(|n_looks| n_looked < n_looks) {
        std::thread::sleep(LOOK);
        n_looked += 1;
    }
}

/// What drives the robot, with the addresses in place of the ports.
fn command_line(args: &Args, served: &[Served]) -> String {
    let set = |one: &Served| match one.model.as_str() {
        BASE => format!(" --set world.port={}", one.address),
        _ => format!(" --set sensor.{}.port={}", one.name, one.address),
    };
    let sets: String = served.iter().map(set).collect();
    format!("rumbo run {} --set world.emulate.enabled=false{sets}", args.file.display())
}

impl Args {
    fn check_what(&self) -> Result<(), Failure> {
        let mut devices: Vec<&str> = models().map(|model| model.name).collect();
        // They come in the linker's order.
        devices.sort_unstable();
        let known = [&[ROBOT, BASE], devices.as_slice()].concat();
        if known.contains(&self.what.as_str()) {
            return Ok(());
        }
        let expected = known.join(", ");
        Err(Failure::Usage(format!("nothing emulates `{}`, expected one of {expected}", self.what)))
    }

    /// What the command line says instead of the file.
    fn change(&self, source: &mut Source) {
        if let Some(seed) = self.seed {
            source.context.seed = seed;
        }
        let emulate = &mut source.emulate;
        emulate.start = self.start.unwrap_or(emulate.start);
        let LineFaultParams { loss, flips, unplug_every_s, unplug_for_s } = emulate.faults;
        emulate.faults = LineFaultParams {
            loss: self.loss.unwrap_or(loss),
            flips: self.flips.unwrap_or(flips),
            unplug_every_s: self.unplug_every.unwrap_or(unplug_every_s),
            unplug_for_s: self.unplug_for.unwrap_or(unplug_for_s),
        };
    }

    fn serve(&self, robot: &mut EmulatedRobot, source: &Source) -> Result<Vec<Served>, Failure> {
        let mut served = Vec::new();
        if self.what == ROBOT || self.what == BASE {
            let outlet = self.outlet(served.len())?;
            let address = robot.serve_base(outlet).map_err(|error| Failure::Usage(error.to_string()))?;
            served.push(Served { name: BASE.to_owned(), model: BASE.to_owned(), address });
        }
        let is_wanted = |device: &&Device| self.what == ROBOT || self.what == device.model;
        for Device { name, model, base_from_sensor } in source.devices(&self.what).iter().filter(is_wanted) {
            let device = OwnDevice { model, name, base_from_sensor };
            let address = robot.serve_device(&device, self.outlet(served.len())?);
            let address = address.map_err(|error| Failure::Usage(error.to_string()))?;
            served.push(Served { name: name.clone(), model: model.clone(), address });
        }
        Ok(served)
    }

    /// Where device number `idx` can be reached.
    fn outlet(&self, idx: usize) -> Result<Outlet, Failure> {
        let Some(first) = &self.tcp else {
            let none =
                |error| Failure::Usage(format!("there is no pseudo-terminal to be had: {error}; use --tcp"));
            return Outlet::any().map_err(none);
        };
        let wrong =
            |why: &str| Failure::Usage(format!("--tcp {first}: {why}, expected such as 127.0.0.1:4001"));
        let (host, port) = first.rsplit_once(':').ok_or_else(|| wrong("has no port"))?;
        let port: u16 = port.parse().map_err(|_| wrong("has no port"))?;
        let idx = u16::try_from(idx).unwrap_or(u16::MAX);
        let next = if port == 0 { Some(0) } else { port.checked_add(idx) };
        let address = format!("{host}:{}", next.ok_or_else(|| wrong("has no port for all devices"))?);
        Outlet::tcp(&address).map_err(|error| Failure::Usage(format!("--tcp {address}: {error}")))
    }
}
