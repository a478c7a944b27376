//! Sensors of several rates, and stamps that are not exactly periodic (ML-A14).

use crate::line_filter::*;
use rumbo_core::time::{Span, Time};

const MS: i64 = 1_000_000;

/// How often each sensor is due from 0 to 60 s.
fn counts(schedule: &Schedule, n_sensors: usize) -> Vec<usize> {
    let mut counts = vec![0; n_sensors];
    let mut at = 0;
    while at <= 60_000 * MS {
        (0..n_sensors).filter(|sensor| schedule.is_due(*sensor, at)).for_each(|sensor| counts[sensor] += 1);
        at = schedule.next_ns(at);
    }
    counts
}

#[test]
fn the_base_period_is_the_greatest_common_divisor_and_counts_are_exact() {
    let schedule = Schedule::new(&[50 * MS, 50 * MS, 500 * MS]).unwrap();
    assert_eq!((schedule.base_ns(), schedule.step_ns()), (50 * MS, Some(50 * MS)));
    assert_eq!(counts(&schedule, 3), [1201, 1201, 121]);
    let schedule = Schedule::new(&[40 * MS, 60 * MS, 500 * MS]).unwrap();
    assert_eq!(schedule.base_ns(), 20 * MS);
    assert_eq!(counts(&schedule, 3), [1501, 1001, 121]);
    let schedule = Schedule::new(&[50 * MS, 33_300_000]).unwrap();
    assert_eq!((schedule.base_ns(), schedule.step_ns()), (100_000, None), "from one instant to the next");
    assert_eq!(counts(&schedule, 2), [1201, 1802]);
    assert_eq!(schedule.next_ns(0), 33_300_000);
    assert_eq!(Schedule::new(&[50 * MS, 0]), Err(ScheduleFault { found_ns: 0 }));
    assert!(Schedule::new(&[]).is_err() && Schedule::new(&[-1]).is_err());
}

fn at(ms: f64) -> Time {
    Time((ms * MS as f64) as i64)
}

const LATE: Span = Span(50 * MS);

#[test]
fn without_periods_the_state_goes_to_each_stamp() {
    let mut clock = Clock::new(LATE);
    assert_eq!(clock.admit(Source::Laser, at(1000.0)), Instant::Slightly, "the first reading is the present");
    let Instant::Ahead(Steps { n: 1, seconds: step_s }) = clock.admit(Source::Wheels, at(1047.5)) else {
        panic!()
    };
    assert!((step_s - 0.0475).abs() < 1e-12);
    assert_eq!(clock.admit(Source::Wheels, at(1047.5)), Instant::Slightly);
    assert_eq!(clock.admit(Source::Laser, at(1047.5 - 50.0)), Instant::Slightly, "a base period old");
    assert_eq!(clock.admit(Source::Laser, at(1047.5 - 50.1)), Instant::Late);
    assert_eq!(clock.now(), Some(at(1047.5)), "late readings do not turn the clock back");
}

#[test]
fn with_periods_steps_are_base_periods_and_each_period_has_one_reading() {
    let periods = [50 * MS, 50 * MS, 500 * MS];
    let mut clock = Clock::scheduled(LATE, Schedule::new(&periods).unwrap(), periods);
    assert_eq!(clock.admit(Source::Wheels, at(0.0)), Instant::Slightly);
    assert_eq!(clock.admit(Source::Wheels, at(20.0)), Instant::NotDue);
    // A hair early and a hair late belong to their period, and are one step.
    let Instant::Ahead(Steps { n: 1, .. }) = clock.admit(Source::Wheels, at(49.5)) else { panic!() };
    let Instant::Ahead(Steps { n: 1, seconds: step_s }) = clock.admit(Source::Wheels, at(100.4)) else {
        panic!()
    };
    assert!((step_s - 0.0509).abs() < 1e-9);
    // Wheels that were silent for half a second: ten predictions.
    let Instant::Ahead(Steps { n: 10, seconds: step_s }) = clock.admit(Source::Laser, at(600.4)) else {
        panic!()
    };
    assert!((step_s - 0.05).abs() < 1e-9);
}

#[test]
fn at_a_single_rate_every_sensor_is_read_as_often_as_the_laser() {
    let periods = [500 * MS; 3];
    let mut clock = Clock::scheduled(LATE, Schedule::new(&periods).unwrap(), periods);
    let mut taken = [0; 2];
    for k in 0..=120 {
        let admitted = |instant| usize::from(!matches!(instant, Instant::NotDue | Instant::Late));
        taken[0] += admitted(clock.admit(Source::Wheels, at(50.0 * f64::from(k))));
        if k % 10 == 0 {
            taken[1] += admitted(clock.admit(Source::Laser, at(50.0 * f64::from(k))));
        }
    }
    assert_eq!(taken, [13, 13]);
}

#[test]
fn a_resumed_clock_does_not_read_a_period_twice() {
    let periods = [50 * MS, 50 * MS, 500 * MS];
    let mut clock = Clock::scheduled(LATE, Schedule::new(&periods).unwrap(), periods);
    clock.resume(at(0.0), Some(at(1000.0)));
    assert_eq!(clock.admit(Source::Laser, at(1000.0)), Instant::NotDue);
    assert!(matches!(clock.admit(Source::Laser, at(1500.0)), Instant::Ahead(Steps { n: 10, .. })));
}
