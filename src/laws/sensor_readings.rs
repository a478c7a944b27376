//! What a sensor says in the simulated hall.

use super::drive::{Drive, STEP_S, TWIST, step_time};
use super::law::Trouble;
use super::subject::Subject;
use super::text_world::TextWorld;
use super::turn::Turn;
use rumbo_core::frames::{Twist, pose2, wrap_angle};
use rumbo_core::messages::{Check, Command, Data, Observation, ObservationKind, Observations, Seen};
use rumbo_core::registry::{Built, Entry, Registry, Stage};
use rumbo_core::stages::{BuildContext, Cx, Sensor, SensorError, World, WorldError};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;
use std::sync::Arc;

/// A sensor and the world that it looks at.
pub struct Watch {
    sensor: Box<dyn Sensor>,
    /// The simulated hall.
    pub world: Box<dyn World>,
    /// What a virtual sensor gets.
    inputs: Option<Drive>,
    trace: Trace,
    out: Observations,
}

impl Watch {
    /// A new sensor in the hall seen from this side.
    pub fn new(subject: &Subject, turn: Turn) -> Result<Watch, Trouble> {
        Watch::of(subject, subject.build()?, turn)
    }

    /// A sensor that has seen other worlds before, in the hall as it is.
    pub fn with(subject: &Subject, sensor: Box<dyn Sensor>) -> Result<Watch, Trouble> {
        Watch::of(subject, sensor, Turn::None)
    }

    fn of(subject: &Subject, sensor: Box<dyn Sensor>, turn: Turn) -> Result<Watch, Trouble> {
        let is_virtual = subject.manifest().is_virtual;
        if is_virtual {
            subject.sees_enough()?;
        }
        Ok(Watch {
            sensor,
            world: hall(subject, turn)?,
            inputs: if is_virtual { Some(Drive::seen_from(turn)?) } else { None },
            trace: Trace::unwatched(),
            out: Observations::default(),
        })
    }

    /// Lets the robot move on like this, and reads at step `k`.
    pub fn read(&mut self, k: usize, twist: Twist) -> Result<(), Trouble> {
        let now = step_time(k);
        let moved = self.world.advance(now).and_then(|_| self.world.drive(&Command { stamp: now, twist }));
        moved.map_err(|error| Trouble::not_applicable(format!("the simulator says: {error}")))?;
        match self.poll(k, now) {
            Ok(()) => Ok(()),
            Err(SensorError::World(WorldError::Unsupported { probe })) => {
                let why = format!("it wants {probe}, which the simulator does not have");
                Err(Trouble::not_applicable(why))
            }
            Err(error) => Err(Trouble::broken(error.to_string(), "a reading")),
        }
    }

    fn poll(&mut self, k: usize, now: Time) -> Result<(), SensorError> {
        let mut cx = Cx { now, trace: &self.trace };
        match &self.inputs {
            None => self.sensor.poll(&mut cx, self.world.as_mut(), &mut self.out),
            Some(drive) => {
                let frame = drive.frames.iter().cycle().nth(k % drive.frames.len().max(1));
                let mut seen = frame.map(|frame| frame.seen.clone()).unwrap_or_default();
                seen.iter_mut().for_each(|observation| observation.stamp = now);
                self.sensor.derive(&mut cx, Seen::sorted(&seen), &mut self.out)
            }
        }
    }

    /// It reads sound messages again, whatever there was before.
    pub fn goes_on(&mut self, before: &str) -> Result<(), Trouble> {
        for k in 10..15 {
            match self.read(k, TWIST) {
                // The hall has nothing for it, so there is nothing to compare with.
                Err(Trouble::NotApplicable { .. }) => return Ok(()),
                read => read?,
            }
        }
        for observation in self.take() {
            observation.check().map_err(|fault| {
                let found = format!("after {before}: {fault}");
                Trouble::broken(found, "sound messages, once the world is fine again")
            })?;
        }
        Ok(())
    }

    /// Everything that was read so far.
    pub fn take(&mut self) -> Vec<Observation> {
        std::iter::from_fn(|| self.out.pop_front()).collect()
    }

    /// Gives the buffers of everything that was read back, as the engine does.
    pub fn recycle(&mut self) {
        while let Some(observation) = self.out.pop_front() {
            self.out.recycle(observation);
        }
    }
}

/// The simulator with the hall seen from this side.
fn hall(subject: &Subject, turn: Turn) -> Result<Box<dyn World>, Trouble> {
    let none = |why: String| Trouble::not_applicable(format!("there is no simulated hall: {why}"));
    let registry = Registry::linked().map_err(|error| none(error.to_string()))?;
    let sim = registry.get(Stage::World, "sim").ok_or_else(|| none("no world `sim`".into()))?;
    let map = subject.props.world(turn).ok_or_else(|| none("its map cannot be written".into()))?;
    let start = TextWorld::hall()?.turned(turn)?.start;
    let somebody = somebody_beside(start.translation.x, start.translation.y);
    let numbers = [
        ("x_m", start.translation.x),
        ("y_m", start.translation.y),
        ("yaw_deg", start.rotation.angle().to_degrees()),
    ];
    let start = toml::Table::from_iter(numbers.map(|(key, value)| (key.to_owned(), value.into())));
    let map = map.to_string_lossy().into_owned();
    let mut keys =
        toml::Table::from_iter([("map".to_owned(), map.into()), ("start".to_owned(), start.into())]);
    // Kinds of one's own may speak of people; for all others the hall stays as it is.
    if subject.manifest().produces.contains(&ObservationKind::Custom) {
        keys.insert("add".to_owned(), somebody.into());
    }
    built_world(sim, keys, subject).map_err(none)
}

