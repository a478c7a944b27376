//! Laws of localizers and SLAM plugins: empty, impossible and huge input.

use super::drive::{Drive, observation};
use super::estimators::{Tracker, prior_of, sane};
use super::law::{Law, Trouble, Verdict, expect};
use super::subject::Subject;
use super::turn::Turn;
use nalgebra::Matrix3;
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Pose2, Twist, pose2};
use rumbo_core::map::Map;
use rumbo_core::messages::{Data, Imu, LaserScan, Mark, Marks, Observation, Odometry, PositionFix, Prior};

pub const NOTHING_NEW: Law = Law::new("it survives an update with nothing new", nothing_new);
pub const NOT_STARTED: Law =
    Law::new("an update before the start gives an error or an estimate", not_started);
pub const BAD_PRIOR: Law = Law::new("a start from numbers that are not finite is refused", bad_prior);
pub const BAD_SAVED: Law = Law::new("a saved state that is cut off or changed is refused", bad_saved);
pub const ODD_READINGS: Law =
    Law::new("it survives empty, impossible and huge readings, and goes on", odd_readings);
pub const EMPTY_MAP: Law = Law::new("an empty map is named where the map is needed", empty_map);

fn nothing_new(subject: &Subject) -> Verdict {
    let drive = Drive::seen_from(Turn::None)?;
    let mut tracker = Tracker::new(subject, &drive)?;
    let Some(first) = drive.frames.first() else { return Ok(String::new()) };
    tracker.start_at(first)?;
    for frame in drive.frames.iter().take(20) {
        let estimate = tracker.update(frame.now, &[]);
        let estimate = estimate.map_err(|error| Trouble::broken(error, "an estimate, as old as it is"))?;
        sane("nothing seen", &estimate, frame.now)?;
    }
    Ok(String::new())
}

fn not_started(subject: &Subject) -> Verdict {
    let drive = Drive::seen_from(Turn::None)?;
    let mut tracker = Tracker::new(subject, &drive)?;
    let Some(first) = drive.frames.first() else { return Ok(String::new()) };
    match tracker.update(first.now, &first.seen) {
        Err(error) => Ok(error),
        Ok(estimate) => sane("not started", &estimate, first.now).map(|()| String::new()),
    }
}

fn bad_prior(subject: &Subject) -> Verdict {
    let drive = Drive::seen_from(Turn::None)?;
    let place = |pose: Pose2, covariance: Matrix3<f64>| Prior::Pose {
        map_from_base: pose,
        odom_from_base: Pose2::identity(),
        covariance,
    };
    let sure = Matrix3::identity() * 1e-3;
    let bad = [
        ("a pose at NaN", place(pose2(f64::NAN, 0.0, 0.0), sure)),
        ("a pose at infinity", place(pose2(0.0, f64::INFINITY, 0.0), sure)),
        ("a covariance of NaN", place(pose2(2.0, 2.0, 0.0), Matrix3::from_element(f64::NAN))),
    ];
    for (what, prior) in bad {
        let mut tracker = Tracker::new(subject, &drive)?;
        let started = tracker.start(&prior);
        expect(started.is_err(), || format!("{what}: it starts"), "an error")?;
    }
    Ok(String::new())
}

fn bad_saved(subject: &Subject) -> Verdict {
    let drive = Drive::seen_from(Turn::None)?;
    let mut first = Tracker::new(subject, &drive)?;
    let Some(start) = drive.frames.first() else { return Ok(String::new()) };
    first.start_at(start)?;
    for frame in drive.frames.iter().take(20) {
        first.follow(frame)?;
    }
    let Some(saved) = first.save() else {
        return Err(Trouble::not_applicable("it cannot save its state"));
    };
    let half = saved.len() / 2;
    let mut flipped = saved.clone();
    if let Some(byte) = flipped.get_mut(half) {
        *byte ^= 1;
    }
    let cut = saved.get(..half).unwrap_or_default().to_vec();
    for (what, bytes) in [("nothing", Vec::new()), ("half of it", cut), ("one bit changed", flipped)] {
        let started = Tracker::new(subject, &drive)?.start(&Prior::Saved(Buffer::from(bytes)));
        expect(started.is_err(), || format!("{what}: it starts"), "an error that says what is wrong")?;
    }
    Ok(format!("{} bytes", saved.len()))
}

