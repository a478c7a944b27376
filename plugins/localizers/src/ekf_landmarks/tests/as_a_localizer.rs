//! Through the trait: when it is sure, lost and found; late marks; nonsense.

use rumbo_core::frames::{Pose3, Twist, lift};
use rumbo_core::map::{Landmark, Landmarks, Map};
use rumbo_core::messages::{
    Data, Estimate, Mark, Marks, Observation, Odometry, Prior, Seen, SensorId, Status,
};
use rumbo_core::registry::{Built, Params, Plugin, Registry, Stage};
use rumbo_core::stages::{BuildContext, Cx, LocalizeError, Localizer};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;

use super::super::EkfLandmarksParams;
use super::*;

const PLACES: [(u32, [f64; 2]); 6] = [
    (6, [-1.0, 4.5]),
    (7, [5.0, 4.0]),
    (8, [6.0, -2.0]),
    (9, [0.5, -3.5]),
    (10, [-3.0, 0.5]),
    (11, [2.5, 3.0]),
];

fn map() -> Map {
    let landmark = |(identity, position)| Landmark { identity, position, ..Landmark::default() };
    let landmarks = PLACES.map(landmark).to_vec().into();
    Map { landmarks: Some(Landmarks { landmarks }), version: 1, ..Map::default() }
}

fn camera() -> Pose2 {
    pose2(0.2, 0.0, 0.3)
}

/// A robot on a circle of 1 m.
struct Robot {
    localizer: Box<dyn Localizer>,
    map_from_odom: Pose2,
    odom_from_base: Pose2,
    now_s: f64,
    rng: Rng,
}

const TWIST: Twist = Twist { forward_m_s: 0.3, left_m_s: 0.0, turn_rad_s: 0.3 };

impl Robot {
    fn new(params: EkfLandmarksParams) -> Robot {
        let localizer = params.build(&BuildContext::bare("localizer")).unwrap();
        let (map_from_odom, odom_from_base) = (pose2(1.0, -0.8, 0.4), pose2(7.0, -3.0, 1.0));
        Robot { localizer, map_from_odom, odom_from_base, now_s: 0.0, rng: rng::stream(41, "robot") }
    }

    fn truth(&self) -> Pose2 {
        self.map_from_odom * self.odom_from_base
    }

    fn prior(&self, off: Pose2, deviation: f64) -> Prior {
        Prior::Pose {
            map_from_base: self.truth() * off,
            odom_from_base: self.odom_from_base,
            covariance: Matrix3::identity() * deviation.powi(2),
        }
    }

    fn odometry(&self) -> Observation {
        let data = Odometry { odom_from_base: self.odom_from_base, twist: TWIST, noise: [0.02; 3] };
        observation(self.now_s, Pose2::identity(), Data::Odometry(data))
    }

    /// What the camera saw `ago_s` seconds ago of the marks in these places of the list.
    fn marks(&mut self, ago_s: f64, which: std::ops::Range<usize>, is_known: bool) -> Observation {
        let then = self.truth() * TWIST.integrate(-ago_s);
        let (deviations, camera) = ([0.05, 0.01], camera());
        let marks = PLACES[which].iter().map(|(identity, [x, y])| {
            let sighting = seen(&then, &camera, &mark(*x, *y), deviations, &mut self.rng);
            let identity = is_known.then_some(*identity);
            Mark { identity, range_m: sighting.measured.x, bearing_rad: sighting.measured.y }
        });
        let (range_deviation_m, bearing_deviation_rad) = (deviations[0], deviations[1]);
        let data = Marks { marks: marks.collect(), range_deviation_m, bearing_deviation_rad };
        observation(self.now_s - ago_s, camera, Data::Marks(data))
    }

    fn moves(&mut self) {
        self.now_s += 0.1;
        self.odom_from_base *= TWIST.integrate(0.1);
    }

    fn update(&mut self, seen: &[Observation]) -> Result<Estimate, LocalizeError> {
        let trace = Trace::unwatched();
        let mut cx = Cx { now: Time::from_secs(self.now_s), trace: &trace };
        self.localizer.update(&mut cx, Seen::sorted(seen), &map())
    }

    /// Drives for so many steps and sees these marks all the time.
    fn drives(&mut self, n: usize, which: std::ops::Range<usize>) -> Estimate {
        let mut last = None;
        for _ in 0..n {
            self.moves();
            let seen = [self.odometry(), self.marks(0.0, which.clone(), true)];
            last = Some(self.update(&seen).unwrap());
        }
        last.unwrap()
    }

    fn off_m(&self, estimate: &Estimate) -> f64 {
        (estimate.pose2().translation.vector - self.truth().translation.vector).norm()
    }
}

fn observation(seconds: f64, base_from_sensor: Pose2, data: Data) -> Observation {
    let base_from_sensor = lift(&base_from_sensor);
    Observation { sensor: SensorId(0), stamp: Time::from_secs(seconds), base_from_sensor, valid: true, data }
}

