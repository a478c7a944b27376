//! What is near, and what is remembered.

use super::*;
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Pose3, lift, pose2};
use rumbo_core::messages::{Data, LaserScan, PointCloud, RangeRing};

fn near(memory_s: f64) -> NearPoints {
    NearPoints::new(NearTuning {
        keep_m: 2.0,
        band_m: [0.05, 0.4],
        stale_after: Span::from_secs(1.0),
        memory: Span::from_secs(memory_s),
    })
}

fn observation(sensor: u16, stamp_s: f64, mount: Pose3, data: Data) -> Observation {
    let stamp = Time::from_secs(stamp_s);
    Observation { sensor: SensorId(sensor), stamp, base_from_sensor: mount, valid: true, data }
}

/// 61 beams of one degree, straight ahead in the middle; all alike but for those named.
fn scan(stamp_s: f64, usual_m: f32, others: &[(usize, f32)]) -> Observation {
    let mut ranges_m = Buffer::filled(61, usual_m);
    others.iter().for_each(|(beam, range_m)| ranges_m.make_mut()[*beam] = *range_m);
    let data = Data::LaserScan(LaserScan {
        first_bearing_rad: -30f64.to_radians(),
        bearing_step_rad: 1f64.to_radians(),
        min_range_m: 0.1,
        max_range_m: 4.0,
        ranges_m,
        ..LaserScan::default()
    });
    observation(0, stamp_s, Pose3::identity(), data)
}

fn positions(
    near: &mut NearPoints,
    now_s: f64,
    odom_from_base: &Pose2,
    with_memory: bool,
) -> Vec<(f64, f64)> {
    near.settle(Time::from_secs(now_s), odom_from_base);
    near.points(with_memory).iter().map(|point| (point.in_base.x, point.in_base.y)).collect()
}

fn is_about(found: &[(f64, f64)], expected: &[(f64, f64)]) -> bool {
    found.len() == expected.len()
        && found.iter().zip(expected).all(|(a, b)| (a.0 - b.0).abs() < 1e-6 && (a.1 - b.1).abs() < 1e-6)
}

const INF: f32 = f32::INFINITY;

#[test]
fn scans_rings_and_clouds_give_the_same_point() {
    // One meter ahead of a sensor that is 0.2 m ahead of the base and looks left.
    let mount = lift(&pose2(0.2, 0.0, 90f64.to_radians())) * Pose3::translation(0.0, 0.0, 0.2);
    let Data::LaserScan(scan) = scan(0.0, INF, &[(30, 1.0)]).data else { panic!() };
    let ring = RangeRing {
        cone_rad: 0.3,
        bearing_step_rad: 1.0,
        ring_radius_m: 0.25,
        max_range_m: 5.0,
        ranges_m: Buffer::from(vec![0.75, INF, 5.5]),
        ..RangeRing::default()
    };
    let points = vec![[f32::NAN; 3], [1.0, 0.0, 0.0], [1.0, 0.0, -0.19], [1.0, 0.0, 0.3], [1.1, 0.0, 0.1]];
    let cloud = PointCloud { points_m: Buffer::from(points) };
    for data in [Data::LaserScan(scan), Data::RangeRing(ring), Data::PointCloud(cloud)] {
        let mut near = near(0.0);
        near.see(&observation(0, 0.0, mount, data.clone()), &Pose2::identity());
        let found = positions(&mut near, 0.0, &Pose2::identity(), true);
        assert!(is_about(&found, &[(0.2, 1.0)]), "{found:?} {data:?}");
    }
}

#[test]
fn a_cloud_counts_between_floor_and_headroom_only() {
    let heights = [-0.1f32, 0.04, 0.06, 0.39, 0.41];
    let points: Vec<[f32; 3]> = (0u8..).zip(heights).map(|(k, z)| [1.0, 0.1 * f32::from(k), z]).collect();
    let mut near = near(0.0);
    let cloud = Data::PointCloud(PointCloud { points_m: Buffer::from(points) });
    near.see(&observation(0, 0.0, Pose3::identity(), cloud), &Pose2::identity());
    let found = positions(&mut near, 0.0, &Pose2::identity(), true);
    assert_eq!(found.iter().map(|(_, y)| (y * 10.0).round()).collect::<Vec<_>>(), [2.0, 3.0]);
}