/// Readings that no sensor should give, and some do.
fn odd() -> Vec<(&'static str, Data)> {
    let odometry =
        |odom_from_base, twist| Data::Odometry(Odometry { odom_from_base, twist, noise: [0.01; 3] });
    let scan = |ranges_m: Buffer<f32>, max_range_m| {
        Data::LaserScan(LaserScan {
            first_bearing_rad: -std::f64::consts::FRAC_PI_2,
            bearing_step_rad: 1f64.to_radians(),
            max_range_m,
            ranges_m,
            ..LaserScan::default()
        })
    };
    let mark = |range_m: f64, bearing_rad: f64| {
        let marks = vec![Mark { identity: Some(1), range_m, bearing_rad }];
        Data::Marks(Marks { marks, range_deviation_m: 0.05, bearing_deviation_rad: 0.02 })
    };
    let fix = |at_m: f64, deviation_m: f64| {
        Data::PositionFix(PositionFix { position_m: [at_m; 3], deviation_m: [deviation_m; 3] })
    };
    let imu = |yaw_rad: f64| Data::Imu(Imu { attitude_rad: Some([0.0, 0.0, yaw_rad]), ..Imu::default() });
    let unknown = Mark { identity: Some(u32::MAX), range_m: 1.0, bearing_rad: 0.0 };
    vec![
        ("a fix at NaN", fix(f64::NAN, 1.0)),
        ("a fix at 1e300 m", fix(1e300, 1.0)),
        ("a fix without deviation", fix(1.0, 0.0)),
        ("a fix with a deviation of -1 m", fix(1.0, -1.0)),
        ("a fix with a deviation of 1e300 m", fix(1.0, 1e300)),
        ("an attitude of NaN", imu(f64::NAN)),
        ("an attitude of 1e300", imu(1e300)),
        ("no attitude", Data::Imu(Imu::default())),
        ("no marks", Data::Marks(Marks::default())),
        (
            "a mark of nowhere, without deviation",
            Data::Marks(Marks { marks: vec![unknown], ..Marks::default() }),
        ),
        ("a mark at NaN", mark(f64::NAN, 0.0)),
        ("a mark with a bearing of NaN", mark(1.0, f64::NAN)),
        ("a mark at 0 m", mark(0.0, 0.0)),
        ("a mark at -1 m", mark(-1.0, 0.0)),
        ("a mark at 1e300 m", mark(1e300, 1e300)),
        ("odometry of NaN", odometry(pose2(f64::NAN, 0.0, 0.0), Twist::ZERO)),
        ("odometry with a heading of NaN", odometry(pose2(0.0, 0.0, f64::NAN), Twist::ZERO)),
        ("odometry of 1e300 m", odometry(pose2(1e300, -1e300, 0.0), Twist::ZERO)),
        ("a speed of NaN", odometry(Pose2::identity(), Twist::new(f64::NAN, f64::NAN))),
        ("a scan without beams", scan(Buffer::default(), 15.0)),
        ("a scan of one beam", scan(Buffer::filled(1, 1.0), 15.0)),
        ("a scan without readings", scan(Buffer::filled(181, f32::NAN), 15.0)),
        ("a scan that meets nothing", scan(Buffer::filled(181, f32::INFINITY), 15.0)),
        ("a scan of 0 m", scan(Buffer::filled(181, 0.0), 15.0)),
        ("a scan of -1 m", scan(Buffer::filled(181, -1.0), 15.0)),
        ("a scan of 1e30 m", scan(Buffer::filled(181, 1e30), 1e31)),
        ("a scan with a reach of NaN", scan(Buffer::filled(181, 1.0), f32::NAN)),
    ]
}

fn odd_readings(subject: &Subject) -> Verdict {
    let drive = Drive::seen_from(Turn::None)?;
    let odd = odd();
    for (what, data) in &odd {
        let mut tracker = Tracker::new(subject, &drive)?;
        for (k, frame) in drive.frames.iter().take(20).enumerate() {
            if k == 0 {
                tracker.start_at(frame)?;
            }
            let spoiled: Vec<Observation>;
            let is_odd = (5..8).contains(&k);
            let seen = if is_odd {
                let sensor = match data {
                    Data::Odometry(_) => 0,
                    Data::PositionFix(_) => 3,
                    Data::Marks(_) => 4,
                    Data::Imu(_) => 5,
                    _ => 1,
                };
                spoiled = vec![observation(sensor, frame.now, data.clone())];
                &spoiled
            } else {
                &frame.seen
            };
            match tracker.update(frame.now, seen) {
                Ok(estimate) => sane(what, &estimate, frame.now)?,
                // One error may be the memory of what was odd; in the end there must be an estimate again.
                Err(_) if k < 19 => {}
                Err(error) => {
                    let found = format!("{what}: 1.2 s later still \"{error}\"");
                    return Err(Trouble::broken(found, "an estimate, once the readings are fine again"));
                }
            }
        }
    }
    Ok(format!("{} kinds of readings", odd.len()))
}

fn empty_map(subject: &Subject) -> Verdict {
    if subject.manifest().needs_layers.is_empty() {
        return Err(Trouble::not_applicable("it needs no map"));
    }
    let drive = Drive::seen_from(Turn::None)?;
    let mut tracker = Tracker::new(subject, &drive)?;
    tracker.map = Map::default();
    let Some(first) = drive.frames.first() else { return Ok(String::new()) };
    let started = tracker.start(&prior_of(first));
    let updated = tracker.update(first.now, &first.seen);
    match (started, updated) {
        (Err(error), _) | (_, Err(error)) => Ok(error),
        (Ok(()), Ok(_)) => Err(Trouble::broken("an estimate without a map", "an error that names the layer")),
    }
}
