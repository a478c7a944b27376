//! Laws of sensors: what they read is sound, of its time, and the same from every side.

use super::drive::TWIST;
use super::law::{Law, Trouble, Verdict, expect};
use super::memory::stays_finite;
use super::odd_world::{Odd, OddWorld};
use super::props::N_RECORDED;
use super::sensor_readings::{
    DRIVE_S, Watch, bearing_as_is, built_world, drive_readings, standing_ranges, text_of,
};
use super::subject::Subject;
use super::turn::Turn;
use rumbo_core::frames::wrap_angle;
use rumbo_core::messages::{Check, Observation, ObservationKind, Observations, Seen};
use rumbo_core::registry::{Registry, Stage};
use rumbo_core::stages::{Advance, Cx, Sensor, SensorError, WorldError};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;

/// What every sensor keeps.
pub const LAWS: &[Law] = &[
    Law::new("it reads, and its messages pass their own check", reads_sound_messages),
    Law::new("it makes what it declares, and nothing of the future", makes_what_it_declares),
    Law::new("the same seed gives the same readings", deterministic).within("to the bit"),
    Law::new("a world turned or mirrored gives the ranges of the same walls", symmetric)
        .within("medians of 41 readings: 95 % of the beams within 5 cm and 2 %"),
    Law::new("a recording is passed on as it is", passes_a_recording_on),
    Law::new("it survives a world that answers nonsense, and goes on", survives_odd_worlds),
    Law::new("one that derives nothing says so", derives_or_says_so),
    Law::new("10,000 calls use finite memory", finite_memory).within("64 MiB").long(),
];

fn reads_sound_messages(subject: &Subject) -> Verdict {
    let readings = drive_readings(subject)?;
    expect(!readings.is_empty(), || format!("nothing in {DRIVE_S} s"), "at least one reading")?;
    for observation in &readings {
        check("a drive", observation)?;
    }
    Ok(format!("{} readings", readings.len()))
}

fn check(what: &str, observation: &Observation) -> Result<(), Trouble> {
    let checked = observation.check();
    checked.map_err(|fault| Trouble::broken(format!("{what}: {fault}"), "a message that passes its check"))
}

fn makes_what_it_declares(subject: &Subject) -> Verdict {
    let produces = subject.manifest().produces;
    let end = Time::from_secs(DRIVE_S);
    for observation in drive_readings(subject)? {
        let kind = observation.data.kind();
        let found = || format!("an observation of the kind {}", kind.name());
        expect(produces.contains(&kind), found, "only kinds that its manifest names")?;
        let found = || format!("a stamp of {:.3} s", observation.stamp.as_secs());
        expect(observation.stamp <= end, found, format!("at most {DRIVE_S} s, when the drive was over"))?;
    }
    Ok(produces.iter().map(|kind| kind.name()).collect::<Vec<_>>().join(", "))
}

fn deterministic(subject: &Subject) -> Verdict {
    let texts = |readings: Vec<Observation>| readings.iter().map(text_of).collect::<Vec<String>>();
    let (one, other) = (texts(drive_readings(subject)?), texts(drive_readings(subject)?));
    let differs = one.iter().zip(&other).position(|(a, b)| a != b);
    let is_same = differs.is_none() && one.len() == other.len();
    let found = || format!("reading {} differs", differs.unwrap_or(one.len().min(other.len())));
    expect(is_same, found, "the same readings")?;
    Ok(format!("{} readings", one.len()))
}

fn symmetric(subject: &Subject) -> Verdict {
    const WITHIN_M: f64 = 0.05;
    const WITHIN_SHARE: f64 = 0.02;
    const MOST_OFF: f64 = 0.05;
    let Some(as_is) = standing_ranges(subject, Turn::None)? else {
        return Err(Trouble::not_applicable("it measures no ranges, and only ranges are compared here"));
    };
    let mut worst = 0f64;
    for turn in Turn::BOTH {
        let turned = standing_ranges(subject, turn)?.unwrap_or_default();
        let (mut n_compared, mut n_off) = (0, 0);
        for (bearing, range) in &turned {
            let wanted = bearing_as_is(turn, *bearing);
            let same = as_is.iter().find(|(known, _)| wrap_angle(known - wanted).abs() < 1e-4);
            // In the mirror a fan that is not symmetric has beams without a twin.
            let Some((_, expected)) = same else { continue };
            n_compared += 1;
            let is_near = (range - expected).abs() <= WITHIN_M + WITHIN_SHARE * expected;
            let is_same = is_near || (!range.is_finite() && !expected.is_finite());
            n_off += usize::from(!is_same);
        }
        if n_compared == 0 {
            continue;
        }
        let share = n_off as f64 / n_compared as f64;
        worst = worst.max(share);
        let found = || format!("{n_off} of {n_compared} beams are off, {}", turn.name());
        expect(share <= MOST_OFF, found, format!("at most {} %", MOST_OFF * 100.0))?;
    }
    Ok(format!("at most {:.1} % of the beams are off", worst * 100.0))
}