#[test]
fn what_is_seen_stays_where_it_is_while_the_robot_moves() {
    let mut near = near(0.0);
    near.see(&scan(0.0, INF, &[(30, 1.0)]), &pose2(5.0, 5.0, 0.0));
    let found = positions(&mut near, 0.1, &pose2(5.5, 5.0, 90f64.to_radians()), true);
    assert!(is_about(&found, &[(0.0, -0.5)]), "{found:?}");
}

#[test]
fn what_left_the_view_is_remembered_for_a_while_and_within_reach() {
    let mut near = near(3.0);
    let turned = |deg: f64| pose2(0.0, 0.0, deg.to_radians());
    near.see(&scan(0.0, INF, &[(30, 1.0)]), &turned(0.0));
    near.see(&scan(0.1, INF, &[]), &turned(60.0));
    assert!(positions(&mut near, 0.1, &turned(60.0), false).is_empty());
    let remembered = positions(&mut near, 0.1, &turned(60.0), true);
    assert!(is_about(&remembered, &[(0.5, -(0.75f64.sqrt()))]), "{remembered:?}");
    assert!(near.points(true)[0].is_remembered);
    assert_eq!(positions(&mut near, 3.0, &turned(60.0), true).len(), 1);
    assert!(positions(&mut near, 3.01, &turned(60.0), true).is_empty());
}

/// A cloud without a point in a direction may look elsewhere: what it showed there is remembered for a while, and not seen.
#[test]
fn what_a_cloud_shows_no_more_is_remembered_for_a_while() {
    let cloud = |stamp_s: f64, points: Vec<[f32; 3]>| {
        let data = Data::PointCloud(PointCloud { points_m: Buffer::from(points) });
        observation(0, stamp_s, Pose3::identity(), data)
    };
    let (mut near, turned) = (near(3.0), pose2(0.0, 0.0, 1.0));
    near.see(&cloud(0.0, vec![[1.0, 0.0, 0.2]]), &Pose2::identity());
    for k in 1..60 {
        near.see(&cloud(0.1 * f64::from(k), vec![[f32::NAN; 3]]), &turned);
        assert!(positions(&mut near, 0.1 * f64::from(k), &turned, false).is_empty());
        assert_eq!(near.points(true).len(), usize::from(k <= 30), "{k}");
    }
}

#[test]
fn what_is_far_away_by_now_is_forgotten() {
    let mut near = near(30.0);
    near.see(&scan(0.0, INF, &[(30, 1.0)]), &pose2(0.0, 0.0, 0.0));
    near.see(&scan(0.1, INF, &[]), &pose2(0.0, 0.0, 2.0));
    assert_eq!(positions(&mut near, 0.1, &pose2(-0.9, 0.0, 2.0), true).len(), 1);
    assert!(positions(&mut near, 0.2, &pose2(-1.1, 0.0, 2.0), true).is_empty());
}

#[test]
fn a_look_through_a_remembered_point_forgets_it_and_one_that_ends_before_it_does_not() {
    let turned = |deg: f64| pose2(0.0, 0.0, deg.to_radians());
    for (range_m, is_kept) in [(INF, false), (2.0, false), (1.05, false), (0.5, true), (f32::NAN, true)] {
        let mut near = near(30.0);
        near.see(&scan(0.0, INF, &[(30, 1.0)]), &turned(0.0));
        near.see(&scan(0.1, INF, &[]), &turned(60.0));
        near.see(&scan(0.2, range_m, &[]), &turned(0.0));
        near.settle(Time::from_secs(0.2), &turned(0.0));
        let at_the_place = |near: &&NearPoint| (near.in_base - Point2::new(1.0, 0.0)).norm() < 1e-6;
        let n_kept = near.points(true).iter().filter(at_the_place).count();
        assert_eq!(n_kept, usize::from(is_kept), "{range_m}");
    }
}

