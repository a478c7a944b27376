//! The figures of `docs/benchmarks.md` that concern whole plugins, called as a pipeline calls them: processor time,
//! median and least of several runs.
//!
//! `cargo run --release --locked --example plugin_figures [part...]`; parts are `plan`, `sim`, `run` and `check`. The
//! kernels inside are timed by the example `figures` of `rumbo-kit`.
#![allow(clippy::print_stdout)]

use rumbo_core::engine::Engine;
use rumbo_core::frames::{Pose3, Twist, pose2};
use rumbo_core::map::{Grid, Map};
use rumbo_core::messages::{Command, Goal, Observations};
use rumbo_core::pipeline::Loaded;
use rumbo_core::registry::Plugin;
use rumbo_core::robot::Robot;
use rumbo_core::stages::{BuildContext, Cx, GiveUp, PlanRequest, Planner, Sensor, World};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;
use rumbo_kit::distance_field::squared_distance_field;
use rumbo_kit::generated_world::{GeneratedWorld, query_cells};
use rumbo_planners::{a_star::AStarParams, dp::DpParams};
use rumbo_sensors::{lms200::Lms200Params, wheel_encoders::WheelEncodersParams};
use rumbo_worlds::sim::{SimParams, Start};
use rustix::time::{ClockId, clock_gettime};
use std::error::Error;
use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

type Fallible<T = ()> = Result<T, Box<dyn Error>>;

const OFFICE: &str = "pipelines/office.toml";

fn cpu_ms() -> f64 {
    let now = clock_gettime(ClockId::ProcessCPUTime);
    now.tv_sec as f64 * 1e3 + now.tv_nsec as f64 * 1e-6
}

/// Median and least time of `run`, milliseconds; `prepare` is not timed and gives each run what it works on.
fn timed<T, R>(
    mut prepare: impl FnMut() -> Fallible<T>,
    run: impl Fn(&mut T) -> Fallible<R>,
) -> Fallible<[f64; 2]> {
    const RUNS: usize = 9;
    let mut times_ms = Vec::new();
    for _ in 0..RUNS {
        let mut subject = prepare()?;
        let begin = cpu_ms();
        black_box(run(&mut subject)?);
        times_ms.push(cpu_ms() - begin);
    }
    times_ms.sort_by(f64::total_cmp);
    Ok([times_ms[RUNS / 2], times_ms[0]])
}

fn print(what: &str, [median_ms, least_ms]: [f64; 2]) {
    println!("{what:52} median {median_ms:9.2} ms  least {least_ms:9.2} ms");
}

fn print_factor(what: &str, robot_s: f64, [median_ms, least_ms]: [f64; 2]) {
    let factor = |ms: f64| robot_s * 1e3 / ms;
    let (median, most) = (factor(median_ms), factor(least_ms));
    println!("{what:52} median {median:7.0} x real time  most {most:7.0} x  ({robot_s:.1} s of robot time)");
}

/// A request on a generated map of 5 cm cells: between its query cells, with a robot of the default size.
fn request(world: &GeneratedWorld) -> Fallible<PlanRequest> {
    let side = u32::try_from(world.size.width)?;
    let mut grid = Grid::unknown(side, side, 0.05)?;
    let log_odds = |&cell: &u8| if cell == 0 { -Grid::CERTAIN } else { Grid::CERTAIN };
    for (to, from) in grid.cells.make_mut().iter_mut().zip(&world.occupied) {
        *to = log_odds(from);
    }
    let costs = world.inflated(&squared_distance_field(world.size, &world.occupied));
    let (start, goal) = query_cells(world.size, &costs);
    let [start, goal] = [start, goal].map(|cell| grid.center_of(grid.cell_of(cell)));
    Ok(PlanRequest {
        stamp: Time::ZERO,
        map: Map::default(),
        grid: Some(grid),
        start: pose2(start.x, start.y, 0.0),
        goal: Goal { position: goal, yaw_rad: None },
        robot: Arc::new(Robot::default()),
        obstacles: Vec::new(),
        give_up: GiveUp::default(),
        trace: Trace::unwatched(),
    })
}

/// Whole calls: on a map that the planner has not seen, on the same map again, and with an obstacle more.
fn plans(name: &str, params: &impl Plugin<dyn Planner>) -> Fallible {
    for (map, world) in [
        ("indoor 2000", GeneratedWorld::indoor(2000, 2042)),
        ("open 2000", GeneratedWorld::open_ground(2000, 2007)),
        ("indoor 4000", GeneratedWorld::indoor(4000, 4042)),
    ] {
        let request_before = request(&world)?;
        let mut request_after = request(&world)?;
        if let Some(grid) = &mut request_after.grid {
            let beside_start = request_before.start.translation.vector + nalgebra::Vector2::new(1.0, 1.0);
            grid.occupy_disc(beside_start.into(), 0.2);
        }
        let new = || -> Fallible<Box<dyn Planner>> { Ok(params.build(&BuildContext::bare("planner"))?) };
        let used = || {
            let mut planner = new()?;
            planner.plan(&request_before)?;
            Ok(planner)
        };
        let again = |planner: &mut Box<dyn Planner>| Ok(planner.plan(&request_before)?);
        print(&format!("{name}, {map}, first plan"), timed(new, again)?);
        print(&format!("{name}, {map}, planned again"), timed(used, again)?);
        let more = |planner: &mut Box<dyn Planner>| Ok(planner.plan(&request_after)?);
        print(&format!("{name}, {map}, an obstacle more"), timed(used, more)?);
    }
    Ok(())
}

