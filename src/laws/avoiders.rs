//! Laws of avoiders: what they steer is sound, the same from every side, and leads to the end of the path.

use super::avoider_faults;
use super::closed_loop::{ARRIVAL_RADIUS_M, Ended, Loop, Moment};
use super::drive::STEP_S;
use super::law::{Law, Trouble, Verdict, expect};
use super::memory::stays_finite;
use super::subject::Subject;
use super::turn::Turn;
use rumbo_core::frames::{Point2, Twist};
use rumbo_core::messages::Path;
use rumbo_core::stages::Steering;

/// What every avoider keeps.
pub const LAWS: &[Law] = &[
    Law::new("it brings the robot to the end of the path", arrives)
        .within("the arrival radius of 0.1 m, 300 s"),
    Law::new("it steers finite twists that the drive can do, no faster than the robot may", keeps_the_limits)
        .within("1e-9"),
    Law::new("the robot does not touch what its scanner sees", touches_nothing).within("60 s"),
    Law::new("the same input gives the same steering", deterministic).within("to the bit"),
    Law::new("a world turned or mirrored turns the steering with it", symmetric)
        .within("1 mm/s and 0.1 degrees/s, over 30 s"),
    Law::new("without a path it needs no path", wanders),
    Law::new("it survives having seen nothing", avoider_faults::survives_nothing),
    Law::new("numbers that are not finite give an error", avoider_faults::names_bad_numbers),
    Law::new("it survives empty, unread and huge scans", avoider_faults::survives_odd_scans),
    Law::new("it survives huge numbers", avoider_faults::survives_huge_numbers),
    Law::new("10,000 calls use finite memory", finite_memory).within("64 MiB").long(),
];

/// Steps of the longest drive.
const N_STEPS: usize = 3000;

fn arrives(subject: &Subject) -> Verdict {
    let mut steered = Loop::new(subject)?;
    let goal = steered.world.goal.position;
    let mut time_s = 0.0;
    let end = steered.drive(N_STEPS, |moment, _| {
        time_s = moment.now.as_secs();
        Ok(())
    })?;
    let left_m = (Point2::from(end.pose.translation.vector) - goal).norm();
    match end.what {
        Ended::Arrived => {
            let found = || format!("it says that it arrived {left_m:.3} m from the end");
            expect(left_m <= ARRIVAL_RADIUS_M, found, format!("at most {ARRIVAL_RADIUS_M} m"))?;
            Ok(format!("{left_m:.3} m from the end, after {time_s:.0} s"))
        }
        Ended::Blocked => {
            let found = format!("it says that the way is blocked, {left_m:.2} m from the end");
            Err(Trouble::broken(found, "an arrival: nothing stands in the way"))
        }
        Ended::StillDriving if is_blind_to_paths(subject)? => {
            Err(Trouble::not_applicable("it wanders: its steering is the same for every path"))
        }
        Ended::StillDriving => {
            let found = format!("{left_m:.2} m from the end after {:.0} s", STEP_S * N_STEPS as f64);
            Err(Trouble::broken(found, "an arrival"))
        }
    }
}

/// What it steers does not depend on the path.
fn is_blind_to_paths(subject: &Subject) -> Result<bool, Trouble> {
    let mut to_the_goal = Loop::new(subject)?;
    let mut elsewhere = Loop::new(subject)?;
    let positions = [elsewhere.world.start.translation.vector.into(), Point2::new(1.0, 5.0)];
    elsewhere.path = Path::through(positions, 0.0);
    Ok(twists(&mut to_the_goal, 100)? == twists(&mut elsewhere, 100)?)
}

/// What it steers while it drives.
fn twists(steered: &mut Loop, n_steps: usize) -> Result<Vec<Twist>, Trouble> {
    let mut twists = Vec::new();
    steered.drive(n_steps, |_, steering| {
        if let Steering::Drive(twist) = steering {
            twists.push(*twist);
        }
        Ok(())
    })?;
    Ok(twists)
}

fn keeps_the_limits(subject: &Subject) -> Verdict {
    const SLACK: f64 = 1e-9;
    let mut steered = Loop::new(subject)?;
    let robot = steered.robot().clone();
    let (mut fastest_m_s, mut fastest_turn_deg_s) = (0f64, 0f64);
    steered.drive(600, |moment, steering| {
        let Steering::Drive(twist) = steering else { return Ok(()) };
        let found = || format!("{twist:?} after {:.1} s", moment.now.as_secs());
        expect(twist.is_finite(), found, "finite numbers")?;
        let (speed_m_s, turn_deg_s) = (twist.speed_m_s(), twist.turn_rad_s.abs().to_degrees());
        fastest_m_s = fastest_m_s.max(speed_m_s);
        fastest_turn_deg_s = fastest_turn_deg_s.max(turn_deg_s);
        let is_slow = speed_m_s <= robot.max_speed_m_s + SLACK && turn_deg_s <= robot.max_turn_deg_s + SLACK;
        let limits = format!("at most {} m/s and {} degrees/s", robot.max_speed_m_s, robot.max_turn_deg_s);
        expect(is_slow, found, limits)?;
        let feasible = robot.drive.feasible(*twist);
        let is_feasible = (feasible.left_m_s - twist.left_m_s).abs() <= SLACK
            && (feasible.turn_rad_s - twist.turn_rad_s).abs() <= SLACK;
        expect(is_feasible, found, format!("what a {} drive can do", robot.drive.kind().name()))
    })?;
    Ok(format!("up to {fastest_m_s:.2} m/s and {fastest_turn_deg_s:.0} degrees/s"))
}

