use rumbo_core::registry::Plugin;
use rumbo_core::stages::BuildContext;

use super::*;
use crate::sim::SimParams;

/// An endless plain with a robot on it.
fn base() -> EmulatedBase {
    let world: Box<dyn World> = SimParams::default().build(&BuildContext::bare("world")).unwrap();
    EmulatedBase::new(&EmulateParams::default(), &Robot::default(), Arc::new(Scene::new(world)))
}

/// Says something at a time, and hears all that came until then.
fn tell(base: &mut EmulatedBase, seconds: f64, line: Option<ToBase>) -> Vec<FromBase> {
    let now = Time::from_secs(seconds);
    if let Some(line) = line {
        base.receive(now, None, &encode(7, &line.to_string()));
    }
    let mut bytes = Vec::new();
    base.transmit(now, None, &mut bytes);
    let mut decoder = Decoder::default();
    let frames = bytes.iter().filter_map(|byte| decoder.push(*byte));
    frames.map(|frame| FromBase::parse(&frame.text).unwrap()).collect()
}

fn speed_m_s(base: &EmulatedBase, seconds: f64) -> f64 {
    base.scene.at(Time::from_secs(seconds), wheels_of).twist.forward_m_s
}

const FORWARD: ToBase = ToBase::Drive(Twist { forward_m_s: 0.3, left_m_s: 0.0, turn_rad_s: 0.0 });

#[test]
fn a_hello_is_answered_by_who_is_there_and_nothing_is_said_before() {
    let mut base = base();
    assert_eq!(tell(&mut base, 0.1, None), []);
    let wrong = tell(&mut base, 0.2, Some(ToBase::Hello { version: 2 }));
    assert_eq!(wrong, [FromBase::No { version: 1 }]);
    assert_eq!(tell(&mut base, 0.3, Some(FORWARD)), [], "who did not say hello is not obeyed");
    assert_eq!(speed_m_s(&base, 1.0), 0.0);
    let answers = tell(&mut base, 1.0, Some(ToBase::Hello { version: 1 }));
    assert!(
        matches!(&answers[..3], [FromBase::Base(who), FromBase::Sonars(ring), FromBase::Bumpers(_)]
            if who.track_m == 0.36 && ring.n_sonars == 16),
        "{answers:?}"
    );
    assert_eq!(tell(&mut base, 1.5, Some(ToBase::Bye))[0], FromBase::Bye);
    assert_eq!(tell(&mut base, 2.0, None), []);
}

/// The command is 0.5 s old at 1.5 s.
#[test]
fn without_commands_the_base_stops_by_itself() {
    let mut base = base();
    tell(&mut base, 0.0, Some(ToBase::Hello { version: 1 }));
    tell(&mut base, 1.0, Some(FORWARD));
    tell(&mut base, 1.49, None);
    assert!(speed_m_s(&base, 1.49) > 0.2);
    let said = tell(&mut base, 1.51, None);
    assert!(!said.is_empty());
    let at_first_m_s = speed_m_s(&base, 1.51);
    assert!(speed_m_s(&base, 1.52) < at_first_m_s, "it brakes at once");
    assert_eq!(speed_m_s(&base, 2.5), 0.0);
    let told = tell(&mut base, 2.6, None);
    assert!(
        told.iter().any(|line| matches!(line, FromBase::State(status) if status.is_watchdog)),
        "{told:?}"
    );
    // A new command ends that.
    let told = tell(&mut base, 2.8, Some(FORWARD));
    let state =
        told.iter().find_map(|line| if let FromBase::State(status) = line { Some(*status) } else { None });
    assert_eq!(state.map(|status| (status.is_watchdog, status.last_command)), Some((false, 7)));
    tell(&mut base, 2.9, Some(FORWARD));
    assert!(speed_m_s(&base, 2.95) > 0.0);
}

#[test]
fn a_host_that_is_gone_is_talked_to_no_longer() {
    let mut base = base();
    tell(&mut base, 0.0, Some(ToBase::Hello { version: 1 }));
    tell(&mut base, 1.0, Some(FORWARD));
    assert!(!tell(&mut base, 2.9, None).is_empty());
    tell(&mut base, 3.1, None);
    assert_eq!(tell(&mut base, 4.0, None), []);
}

#[test]
fn the_emergency_stop_holds_until_it_is_released() {
    let mut base = base();
    tell(&mut base, 0.0, Some(ToBase::Hello { version: 1 }));
    base.press_emergency(Time::from_secs(0.1), true);
    let told = tell(&mut base, 0.3, Some(FORWARD));
    assert!(told.iter().any(|line| matches!(line, FromBase::State(status) if status.is_emergency)));
    assert_eq!(speed_m_s(&base, 0.6), 0.0);
    base.press_emergency(Time::from_secs(0.7), false);
    tell(&mut base, 0.8, Some(FORWARD));
    assert!(speed_m_s(&base, 1.0) > 0.0);
}

/// Reports in ten seconds: 50, 20, 10 and 5 a second.
#[test]
fn reports_come_at_their_rates() {
    let mut base = base();
    tell(&mut base, 0.0, Some(ToBase::Hello { version: 1 }));
    let mut counts = [0i32; 4];
    for k in 1..=2500 {
        let command = (k % 25 == 0).then_some(ToBase::Drive(Twist::ZERO));
        for line in tell(&mut base, f64::from(k) * 0.004, command) {
            match line {
                FromBase::Wheels(_) => counts[0] += 1,
                FromBase::Touch { .. } => counts[1] += 1,
                FromBase::Ranges { readings, .. } => {
                    assert_eq!(readings, [SonarReading::Nothing; 16]);
                    counts[2] += 1;
                }
                FromBase::State(_) => counts[3] += 1,
                other => panic!("{other:?}"),
            }
        }
    }
    for (found, expected) in counts.into_iter().zip([500, 200, 100, 50]) {
        assert!((found - expected).abs() <= 1, "{counts:?}");
    }
}
