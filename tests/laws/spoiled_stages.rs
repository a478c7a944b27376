//! Localizers, avoiders, sensors, map builders, worlds and SLAM plugins that break a law, and a SLAM plugin that keeps
//! all of them.

use super::doubles::{Double, build, manifest};
use super::*;
use rumbo_core::frames::{Pose2, Twist};
use rumbo_core::map::{Grid, Layer, Map};
use rumbo_core::messages::*;
use rumbo_core::registry::{Built, Manifest};
use rumbo_core::stages::*;
use rumbo_core::time::{Span, Time};

struct SpoiledLocalizer {
    inner: Box<dyn Localizer>,
    spoil: fn(&mut Estimate),
}

impl Localizer for SpoiledLocalizer {
    fn start(&mut self, prior: &Prior, map: &Map) -> Result<(), LocalizeError> {
        self.inner.start(prior, map)
    }

    fn update(&mut self, cx: &mut Cx<'_>, seen: Seen<'_>, map: &Map) -> Result<Estimate, LocalizeError> {
        let mut estimate = self.inner.update(cx, seen, map)?;
        (self.spoil)(&mut estimate);
        Ok(estimate)
    }
}

fn localizer(context: &BuildContext, spoil: fn(&mut Estimate)) -> Built {
    let inner = build(Stage::Localizer, "odometry", context);
    Built::Localizer(Box::new(SpoiledLocalizer { inner, spoil }))
}

#[test]
fn a_covariance_that_is_none_is_told() {
    let law = "covariances are symmetric and positive semi-definite";
    let lopsided =
        Double::entry(Stage::Localizer, "lopsided", manifest(Stage::Localizer, "odometry"), |context| {
            localizer(context, |estimate| estimate.covariance[(0, 1)] += 1e-3)
        });
    let report = report(lopsided);
    assert!(broken(&report).contains(&law), "{}", told(report.broken()));
    assert!(told(report.broken()).contains("a symmetric covariance"));
    let indefinite =
        Double::entry(Stage::Localizer, "indefinite", manifest(Stage::Localizer, "odometry"), |context| {
            localizer(context, |estimate| {
                estimate.covariance[(0, 1)] += 1.0;
                estimate.covariance[(1, 0)] += 1.0;
            })
        });
    let report = super::report(indefinite);
    assert!(broken(&report).contains(&law), "{}", told(report.broken()));
    assert!(told(report.broken()).contains("no negative eigenvalue"));
}

#[test]
fn an_estimate_of_the_future_and_one_that_does_not_turn_with_the_world_are_told() {
    let prophet =
        Double::entry(Stage::Localizer, "prophet", manifest(Stage::Localizer, "odometry"), |context| {
            localizer(context, |estimate| estimate.stamp = estimate.stamp + Span::from_secs(1.0))
        });
    let report = report(prophet);
    let law = "every number of an estimate is finite, and none is of the future";
    assert!(broken(&report).contains(&law), "{}", told(report.broken()));
    let leaning =
        Double::entry(Stage::Localizer, "leaning", manifest(Stage::Localizer, "odometry"), |context| {
            localizer(context, |estimate| estimate.map_from_base.translation.y += 0.1)
        });
    breaks(leaning, &["a world turned or mirrored turns the estimate with it"]);
}

struct SpoiledAvoider(Box<dyn Avoider>, fn(&mut Twist));

impl Avoider for SpoiledAvoider {
    fn steer(&mut self, cx: &mut Cx<'_>, input: &AvoidInput<'_>) -> Result<Steering, AvoidError> {
        let mut steering = self.0.steer(cx, input)?;
        if let Steering::Drive(twist) = &mut steering {
            (self.1)(twist);
        }
        Ok(steering)
    }
}

#[test]
fn an_avoider_that_turns_the_same_way_in_the_mirror_is_told() {
    let one_sided =
        Double::entry(Stage::Avoider, "one_sided", manifest(Stage::Avoider, "stop_and_replan"), |context| {
            let inner = build(Stage::Avoider, "stop_and_replan", context);
            Built::Avoider(Box::new(SpoiledAvoider(inner, |twist| twist.turn_rad_s = twist.turn_rad_s.abs())))
        });
    let report = report(one_sided);
    let law = "a world turned or mirrored turns the steering with it";
    assert!(broken(&report).contains(&law), "{}", told(report.broken()));
}

