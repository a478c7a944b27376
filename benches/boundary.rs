//! What a call across the plugin boundary costs: the same plugins, linked and as a library's entries.
//!
//! The doubles do next to nothing, so that the difference is the boundary's. `cargo bench --bench boundary`
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, unsafe_code, missing_docs)]

use divan::{Bencher, black_box};
use rumbo_core::boundary::Buffer;
use rumbo_core::boundary::abi::{rumbo_host, rumbo_module};
use rumbo_core::boundary::export::{Exporter, module};
use rumbo_core::boundary::host::Library;
use rumbo_core::frames::{Point2, Pose3, Twist, pose2};
use rumbo_core::map::{Grid, Map};
use rumbo_core::messages::*;
use rumbo_core::registry::{Built, Params, Plugin, Registry, Stage};
use rumbo_core::robot::Robot;
use rumbo_core::stages::*;
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

fn main() {
    divan::main();
}

#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
struct NullParams {}
impl Params for NullParams {}
struct Null(Estimate);

macro_rules! null {
    ($stage:ident, $register:ident) => {
        impl Plugin<dyn $stage> for NullParams {
            fn build(&self, _: &BuildContext) -> Result<Box<dyn $stage>, BuildError> {
                let odom = pose2(0.5, 0.0, 0.1);
                let covariance = nalgebra::Matrix3::identity();
                Ok(Box::new(Null(Estimate::planar(Time(5), pose2(1.0, 2.0, 0.3), odom, covariance))))
            }
        }
        rumbo_core::$register!(NullParams, "null_in_bench", "does nothing");
    };
}
null!(Planner, register_planner);
null!(Avoider, register_avoider);
null!(Localizer, register_localizer);

impl Planner for Null {
    fn plan(&mut self, request: &PlanRequest) -> Result<Path, PlanError> {
        let grid = request.grid.as_ref().ok_or(PlanError::GivenUp)?;
        let start = Point2::from(request.start.translation.vector);
        let height = f64::from(grid.cells[grid.cells.len() / 2]);
        Path::through([start, request.goal.position], height).ok_or(PlanError::GivenUp)
    }
}

impl Avoider for Null {
    fn steer(&mut self, _: &mut Cx<'_>, input: &AvoidInput<'_>) -> Result<Steering, AvoidError> {
        let scan = input.seen.laser_scans().next_back();
        let nearest = scan.map_or(0.0, |(_, scan)| scan.ranges_m.iter().copied().fold(f32::MAX, f32::min));
        Ok(Steering::Drive(Twist::new(nearest.into(), 0.0)))
    }
}

impl Localizer for Null {
    fn start(&mut self, _: &Prior, _: &Map) -> Result<(), LocalizeError> {
        Ok(())
    }
    fn update(&mut self, _: &mut Cx<'_>, seen: Seen<'_>, map: &Map) -> Result<Estimate, LocalizeError> {
        self.0.stamp = Time(seen.len() as i64 + map.version as i64);
        Ok(self.0.clone())
    }
}

unsafe extern "C" fn entry(host: *const rumbo_host) -> *const rumbo_module {
    let packages = &["rumbo", "rumbo-localizers", "rumbo-avoiders", "rumbo-planners"];
    unsafe { module(host, Exporter { packages, crate_info: "bench", unwinds: true }) }
}

/// The same plugins on both sides of the boundary.
#[derive(Debug, Clone, Copy)]
enum Tier {
    Linked,
    Dynamic,
}
const TIERS: [Tier; 2] = [Tier::Linked, Tier::Dynamic];

impl Tier {
    fn stage<T: TryFrom<Built, Error = BuildError>>(self, stage: Stage, name: &str) -> T {
        let mut registry = Registry::default();
        match self {
            Tier::Linked => registry = rumbo::registry().unwrap(),
            Tier::Dynamic => {
                registry.add_library(&unsafe { Library::of_function(entry, "bench.so") }.unwrap()).unwrap();
            }
        }
        let configured = registry.get(stage, name).unwrap().source.parse(toml::Table::new()).ok().unwrap();
        T::try_from(configured.build(&BuildContext::bare(name)).unwrap()).unwrap()
    }
}

fn map(n_cells: u32) -> Map {
    let mut grid = Grid::unknown(n_cells, n_cells, 0.05).unwrap();
    grid.cells.make_mut().fill(-4.0);
    Map { version: 3, grid: Some(grid), ..Map::default() }
}

