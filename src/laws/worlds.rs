//! Laws of worlds: time goes forward, commands and probes are answered or refused.

use super::drive::{STEP_S, TWIST, step_time};
use super::law::{Law, Trouble, Verdict, expect};
use super::memory::stays_finite;
use super::subject::Subject;
use rumbo_core::frames::{Pose3, Twist, is_finite3};
use rumbo_core::messages::Command;
use rumbo_core::stages::{Advance, Answer, Probe, World, WorldError};
use rumbo_core::time::Time;

/// What every world keeps.
pub const LAWS: &[Law] = &[
    Law::new("time runs forward only", runs_forward),
    Law::new("commands that are not finite are refused", refuses_bad_commands),
    Law::new("a probe is answered, or said to be unsupported", answers_probes),
    Law::new(
        "probes of nothing, of nonsense and of too much give an error or an answer",
        survives_odd_probes,
    ),
    Law::new("answers and truth are finite, also after huge commands", stays_finite_itself),
    Law::new("the same commands give the same world", deterministic).within("to the bit, with the same seed"),
    Law::new("10,000 calls use finite memory", finite_memory).within("64 MiB").long(),
];

/// A world that passes by itself answers as its devices do.
fn built(subject: &Subject) -> Result<Box<dyn World>, Trouble> {
    let world: Box<dyn World> = subject.build()?;
    if world.is_real_time() {
        return Err(Trouble::not_applicable("its time is that of the wall"));
    }
    Ok(world)
}

fn fails(what: &str, error: &WorldError) -> Trouble {
    Trouble::broken(format!("{what}: {error}"), "an answer")
}

fn runs_forward(subject: &Subject) -> Verdict {
    let mut world = built(subject)?;
    let second = Time::from_secs(1.0);
    let advanced = world.advance(second);
    let is_there = advanced == Ok(Advance::Reached(second)) && world.now() == second;
    expect(is_there, || format!("{advanced:?} at {} s", world.now().as_secs()), "1 s, as asked")?;
    let again = world.advance(second);
    let is_same = again == Ok(Advance::Reached(second));
    expect(is_same, || format!("asked for the time it is: {again:?}"), "no change")?;
    let back = world.advance(Time::from_secs(0.5));
    let is_refused = matches!(back, Err(WorldError::Backwards { .. }));
    expect(is_refused, || format!("asked to go back: {back:?}"), "WorldError::Backwards")?;
    Ok(String::new())
}

fn refuses_bad_commands(subject: &Subject) -> Verdict {
    let mut world = built(subject)?;
    for (forward_m_s, turn_rad_s) in [(f64::NAN, 0.0), (0.0, f64::INFINITY)] {
        let command = Command { stamp: world.now(), twist: Twist::new(forward_m_s, turn_rad_s) };
        let drove = world.drive(&command);
        let found = || format!("{forward_m_s} m/s and {turn_rad_s} rad/s: {drove:?}");
        expect(drove == Err(WorldError::NotFinite), found, "WorldError::NotFinite")?;
    }
    Ok(String::new())
}

fn beams(mount: &Pose3, first_bearing_rad: f64, n_beams: usize, max_range_m: f64) -> Probe<'_> {
    Probe::Beams { base_from_sensor: mount, first_bearing_rad, bearing_step_rad: 0.01, n_beams, max_range_m }
}

fn answers_probes(subject: &Subject) -> Verdict {
    let mut world = built(subject)?;
    let mount = Pose3::identity();
    let marks = Probe::Marks { base_from_sensor: &mount, field_of_view_rad: 3.0, max_range_m: 8.0 };
    let mut given = Vec::new();
    for probe in [
        beams(&mount, -1.0, 200, 8.0),
        Probe::Wheels,
        Probe::Attitude,
        Probe::Position,
        Probe::Contacts,
        marks,
        Probe::Person { name: "nobody is called this" },
        Probe::Channel { name: "no sensor is called this" },
    ] {
        match world.probe(&probe) {
            Ok(_) => given.push(probe.name()),
            Err(WorldError::Unsupported { .. }) => {}
            Err(error) => return Err(fails(probe.name(), &error)),
        }
    }
    Ok(if given.is_empty() { "it has nothing of these".into() } else { given.join(", ") })
}