/// Nearer than a real camera can see: the reading is gone, the thing is not.
#[test]
fn what_turns_into_no_reading_while_it_is_looked_at_counts_as_seen() {
    let mut near = near(30.0);
    near.see(&scan(0.0, INF, &[(30, 0.6)]), &pose2(0.0, 0.0, 0.0));
    near.see(&scan(0.1, INF, &[(30, f32::NAN)]), &pose2(0.2, 0.0, 0.0));
    // As good as seen, and not for a while only.
    let found = positions(&mut near, 0.1, &pose2(0.2, 0.0, 0.0), false);
    assert!(is_about(&found, &[(0.4, 0.0)]), "{found:?}");
    near.see(&scan(50.0, INF, &[(30, f32::NAN)]), &pose2(0.2, 0.0, 0.0));
    assert_eq!(positions(&mut near, 50.1, &pose2(0.2, 0.0, 0.0), false).len(), 1);
    // Out of view it is remembered like everything else.
    near.see(&scan(50.2, INF, &[]), &pose2(0.2, 0.0, 2.0));
    assert!(positions(&mut near, 50.3, &pose2(0.2, 0.0, 2.0), false).is_empty());
    assert_eq!(positions(&mut near, 50.4, &pose2(0.2, 0.0, 2.0), true).len(), 1);
}

#[test]
fn sound_does_not_forget_what_light_saw() {
    let mut near = near(30.0);
    let ring = |stamp_s: f64| {
        let ring = RangeRing {
            cone_rad: 1.0,
            bearing_step_rad: 1.0,
            max_range_m: 5.0,
            ranges_m: Buffer::filled(6, INF),
            ..RangeRing::default()
        };
        observation(1, stamp_s, Pose3::identity(), Data::RangeRing(ring))
    };
    near.see(&scan(0.0, INF, &[(30, 1.0)]), &pose2(0.0, 0.0, 0.0));
    near.see(&scan(0.1, INF, &[]), &pose2(0.0, 0.0, 1.0));
    near.see(&ring(0.2), &pose2(0.0, 0.0, 1.0));
    assert_eq!(positions(&mut near, 0.2, &pose2(0.0, 0.0, 1.0), true).len(), 1);
}

#[test]
fn memory_is_bounded_and_merges_what_is_close() {
    let mut near = near(600.0);
    for k in 0..3000 {
        let at = pose2(0.0, 0.0, 0.7 * f64::from(k));
        near.see(&scan(0.05 * f64::from(k), 0.3 + 0.0005 * k as f32, &[]), &at);
        near.settle(Time::from_secs(0.05 * f64::from(k)), &at);
    }
    assert!(near.points(true).len() <= 61 + 512);
    let apart = |a: &NearPoint, b: &NearPoint| (a.in_base - b.in_base).norm() > 0.039;
    let remembered: Vec<_> = near.points(true).iter().filter(|near| near.is_remembered).collect();
    assert!(remembered.len() > 100);
    assert!(remembered.iter().enumerate().all(|(k, a)| remembered[..k].iter().all(|b| apart(a, b))));
}

#[test]
fn a_blind_sensor_stops_the_robot_and_a_silent_one_is_named() {
    let mut near = near(0.0);
    let at = Time::from_secs;
    assert_eq!(near.sight(at(0.0)), Ok(Sight::Blind));
    assert_eq!(near.sight(at(1.0)), Ok(Sight::Blind));
    let message = near.sight(at(1.1)).unwrap_err().to_string();
    assert_eq!(message, "no point cloud, laser scan or range ring for 1.10 s");
    near.see(&scan(2.0, 1.0, &[]), &Pose2::identity());
    assert_eq!(near.sight(at(2.0)), Ok(Sight::Clear));
    near.see(&Observation { valid: false, ..scan(2.5, INF, &[]) }, &Pose2::identity());
    assert_eq!(near.sight(at(2.5)), Ok(Sight::Blind));
    near.see(&scan(2.6, 1.0, &[]), &Pose2::identity());
    assert_eq!(near.sight(at(2.6)), Ok(Sight::Clear));
    near.see(&Observation { valid: false, ..scan(2.7, INF, &[]) }, &Pose2::identity());
    // Its last word ages, then the wait for the next begins.
    assert_eq!(near.sight(at(3.7)), Ok(Sight::Blind));
    assert!(near.sight(at(4.8)).unwrap_err().to_string().starts_with("no laser_scan"));
}