/// A simulated office with a robot that has a laser scanner and wheel encoders.
struct Simulated {
    world: Box<dyn World>,
    sensors: [(Box<dyn Sensor>, i64); 2],
    due_ns: [i64; 2],
    observations: Observations,
}

impl Simulated {
    fn new(map: &str, (x_m, y_m): (f64, f64)) -> Fallible<Self> {
        let start = Start { x_m, y_m, yaw_deg: 0.0 };
        let map = Some(Path::new("pipelines/worlds").join(map));
        let world = SimParams { map, start, ..SimParams::default() }.build(&BuildContext::bare("world"))?;
        let mount = BuildContext {
            base_from_sensor: Pose3::translation(0.0, 0.0, 0.3),
            ..BuildContext::bare("laser")
        };
        let laser = Lms200Params::default().build(&mount)?;
        let wheels = WheelEncodersParams::default().build(&BuildContext::bare("wheels"))?;
        // 37.5 scans of 361 beams and 20 looks at the wheels in a second.
        let sensors = [(laser, 26_666_667), (wheels, 50_000_000)];
        let mut simulated = Self { world, sensors, due_ns: [0, 0], observations: Observations::default() };
        // The first scan prepares the place for rays.
        simulated.run_until(1)?;
        Ok(simulated)
    }

    /// Drives in a circle of 0.8 m radius.
    fn run_until(&mut self, robot_s: i64) -> Fallible {
        let trace = Trace::unwatched();
        let command = Command { twist: Twist::new(0.2, 0.25), ..Command::default() };
        loop {
            let idx = usize::from(self.due_ns[1] < self.due_ns[0]);
            let now = Time(self.due_ns[idx]);
            if now.0 >= robot_s * 1_000_000_000 {
                return Ok(());
            }
            self.world.advance(now)?;
            if idx == 1 {
                self.world.drive(&command)?;
            }
            let (sensor, period_ns) = &mut self.sensors[idx];
            sensor.poll(&mut Cx { now, trace: &trace }, &mut *self.world, &mut self.observations)?;
            self.due_ns[idx] += *period_ns;
            while let Some(observation) = self.observations.pop_front() {
                self.observations.recycle(observation);
            }
        }
    }
}

/// World and sensor plugins, nothing else: a minute at each of four places in different rooms.
fn simulations() -> Fallible {
    const ROBOT_S: i64 = 60;
    const PLACES_M: [(f64, f64); 4] = [(3.0, 4.5), (2.0, 8.0), (10.0, 8.0), (24.0, 19.0)];
    for map in ["office-20m.yaml", "office_people.toml"] {
        let prepare = || PLACES_M.map(|place| Simulated::new(map, place)).into_iter().collect();
        let run = |simulated: &mut Vec<Simulated>| {
            simulated.iter_mut().try_for_each(|simulated| simulated.run_until(ROBOT_S + 1))
        };
        let robot_s = (ROBOT_S * PLACES_M.len() as i64) as f64;
        print_factor(
            &format!("simulator with its sensors, {map}"),
            robot_s,
            timed::<Vec<_>, _>(prepare, run)?,
        );
    }
    Ok(())
}

/// The office crossing from the built engine to the goal, all stages included.
fn runs() -> Fallible {
    for scans_hz in ["5.0", "37.5"] {
        let sets = [format!("sensor.front_laser.rate_hz={scans_hz}")];
        let registry = rumbo::registry().map_err(|failure| failure.to_string())?;
        let loaded = Loaded::read(Path::new(OFFICE), &sets, &registry);
        let pipeline = loaded.sound().ok_or_else(|| loaded.lines().join("\n"))?;
        let times_ms = timed(
            || Ok(Engine::build(pipeline)?),
            |engine| {
                engine.run(&mut [], &AtomicBool::new(false));
                Ok(())
            },
        )?;
        let mut engine = Engine::build(pipeline)?;
        engine.run(&mut [], &AtomicBool::new(false));
        let robot_s = engine.view().now.0 as f64 * 1e-9;
        print_factor(&format!("office crossing, {scans_hz} scans a second"), robot_s, times_ms);
    }
    Ok(())
}

/// All of `rumbo check pipelines/office.toml`.
fn check() -> Fallible {
    let times_ms = timed(
        || Ok(()),
        |()| {
            let registry = rumbo::registry().map_err(|failure| failure.to_string())?;
            let mut loaded = Loaded::read(Path::new(OFFICE), &[], &registry);
            loaded.check();
            Ok(loaded.sound().map(|_| ()).ok_or_else(|| loaded.lines().join("\n"))?)
        },
    )?;
    print("rumbo check, office", times_ms);
    Ok(())
}

fn main() -> Fallible {
    let wanted: Vec<String> = std::env::args().skip(1).collect();
    let is_wanted = |part: &str| wanted.is_empty() || wanted.iter().any(|word| word == part);
    if is_wanted("plan") {
        plans("dp", &DpParams::default())?;
        plans("a_star", &AStarParams::default())?;
    }
    if is_wanted("sim") {
        simulations()?;
    }
    if is_wanted("run") {
        runs()?;
    }
    if is_wanted("check") {
        check()?;
    }
    Ok(())
}
