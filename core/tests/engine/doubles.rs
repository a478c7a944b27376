//! Stages that are as simple as can be: an endless floor, perfect wheels, a beeline.

use rumbo_core::frames::{Point2, Pose2, Twist, lift, pose2};
use rumbo_core::map::{Grid, Layer, Map};
use rumbo_core::messages::*;
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::stages::*;
use rumbo_core::time::{Span, Time};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Mutex;

/// What doubles saw, as (name of the instance, words).
pub static LOG: Mutex<Vec<(String, String)>> = Mutex::new(Vec::new());

pub fn logged(name: &str) -> Vec<String> {
    LOG.lock().unwrap().iter().filter(|(n, _)| n == name).map(|(_, words)| words.clone()).collect()
}

macro_rules! params {
    ($(#[$doc:meta])* $name:ident { $($field:ident: $t:ty = $default:expr),* $(,)? }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
        #[serde(default, deny_unknown_fields)]
        pub struct $name { $(pub $field: $t),* }
        impl Default for $name {
            fn default() -> Self { $name { $($field: $default),* } }
        }
        impl Params for $name {}
    };
}

params!(
    /// An endless floor with one wall across.
    FloorParams { wall_x_m: f64 = 1e9, real_time: bool = false, drives: bool = true, ends_at_s: f64 = 1e9, recorded_s: Vec<f64> = vec![] }
);
struct Floor {
    params: FloorParams,
    now: Time,
    twist: Twist,
    rolled_m: [f64; 2],
    truth: Truth,
    ranges: Vec<f32>,
    track_m: f64,
}
impl Plugin<dyn World> for FloorParams {
    fn build(&self, context: &BuildContext) -> Result<Box<dyn World>, BuildError> {
        let rumbo_core::robot::Drive::Differential { track_m } = context.robot.drive else {
            return Err(BuildError::at("", "this floor is for two wheels"));
        };
        Ok(Box::new(Floor {
            params: self.clone(),
            now: Time::ZERO,
            twist: Twist::ZERO,
            rolled_m: [0.0; 2],
            truth: Truth {
                map_from_base: lift(&Pose2::identity()),
                twist: Twist::ZERO,
                clearance_m: f64::INFINITY,
                contact_episodes: Some(0),
                driven_contact_episodes: Some(0),
            },
            ranges: Vec::with_capacity(1024),
            track_m,
        }))
    }
}
impl World for Floor {
    fn now(&self) -> Time {
        self.now
    }
    fn advance(&mut self, to: Time) -> Result<Advance, WorldError> {
        if to < self.now {
            return Err(WorldError::Backwards { now: self.now, to });
        }
        if to > Time::from_secs(self.params.ends_at_s) {
            return Ok(Advance::Ended);
        }
        let seconds = (to - self.now).as_secs();
        let step = lift(&self.twist.integrate(seconds));
        self.truth.map_from_base *= step;
        self.truth.clearance_m = self.params.wall_x_m - self.truth.map_from_base.translation.x - 0.2;
        let half = self.twist.turn_rad_s * self.track_m / 2.0;
        self.rolled_m[0] += (self.twist.forward_m_s - half) * seconds;
        self.rolled_m[1] += (self.twist.forward_m_s + half) * seconds;
        self.now = to;
        Ok(Advance::Reached(to))
    }
    fn drive(&mut self, command: &Command) -> Result<Drove, WorldError> {
        if !self.params.drives {
            return Ok(Drove::NotActuated);
        }
        self.twist = command.twist;
        Ok(Drove::Drove)
    }
    fn probe<'w>(&'w mut self, probe: &Probe<'_>) -> Result<Answer<'w>, WorldError> {
        match probe {
            Probe::Wheels => Ok(Answer::Wheels(WheelMotion {
                rolled_m: [self.rolled_m[0], self.rolled_m[1], 0.0, 0.0],
                n_wheels: 2,
                twist: self.twist,
                ..WheelMotion::default()
            })),
            Probe::Beams { first_bearing_rad, bearing_step_rad, n_beams, max_range_m, .. } => {
                let pose = rumbo_core::frames::flatten(&self.truth.map_from_base);
                self.ranges.clear();
                for k in 0..*n_beams {
                    let bearing = pose.rotation.angle() + first_bearing_rad + bearing_step_rad * k as f64;
                    let range = (self.params.wall_x_m - pose.translation.x) / bearing.cos();
                    let seen = range > 0.0 && range <= *max_range_m;
                    self.ranges.push(if seen { range as f32 } else { f32::INFINITY });
                }
                Ok(Answer::Ranges(&self.ranges))
            }
            other => Err(WorldError::Unsupported { probe: other.name() }),
        }
    }
    fn truth(&self) -> Option<&Truth> {
        Some(&self.truth)
    }
    fn start(&self) -> Option<Pose2> {
        Some(Pose2::identity())
    }
    fn is_real_time(&self) -> bool {
        self.params.real_time
    }
    fn next_recorded(&self) -> Option<Time> {
        self.params.recorded_s.iter().map(|s| Time::from_secs(*s)).find(|t| *t > self.now)
    }
}
rumbo_core::register_world!(FloorParams, "floor", "an endless floor");

params!(
    /// Perfect wheels, perhaps late, perhaps broken.
    WheelsParams { delay_s: f64 = 0.0, poison_after_s: f64 = 1e9 }
);
struct Wheels {
    params: WheelsParams,
    context: BuildContext,
    last_m: [f64; 2],
    pose: Pose2,
}
impl Plugin<dyn Sensor> for WheelsParams {
    fn manifest(&self) -> Manifest {
        Manifest { produces: vec![ObservationKind::Odometry], ..Manifest::default() }
    }
    fn build(&self, context: &BuildContext) -> Result<Box<dyn Sensor>, BuildError> {
        let (params, context) = (self.clone(), context.clone());
        Ok(Box::new(Wheels { params, context, last_m: [0.0; 2], pose: Pose2::identity() }))
    }
}
impl Sensor for Wheels {
    fn poll(
        &mut self,
        cx: &mut Cx<'_>,
        world: &mut dyn World,
        out: &mut Observations,
    ) -> Result<(), SensorError> {
        let Answer::Wheels(motion) = world.probe(&Probe::Wheels)? else {
            return Err(SensorError::Other("?".into()));
        };
        let rumbo_core::robot::Drive::Differential { track_m } = self.context.robot.drive else {
            return Ok(());
        };
        let (left, right) = (motion.rolled_m[0] - self.last_m[0], motion.rolled_m[1] - self.last_m[1]);
        self.last_m = [motion.rolled_m[0], motion.rolled_m[1]];
        self.pose *= Twist::new((left + right) / 2.0, (right - left) / track_m).integrate(1.0);
        let poisoned = cx.now > Time::from_secs(self.params.poison_after_s);
        let twist = if poisoned { Twist::new(f64::NAN, 0.0) } else { motion.twist };
        out.push(Observation {
            sensor: self.context.sensor,
            stamp: cx.now - Span::from_secs(self.params.delay_s),
            base_from_sensor: self.context.base_from_sensor,
            valid: true,
            data: Data::Odometry(Odometry { odom_from_base: self.pose, twist, noise: [0.01; 3] }),
        });
        Ok(())
    }
}
rumbo_core::register_sensor!(WheelsParams, "wheels", "perfect wheels");

params!(
    /// A scanner of 181 beams.
    ScannerParams { silent_after_s: f64 = 1e9 }
);
struct Scanner(ScannerParams, BuildContext);
impl Plugin<dyn Sensor> for ScannerParams {
    fn manifest(&self) -> Manifest {
        Manifest { produces: vec![ObservationKind::LaserScan], ..Manifest::default() }
    }
    fn build(&self, context: &BuildContext) -> Result<Box<dyn Sensor>, BuildError> {
        Ok(Box::new(Scanner(self.clone(), context.clone())))
    }
}
impl Sensor for Scanner {
    fn poll(
        &mut self,
        cx: &mut Cx<'_>,
        world: &mut dyn World,
        out: &mut Observations,
    ) -> Result<(), SensorError> {
        if cx.now > Time::from_secs(self.0.silent_after_s) {
            return Ok(());
        }
        let (first, step) = (-std::f64::consts::FRAC_PI_2, std::f64::consts::PI / 180.0);
        let probe = Probe::Beams {
            base_from_sensor: &self.1.base_from_sensor,
            first_bearing_rad: first,
            bearing_step_rad: step,
            n_beams: 181,
            max_range_m: 8.0,
        };
        let Answer::Ranges(exact) = world.probe(&probe)? else { return Err(SensorError::Other("?".into())) };
        let mut ranges_m = out.buffer(exact.len());
        ranges_m.make_mut().copy_from_slice(exact);
        let scan = LaserScan {
            first_bearing_rad: first,
            bearing_step_rad: step,
            max_range_m: 8.0,
            ranges_m,
            ..LaserScan::default()
        };
        out.push(Observation {
            sensor: self.1.sensor,
            stamp: cx.now,
            base_from_sensor: self.1.base_from_sensor,
            valid: true,
            data: Data::LaserScan(scan),
        });
        Ok(())
    }
}
rumbo_core::register_sensor!(ScannerParams, "scanner", "181 beams");

params!(
    /// A virtual sensor: the shortest beam of a scan as one sonar.
    ShortestParams {}
);
struct Shortest(BuildContext);
impl Plugin<dyn Sensor> for ShortestParams {
    fn manifest(&self) -> Manifest {
        Manifest { produces: vec![ObservationKind::RangeRing], is_virtual: true, ..Manifest::default() }
    }
    fn build(&self, context: &BuildContext) -> Result<Box<dyn Sensor>, BuildError> {
        Ok(Box::new(Shortest(context.clone())))
    }
}
impl Sensor for Shortest {
    fn poll(&mut self, _: &mut Cx<'_>, _: &mut dyn World, _: &mut Observations) -> Result<(), SensorError> {
        Ok(())
    }
    fn derive(
        &mut self,
        _: &mut Cx<'_>,
        inputs: Seen<'_>,
        out: &mut Observations,
    ) -> Result<(), SensorError> {
        for (observation, scan) in inputs.laser_scans() {
            let mut ranges_m = out.buffer(1);
            ranges_m.make_mut()[0] = scan.ranges_m.iter().copied().fold(f32::INFINITY, f32::min);
            let ring = RangeRing { cone_rad: 3.0, max_range_m: 8.0, ranges_m, ..RangeRing::default() };
            let data = Data::RangeRing(ring);
            out.push(Observation { sensor: self.0.sensor, data, ..observation.clone() });
        }
        Ok(())
    }
}
rumbo_core::register_sensor!(ShortestParams, "shortest", "the shortest beam");

params!(
    /// Dead reckoning that writes down what it sees, and may lose itself.
    ReckoningParams { scale: f64 = 1.0, lost_at_s: f64 = 1e9, fails: bool = false, needs_grid: bool = false, stands: bool = false }
);
struct Reckoning {
    params: ReckoningParams,
    name: String,
    map_from_odom: Option<Pose2>,
    odom: Pose2,
}
impl Plugin<dyn Localizer> for ReckoningParams {
    fn manifest(&self) -> Manifest {
        let needs_layers = if self.needs_grid { vec![Layer::Grid] } else { Vec::new() };
        Manifest { needs_layers, consumes: vec![vec![ObservationKind::Odometry]], ..Manifest::default() }
    }
    fn build(&self, context: &BuildContext) -> Result<Box<dyn Localizer>, BuildError> {
        let (params, name) = (self.clone(), context.name.clone());
        Ok(Box::new(Reckoning { params, name, map_from_odom: None, odom: Pose2::identity() }))
    }
}
impl Localizer for Reckoning {
    fn start(&mut self, prior: &Prior, _: &Map) -> Result<(), LocalizeError> {
        let Prior::Pose { map_from_base, odom_from_base, .. } = prior else {
            return Err(LocalizeError::Prior { prior: "nothing", needs: "a pose" });
        };
        self.map_from_odom = Some(map_from_base * odom_from_base.inverse());
        Ok(())
    }
    fn update(&mut self, cx: &mut Cx<'_>, seen: Seen<'_>, _: &Map) -> Result<Estimate, LocalizeError> {
        if self.params.fails {
            return Err(LocalizeError::Other("told to fail".into()));
        }
        if !self.name.starts_with("quiet") {
            let words = seen
                .iter()
                .map(|o| format!("{}:{}@{}", o.data.kind().name(), o.sensor.0, o.stamp.0 / 1_000_000));
            LOG.lock().unwrap().push((self.name.clone(), words.collect::<Vec<_>>().join(" ")));
        }
        if let Some((_, odometry)) = seen.odometry().last() {
            let pose = odometry.odom_from_base;
            self.odom =
                pose2(pose.translation.x * self.params.scale, pose.translation.y, pose.rotation.angle());
        }
        let map_from_odom = self.map_from_odom.ok_or(LocalizeError::NotStarted)?;
        let covariance = nalgebra::Matrix3::identity() * 1e-4;
        let map_from_base = if self.params.stands { map_from_odom } else { map_from_odom * self.odom };
        let mut estimate = Estimate::planar(cx.now, map_from_base, self.odom, covariance);
        if cx.now > Time::from_secs(self.params.lost_at_s) {
            self.params.lost_at_s = 1e9;
            estimate.status = Status::Lost;
        }
        Ok(estimate)
    }
}
rumbo_core::register_localizer!(ReckoningParams, "reckoning", "dead reckoning");

params!(
    /// Finds the robot after a turn that it wishes for, or gives up then.
    TurnerParams { gives_up: bool = false }
);
struct Turner {
    gives_up: bool,
    turned: f64,
    last: Pose2,
}
impl Plugin<dyn Localizer> for TurnerParams {
    fn build(&self, _: &BuildContext) -> Result<Box<dyn Localizer>, BuildError> {
        Ok(Box::new(Turner { gives_up: self.gives_up, turned: 0.0, last: Pose2::identity() }))
    }
}
impl Localizer for Turner {
    fn start(&mut self, _: &Prior, _: &Map) -> Result<(), LocalizeError> {
        self.turned = 0.0;
        Ok(())
    }
    fn update(&mut self, cx: &mut Cx<'_>, seen: Seen<'_>, _: &Map) -> Result<Estimate, LocalizeError> {
        for (_, odometry) in seen.odometry() {
            self.turned += (self.last.inverse() * odometry.odom_from_base).rotation.angle();
            self.last = odometry.odom_from_base;
        }
        let mut estimate =
            Estimate::planar(cx.now, self.last, self.last, nalgebra::Matrix3::identity() * 1e-4);
        if self.turned < 0.95 {
            estimate.status = Status::Converging;
            estimate.wish = Some(Wish::TurnBy(1.0));
        } else if self.gives_up {
            estimate.status = Status::Lost;
        }
        Ok(estimate)
    }
}
rumbo_core::register_localizer!(TurnerParams, "turner", "turns, then knows");

params!(
    /// A free grid around the origin.
    BlankParams { resolution_m: f64 = 0.1 }
);
struct Blank(f64);
impl Plugin<dyn MapBuilder> for BlankParams {
    fn manifest(&self) -> Manifest {
        Manifest { gives_layers: vec![Layer::Grid], ..Manifest::default() }
    }
    fn build(&self, _: &BuildContext) -> Result<Box<dyn MapBuilder>, BuildError> {
        Ok(Box::new(Blank(self.resolution_m)))
    }
}
impl MapBuilder for Blank {
    fn start(&mut self, map: &mut Map) -> Result<(), MapError> {
        let mut grid = Grid::unknown(100, 100, self.0)?;
        grid.cells.make_mut().fill(-5.0);
        map.grid = Some(grid);
        Ok(())
    }
    fn insert(&mut self, _: &mut Cx<'_>, _: &MapInput<'_>, _: &mut Map) -> Result<(), MapError> {
        Ok(())
    }
}
rumbo_core::register_map_builder!(BlankParams, "blank", "a free grid");

params!(
    /// Writes one landmark for every scan, on top of a grid that must be there.
    CounterParams {}
);
struct Counter(usize);
impl Plugin<dyn MapBuilder> for CounterParams {
    fn manifest(&self) -> Manifest {
        Manifest {
            needs_layers: vec![Layer::Grid],
            gives_layers: vec![Layer::Landmarks],
            overlays: true,
            ..Manifest::default()
        }
    }
    fn build(&self, _: &BuildContext) -> Result<Box<dyn MapBuilder>, BuildError> {
        Ok(Box::new(Counter(0)))
    }
}
impl MapBuilder for Counter {
    fn start(&mut self, map: &mut Map) -> Result<(), MapError> {
        map.grid.as_ref().map(|_| ()).ok_or(MapError::MissingLayer { layer: "grid" })
    }
    fn insert(&mut self, _: &mut Cx<'_>, input: &MapInput<'_>, map: &mut Map) -> Result<(), MapError> {
        self.0 += input.seen.laser_scans().count();
        let landmarks = vec![rumbo_core::map::Landmark::default(); self.0].into();
        map.landmarks = Some(rumbo_core::map::Landmarks { landmarks });
        map.touch();
        Ok(())
    }
    fn save(&self, map: &mut Map) -> Result<Option<Vec<u8>>, MapError> {
        map.lines = Some(rumbo_core::map::Lines::default());
        Ok(Some(self.0.to_le_bytes().to_vec()))
    }
}
rumbo_core::register_map_builder!(CounterParams, "counter", "one landmark a scan");

params!(
    /// Goes straight, or refuses, or waits to be given up, or never comes back.
    LineParams { refuses: bool = false, waits: bool = false, is_deaf: bool = false, refuses_obstacles: bool = false }
);
struct LinePlanner(LineParams, String);
impl Plugin<dyn Planner> for LineParams {
    fn build(&self, context: &BuildContext) -> Result<Box<dyn Planner>, BuildError> {
        Ok(Box::new(LinePlanner(self.clone(), context.name.clone())))
    }
}
impl Planner for LinePlanner {
    fn plan(&mut self, request: &PlanRequest) -> Result<Path, PlanError> {
        let occupied = request.grid.as_ref().map_or(0, |g| g.cells.iter().filter(|v| **v > 0.0).count());
        let words = format!("{} obstacles, {occupied} cells", request.obstacles.len());
        LOG.lock().unwrap().push((self.1.clone(), words));
        if self.0.is_deaf {
            loop {
                std::thread::sleep(std::time::Duration::from_millis(50));
            }
        }
        while self.0.waits && !request.give_up.is_raised() {
            std::thread::yield_now();
        }
        if request.give_up.is_raised() {
            return Err(PlanError::GivenUp);
        }
        if self.0.refuses || (self.0.refuses_obstacles && !request.obstacles.is_empty()) {
            return Err(PlanError::Unreachable { reason: "told to refuse".into() });
        }
        request.trace.draw(|| rumbo_core::trace::Drawing::Points {
            name: "goal",
            points: vec![request.goal.position],
        });
        Path::through([request.start.translation.vector.into(), request.goal.position], 0.0)
            .ok_or(PlanError::GivenUp)
    }
}
rumbo_core::register_planner!(LineParams, "line", "goes straight");

params!(
    /// Turns towards the end of the path and drives there.
    BeelineParams {
        blocked_at_s: f64 = 1e9,
        keeps_blocking: bool = false,
        obstacle_x_m: f64 = 1.0,
        nan_at_s: f64 = 1e9,
        dithers_at_s: f64 = 1e9,
        dithers_on_paths: u64 = 1_000_000,
    }
);
struct Beeline {
    params: BeelineParams,
    last_path: u64,
}
impl Plugin<dyn Avoider> for BeelineParams {
    fn build(&self, _: &BuildContext) -> Result<Box<dyn Avoider>, BuildError> {
        Ok(Box::new(Beeline { params: self.clone(), last_path: 0 }))
    }
}
impl Avoider for Beeline {
    fn steer(&mut self, cx: &mut Cx<'_>, input: &AvoidInput<'_>) -> Result<Steering, AvoidError> {
        let Some(path) = input.path else { return Ok(Steering::Drive(Twist::new(0.1, 0.0))) };
        let end = input.map_from_base.inverse() * path.end().position;
        if end.coords.norm() < input.arrival_radius_m {
            return Ok(Steering::Arrived);
        }
        if cx.now > Time::from_secs(self.params.dithers_at_s)
            && input.path_number <= self.params.dithers_on_paths
        {
            // A degree to either side of where it looks, and never a step.
            let side = if (cx.now.as_secs() * 2.0) as i64 % 2 == 0 { 1.0 } else { -1.0 };
            return Ok(Steering::Drive(Twist::new(0.0, 0.1 * side)));
        }
        if cx.now > Time::from_secs(self.params.nan_at_s) {
            return Ok(Steering::Drive(Twist::new(f64::NAN, 0.0)));
        }
        if cx.now > Time::from_secs(self.params.blocked_at_s) && self.last_path != input.path_number {
            self.last_path = if self.params.keeps_blocking { 0 } else { input.path_number + 1 };
            let position: Point2 = input.map_from_base * Point2::new(self.params.obstacle_x_m, 0.0);
            return Ok(Steering::Blocked {
                obstacles: vec![Obstacle { position, radius_m: 0.0, stamp: cx.now }],
            });
        }
        cx.trace.count("beeline", end.coords.norm());
        let bearing = end.y.atan2(end.x);
        let forward = if bearing.abs() < 0.2 { 0.4 } else { 0.0 };
        Ok(Steering::Drive(Twist::new(forward, bearing.clamp(-0.5, 0.5))))
    }
}
rumbo_core::register_avoider!(BeelineParams, "beeline", "drives straight to the end");

params!(
    /// Map and place at once, by believing the wheels: writes down what it is told, and may lose itself for a while.
    BelieverParams { is_told: bool = true, lost_s: [f64; 2] = [1e9, 1e9], steps_back: bool = false }
);
struct Believer(Reckoning, BelieverParams, Vec<StampedPose>);
impl Believer {
    fn note(&self, what: &str, prior: &Prior) {
        let words = match prior {
            Prior::Unknown => format!("{what} unknown"),
            Prior::Pose { map_from_base, .. } => format!("{what} {:.1}", map_from_base.translation.x),
            Prior::Saved(bytes) => format!("{what} saved {:?}", bytes.as_slice()),
        };
        LOG.lock().unwrap().push((self.0.name.clone(), words));
    }
}
impl Plugin<dyn Slam> for BelieverParams {
    fn manifest(&self) -> Manifest {
        Manifest { gives_layers: vec![Layer::Grid], ..Manifest::default() }
    }
    fn build(&self, context: &BuildContext) -> Result<Box<dyn Slam>, BuildError> {
        let name = format!("quiet {}", context.name);
        let params = ReckoningParams::default();
        let reckoning = Reckoning { params, name, map_from_odom: None, odom: Pose2::identity() };
        Ok(Box::new(Believer(reckoning, self.clone(), Vec::new())))
    }
}
impl Slam for Believer {
    fn start(&mut self, prior: &Prior, map: &mut Map) -> Result<(), SlamError> {
        self.note("starts", prior);
        map.grid = Grid::unknown(50, 50, 0.2).ok();
        let zero = Pose2::identity();
        let covariance = nalgebra::Matrix3::identity();
        let somewhere = Prior::Pose { map_from_base: zero, odom_from_base: zero, covariance };
        let prior = if matches!(prior, Prior::Pose { .. }) { prior } else { &somewhere };
        self.0.start(prior, map).map_err(|e| SlamError::Other(e.to_string()))
    }
    fn update(&mut self, cx: &mut Cx<'_>, seen: Seen<'_>, map: &mut Map) -> Result<Estimate, SlamError> {
        map.touch();
        // What it has seen so far is in its map: one cell for each update.
        if let Some(cell) = map.grid.as_mut().and_then(|grid| grid.cells.make_mut().get_mut(0)) {
            *cell += 1.0;
        }
        let estimate = self.0.update(cx, seen, map).map_err(|e| SlamError::Other(e.to_string()))?;
        let stamp = if self.1.steps_back { Time::ZERO } else { cx.now };
        self.2.push(StampedPose { stamp, map_from_base: estimate.map_from_base });
        let [from, to] = self.1.lost_s;
        let is_lost = (from..to).contains(&cx.now.as_secs());
        Ok(Estimate { status: if is_lost { Status::Lost } else { Status::Tracking }, ..estimate })
    }
    fn relocate(&mut self, prior: &Prior, map: &mut Map) -> Result<(), SlamError> {
        self.note("is told", prior);
        if !self.1.is_told || !matches!(prior, Prior::Pose { .. }) {
            return Err(SlamError::CannotRelocate);
        }
        self.0.start(prior, map).map_err(|e| SlamError::Other(e.to_string()))
    }
    fn trajectory(&self) -> Result<Vec<StampedPose>, SlamError> {
        Ok(self.2.clone())
    }
    fn save_map(&self, map: &mut Map) -> Result<(), SlamError> {
        // The cell beside that of the updates.
        map.grid.iter_mut().filter_map(|grid| grid.cells.make_mut().get_mut(1)).for_each(|cell| *cell = 7.0);
        Ok(())
    }
    fn save(&self) -> Result<Vec<u8>, SlamError> {
        Ok(vec![self.2.len().min(9) as u8])
    }
}
rumbo_core::register_slam!(BelieverParams, "believer", "believes the wheels");

params!(
    /// The phone of somebody who is at x, y from time t on, in straight lines, and silent in some spans of time.
    PhoneParams { route: Vec<[f64; 3]> = vec![], silent_s: Vec<[f64; 2]> = vec![], deviation_m: f64 = 0.0 }
);
struct Phone(PhoneParams, BuildContext);
impl Plugin<dyn Sensor> for PhoneParams {
    fn manifest(&self) -> Manifest {
        Manifest { produces: vec![ObservationKind::Custom], ..Manifest::default() }
    }
    fn build(&self, context: &BuildContext) -> Result<Box<dyn Sensor>, BuildError> {
        Ok(Box::new(Phone(self.clone(), context.clone())))
    }
}
/// Where somebody with this route is.
pub fn on_route(route: &[[f64; 3]], t: f64) -> Point2 {
    let point = |k: usize| Point2::new(route[k][1], route[k][2]);
    let after = route.partition_point(|[start, ..]| *start <= t);
    if after == 0 || after == route.len() {
        return point(after.saturating_sub(1).min(route.len() - 1));
    }
    let share = (t - route[after - 1][0]) / (route[after][0] - route[after - 1][0]);
    point(after - 1) + (point(after) - point(after - 1)) * share
}
impl Sensor for Phone {
    fn poll(
        &mut self,
        cx: &mut Cx<'_>,
        _: &mut dyn World,
        out: &mut Observations,
    ) -> Result<(), SensorError> {
        let t = cx.now.as_secs();
        if self.0.silent_s.iter().any(|[from, to]| (*from..*to).contains(&t)) {
            return Ok(());
        }
        let person = PersonPosition { position: on_route(&self.0.route, t), deviation_m: self.0.deviation_m };
        out.push(Observation {
            sensor: self.1.sensor,
            stamp: cx.now,
            base_from_sensor: self.1.base_from_sensor,
            valid: true,
            data: Data::Custom(person.to_custom()),
        });
        Ok(())
    }
}
rumbo_core::register_sensor!(PhoneParams, "phone", "somebody's phone");
