use rumbo_core::messages::LaserScan;
use rumbo_core::stages::WorldError;
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;

use super::*;
use crate::laser_2d::GaussianNoise;
use crate::test_world::{TestWorld, given};

fn params(noise: GaussianNoise) -> Laser2dParams {
    let noise = Box::new(noise);
    Laser2dParams {
        field_of_view_deg: 90.0,
        step_deg: 1.0,
        max_range_m: 4.0,
        noise,
        ..Laser2dParams::default()
    }
}

fn scan(params: &Laser2dParams, world: &mut TestWorld) -> LaserScan {
    let mut sensor = params.build(&BuildContext::bare("sensor")).unwrap();
    let mut out = Observations::default();
    let trace = Trace::unwatched();
    sensor.poll(&mut Cx { now: Time(5), trace: &trace }, world, &mut out).unwrap();
    let given = given(&out);
    let [Observation { stamp: Time(5), valid: true, data: Data::LaserScan(scan), .. }] = given.as_slice()
    else {
        panic!("{given:?}")
    };
    scan.clone()
}

#[test]
fn without_noise_the_readings_are_exact_and_nothing_within_reach_is_infinite() {
    let scan = scan(&params(GaussianNoise::default()), &mut TestWorld::with_wall(3.0));
    assert_eq!(scan.ranges_m.len(), 91);
    assert!((scan.first_bearing_rad + 45f64.to_radians()).abs() < 1e-12);
    assert!((scan.ranges_m[45] - 3.0).abs() < 1e-6);
    assert!((f64::from(scan.ranges_m[5]) - 3.0 / 40f64.to_radians().cos()).abs() < 1e-6);
    assert!(scan.ranges_m[0].is_infinite(), "4.24 m is beyond 4 m");
    let blind = self::scan(&params(GaussianNoise::default()), &mut TestWorld::with_wall(0.01));
    assert!(blind.ranges_m[45].is_nan(), "nearer than the device can see");
}

#[test]
fn a_full_turn_has_no_doubled_beam() {
    let shape = Laser2dParams { field_of_view_deg: 360.0, step_deg: 0.5, ..Laser2dParams::default() }.shape();
    assert_eq!(shape.n_beams, 720);
    assert!((shape.first_bearing_rad + std::f64::consts::PI).abs() < 1e-12);
    let odd = Laser2dParams { field_of_view_deg: 100.0, step_deg: 0.3, ..Laser2dParams::default() }.shape();
    assert_eq!(odd.n_beams, 334);
    assert!((odd.first_bearing_rad + 49.95f64.to_radians()).abs() < 1e-12, "the middle stays the x axis");
}

