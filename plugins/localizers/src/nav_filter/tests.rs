use nalgebra::{Translation3, UnitQuaternion, Vector3};
use rumbo_core::frames::{Pose2, Pose3, Twist, lift, pose2};
use rumbo_core::map::Map;
use rumbo_core::messages::{
    Check, Data, Estimate, Imu, LaserScan, Observation, Odometry, Prior, Seen, SensorId, Status,
};
use rumbo_core::registry::{Params, Plugin, Registry, Stage};
use rumbo_core::stages::{BuildContext, Cx, LocalizeError, Localizer};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;
use rumbo_kit::nav_filter::FrameChain;

use super::NavFilterParams;

mod hall;
mod ladder;

use hall::{Device, Drive};

fn localizer(params: &NavFilterParams) -> Box<dyn Localizer> {
    let mut localizer: Box<dyn Localizer> = params.build(&BuildContext::bare("odometer")).unwrap();
    localizer.start(&at(Pose2::identity()), &Map::default()).unwrap();
    localizer
}

fn at(map_from_base: Pose2) -> Prior {
    let covariance = nalgebra::Matrix3::zeros();
    Prior::Pose { map_from_base, odom_from_base: Pose2::identity(), covariance }
}

fn update(localizer: &mut dyn Localizer, now: Time, seen: &[Observation]) -> Estimate {
    let trace = Trace::unwatched();
    let estimate = localizer.update(&mut Cx { now, trace: &trace }, Seen::sorted(seen), &Map::default());
    let estimate = estimate.unwrap();
    estimate.check().unwrap();
    estimate
}

fn tilt_deg(estimate: &Estimate, truth: &Pose3) -> f64 {
    let up = |pose: &Pose3| pose.rotation.inverse() * Vector3::z();
    up(&estimate.map_from_base).angle(&up(truth)).to_degrees()
}

/// Goes through a drive; the estimates with the truth at the scans.
fn follow(localizer: &mut dyn Localizer, drive: &Drive) -> Vec<(f64, Estimate, Pose3)> {
    let mut found = Vec::new();
    let mut pending = Vec::new();
    for observation in drive.observations() {
        let (stamp, is_scan) = (observation.stamp, matches!(observation.data, Data::LaserScan(_)));
        pending.push(observation);
        if is_scan {
            let estimate = update(localizer, stamp, &pending);
            pending.clear();
            let truth = drive.start().inverse() * drive.truth(estimate.stamp.as_secs());
            found.push((estimate.stamp.as_secs(), estimate, truth));
        }
    }
    found
}

fn off(estimate: &Estimate, truth: &Pose3) -> (f64, f64) {
    let way = estimate.pose2().inverse() * FrameChain::of(truth).odom_from_footprint;
    (way.translation.vector.norm(), way.rotation.angle().abs().to_degrees())
}

#[test]
fn a_drive_through_a_hall_is_followed_by_scans_and_inertia_alone() {
    let drive = Drive { seconds: 30.0, speed_m_s: 0.8, turn_rad_s: 0.4, ..Drive::default() };
    let found = follow(&mut *localizer(&NavFilterParams::default()), &drive);
    let (_, last, truth) = found.last().unwrap();
    let (off_m, off_deg) = off(last, truth);
    assert!(off_m < 0.12 && off_deg < 1.0, "{off_m} m, {off_deg} degrees");
    assert!(found.iter().skip(10).all(|(_, estimate, truth)| tilt_deg(estimate, truth) < 1.0));
    assert!(last.map_from_base.translation.z.abs() < 0.1);
    assert!(found[5..].iter().all(|(_, estimate, _)| estimate.status == Status::Tracking));
    let deviation_m = last.covariance[(0, 0)].sqrt().max(last.covariance[(1, 1)].sqrt());
    assert!(off_m < 4.0 * deviation_m && deviation_m < 0.5, "it knows how sure it is: {deviation_m}");
}

/// Roll and pitch sway by 20 degrees at 0.5 Hz, and the attitude that levels each scan errs by half a degree, anew each time.
/// The specification asks a map for 15 cm on such a drive; without one, 2 % of the way of 9 m more.
#[test]
fn on_a_swaying_base_attitude_and_way_hold() {
    let drive = Drive { seconds: 20.0, speed_m_s: 0.5, turn_rad_s: 0.3, sway_deg: 20.0, ..Drive::default() };
    let found = follow(&mut *localizer(&NavFilterParams::default()), &drive);
    let worst_m = found.iter().map(|(_, estimate, truth)| off(estimate, truth).0).fold(0.0, f64::max);
    let worst_deg = found.iter().skip(10).map(|(_, e, truth)| tilt_deg(e, truth)).fold(0.0, f64::max);
    assert!(worst_m < 0.15 + 0.02 * 9.25, "{worst_m} m");
    assert!(worst_deg < 1.0, "{worst_deg} degrees");
}

/// The specification's row: 45 degrees for five seconds, then level.
#[test]
fn steep_for_five_seconds_and_level_again_it_is_where_it_was() {
    let drive = Drive { seconds: 9.0, steep_deg: 45.0, ..Drive::default() };
    let found = follow(&mut *localizer(&NavFilterParams::default()), &drive);
    for (seconds, estimate, truth) in &found {
        assert!(tilt_deg(estimate, truth) < 1.0, "{seconds} s: {} degrees", tilt_deg(estimate, truth));
    }
    let (_, last, truth) = found.last().unwrap();
    // While it is steep only beams abeam see walls.
    assert!(off(last, truth).0 < 0.15, "{} m", off(last, truth).0);
}