/// Drives ahead, whatever there is.
struct Blind;

impl Avoider for Blind {
    fn steer(&mut self, _: &mut Cx<'_>, _: &AvoidInput<'_>) -> Result<Steering, AvoidError> {
        Ok(Steering::Drive(Twist { forward_m_s: 0.6, left_m_s: 0.1, turn_rad_s: 0.0 }))
    }
}

#[test]
fn an_avoider_that_drives_into_walls_faster_than_it_may_is_told() {
    let blind =
        Double::entry(Stage::Avoider, "blind", Manifest::default(), |_| Built::Avoider(Box::new(Blind)));
    let report = report(blind);
    let laws = broken(&report);
    for law in [
        "it steers finite twists that the drive can do, no faster than the robot may",
        "the robot does not touch what its scanner sees",
        "a world turned or mirrored turns the steering with it",
    ] {
        assert!(laws.contains(&law), "{law}: {}", told(report.broken()));
    }
    let arrives = report.findings.iter().find(|finding| finding.law.contains("to the end of the path"));
    assert!(matches!(&arrives.unwrap().outcome, Outcome::NotApplicable { why } if why.contains("wanders")));
}

struct LateSensor(Box<dyn Sensor>);

impl Sensor for LateSensor {
    fn poll(
        &mut self,
        cx: &mut Cx<'_>,
        world: &mut dyn World,
        out: &mut Observations,
    ) -> Result<(), SensorError> {
        let mut later = Cx { now: cx.now + Span::from_secs(60.0), trace: cx.trace };
        self.0.poll(&mut later, world, out)
    }
}

#[test]
fn a_sensor_that_reads_the_future_is_told() {
    let late = Double::entry(Stage::Sensor, "late", manifest(Stage::Sensor, "laser_2d"), |context| {
        Built::Sensor(Box::new(LateSensor(build(Stage::Sensor, "laser_2d", context))))
    });
    breaks(late, &["it makes what it declares, and nothing of the future"]);
}

struct SpoiledBuilder(Box<dyn MapBuilder>);

impl MapBuilder for SpoiledBuilder {
    fn start(&mut self, map: &mut Map) -> Result<(), MapError> {
        self.0.start(map)
    }

    fn insert(&mut self, cx: &mut Cx<'_>, input: &MapInput<'_>, map: &mut Map) -> Result<(), MapError> {
        let version = map.version;
        self.0.insert(cx, input, map)?;
        map.version = version;
        map.landmarks = None;
        Ok(())
    }
}

#[test]
fn a_map_builder_that_counts_no_versions_and_drops_other_layers_is_told() {
    let careless = Double::entry(
        Stage::MapBuilder,
        "careless",
        manifest(Stage::MapBuilder, "occupancy_grid"),
        |context| {
            Built::MapBuilder(Box::new(SpoiledBuilder(build(Stage::MapBuilder, "occupancy_grid", context))))
        },
    );
    breaks(careless, &["it leaves other layers alone", "the map's version goes up with every change"]);
}

/// Each time that it is asked it has more to remember.
struct Restless(Box<dyn MapBuilder>, std::cell::Cell<u8>);

impl MapBuilder for Restless {
    fn start(&mut self, map: &mut Map) -> Result<(), MapError> {
        self.0.start(map)
    }

    fn insert(&mut self, cx: &mut Cx<'_>, input: &MapInput<'_>, map: &mut Map) -> Result<(), MapError> {
        self.0.insert(cx, input, map)
    }

    fn save(&self, _: &mut Map) -> Result<Option<Vec<u8>>, MapError> {
        self.1.set(self.1.get() + 1);
        Ok(Some(vec![self.1.get()]))
    }
}