/// A wall seen at bearing b has slope 2 sin b / cos² b: a bearing error of s gives a range error of slope times s.
#[test]
fn bent_beams_err_where_the_wall_is_slanted() {
    let noise = GaussianNoise { bearing_deg: 0.5, ..GaussianNoise::default() };
    let (mut ahead, mut slanted) = (Vec::new(), Vec::new());
    let params = params(noise);
    let mut sensor = params.build(&BuildContext::bare("sensor")).unwrap();
    let (mut world, mut out, trace) =
        (TestWorld::with_wall(2.0), Observations::default(), Trace::unwatched());
    for _ in 0..2_000 {
        sensor.poll(&mut Cx { now: Time(5), trace: &trace }, &mut world, &mut out).unwrap();
        while let Some(observation) = out.pop_front() {
            let Data::LaserScan(scan) = observation.data else { panic!() };
            ahead.push(f64::from(scan.ranges_m[45]) - 2.0);
            slanted.push(f64::from(scan.ranges_m[5]) - 2.0 / 40f64.to_radians().cos());
        }
    }
    let deviation = |errors: &[f64]| (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
    let bearing_rad = 40f64.to_radians();
    let expected = 2.0 * bearing_rad.sin() / bearing_rad.cos().powi(2) * 0.5f64.to_radians();
    assert!((deviation(&slanted) / expected - 1.0).abs() < 0.1, "{} {expected}", deviation(&slanted));
    assert!(deviation(&ahead) < 2e-4);
}

#[test]
fn the_seed_and_the_name_decide_the_noise() {
    let noise = GaussianNoise { range_m: 0.02, dropout: 0.05, ..GaussianNoise::default() };
    let bits = |seed: u64| -> Vec<u32> {
        let context = BuildContext { seed, ..BuildContext::bare("sensor") };
        let mut sensor = params(noise).build(&context).unwrap();
        let (mut out, trace) = (Observations::default(), Trace::unwatched());
        sensor
            .poll(&mut Cx { now: Time(0), trace: &trace }, &mut TestWorld::with_wall(3.0), &mut out)
            .unwrap();
        let Data::LaserScan(scan) = &given(&out)[0].data else { panic!() };
        scan.ranges_m.iter().map(|range| range.to_bits()).collect()
    };
    assert_eq!(bits(1), bits(1));
    assert_ne!(bits(1), bits(2));
}

#[test]
fn a_silent_laser_gives_nothing_and_a_spoiled_one_rubbish() {
    let scans = |faults: ScanFaultParams| {
        let mut sensor = Laser2dParams { faults, ..params(GaussianNoise::default()) }
            .build(&BuildContext::bare("sensor"))
            .unwrap();
        let (mut out, trace) = (Observations::default(), Trace::unwatched());
        for second in 0..4 {
            let now = Time::from_secs(f64::from(second));
            sensor.poll(&mut Cx { now, trace: &trace }, &mut TestWorld::with_wall(3.0), &mut out).unwrap();
        }
        given(&out)
    };
    let stamps: Vec<f64> = scans(ScanFaultParams { silent_from_s: 1.0, silent_for_s: 2.0, corrupt: 0.0 })
        .iter()
        .map(|observation| observation.stamp.as_secs())
        .collect();
    assert_eq!(stamps, [0.0, 3.0]);
    for observation in scans(ScanFaultParams { corrupt: 1.0, ..ScanFaultParams::default() }) {
        let Data::LaserScan(scan) = &observation.data else { panic!() };
        assert!((scan.ranges_m[45] - 3.0).abs() > 1e-6, "the exact range by chance");
    }
}

#[test]
fn a_recording_is_passed_on_with_its_stamps() {
    let stamp = Time(123);
    let data = Data::LaserScan(LaserScan { ranges_m: vec![1.0f32].into(), ..LaserScan::default() });
    let context = BuildContext { sensor: rumbo_core::messages::SensorId(3), ..BuildContext::bare("sensor") };
    let old = Observation {
        sensor: rumbo_core::messages::SensorId(9),
        stamp,
        base_from_sensor: rumbo_core::frames::Pose3::identity(),
        valid: true,
        data: data.clone(),
    };
    let trace = Trace::unwatched();
    let bent = GaussianNoise { bearing_deg: 0.5, ..GaussianNoise::default() };
    for noise in [GaussianNoise::default(), bent] {
        let mut sensor = params(noise).build(&context).unwrap();
        let (mut world, mut out) = (TestWorld::recorded(vec![old.clone()]), Observations::default());
        sensor.poll(&mut Cx { now: Time(200), trace: &trace }, &mut world, &mut out).unwrap();
        assert_eq!((given(&out)[0].sensor, given(&out)[0].stamp), (context.sensor, stamp));
        assert_eq!(given(&out)[0].data, data);
    }
    let mut out = Observations::default();
    let mut nameless = params(GaussianNoise::default()).build(&BuildContext::bare("other")).unwrap();
    let error =
        nameless.poll(&mut Cx { now: Time(0), trace: &trace }, &mut TestWorld::recorded(vec![]), &mut out);
    assert_eq!(error, Err(SensorError::World(WorldError::Unsupported { probe: "beams" })));
}

#[test]
fn impossible_lasers_are_named() {
    let bad = Laser2dParams {
        field_of_view_deg: 400.0,
        step_deg: 0.0,
        min_range_m: f64::NAN,
        max_range_m: -1.0,
        noise: Box::new(GaussianNoise { dropout: 2.0, ..GaussianNoise::default() }),
        faults: ScanFaultParams { corrupt: 2.0, ..ScanFaultParams::default() },
    };
    let keys: Vec<String> = bad.check().into_iter().map(|fault| fault.path).collect();
    assert_eq!(
        keys,
        ["field_of_view_deg", "step_deg", "min_range_m", "max_range_m", "noise.dropout", "faults.corrupt"]
    );
    assert!(Laser2dParams::default().check().is_empty());
    assert!(Laser2dParams { step_deg: 1e-6, ..Laser2dParams::default() }.check().len() == 1);
}