fn survives_odd_probes(subject: &Subject) -> Verdict {
    let mut world = built(subject)?;
    let mount = Pose3::identity();
    let nowhere = Pose3::translation(f64::NAN, 0.0, 0.0);
    let probes = [
        ("no beams", beams(&mount, -1.0, 0, 8.0)),
        ("beams without reach", beams(&mount, -1.0, 10, 0.0)),
        ("beams of a reach of NaN", beams(&mount, -1.0, 10, f64::NAN)),
        ("beams of an endless reach", beams(&mount, -1.0, 10, f64::INFINITY)),
        ("beams to NaN", beams(&mount, f64::NAN, 10, 8.0)),
        ("beams from nowhere", beams(&nowhere, -1.0, 10, 8.0)),
        ("2^40 beams", beams(&mount, -1.0, 1 << 40, 8.0)),
    ];
    for (what, probe) in &probes {
        if let Ok(Answer::Ranges(ranges)) = world.probe(probe) {
            let is_odd = |range: &&f32| **range < 0.0;
            let found = || format!("{what}: a negative range");
            expect(
                !ranges.iter().any(|range| is_odd(&range)),
                found,
                "an error, or ranges of at least zero",
            )?;
        }
    }
    Ok(format!("{} probes", probes.len()))
}

fn stays_finite_itself(subject: &Subject) -> Verdict {
    let mut world = built(subject)?;
    for (k, twist) in (1..).zip([TWIST, Twist::new(1e300, -1e300), Twist::new(-1e3, 1e3), Twist::ZERO]) {
        // A world may refuse what no robot can do.
        let _ = world.drive(&Command { stamp: world.now(), twist });
        let advanced = world.advance(step_time(k));
        advanced.map_err(|error| fails("advance", &error))?;
        if let Ok(Answer::Position(position)) = world.probe(&Probe::Position) {
            let found = || format!("a position of {position:?} after {twist:?}");
            expect(position.iter().all(|v| v.is_finite()), found, "finite numbers")?;
        }
        if let Ok(Answer::Wheels(wheels)) = world.probe(&Probe::Wheels) {
            let found = || format!("wheels that rolled {:?} m after {twist:?}", wheels.rolled_m);
            expect(wheels.rolled_m.iter().all(|v| v.is_finite()), found, "finite numbers")?;
        }
        if let Some(truth) = world.truth() {
            let found = || format!("a true pose at {} after {twist:?}", truth.map_from_base.translation);
            expect(is_finite3(&truth.map_from_base), found, "finite numbers")?;
        }
    }
    Ok(String::new())
}

fn deterministic(subject: &Subject) -> Verdict {
    let history = || -> Result<Vec<String>, Trouble> {
        let mut world = built(subject)?;
        let mut history = Vec::new();
        for k in 0..20 {
            world.advance(step_time(k)).map_err(|error| fails("advance", &error))?;
            let twist = TWIST.scaled(1.0 + k as f64 * STEP_S);
            world.drive(&Command { stamp: world.now(), twist }).map_err(|error| fails("drive", &error))?;
            let mount = Pose3::identity();
            for probe in [beams(&mount, -1.0, 20, 8.0), Probe::Wheels, Probe::Position] {
                history.push(format!("{:?}", world.probe(&probe)));
            }
            history.push(format!("{:?}", world.truth()));
        }
        Ok(history)
    };
    let (one, other) = (history()?, history()?);
    let differs = one.iter().zip(&other).find(|(a, b)| a != b);
    let found = || differs.map(|(a, b)| format!("{a} and {b}")).unwrap_or_default();
    expect(differs.is_none(), found, "the same answers")?;
    Ok(String::new())
}

fn finite_memory(subject: &Subject) -> Verdict {
    let mut world = built(subject)?;
    let mount = Pose3::identity();
    stays_finite(|k| {
        // At the end of a recording time stands still.
        let _ = world.advance(step_time(k));
        let _ = world.drive(&Command { stamp: world.now(), twist: TWIST });
        for probe in [beams(&mount, -1.0, 20, 8.0), Probe::Wheels] {
            let _ = world.probe(&probe);
        }
        let _ = world.take_notice();
        Ok(())
    })
}