fn touches_nothing(subject: &Subject) -> Verdict {
    let mut steered = Loop::new(subject)?;
    // Something on the way that the map does not show.
    steered.world = steered.world.with_disc(Point2::new(3.6, 2.9), 0.2);
    let scene = steered.world.clone();
    let (hull_m, mut least_m) = (steered.robot().hull().outer_radius_m(), f64::INFINITY);
    let end = steered.drive(600, |moment, _| {
        let at: Point2 = moment.map_from_base.translation.vector.into();
        least_m = least_m.min(scene.clearance_m(at) - hull_m);
        let found = || format!("contact at ({:.2}, {:.2}) m", at.x, at.y);
        expect(least_m > 0.0, found, "a stop, or a way around")
    })?;
    let what = match end.what {
        Ended::Blocked => "stopped",
        Ended::Arrived => "went around",
        Ended::StillDriving => "was still on its way",
    };
    Ok(format!("it {what}, {least_m:.2} m at the least"))
}

fn deterministic(subject: &Subject) -> Verdict {
    let first = twists(&mut Loop::new(subject)?, 600)?;
    let second = twists(&mut Loop::new(subject)?, 600)?;
    let differs = first.iter().zip(&second).position(|(a, b)| a != b);
    let differs = differs.or_else(|| (first.len() != second.len()).then(|| first.len().min(second.len())));
    let found = || format!("step {} differs", differs.unwrap_or_default());
    expect(differs.is_none(), found, "the same steering")?;
    Ok(format!("{} steps", first.len()))
}

fn symmetric(subject: &Subject) -> Verdict {
    const M_S: f64 = 1e-3;
    let rad_s = 0.1f64.to_radians();
    let mut straight = Loop::new(subject)?;
    let mut answers: Vec<(Moment, Steering)> = Vec::new();
    straight.drive(300, |moment, steering| {
        answers.push((moment.clone(), steering.clone()));
        Ok(())
    })?;
    let height_m = straight.world.height_m();
    let (mut worst_m_s, mut worst_rad_s) = (0f64, 0f64);
    for turn in Turn::BOTH {
        let mut turned = straight.turned(subject, turn)?;
        for (moment, steering) in &answers {
            let same = Moment {
                map_from_base: turn.pose(&moment.map_from_base, height_m),
                odom_from_base: turn.own_pose(&moment.odom_from_base),
                twist: turn.twist(moment.twist),
                seen: moment.seen.iter().map(|observation| turn.observation(observation)).collect(),
                ..moment.clone()
            };
            let answer = turned.steer(&same);
            let off = match (steering, &answer) {
                (Steering::Drive(as_is), Ok(Steering::Drive(other))) => {
                    let wanted = turn.twist(*as_is);
                    let (ahead, left) =
                        (other.forward_m_s - wanted.forward_m_s, other.left_m_s - wanted.left_m_s);
                    [ahead.hypot(left), (other.turn_rad_s - wanted.turn_rad_s).abs()]
                }
                (Steering::Arrived, Ok(Steering::Arrived)) => [0.0; 2],
                (Steering::Blocked { .. }, Ok(Steering::Blocked { .. })) => [0.0; 2],
                _ => [f64::INFINITY; 2],
            };
            (worst_m_s, worst_rad_s) = (worst_m_s.max(off[0]), worst_rad_s.max(off[1]));
            let found = || {
                let after_s = moment.now.as_secs();
                format!("after {after_s:.1} s {steering:?} as it is, {answer:?} {}", turn.name())
            };
            expect(
                off[0] <= M_S && off[1] <= rad_s,
                found,
                "the same, left and right swapped in the mirror",
            )?;
        }
    }
    let worst_deg_s = worst_rad_s.to_degrees();
    Ok(format!("at most {:.4} mm/s and {worst_deg_s:.5} degrees/s", worst_m_s * 1e3))
}

fn wanders(subject: &Subject) -> Verdict {
    let mut steered = Loop::new(subject)?;
    steered.path = None;
    let moment = steered.moment(0, steered.world.start, Twist::ZERO);
    match steered.steer(&moment) {
        Ok(Steering::Drive(twist)) if twist.is_finite() => Ok(String::new()),
        other => Err(Trouble::broken(format!("{other:?}"), "a twist, or standing still")),
    }
}

fn finite_memory(subject: &Subject) -> Verdict {
    let mut steered = Loop::new(subject)?;
    let mut pose = steered.world.start;
    // Looking around is slow: a few hundred moments are shown again and again, with times that go on.
    let moments: Vec<Moment> = (0..200)
        .map(|k| {
            let twist = Twist::new(0.1, 0.1);
            let moment = steered.moment(k, pose, twist);
            pose *= twist.integrate(STEP_S);
            moment
        })
        .collect();
    let mut moments = moments.iter().cycle();
    stays_finite(|k| {
        if let Some(moment) = moments.next() {
            let now = super::drive::step_time(k);
            let mut moment = moment.clone();
            moment.now = now;
            moment.seen.iter_mut().for_each(|observation| observation.stamp = now);
            // What it answers is judged by other laws.
            let _ = steered.steer(&moment);
        }
        Ok(())
    })
}
