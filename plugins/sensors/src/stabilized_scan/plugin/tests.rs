use nalgebra::{Point3, UnitQuaternion, Vector3};
use rumbo_core::messages::{Check, Imu};
use rumbo_core::trace::Trace;
use serde_json::Value;

use super::*;
use crate::test_world::given;

const VECTOR: &str = include_str!("../../../tests/data/slam2d_frames.json");

fn sensor(params: &StabilizedScanParams) -> Box<dyn Sensor> {
    params.build(&BuildContext::bare("scan")).unwrap()
}

fn mount(x_m: f64, z_m: f64) -> Pose3 {
    Pose3::from_parts(Translation3::new(x_m, 0.0, z_m), UnitQuaternion::identity())
}

fn observation(stamp_s: f64, base_from_sensor: Pose3, data: Data) -> Observation {
    Observation { sensor: SensorId(1), stamp: Time::from_secs(stamp_s), base_from_sensor, valid: true, data }
}

fn imu(stamp_s: f64, roll_rad: f64, pitch_rad: f64, yaw_rad: f64) -> Observation {
    let attitude_rad = Some([roll_rad, pitch_rad, yaw_rad]);
    observation(stamp_s, Pose3::identity(), Data::Imu(Imu { attitude_rad, ..Imu::default() }))
}

/// Five beams from right to left.
fn scan_of(ranges_m: &[f32]) -> LaserScan {
    LaserScan {
        first_bearing_rad: -std::f64::consts::FRAC_PI_2,
        bearing_step_rad: std::f64::consts::FRAC_PI_4,
        max_range_m: 30.0,
        ranges_m: ranges_m.to_vec().into(),
        ..LaserScan::default()
    }
}

fn scan(stamp_s: f64, base_from_sensor: Pose3, ranges_m: &[f32]) -> Observation {
    observation(stamp_s, base_from_sensor, Data::LaserScan(scan_of(ranges_m)))
}