/// A second of a robot: four scans of 361 beams and twenty odometry readings would be too many for one call; this is
/// one scan and four readings, what a control step sees.
fn seen() -> Vec<Observation> {
    let scan = LaserScan {
        first_bearing_rad: -std::f64::consts::FRAC_PI_2,
        bearing_step_rad: 0.5f64.to_radians(),
        max_range_m: 30.0,
        ranges_m: Buffer::filled(361, 4.0),
        ..LaserScan::default()
    };
    let observation = |stamp: i64, data| Observation {
        sensor: SensorId(0),
        stamp: Time(stamp),
        base_from_sensor: Pose3::identity(),
        valid: true,
        data,
    };
    let odometry = |k: i64| observation(k, Data::Odometry(Odometry::default()));
    (0..4).map(odometry).chain([observation(9, Data::LaserScan(scan))]).collect()
}

#[divan::bench(args = TIERS, consts = [500, 2000])]
fn plan<const CELLS: u32>(bencher: Bencher, tier: Tier) {
    let mut planner: Box<dyn Planner> = tier.stage(Stage::Planner, "null_in_bench");
    let map = map(CELLS);
    let request = PlanRequest {
        stamp: Time(5),
        grid: map.grid.clone(),
        map,
        start: pose2(1.0, 2.0, 0.3),
        goal: Goal { position: Point2::new(20.0, 20.0), yaw_rad: None },
        robot: Arc::new(Robot::default()),
        obstacles: Vec::new(),
        give_up: GiveUp::default(),
        trace: Trace::unwatched(),
    };
    bencher.bench_local(|| planner.plan(black_box(&request)));
}

#[divan::bench(args = TIERS, consts = [500, 2000])]
fn steer<const CELLS: u32>(bencher: Bencher, tier: Tier) {
    let mut avoider: Box<dyn Avoider> = tier.stage(Stage::Avoider, "null_in_bench");
    let (map, seen, robot, trace) = (map(CELLS), seen(), Robot::default(), Trace::unwatched());
    let estimate = Estimate::lost(Time(5));
    let path = Path::through((0..500).map(|k| Point2::new(f64::from(k) * 0.05, 1.0)), 1.0).unwrap();
    bencher.bench_local(|| {
        let input = AvoidInput {
            map_from_base: pose2(1.0, 2.0, 0.3),
            estimate: &estimate,
            twist: Twist::ZERO,
            seen: Seen::sorted(&seen),
            map: &map,
            grid: map.grid.as_ref(),
            path: Some(&path),
            path_number: 1,
            arrival_radius_m: 0.1,
            obstacles: &[],
            robot: &robot,
        };
        avoider.steer(&mut Cx { now: Time(5), trace: &trace }, black_box(&input))
    });
}

#[divan::bench(args = TIERS, consts = [500, 2000])]
fn localize<const CELLS: u32>(bencher: Bencher, tier: Tier) {
    let mut localizer: Box<dyn Localizer> = tier.stage(Stage::Localizer, "null_in_bench");
    let (map, seen, trace) = (map(CELLS), seen(), Trace::unwatched());
    bencher.bench_local(|| {
        let mut cx = Cx { now: Time(5), trace: &trace };
        localizer.update(&mut cx, black_box(Seen::sorted(&seen)), &map)
    });
}

/// The real thing: how little the boundary is beside the work.
#[divan::bench(args = TIERS)]
fn particle_filter_update(bencher: Bencher, tier: Tier) {
    let mut filter: Box<dyn Localizer> = tier.stage(Stage::Localizer, "particle_filter");
    let (map, trace) = (map(400), Trace::unwatched());
    let covariance = nalgebra::Matrix3::identity() * 0.01;
    let start = pose2(10.0, 10.0, 0.0);
    let prior = Prior::Pose { map_from_base: start, odom_from_base: pose2(0.0, 0.0, 0.0), covariance };
    filter.start(&prior, &map).unwrap();
    let mut now = 0i64;
    bencher.bench_local(|| {
        now += 250_000_000;
        let mut seen = seen();
        for observation in &mut seen {
            observation.stamp = Time(now);
            if let Data::Odometry(odometry) = &mut observation.data {
                odometry.odom_from_base = pose2(0.3 * (now as f64 / 1e9), 0.0, 0.0);
            }
        }
        filter.update(&mut Cx { now: Time(now), trace: &trace }, black_box(Seen::sorted(&seen)), &map)
    });
}