#[test]
fn a_map_builder_that_changes_when_it_is_asked_to_save_is_told() {
    let manifest = manifest(Stage::MapBuilder, "lasting_changes");
    let restless = Double::entry(Stage::MapBuilder, "restless", manifest, |context| {
        let inner = build(Stage::MapBuilder, "lasting_changes", context);
        Built::MapBuilder(Box::new(Restless(inner, Default::default())))
    });
    breaks(restless, &["it saves the same twice, and goes on as if nobody had asked"]);
}

/// Time stands still.
struct Frozen;

impl World for Frozen {
    fn now(&self) -> Time {
        Time::ZERO
    }

    fn advance(&mut self, to: Time) -> Result<Advance, WorldError> {
        Ok(Advance::Reached(to))
    }

    fn drive(&mut self, _: &Command) -> Result<Drove, WorldError> {
        Ok(Drove::Drove)
    }

    fn probe<'w>(&'w mut self, _: &Probe<'_>) -> Result<Answer<'w>, WorldError> {
        Ok(Answer::Position([f64::NAN; 3]))
    }
}

#[test]
fn a_world_without_time_is_told() {
    let frozen =
        Double::entry(Stage::World, "frozen", Manifest::default(), |_| Built::World(Box::new(Frozen)));
    breaks(
        frozen,
        &[
            "time runs forward only",
            "commands that are not finite are refused",
            "answers and truth are finite, also after huge commands",
        ],
    );
}

/// Dead reckoning that marks where it was.
struct Breadcrumbs {
    localizer: Box<dyn Localizer>,
    is_careful: bool,
    poses: Vec<StampedPose>,
}

impl Slam for Breadcrumbs {
    fn start(&mut self, prior: &Prior, map: &mut Map) -> Result<(), SlamError> {
        map.grid = Grid::unknown(240, 240, 0.05).ok();
        map.touch();
        self.localizer.start(prior, map).map_err(|error| SlamError::Other(error.to_string()))
    }

    fn update(&mut self, cx: &mut Cx<'_>, seen: Seen<'_>, map: &mut Map) -> Result<Estimate, SlamError> {
        let estimate = self.localizer.update(cx, seen, map);
        let estimate = estimate.map_err(|error| SlamError::Other(error.to_string()))?;
        let Pose2 { translation, .. } = estimate.pose2();
        if let Some(grid) = &mut map.grid {
            grid.occupy_disc(translation.vector.into(), 0.0);
        }
        if self.is_careful {
            map.touch();
        }
        let stamp = if self.is_careful { estimate.stamp } else { Time::ZERO };
        if seen.iter().next().is_some() {
            self.poses.push(StampedPose { stamp, map_from_base: estimate.map_from_base });
        }
        Ok(estimate)
    }

    fn relocate(&mut self, prior: &Prior, map: &mut Map) -> Result<(), SlamError> {
        if !self.is_careful {
            return self.start(prior, map);
        }
        self.poses.clear();
        self.localizer.start(prior, map).map_err(|error| SlamError::Other(error.to_string()))
    }

    fn trajectory(&self) -> Result<Vec<StampedPose>, SlamError> {
        Ok(self.poses.clone())
    }
}

fn slam(is_careful: bool, name: &str) -> Entry {
    let manifest = Manifest {
        gives_layers: vec![Layer::Grid],
        consumes: vec![vec![ObservationKind::Odometry]],
        ..Manifest::default()
    };
    let make: doubles::Make =
        if is_careful { |context| breadcrumbs(context, true) } else { |context| breadcrumbs(context, false) };
    Double::entry(Stage::Slam, name, manifest, make)
}

fn breadcrumbs(context: &BuildContext, is_careful: bool) -> Built {
    let localizer = build(Stage::Localizer, "odometry", context);
    Built::Slam(Box::new(Breadcrumbs { localizer, is_careful, poses: Vec::new() }))
}

#[test]
fn a_simple_slam_plugin_keeps_the_laws_and_a_careless_one_does_not() {
    breaks(slam(true, "breadcrumbs"), &[]);
    breaks(
        slam(false, "careless"),
        &[
            "it gives the layers that it declares",
            "its trajectory is finite, in order, and of moments at which it was given something",
            "told where the robot is, it keeps its map and goes on from there with another clock and odometer",
        ],
    );
}