#[test]
fn an_unsure_start_becomes_sure_by_marks_and_stays_right() {
    let mut robot = Robot::new(EkfLandmarksParams::default());
    let prior = robot.prior(pose2(0.5, -0.4, 0.2), 0.7);
    robot.localizer.start(&prior, &map()).unwrap();
    robot.moves();
    let before = robot.update(&[robot.odometry()]).unwrap();
    assert_eq!(before.status, Status::Converging);
    let after = robot.drives(50, 0..6);
    assert_eq!(after.status, Status::Tracking);
    assert!(robot.off_m(&after) < 0.06, "{}", robot.off_m(&after));
    assert!(after.covariance2()[(0, 0)].sqrt() < 0.05);
    let odom = after.map_from_odom.inverse() * after.map_from_base;
    assert!((odom.translation.x - robot.odom_from_base.translation.x).abs() < 1e-9);
}

#[test]
fn a_robot_that_may_be_anywhere_is_lost_until_three_marks_agree() {
    let mut robot = Robot::new(EkfLandmarksParams::default());
    robot.localizer.start(&Prior::Unknown, &map()).unwrap();
    let lost = robot.drives(20, 0..2);
    assert_eq!(lost.status, Status::Lost);
    // One mark after the other will do: the odometer holds them together.
    for which in [2..3, 3..4] {
        robot.drives(5, which);
    }
    let found = robot.drives(1, 2..3);
    assert_eq!(found.status, Status::Tracking);
    assert!(robot.off_m(&found) < 0.25, "{}", robot.off_m(&found));
    let followed = robot.drives(50, 0..6);
    assert!(robot.off_m(&followed) < 0.06);
}

#[test]
fn a_robot_that_was_carried_away_is_lost_and_found_again() {
    let mut robot = Robot::new(EkfLandmarksParams::default());
    let prior = robot.prior(Pose2::identity(), 0.01);
    robot.localizer.start(&prior, &map()).unwrap();
    robot.drives(20, 0..6);
    robot.map_from_odom = pose2(2.0, -1.5, 1.4) * robot.map_from_odom;
    let mut statuses = Vec::new();
    for _ in 0..20 {
        statuses.push(robot.drives(1, 0..2).status);
    }
    assert!(statuses.contains(&Status::Lost), "{statuses:?}: two marks do not tell where it is");
    let found = robot.drives(30, 0..6);
    assert!(found.status == Status::Tracking && robot.off_m(&found) < 0.1, "{}", robot.off_m(&found));
}

#[test]
fn marks_that_come_late_or_early_are_seen_from_where_the_robot_was() {
    for ago_s in [0.75, 0.4, 0.0, -0.06] {
        let mut robot = Robot::new(EkfLandmarksParams::default());
        let prior = robot.prior(pose2(0.2, 0.1, 0.05), 0.2);
        robot.localizer.start(&prior, &map()).unwrap();
        let mut last = None;
        for k in 0..60 {
            robot.moves();
            let mut seen = vec![robot.odometry()];
            if k > 20 {
                let marks = robot.marks(ago_s, 0..6, true);
                seen.insert(usize::from(ago_s <= 0.0), marks);
            }
            last = Some(robot.update(&seen).unwrap());
        }
        let off_m = robot.off_m(&last.unwrap());
        assert!(off_m < 0.06, "{ago_s} s ago: {off_m} m");
    }
}

#[test]
fn marks_without_identity_are_matched_only_if_that_is_wanted_and_clear() {
    for match_unknown in [false, true] {
        let mut robot = Robot::new(EkfLandmarksParams { match_unknown, ..EkfLandmarksParams::default() });
        let prior = robot.prior(pose2(0.15, 0.1, 0.0), 0.15);
        robot.localizer.start(&prior, &map()).unwrap();
        let mut last = None;
        for _ in 0..50 {
            robot.moves();
            let seen = [robot.odometry(), robot.marks(0.0, 0..6, false)];
            last = Some(robot.update(&seen).unwrap());
        }
        let off_m = robot.off_m(&last.unwrap());
        assert_eq!(off_m < 0.08, match_unknown, "{off_m}");
    }
}

#[test]
fn wrong_identities_do_not_carry_the_pose_away() {
    let mut robot = Robot::new(EkfLandmarksParams::default());
    let prior = robot.prior(Pose2::identity(), 0.05);
    robot.localizer.start(&prior, &map()).unwrap();
    for k in 0..100 {
        robot.moves();
        let mut marks = robot.marks(0.0, 0..6, true);
        if let Data::Marks(marks) = &mut marks.data {
            let idx = k % 6;
            marks.marks[idx].identity = Some(6 + (k as u32 + 1) % 6);
        }
        let estimate = robot.update(&[robot.odometry(), marks]).unwrap();
        assert!(robot.off_m(&estimate) < 0.12 && estimate.status == Status::Tracking, "{k}");
    }
}