/// Somebody of the usual name who walks to and fro two meters from here.
fn somebody_beside(x_m: f64, y_m: f64) -> toml::Table {
    let route = toml::Value::from(vec![vec![x_m + 2.0, y_m], vec![x_m + 2.0, y_m + 2.0]]);
    let person = toml::Table::from_iter([
        ("route".to_owned(), route),
        ("speed_m_s".to_owned(), toml::Value::from(0.5)),
    ]);
    toml::Table::from_iter([("person".to_owned(), toml::Value::from(vec![person]))])
}

/// A world of the registry, around this sensor's robot.
pub fn built_world(
    entry: &Arc<Entry>,
    keys: toml::Table,
    subject: &Subject,
) -> Result<Box<dyn World>, String> {
    let configured = entry.source.parse(keys).map_err(|fault| fault.message)?;
    let context = BuildContext { robot: Arc::new(subject.robot()), ..BuildContext::bare("world") };
    let built = configured.build(&context).map_err(|error| error.to_string())?;
    match built {
        Built::World(world) => Ok(world),
        _ => Err("it builds something else".into()),
    }
}

/// What a sensor reads on a short drive.
pub fn drive_readings(subject: &Subject) -> Result<Vec<Observation>, Trouble> {
    let mut watch = Watch::new(subject, Turn::None)?;
    for k in 0..20 {
        watch.read(k, TWIST)?;
    }
    Ok(watch.take())
}

/// Everything in an observation as text: all numbers to the last bit, and NaN is like itself.
pub fn text_of(observation: &Observation) -> String {
    let rows = match &observation.data {
        Data::LaserScan(scan) => format!("{:?} {:?}", &*scan.ranges_m, &*scan.intensities),
        Data::RangeRing(ring) => format!("{:?}", &*ring.ranges_m),
        Data::DepthImage(image) => format!("{:?}", &*image.depth),
        Data::PointCloud(cloud) => format!("{:?}", &*cloud.points_m),
        Data::Custom(custom) => format!("{custom:?}"),
        _ => String::new(),
    };
    format!("{observation:?} {rows}")
}

/// Ranges by bearing, of a robot that stands still: medians over some readings. None where the sensor does not measure
/// ranges.
pub fn standing_ranges(subject: &Subject, turn: Turn) -> Result<Option<Vec<(f64, f64)>>, Trouble> {
    const N_READINGS: usize = 41;
    let measures_ranges =
        |kind: &ObservationKind| matches!(kind, ObservationKind::LaserScan | ObservationKind::RangeRing);
    if !subject.manifest().produces.iter().any(measures_ranges) {
        return Ok(None);
    }
    let mut watch = Watch::new(subject, turn)?;
    let mut by_bearing: Vec<(f64, Vec<f64>)> = Vec::new();
    for k in 0..N_READINGS {
        watch.read(k, Twist::ZERO)?;
        for observation in watch.take() {
            let (first, step, ranges) = match &observation.data {
                Data::LaserScan(scan) => (scan.first_bearing_rad, scan.bearing_step_rad, &scan.ranges_m),
                Data::RangeRing(ring) => (ring.first_bearing_rad, ring.bearing_step_rad, &ring.ranges_m),
                _ => continue,
            };
            for (idx, range) in ranges.iter().enumerate() {
                let bearing = wrap_angle(first + step * idx as f64);
                let known = by_bearing.iter_mut().find(|(known, _)| wrap_angle(known - bearing).abs() < 1e-6);
                match known {
                    Some((_, all)) => all.push(f64::from(*range)),
                    None => by_bearing.push((bearing, vec![f64::from(*range)])),
                }
            }
        }
    }
    let medians = by_bearing.into_iter().map(|(bearing, mut all)| {
        all.sort_by(f64::total_cmp);
        (bearing, all.get(all.len() / 2).copied().unwrap_or(f64::NAN))
    });
    Ok(Some(medians.collect()))
}

/// Where the robot of a turned hall stands, the ranges of these bearings belong to those of the hall as it is.
pub fn bearing_as_is(turn: Turn, bearing_rad: f64) -> f64 {
    let own = turn.own_pose(&pose2(0.0, 0.0, bearing_rad));
    wrap_angle(own.rotation.angle())
}

/// Time that a short drive takes, seconds.
pub const DRIVE_S: f64 = 20.0 * STEP_S;
