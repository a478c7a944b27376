//! Laws of avoiders: empty, impossible and huge input.

use super::closed_loop::{Loop, Moment};
use super::drive::{observation, step_time};
use super::law::{Trouble, Verdict, expect};
use super::subject::Subject;
use nalgebra::Matrix3;
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Twist, pose2};
use rumbo_core::messages::{Data, Estimate, LaserScan};
use rumbo_core::stages::{AvoidError, Steering};

/// What is wrong, and how it gets so.
type Spoil = (&'static str, fn(&mut Moment));

pub fn survives_nothing(subject: &Subject) -> Verdict {
    let mut steered = Loop::new(subject)?;
    for k in 0..50 {
        let moment = Moment { seen: Vec::new(), ..steered.moment(k, steered.world.start, Twist::ZERO) };
        let answer = steered.steer(&moment);
        sane("nothing seen", &answer)?;
    }
    Ok(String::new())
}

pub fn names_bad_numbers(subject: &Subject) -> Verdict {
    let bad: [Spoil; 3] = [
        ("a pose at NaN", |moment| moment.map_from_base = pose2(f64::NAN, 0.0, 0.0)),
        ("a pose with a heading of NaN", |moment| moment.map_from_base = pose2(1.0, 1.0, f64::NAN)),
        ("a twist of NaN", |moment| moment.twist = Twist::new(f64::NAN, 0.0)),
    ];
    for (what, spoil) in bad {
        let mut steered = Loop::new(subject)?;
        let mut moment = steered.moment(0, steered.world.start, Twist::ZERO);
        let estimate = estimate_of(&moment);
        spoil(&mut moment);
        let answer = steered.steer_with(&moment, &estimate);
        let is_still = matches!(answer, Ok(Steering::Drive(Twist::ZERO)));
        expect(answer.is_err() || is_still, || format!("{what}: {answer:?}"), "an error")?;
    }
    Ok(String::new())
}

pub fn survives_odd_scans(subject: &Subject) -> Verdict {
    let scans: [(&str, Buffer<f32>); 6] = [
        ("no beams", Buffer::default()),
        ("one beam", Buffer::filled(1, 1.0)),
        ("beams without a reading", Buffer::filled(181, f32::NAN)),
        ("beams that meet nothing", Buffer::filled(181, f32::INFINITY)),
        ("beams of 0 m", Buffer::filled(181, 0.0)),
        ("beams of 1e30 m", Buffer::filled(181, 1e30)),
    ];
    for (what, ranges_m) in scans {
        let mut steered = Loop::new(subject)?;
        for k in 0..20 {
            let scan = LaserScan {
                first_bearing_rad: -std::f64::consts::FRAC_PI_2,
                bearing_step_rad: 1f64.to_radians(),
                max_range_m: 1e31,
                ranges_m: ranges_m.clone(),
                ..LaserScan::default()
            };
            let mut moment = steered.moment(k, steered.world.start, Twist::ZERO);
            moment.seen = vec![observation(1, step_time(k), Data::LaserScan(scan))];
            let answer = steered.steer(&moment);
            sane(what, &answer)?;
        }
    }
    Ok(String::new())
}

pub fn survives_huge_numbers(subject: &Subject) -> Verdict {
    let huge: [Spoil; 3] = [
        ("a pose at 1e300 m", |moment| moment.map_from_base = pose2(1e300, -1e300, 0.0)),
        ("an odometer at 1e300 m", |moment| moment.odom_from_base = pose2(-1e300, 0.0, 0.0)),
        ("a twist of 1e300 m/s", |moment| moment.twist = Twist::new(1e300, 1e300)),
    ];
    for (what, spoil) in huge {
        let mut steered = Loop::new(subject)?;
        for k in 0..5 {
            let mut moment = steered.moment(k, steered.world.start, Twist::ZERO);
            spoil(&mut moment);
            let answer = steered.steer(&moment);
            sane(what, &answer)?;
        }
    }
    Ok(String::new())
}

fn estimate_of(moment: &Moment) -> Estimate {
    Estimate::planar(moment.now, moment.map_from_base, moment.odom_from_base, Matrix3::identity() * 1e-4)
}

/// Any error, or finite numbers.
fn sane(what: &str, answer: &Result<Steering, AvoidError>) -> Result<(), Trouble> {
    let is_sane = match answer {
        Ok(Steering::Drive(twist)) => twist.is_finite(),
        Ok(Steering::Blocked { obstacles }) => {
            obstacles.iter().all(|o| o.position.coords.iter().all(|v| v.is_finite()) && o.radius_m >= 0.0)
        }
        _ => true,
    };
    expect(is_sane, || format!("{what}: {answer:?}"), "an error, or finite numbers")
}
