//! What a robot meets in a disaster, for every plugin that maps with scans and without wheels: it goes on rightly, or says that
//! it does not know where it is. Never for long it is sure of a wrong place.

use super::course::{Mapper, off_m};
use super::world::{LoopWorld, lane, laser, observation, rubbish, stream};
use rumbo_core::frames::{Pose2, pose2};
use rumbo_core::messages::{Data, Estimate, LaserScan, Odometry, Prior, Status};
use rumbo_core::rng::Rng;
use rumbo_core::time::Time;
use rumbo_slam::graph_slam::GraphSlamParams;
use rumbo_slam::rbpf_slam::RbpfSlamParams;
use rumbo_slam::scan_match_slam::ScanMatchSlamParams;

/// Where the robot may be while it says that it tracks its way, meters.
const SURE_M: f64 = 0.3;
/// The scans that it may take to see that something is wrong.
const SCANS_TO_SEE: usize = 5;

/// A robot on the lane, ten scans a second, and what it said.
struct Robot {
    name: &'static str,
    world: LoopWorld,
    mapper: Mapper,
    rng: Rng,
    time_s: f64,
    n_wrong: usize,
}

fn mappers(map_from_base: Pose2) -> [(&'static str, Mapper); 3] {
    [
        ("scan_match_slam", Mapper::start_at(&ScanMatchSlamParams::default(), map_from_base)),
        ("rbpf_slam", Mapper::start_at(&RbpfSlamParams::default(), map_from_base)),
        ("graph_slam", Mapper::start_at(&GraphSlamParams::default(), map_from_base)),
    ]
}

/// Each plugin after it has mapped twelve meters of the lane, a meter a second.
fn robots() -> impl Iterator<Item = Robot> {
    mappers(lane(0.0)).into_iter().map(|(name, mapper)| {
        let mut robot =
            Robot { name, world: LoopWorld::load(), mapper, rng: stream(9), time_s: 1.0, n_wrong: 0 };
        for k in 0..=120 {
            robot.sees_from(&lane(0.1 * f64::from(k)));
        }
        assert_eq!(robot.n_wrong, 0, "{name}");
        robot
    })
}

impl Robot {
    fn scan(&mut self, truth: &Pose2) -> LaserScan {
        self.world.scan(truth, &mut self.rng)
    }

    fn sees_from(&mut self, truth: &Pose2) -> Estimate {
        let scan = self.scan(truth);
        self.sees(scan, None, truth)
    }

    fn sees(&mut self, scan: LaserScan, odom_from_base: Option<Pose2>, truth: &Pose2) -> Estimate {
        self.time_s += 0.1;
        let mut seen = Vec::new();
        if let Some(odom_from_base) = odom_from_base {
            let odometry = Odometry { odom_from_base, ..Odometry::default() };
            seen.push(observation(0, self.time_s, Data::Odometry(odometry)));
        }
        seen.push(laser(self.time_s, scan));
        let estimate = self.mapper.see(&seen);
        let is_wrong = off_m(&estimate.pose2(), truth) > SURE_M && estimate.status == Status::Tracking;
        self.n_wrong += usize::from(is_wrong);
        estimate
    }

    fn ends_well(&self, estimate: &Estimate, truth: &Pose2, may_be_lost: bool) {
        let Robot { name, n_wrong, .. } = self;
        assert!(*n_wrong <= SCANS_TO_SEE, "{name}: sure of a wrong place {n_wrong} times");
        let knows = estimate.status == Status::Tracking && off_m(&estimate.pose2(), truth) < 0.15;
        let says = estimate.status == Status::Lost && may_be_lost;
        assert!(knows || says, "{name}: {:?} {} m off", estimate.status, off_m(&estimate.pose2(), truth));
    }
}

/// Half a minute in which it walks back by six meters, without scans, wheels or gyroscope.
#[test]
fn half_a_minute_of_blindness() {
    for mut robot in robots() {
        let before = robot.mapper.see_at(Time::from_secs(robot.time_s), &[]);
        assert_eq!(before.status, Status::Tracking);
        for k in 1..=300 {
            let silent_s = 0.1 * f64::from(k);
            let now = Time::from_secs(robot.time_s + silent_s);
            let blind = robot.mapper.see_at(now, &[]);
            assert!(silent_s < 2.5 || blind.status != Status::Tracking, "{}: {silent_s} s", robot.name);
            let grown = blind.covariance2().trace() / before.covariance2().trace();
            assert!(silent_s < 2.5 || grown > 2.0, "{}: {silent_s} s, {grown}", robot.name);
        }
        robot.time_s += 30.0;
        let mut last = before;
        for k in 0..80 {
            last = robot.sees_from(&lane(6.0 + 0.05 * f64::from(k)));
        }
        robot.ends_well(&last, &lane(6.0 + 0.05 * 79.0), true);
    }
}

/// It stands elsewhere on its map all at once, turned by 143 degrees.
#[test]
fn carried_away() {
    robots().for_each(|robot| goes_on_elsewhere(robot, |_| None));
}

/// The same robot with wheels, which turned in the air by nothing.
#[test]
fn carried_away_with_wheels() {
    robots().for_each(|robot| goes_on_elsewhere(robot, |k| Some(pose2(0.01 * f64::from(k), 0.0, 0.0))));
}

fn goes_on_elsewhere(mut robot: Robot, odom_from_base: impl Fn(i32) -> Option<Pose2>) {
    let truth = |k: i32| lane(1.5) * pose2(0.01 * f64::from(k), 0.0, 2.5);
    let mut see = |odom_from_base, truth: &Pose2| {
        let scan = robot.scan(truth);
        robot.sees(scan, odom_from_base, truth)
    };
    for _ in 0..5 {
        see(odom_from_base(0), &lane(12.0));
    }
    let last = (0..80).map(|k| see(odom_from_base(k), &truth(k))).last().unwrap();
    robot.ends_well(&last, &truth(79), true);
}

/// Scans of other places that come late, or twice.
#[test]
fn scans_that_are_not_newer_change_nothing() {
    for mut robot in robots() {
        let now = Time::from_secs(robot.time_s);
        let (before, map) = (robot.mapper.see_at(now, &[]), robot.mapper.map.clone());
        for age_s in [0.0, 0.5] {
            let scan = robot.scan(&lane(20.0));
            let after = robot.mapper.see_at(now, &[laser(robot.time_s - age_s, scan)]);
            assert_eq!(
                (after.stamp, after.map_from_base),
                (before.stamp, before.map_from_base),
                "{}",
                robot.name
            );
        }
        assert_eq!(map.grid, robot.mapper.map.grid, "{}", robot.name);
    }
}

/// Every tenth scan has nothing to do with the world.
#[test]
fn one_scan_in_ten_is_rubbish() {
    for mut robot in robots() {
        let mut last = None;
        for k in 1..=120 {
            let truth = lane(12.0 + 0.1 * f64::from(k));
            let mut scan = robot.scan(&truth);
            if k % 10 == 7 {
                scan.ranges_m = rubbish(&mut robot.rng).into();
            }
            last = Some((robot.sees(scan, None, &truth), truth));
        }
        let (last, truth) = last.unwrap();
        robot.ends_well(&last, &truth, false);
    }
}

/// For five seconds the wheels count 0.6 m/s while it stands, and then it drives on.
#[test]
fn wheels_that_spin_in_place() {
    for mut robot in robots() {
        let mut last = None;
        for k in 0..=120 {
            let t = 0.1 * f64::from(k);
            let truth = lane(12.0 + (t - 5.0).max(0.0));
            let odom_from_base = pose2(0.6 * t.min(5.0), 0.0, 0.0) * lane(12.0).inverse() * truth;
            let scan = robot.scan(&truth);
            last = Some((robot.sees(scan, Some(odom_from_base), &truth), truth));
        }
        let (last, truth) = last.unwrap();
        robot.ends_well(&last, &truth, false);
    }
}

/// Two walls whose ends nobody sees, and who stands between them: a body half a meter wide.
fn bare_walls(bodies: &[[f64; 2]]) -> LoopWorld {
    let mut walls = vec![[-60.0, -1.0, 60.0, -1.0], [-60.0, 1.0, 60.0, 1.0]];
    for [x, y] in bodies {
        let [left, right, near, far] = [y + 0.25, y - 0.25, x - 0.15, x + 0.15];
        walls.extend([[near, right, near, left], [far, right, far, left]]);
        walls.extend([[near, right, far, right], [near, left, far, left]]);
    }
    LoopWorld::of(walls)
}

/// Eight meters between bare walls, a meter a second: what each plugin says, and how far off it is.
fn between_bare_walls(
    has_wheels: impl Fn(i32) -> bool,
    judge: impl Fn(&str, i32, &Estimate, &Pose2),
) -> Vec<(&'static str, Mapper)> {
    between(&|_| bare_walls(&[]), has_wheels, judge)
}

fn between(
    world: &dyn Fn(i32) -> LoopWorld,
    has_wheels: impl Fn(i32) -> bool,
    judge: impl Fn(&str, i32, &Estimate, &Pose2),
) -> Vec<(&'static str, Mapper)> {
    let drive = |(name, mapper)| (name, drive_between(name, mapper, world, &has_wheels, &judge));
    mappers(Pose2::identity()).into_iter().map(drive).collect()
}

fn drive_between(
    name: &str,
    mut mapper: Mapper,
    world: &dyn Fn(i32) -> LoopWorld,
    has_wheels: &dyn Fn(i32) -> bool,
    judge: &dyn Fn(&str, i32, &Estimate, &Pose2),
) -> Mapper {
    let mut rng = stream(10);
    for k in 0..=80 {
        let (time_s, truth) = (1.0 + 0.1 * f64::from(k), pose2(0.1 * f64::from(k), 0.0, 0.0));
        let odometry = Odometry { odom_from_base: truth, ..Odometry::default() };
        let mut seen = vec![laser(time_s, world(k).scan(&truth, &mut rng))];
        if has_wheels(k) {
            seen.insert(0, observation(0, time_s, Data::Odometry(odometry)));
        }
        let estimate = mapper.see(&seen);
        let off = truth.inverse() * estimate.pose2();
        assert!(off.translation.y.abs() < 0.1, "{name}: {k} {off}");
        judge(name, k, &estimate, &off);
    }
    mapper
}

/// Wheels tell the way along the walls, scans that across, and it is said which is surer.
#[test]
fn a_corridor_without_ends_is_kept_by_wheels() {
    let driven = between_bare_walls(
        |_| true,
        |name, k, estimate, off| {
            let covariance = estimate.covariance2();
            let deviation_m = covariance[(0, 0)].sqrt();
            assert_eq!(estimate.status, Status::Tracking, "{name}: {k}");
            assert!(
                off.translation.x.abs() < (3.0 * deviation_m).max(0.01),
                "{name}: {k} {off}, {deviation_m} m"
            );
            assert!(off.translation.x.abs() < 0.5 && deviation_m < 0.4, "{name}: {k} {off}, {deviation_m} m");
            assert!(k < 20 || covariance[(0, 0)] > 4.0 * covariance[(1, 1)], "{name}: {k} {covariance}");
        },
    );
    for (name, mapper) in driven {
        let grid = mapper.map.grid.as_ref().unwrap();
        assert!(grid.cells.iter().filter(|cell| **cell > 1.0).count() > 200, "{name}: the walls are mapped");
    }
}

/// After the first of these scans it says so, and from the second on its deviation covers how far off it is.
fn is_not_sure(name: &str, k: i32, [says_after, covers_from]: [i32; 2], estimate: &Estimate, off: &Pose2) {
    let deviation_m = estimate.covariance2()[(0, 0)].sqrt();
    assert!(k <= says_after || estimate.status == Status::Converging, "{name}: {k} {:?}", estimate.status);
    let is_covered = off.translation.x.abs() < 3.0 * deviation_m;
    assert!(k < covers_from || is_covered, "{name}: {k} {off}, {deviation_m} m");
}

/// Without wheels nobody can know the way, and after a second each plugin says so.
#[test]
fn a_corridor_without_ends_and_wheels_makes_nobody_sure() {
    between_bare_walls(|_| false, |name, k, estimate, off| is_not_sure(name, k, [12, 3], estimate, off));
}

/// Wheels that fall silent count as none, not as wheels that stand.
#[test]
fn wheels_that_fall_silent_between_bare_walls_make_nobody_sure() {
    between_bare_walls(|k| k <= 20, |name, k, estimate, off| is_not_sure(name, k, [40, 40], estimate, off));
}

/// Somebody whom nobody has seen before looks like a way to tell how far it is, and is none.
#[test]
fn people_who_step_out_between_bare_walls_hold_nobody_back() {
    let steps_out = |k: i32| match k {
        5..=17 => bare_walls(&[[4.3, 0.5]]),
        22..=40 => bare_walls(&[[7.1, -0.6]]),
        46..=57 => bare_walls(&[[8.2, 0.4]]),
        63..=75 => bare_walls(&[[9.6, -0.4]]),
        _ => bare_walls(&[]),
    };
    between(&steps_out, |_| true, is_covered);
}

/// Somebody steps out right before the robot, so near that he is a sixth of all it sees.
#[test]
fn somebody_who_steps_out_right_before_it_holds_nobody_back() {
    let steps_out = |k: i32| match k {
        20..=27 => bare_walls(&[[3.1, 0.6]]),
        45..=52 => bare_walls(&[[5.4, -0.55]]),
        _ => bare_walls(&[]),
    };
    between(&steps_out, |_| true, is_covered);
}

/// It tracks its way, and is no farther off than a tenth of a meter, or than its deviation covers.
fn is_covered(name: &str, k: i32, estimate: &Estimate, off: &Pose2) {
    let (off_m, deviation_m) = (off.translation.x.abs(), estimate.covariance2()[(0, 0)].sqrt());
    assert_eq!(estimate.status, Status::Tracking, "{name}: {k}");
    assert!(off_m < (3.0 * deviation_m).max(0.1), "{name}: {k} {off}, {deviation_m} m");
    assert!(off_m < 0.5 && deviation_m < 0.4, "{name}: {k} {off}, {deviation_m} m");
}

/// Somebody stands there once nobody knows the way any more: beside him the robot finds its way, and not on the map.
#[test]
fn somebody_between_bare_walls_makes_nobody_sure_who_was_not() {
    let stands = |k: i32| if k <= 30 { bare_walls(&[]) } else { bare_walls(&[[9.5, 0.5]]) };
    between(&stands, |_| false, |name, k, estimate, off| is_not_sure(name, k, [12, 3], estimate, off));
}

/// What a laser sees whose reach is six meters.
fn near_sighted(mut scan: LaserScan) -> LaserScan {
    let far = scan.ranges_m.make_mut().iter_mut().filter(|range_m| **range_m > 6.0);
    far.for_each(|range_m| *range_m = f32::INFINITY);
    LaserScan { max_range_m: 6.0, ..scan }
}

/// A laser that sees six meters, between walls with one end: back to where that is not seen, and there again, without wheels.
#[test]
fn who_comes_back_to_what_was_mapped_before_is_sure_again() {
    let world = LoopWorld::of(vec![[-60.0, -1.0, 3.0, -1.0], [-60.0, 1.0, 3.0, 1.0], [3.0, -1.0, 3.0, 1.0]]);
    for (name, mut mapper) in mappers(Pose2::identity()) {
        let mut rng = stream(11);
        let mut last = None;
        for k in 0..=160i32 {
            let at_m = -0.05 * f64::from(if k <= 80 { k } else { 160 - k });
            let truth = pose2(at_m, 0.0, 0.0);
            let scan = near_sighted(world.scan(&truth, &mut rng));
            let estimate = mapper.see(&[laser(1.0 + 0.1 * f64::from(k), scan)]);
            let (off, deviation_m) =
                (truth.inverse() * estimate.pose2(), estimate.covariance2()[(0, 0)].sqrt());
            let off_m = off.translation.x.abs();
            assert!(off_m < (3.0 * deviation_m).max(0.15), "{name}: {k} {off}, {deviation_m} m");
            assert!(k != 90 || estimate.status == Status::Converging, "{name}: {:?}", estimate.status);
            last = Some((estimate, off));
        }
        let (estimate, off) = last.unwrap();
        let knows = estimate.status == Status::Tracking && off.translation.x.abs() < 0.15;
        assert!(knows, "{name}: {:?} {off}", estimate.status);
    }
}

/// Ten meters of a bare corridor, a bend to the left, and on: after each scan.
fn around_a_bend(k: i32) -> Pose2 {
    let way_m = 0.1 * f64::from(k);
    let (to_bend_m, radius_m) = (10.0, 2.0);
    let turn_rad = ((way_m - to_bend_m) / radius_m).clamp(0.0, std::f64::consts::FRAC_PI_2);
    let past_m = (way_m - to_bend_m - radius_m * std::f64::consts::FRAC_PI_2).max(0.0);
    let (sin, cos) = turn_rad.sin_cos();
    pose2(way_m.min(to_bend_m) + radius_m * sin, radius_m * (1.0 - cos) + past_m, turn_rad)
}

/// The next leg tells the way that the last one did not, but on what was mapped since nobody knew it.
#[test]
fn around_a_bend_of_bare_walls_nobody_becomes_sure() {
    let world = LoopWorld::of(vec![
        [-60.0, -1.0, 13.0, -1.0],
        [-60.0, 1.0, 11.0, 1.0],
        [13.0, -1.0, 13.0, 60.0],
        [11.0, 1.0, 11.0, 60.0],
    ]);
    for (name, mut mapper) in mappers(Pose2::identity()) {
        let mut rng = stream(12);
        for k in 0..=200 {
            let truth = around_a_bend(k);
            let scan = near_sighted(world.scan(&truth, &mut rng));
            let estimate = mapper.see(&[laser(1.0 + 0.1 * f64::from(k), scan)]);
            let off = estimate.pose2().translation.vector - truth.translation.vector;
            let deviations_m = estimate.covariance2().diagonal().xy().map(f64::sqrt);
            let is_covered = (0..2).all(|axis| off[axis].abs() < (3.0 * deviations_m[axis]).max(0.1));
            assert!(k < 3 || is_covered, "{name}: {k} {off}, {deviations_m}");
            assert!(k <= 12 || estimate.status == Status::Converging, "{name}: {k} {:?}", estimate.status);
        }
    }
}

/// Who did not know his way when his state was saved does not know it afterwards.
#[test]
fn a_state_saved_by_who_is_not_sure_makes_nobody_sure() {
    let world = bare_walls(&[]);
    let fresh = mappers(Pose2::identity());
    for ((name, mut mapper), (_, mut resumed)) in mappers(Pose2::identity()).into_iter().zip(fresh) {
        let mut rng = stream(13);
        let mut see = |mapper: &mut Mapper, k: i32| {
            let truth = pose2(0.1 * f64::from(k), 0.0, 0.0);
            let estimate = mapper.see(&[laser(1.0 + 0.1 * f64::from(k), world.scan(&truth, &mut rng))]);
            (truth.inverse() * estimate.pose2(), estimate)
        };
        let before = (0..=40).map(|k| see(&mut mapper, k)).last().unwrap().1;
        let saved = mapper.slam.save().unwrap();
        resumed.slam.start(&Prior::Saved(saved.into()), &mut resumed.map).unwrap();
        for k in 41..=60 {
            let (off, estimate) = see(&mut resumed, k);
            is_not_sure(name, k, [40, 40], &estimate, &off);
            let grown = estimate.covariance2()[(0, 0)] / before.covariance2()[(0, 0)];
            assert!(grown > 0.99, "{name}: {k} {grown}");
        }
    }
}

/// A box stands by the wall, and nothing else tells the way: who drives by sees its back where its front was. The other two
/// plugins, which match on cells, cannot tell these apart.
#[test]
fn a_box_by_the_wall_pulls_no_graph_back() {
    for box_y_m in [0.5, 0.55, 0.6, 0.65, 0.7] {
        let judge = |_: &str, k: i32, estimate: &Estimate, off: &Pose2| {
            let is_right = off.translation.x.abs() < 0.1 && estimate.status == Status::Tracking;
            assert!(is_right, "{box_y_m} {k} {off}");
        };
        let graph = Mapper::start_at(&GraphSlamParams::default(), Pose2::identity());
        drive_between("graph_slam", graph, &|_| bare_walls(&[[4.0, box_y_m]]), &|_| true, &judge);
    }
}