#[test]
fn wheels_change_nothing_unless_they_are_asked() {
    let drive = Drive { seconds: 4.0, speed_m_s: 0.5, turn_rad_s: 0.2, ..Drive::default() };
    let slipping = Odometry { twist: Twist::new(0.25, 0.1), ..Odometry::default() };
    let poses = |params: &NavFilterParams, with_wheels: bool| -> Vec<Pose3> {
        let mut localizer = localizer(params);
        let mut poses = Vec::new();
        for observation in drive.observations() {
            let now = observation.stamp;
            let wheels =
                Observation { sensor: SensorId(7), data: Data::Odometry(slipping), ..observation.clone() };
            let both = [observation, wheels];
            let seen = if with_wheels { &both[..] } else { &both[..1] };
            poses.push(update(&mut *localizer, now, seen).map_from_base);
        }
        poses
    };
    let params = NavFilterParams::default();
    let bits = |poses: &[Pose3]| -> Vec<u64> {
        poses
            .iter()
            .flat_map(|p| {
                p.translation
                    .vector
                    .iter()
                    .chain(p.rotation.coords.iter())
                    .map(|v| v.to_bits())
                    .collect::<Vec<_>>()
            })
            .collect()
    };
    let without = poses(&params, false);
    assert_eq!(bits(&without), bits(&poses(&params, true)), "to the bit");
    let asked = NavFilterParams { wheels: true, ..params };
    assert_ne!(bits(&without), bits(&poses(&asked, true)));
}

#[test]
fn without_samples_scans_go_on_alone_and_without_scans_the_filter_reckons() {
    let drive = Drive { seconds: 10.0, speed_m_s: 0.4, turn_rad_s: 0.2, ..Drive::default() };
    let mut silent = localizer(&NavFilterParams::default());
    let mut last = None;
    for observation in drive.observations() {
        let t = observation.stamp.as_secs();
        let is_imu = matches!(observation.data, Data::Imu(_));
        // The device falls silent after 4 s.
        if !(is_imu && t > 4.0) {
            last = Some((update(&mut *silent, observation.stamp, &[observation]), t));
        }
    }
    let (estimate, t) = last.unwrap();
    let truth = drive.start().inverse() * drive.truth(t);
    assert!(off(&estimate, &truth).0 < 0.15, "{}", off(&estimate, &truth).0);
    let mut blind = localizer(&NavFilterParams::default());
    let mut status = Vec::new();
    for observation in drive.observations() {
        let t = observation.stamp.as_secs();
        if matches!(observation.data, Data::Imu(_)) || t < 4.0 {
            status.push((t, update(&mut *blind, observation.stamp, &[observation]).status));
        }
    }
    let is = |from: f64, to: f64, wanted: Status| {
        status.iter().filter(|(t, _)| (from..to).contains(t)).all(|(_, found)| *found == wanted)
    };
    assert!(is(0.5, 4.5, Status::Tracking) && is(5.2, 10.0, Status::Converging));
    let nothing = update(&mut *blind, Time::from_secs(20.0), &[]);
    assert_eq!(nothing.status, Status::Lost);
}

#[test]
fn a_robot_that_stands_stays_where_it_is_for_minutes() {
    let drive = Drive {
        seconds: 60.0,
        device: Device { rate_bias_rad_s: 0.01, ..Device::default() },
        ..Drive::default()
    };
    let found = follow(&mut *localizer(&NavFilterParams::default()), &drive);
    let (_, last, truth) = found.last().unwrap();
    let (off_m, off_deg) = off(last, truth);
    assert!(off_m < 0.10 && off_deg < 0.3, "{off_m} m, {off_deg} degrees");
    assert!(last.map_from_base.translation.z.abs() < 0.05);
}

#[test]
fn a_start_is_needed_and_needs_a_pose_and_the_start_is_kept() {
    let params = NavFilterParams::default();
    let mut fresh: Box<dyn Localizer> = params.build(&BuildContext::bare("odometer")).unwrap();
    let trace = Trace::unwatched();
    let mut cx = Cx { now: Time::ZERO, trace: &trace };
    assert_eq!(fresh.update(&mut cx, Seen::NOTHING, &Map::default()), Err(LocalizeError::NotStarted));
    assert!(fresh.start(&Prior::Unknown, &Map::default()).is_err());
    let there = pose2(3.0, 4.0, 2.0);
    fresh.start(&at(there), &Map::default()).unwrap();
    let estimate = update(&mut *fresh, Time::ZERO, &[]);
    assert!((estimate.pose2().inverse() * there).translation.vector.norm() < 1e-12);
    let drive = Drive { seconds: 2.0, ..Drive::default() };
    let mut last = estimate;
    for observation in drive.observations() {
        last = update(&mut *fresh, observation.stamp, &[observation]);
    }
    let off = last.pose2().inverse() * there;
    assert!(off.translation.vector.norm() < 0.01 && off.rotation.angle().abs() < 0.01);
    assert!((last.map_from_odom.translation.vector - lift(&there).translation.vector).norm() < 0.02);
}

#[test]
fn the_registry_builds_it_and_bad_values_are_named() {
    let registry = Registry::linked().unwrap();
    let entry = registry.get(Stage::Localizer, "nav_filter").unwrap();
    let configured =
        entry.source.parse("ci_omega = 0.5\nintersection = 'everything'".parse().unwrap()).ok().unwrap();
    assert!(configured.check().is_empty());
    let bad = NavFilterParams {
        ci_omega: Some(1.0),
        aid_rate_hz: 0.0,
        max_rejects: 0,
        history_s: f64::NAN,
        ..NavFilterParams::default()
    };
    let keys: Vec<String> = Params::check(&bad).into_iter().map(|fault| fault.path).collect();
    assert_eq!(keys, ["history_s", "aid_rate_hz", "ci_omega", "max_rejects"]);
}