#[test]
fn an_odometer_that_begins_anew_keeps_the_pose_and_makes_it_unsure() {
    let mut robot = Robot::new(EkfLandmarksParams::default());
    let prior = robot.prior(Pose2::identity(), 0.01);
    robot.localizer.start(&prior, &map()).unwrap();
    let before = robot.drives(30, 0..6);
    let truth = robot.truth();
    robot.odom_from_base = pose2(-40.0, 3.0, -1.0);
    robot.map_from_odom = truth * robot.odom_from_base.inverse();
    robot.now_s += 0.1;
    let jumped = robot.update(&[robot.odometry()]).unwrap();
    assert!(robot.off_m(&jumped) < 0.1 && jumped.covariance2()[(0, 0)] > before.covariance2()[(0, 0)]);
    let after = robot.drives(20, 0..6);
    assert!(robot.off_m(&after) < 0.06);
}

#[test]
fn what_cannot_be_started_from_is_said() {
    let mut robot = Robot::new(EkfLandmarksParams::default());
    assert_eq!(robot.update(&[]), Err(LocalizeError::NotStarted));
    let saved = robot.localizer.start(&Prior::Saved(Vec::new().into()), &map()).unwrap_err();
    assert!(saved.to_string().contains("saved state"), "{saved}");
    let missing = robot.localizer.start(&Prior::Unknown, &Map::default());
    assert_eq!(missing, Err(LocalizeError::MissingLayer { layer: "landmarks" }));
    let twice = Landmarks { landmarks: vec![Landmark::default(); 2].into() };
    let odd = Landmark { covariance: [-1.0, 0.0, 1.0], ..Landmark::default() };
    for (landmarks, told) in
        [(twice, "two landmarks of identity 0"), (Landmarks { landmarks: vec![odd].into() }, "landmark 0")]
    {
        let map = Map { landmarks: Some(landmarks), ..Map::default() };
        let error = robot.localizer.start(&Prior::Unknown, &map).unwrap_err().to_string();
        assert!(error.contains(told), "{error}");
    }
    let negative = Prior::Pose {
        map_from_base: Pose2::identity(),
        odom_from_base: Pose2::identity(),
        covariance: Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, 1.0)),
    };
    assert!(robot.localizer.start(&negative, &map()).unwrap_err().to_string().contains("at least zero"));
}

#[test]
fn marks_that_are_none_are_refused_and_nothing_counts_twice() {
    let mut robot = Robot::new(EkfLandmarksParams::default());
    let prior = robot.prior(pose2(0.2, 0.0, 0.0), 0.2);
    robot.localizer.start(&prior, &map()).unwrap();
    robot.moves();
    let good = [robot.odometry(), robot.marks(0.0, 0..1, true)];
    let bad = Marks { marks: vec![Mark { range_m: f64::NAN, ..Mark::default() }], ..Marks::default() };
    let bad = observation(robot.now_s, Pose2::identity(), Data::Marks(bad));
    let with_bad = [good[0].clone(), good[1].clone(), bad.clone()];
    assert!(matches!(robot.update(&with_bad), Err(LocalizeError::Message(_))));
    let once = robot.update(&good).unwrap();
    let mut other = Robot::new(EkfLandmarksParams::default());
    other.localizer.start(&prior, &map()).unwrap();
    other.now_s = robot.now_s;
    assert_eq!(other.update(&good).unwrap(), once);
    let invalid = Observation { valid: false, ..bad };
    assert_eq!(robot.update(&[invalid]).unwrap(), once);
}

#[test]
fn a_camera_that_looks_from_a_height_measures_in_the_plane() {
    let mut robot = Robot::new(EkfLandmarksParams::default());
    let prior = robot.prior(pose2(0.1, 0.1, 0.0), 0.2);
    robot.localizer.start(&prior, &map()).unwrap();
    let mut last = None;
    for _ in 0..30 {
        robot.moves();
        let mut marks = robot.marks(0.0, 0..6, true);
        marks.base_from_sensor = Pose3::translation(0.0, 0.0, 1.2) * marks.base_from_sensor;
        last = Some(robot.update(&[robot.odometry(), marks]).unwrap());
    }
    assert!(robot.off_m(&last.unwrap()) < 0.06);
}

#[test]
fn the_registry_builds_it_from_its_defaults_and_every_bad_value_is_named() {
    let registry = Registry::linked().unwrap();
    let entry = registry.get(Stage::Localizer, "ekf_landmarks").unwrap();
    let keys = "match_unknown = true\nturn_noise = 0.1\nrange_share = 0.05";
    let configured = entry.source.parse(keys.parse().unwrap()).ok().unwrap();
    assert!(configured.check().is_empty());
    assert!(matches!(configured.build(&BuildContext::bare("localizer")), Ok(Built::Localizer(_))));
    let bad = EkfLandmarksParams {
        distance_noise: Some(-1.0),
        direction_noise_deg_m: Some(f64::NAN),
        turn_noise: Some(f64::INFINITY),
        distance_scale_deviation: -0.1,
        turn_scale_deviation: f64::NAN,
        range_deviation_m: Some(-1.0),
        range_share: -1.0,
        bearing_deviation_deg: Some(-1.0),
        match_unknown: false,
        lost_after: 0,
        sure_deviation_m: 0.0,
        sure_deviation_deg: -1.0,
        jump_m: f64::INFINITY,
    };
    // All but `match_unknown`, which cannot be wrong.
    assert_eq!(Params::check(&bad).len(), 12);
}