/// What it gives, and its counters.
fn derive(sensor: &mut dyn Sensor, seen: &[Observation]) -> (Vec<Observation>, Vec<(&'static str, f64)>) {
    let (trace, mut out) = (Trace::counting(), Observations::default());
    sensor.derive(&mut Cx { now: Time::ZERO, trace: &trace }, Seen::sorted(seen), &mut out).unwrap();
    let given = given(&out);
    given.iter().for_each(|observation| observation.check().unwrap());
    (given, trace.take().1)
}

fn ranges(observation: &Observation) -> &Buffer<f32> {
    let Data::LaserScan(scan) = &observation.data else { panic!("a scan") };
    &scan.ranges_m
}

fn count(counters: &[(&'static str, f64)], name: &str) -> f64 {
    counters.iter().find(|(known, _)| *known == name).unwrap().1
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect()
}

/// The specification's chain of frames: a camera on a base that rolls and pitches.
#[test]
fn points_are_where_the_specification_puts_them_in_the_level_frame() {
    let chain: Value = serde_json::from_str(VECTOR).unwrap();
    let chain = &chain["point_chain"];
    let at = |key: &str| numbers(&chain[key]);
    let (xyz, tilt) = (at("sensor_to_base_link_xyz"), at("roll_pitch_of_base_link_in_base_stabilized"));
    for yaw_rad in [0.0, 0.6, -3.0] {
        let seen = [imu(1.0, tilt[0], tilt[1], yaw_rad), scan(1.0, mount(xyz[0], xyz[2]), &[3.0; 5])];
        let (leveled, _) = derive(&mut *sensor(&StabilizedScanParams::default()), &seen);
        let point = Point3::from(Vector3::from_vec(at("point_in_sensor")));
        let found = leveled[0].base_from_sensor * point;
        let expected = Point3::from(Vector3::from_vec(at("point_in_base_stabilized")));
        assert!((found - expected).norm() < 1e-10, "{found} {expected}");
        let origin = Vector3::from_vec(at("sensor_origin_in_base_stabilized"));
        assert!((leveled[0].base_from_sensor.translation.vector - origin).norm() < 1e-10);
    }
}

#[test]
fn a_scan_in_which_nothing_changes_shares_its_ranges_with_the_lasers() {
    let given = scan(1.0, mount(0.0, 0.3), &[2.0, 3.0, f32::NAN, f32::INFINITY, 0.0]);
    let (leveled, _) =
        derive(&mut *sensor(&StabilizedScanParams::default()), &[imu(1.0, 0.0, 0.0, 2.0), given.clone()]);
    assert_eq!(ranges(&leveled[0]).as_slice().as_ptr(), ranges(&given).as_slice().as_ptr());
    let short = StabilizedScanParams { max_range_m: Some(2.5), ..StabilizedScanParams::default() };
    let (leveled, _) = derive(&mut *sensor(&short), &[imu(1.0, 0.0, 0.0, 2.0), given.clone()]);
    assert_eq!(ranges(&leveled[0])[0], 2.0);
    assert!(ranges(&leveled[0])[1].is_nan());
    assert_eq!(ranges(&given)[1], 3.0, "the laser's own scan stays");
}

/// 45 degrees down, all that the laser sees ahead is floor; on the level again everything is as before.
#[test]
fn steeply_down_the_floor_is_no_wall_and_level_again_all_is_as_before() {
    let mut leveler = sensor(&StabilizedScanParams::default());
    let steep = std::f64::consts::FRAC_PI_4;
    let floor_m = (0.3 / steep.tan() / steep.cos()) as f32;
    let (leveled, counters) =
        derive(&mut *leveler, &[imu(1.0, 0.0, steep, 0.0), scan(1.0, mount(0.0, 0.3), &[floor_m; 5])]);
    // Beams abeam stay level.
    assert_eq!(
        ranges(&leveled[0]).iter().map(|r| r.is_nan()).collect::<Vec<_>>(),
        [false, true, true, true, false]
    );
    assert_eq!((count(&counters, "beams_out_of_height"), leveled[0].valid), (3.0, true));
    let (leveled, _) =
        derive(&mut *leveler, &[imu(1.1, 0.0, 0.0, 0.0), scan(1.1, mount(0.0, 0.3), &[4.0; 5])]);
    assert_eq!(ranges(&leveled[0])[..], [4.0; 5]);
}

#[test]
fn an_old_attitude_is_used_flagged_and_counted_and_without_any_there_is_no_scan() {
    let mut leveler = sensor(&StabilizedScanParams::default());
    let (leveled, counters) = derive(&mut *leveler, &[scan(0.5, mount(0.0, 0.3), &[2.0; 5])]);
    assert_eq!((leveled.len(), count(&counters, "scans_without_attitude")), (0, 1.0));
    let seen = [imu(1.0, 0.0, 0.1, 0.0), scan(1.2, mount(0.0, 0.3), &[2.0; 5])];
    let (leveled, counters) = derive(&mut *leveler, &seen);
    assert_eq!((leveled[0].valid, count(&counters, "scans_attitude_stale")), (false, 1.0));
    let pitch_rad = leveled[0].base_from_sensor.rotation.euler_angles().1;
    assert!((pitch_rad - 0.1).abs() < 1e-12);
    let (leveled, counters) =
        derive(&mut *leveler, &[imu(1.25, 0.0, 0.0, 0.0), scan(1.3, mount(0.0, 0.3), &[2.0; 5])]);
    assert_eq!((leveled[0].valid, count(&counters, "scans_attitude_stale")), (true, 1.0));
}

#[test]
fn stamps_that_do_not_grow_are_dropped_and_empty_scans_are_told() {
    let mut leveler = sensor(&StabilizedScanParams::default());
    let seen = [imu(1.0, 0.0, 0.0, 0.0), scan(1.0, mount(0.0, 0.3), &[2.0; 5])];
    assert_eq!(derive(&mut *leveler, &seen).0.len(), 1);
    let (leveled, counters) = derive(&mut *leveler, &seen);
    assert_eq!((leveled.len(), count(&counters, "scans_not_newer")), (0, 1.0));
    for (k, empty) in [&[f32::NAN; 5][..], &[]].into_iter().enumerate() {
        let (leveled, counters) = derive(&mut *leveler, &[scan(1.05, mount(0.0, 0.3), empty)]);
        if k == 0 {
            assert_eq!((leveled.len(), count(&counters, "scans_too_few_points")), (1, 1.0));
        } else {
            assert_eq!((leveled.len(), count(&counters, "scans_not_newer")), (0, 2.0));
        }
    }
    let bad = Observation { valid: false, ..imu(1.1, 0.0, 9.0, 0.0) };
    let (leveled, _) = derive(&mut *leveler, &[bad, scan(1.1, mount(0.0, 0.3), &[])]);
    assert!(leveled[0].base_from_sensor.rotation.angle() < 1e-12, "what its device does not stand by");
}

/// A laser that turns with the robot while its mirror turns sees the walls of the corner where they are.
#[test]
fn beams_of_a_turning_laser_are_put_where_they_were_at_the_stamp() {
    let params = StabilizedScanParams { deskew: true, ..StabilizedScanParams::default() };
    let (n, sweep_s, rate_rad_s) = (181, 0.05, 2.0);
    let step_rad = std::f64::consts::PI / 180.0;
    // A wall 2 m ahead; beam k leaves at k / 180 of the sweep, when the laser looks further to the left.
    let seen_m = |k: usize| {
        let bearing = step_rad * (k as f64 - 90.0) + rate_rad_s * sweep_s * k as f64 / 180.0;
        let range = 2.0 / bearing.cos();
        if bearing.cos() > 0.1 { range as f32 } else { f32::NAN }
    };
    let swept = LaserScan {
        bearing_step_rad: step_rad,
        sweep_s,
        ranges_m: (0..n).map(seen_m).collect::<Vec<f32>>().into(),
        ..scan_of(&[])
    };
    let turning = Imu { attitude_rad: Some([0.0; 3]), rates_rad_s: [0.0, 0.0, rate_rad_s], ..Imu::default() };
    let seen = [
        observation(1.0, Pose3::identity(), Data::Imu(turning)),
        observation(1.0, mount(0.2, 0.3), Data::LaserScan(swept)),
    ];
    let (leveled, _) = derive(&mut *sensor(&params), &seen);
    let Data::LaserScan(scan) = &leveled[0].data else { panic!("a scan") };
    assert_eq!(scan.sweep_s, 0.0);
    for (bearing, range) in scan.hits() {
        assert!((range * bearing.cos() - 2.0).abs() < 1e-5, "{bearing} {range}");
    }
    assert!(scan.hits().count() > 140);
}

#[test]
fn a_few_points_are_as_many_as_asked_for() {
    let params = StabilizedScanParams { max_points: 2, ..StabilizedScanParams::default() };
    let (leveled, _) = derive(
        &mut *sensor(&params),
        &[imu(1.0, 0.0, 0.0, 0.0), scan(1.0, mount(0.0, 0.3), &[2.0, 3.0, 4.0, 2.5, 1.0])],
    );
    assert_eq!(ranges(&leveled[0]).iter().filter(|range_m| range_m.is_finite()).count(), 2);
}

#[test]
fn bad_values_are_named() {
    let bad = StabilizedScanParams {
        min_range_m: Some(-1.0),
        max_range_m: Some(-2.0),
        self_filter_m: Some(0.0),
        lowest_m: 0.0,
        highest_m: f64::NAN,
        floor_m: f64::INFINITY,
        tilt_margin_deg: 45.0,
        max_attitude_age_s: -0.1,
        ..StabilizedScanParams::default()
    };
    let keys: Vec<String> = Params::check(&bad).into_iter().map(|fault| fault.path).collect();
    let expected = [
        "min_range_m",
        "max_range_m",
        "self_filter_m",
        "lowest_m",
        "highest_m",
        "floor_m",
        "tilt_margin_deg",
        "max_attitude_age_s",
    ];
    assert_eq!(keys, expected);
    assert!(bad.build(&BuildContext::bare("scan")).is_err());
}