fn passes_a_recording_on(subject: &Subject) -> Verdict {
    if subject.manifest().is_virtual {
        return Err(Trouble::not_applicable("it derives its readings from recorded ones, and plays none"));
    }
    let name = match subject.manifest().produces.as_slice() {
        [ObservationKind::LaserScan] => "laser scans",
        [ObservationKind::Odometry] => "readings of the odometer",
        _ => {
            let why = "the made-up recording has laser scans and odometry only";
            return Err(Trouble::not_applicable(why));
        }
    };
    let none = |why: String| Trouble::not_applicable(format!("there is no recording: {why}"));
    let registry = Registry::linked().map_err(|error| none(error.to_string()))?;
    let log = registry.get(Stage::World, "log").ok_or_else(|| none("no world `log`".into()))?;
    let file = subject.props.recording().ok_or_else(|| none("it cannot be written".into()))?;
    let keys = toml::Table::from_iter([("file".to_owned(), file.to_string_lossy().into_owned().into())]);
    let mut world = built_world(log, keys, subject).map_err(none)?;
    let mut sensor: Box<dyn Sensor> = subject.build()?;
    let (trace, mut out) = (Trace::unwatched(), Observations::default());
    while let Some(due) = world.next_recorded()
        && let Ok(Advance::Reached(now)) = world.advance(due)
    {
        let polled = sensor.poll(&mut Cx { now, trace: &trace }, world.as_mut(), &mut out);
        polled.map_err(|error| match error {
            SensorError::World(WorldError::Unsupported { probe }) => Trouble::not_applicable(format!(
                "it wants {probe}, which the made-up recording does not have"
            )),
            error => Trouble::broken(error.to_string(), "what is recorded"),
        })?;
    }
    let mut last = None;
    for observation in out.iter() {
        check("a recording", observation)?;
        let found = || format!("{:.3} s after a later one", observation.stamp.as_secs());
        expect(last.replace(observation.stamp) <= Some(observation.stamp), found, "stamps in order")?;
    }
    let n_read = out.iter().count();
    let found = || format!("{n_read} {name}");
    expect(n_read == N_RECORDED, found, format!("all {N_RECORDED} of the recording"))?;
    Ok(format!("{n_read} {name}"))
}

fn survives_odd_worlds(subject: &Subject) -> Verdict {
    if subject.manifest().is_virtual {
        return Err(Trouble::not_applicable("it does not ask the world"));
    }
    for (what, odd) in Odd::ALL {
        let mut sensor: Box<dyn Sensor> = subject.build()?;
        let (mut world, trace, mut out) = (OddWorld::new(odd), Trace::unwatched(), Observations::default());
        for k in 0..5 {
            let mut cx = Cx { now: super::drive::step_time(k), trace: &trace };
            // Any error is fine here, and so is a message that is sound.
            let _ = sensor.poll(&mut cx, &mut world, &mut out);
        }
        for observation in out.iter() {
            check(what, observation)?;
        }
        Watch::with(subject, sensor)?.goes_on(what)?;
    }
    Ok(format!("{} kinds of nonsense", Odd::ALL.len()))
}

fn derives_or_says_so(subject: &Subject) -> Verdict {
    let mut sensor: Box<dyn Sensor> = subject.build()?;
    let (trace, mut out) = (Trace::unwatched(), Observations::default());
    let derived = sensor.derive(&mut Cx { now: Time::ZERO, trace: &trace }, Seen::NOTHING, &mut out);
    if subject.manifest().is_virtual {
        let found = || "it is virtual and says that it derives nothing".into();
        expect(derived != Err(SensorError::NotVirtual), found, "readings, or another error")?;
        return Ok("virtual".into());
    }
    let found = || format!("{derived:?}");
    expect(derived == Err(SensorError::NotVirtual), found, "SensorError::NotVirtual")?;
    Ok(String::new())
}

fn finite_memory(subject: &Subject) -> Verdict {
    let mut watch = Watch::new(subject, Turn::None)?;
    stays_finite(|k| {
        // In circles, so that the robot never reaches a wall.
        let twist = rumbo_core::frames::Twist { turn_rad_s: 1.0, ..TWIST };
        let read = watch.read(k, twist);
        watch.recycle();
        read
    })
}
