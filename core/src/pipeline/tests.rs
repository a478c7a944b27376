use super::*;
use crate::map::{Grid, Layer, Map};
use crate::messages::{Command, Estimate, Observations, Path, Prior, Seen};
use crate::registry::{Manifest, Params, Plugin, Registry};
use crate::stages::*;
use crate::time::Time;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::Path as FilePath;

/// One stage of every kind, which does nothing.
struct Idle(Time);

impl World for Idle {
    fn now(&self) -> Time {
        self.0
    }
    fn advance(&mut self, to: Time) -> Result<Advance, WorldError> {
        self.0 = to;
        Ok(Advance::Reached(to))
    }
    fn drive(&mut self, _: &Command) -> Result<Drove, WorldError> {
        Ok(Drove::Drove)
    }
    fn probe<'w>(&'w mut self, _: &Probe<'_>) -> Result<Answer<'w>, WorldError> {
        Ok(Answer::Live)
    }
}

impl Sensor for Idle {
    fn poll(&mut self, _: &mut Cx<'_>, _: &mut dyn World, _: &mut Observations) -> Result<(), SensorError> {
        Ok(())
    }
}

impl MapBuilder for Idle {
    fn start(&mut self, map: &mut Map) -> Result<(), MapError> {
        let mut grid = Grid::unknown(10, 10, 1.0)?;
        grid.cells.make_mut()[..50].fill(-4.0);
        map.grid = Some(grid);
        Ok(())
    }
    fn insert(&mut self, _: &mut Cx<'_>, _: &MapInput<'_>, _: &mut Map) -> Result<(), MapError> {
        Ok(())
    }
}

impl Localizer for Idle {
    fn start(&mut self, _: &Prior, _: &Map) -> Result<(), LocalizeError> {
        Ok(())
    }
    fn update(&mut self, cx: &mut Cx<'_>, _: Seen<'_>, _: &Map) -> Result<Estimate, LocalizeError> {
        Ok(Estimate::lost(cx.now))
    }
}

impl Slam for Idle {
    fn start(&mut self, _: &Prior, _: &mut Map) -> Result<(), SlamError> {
        Ok(())
    }
    fn update(&mut self, cx: &mut Cx<'_>, _: Seen<'_>, _: &mut Map) -> Result<Estimate, SlamError> {
        Ok(Estimate::lost(cx.now))
    }
}

impl Planner for Idle {
    fn plan(&mut self, _: &PlanRequest) -> Result<Path, PlanError> {
        Err(PlanError::GivenUp)
    }
}

impl Avoider for Idle {
    fn steer(&mut self, _: &mut Cx<'_>, _: &AvoidInput<'_>) -> Result<Steering, AvoidError> {
        Ok(Steering::Arrived)
    }
}

macro_rules! doubles {
    ($($register:ident $seam:ident $name:literal $params:ident { $($field:ident: $value:expr),* };)*) => { $(
        /// A double.
        #[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
        #[serde(default, deny_unknown_fields)]
        struct $params {
            /// At least zero.
            size_m: f64,
            /// Refuses to be built.
            broken: bool,
        }
        impl Default for $params {
            fn default() -> Self {
                $params { size_m: 0.5, broken: false }
            }
        }
        impl Params for $params {
            fn check(&self) -> Vec<BuildError> {
                let fault = BuildError::at("size_m", format!("is {}, expected at least 0", self.size_m));
                if self.size_m < 0.0 { vec![fault] } else { Vec::new() }
            }
        }
        impl Plugin<dyn $seam> for $params {
            fn manifest(&self) -> Manifest {
                #[allow(clippy::needless_update)]
                Manifest { $($field: $value,)* ..Manifest::default() }
            }
            fn build(&self, _: &BuildContext) -> Result<Box<dyn $seam>, BuildError> {
                if self.broken {
                    return Err(BuildError::at("broken", "is broken").help("mend it"));
                }
                Ok(Box::new(Idle(Time::ZERO)))
            }
        }
        crate::$register!($params, $name, "a double");
    )* };
}

use crate::messages::ObservationKind as Kind;
use crate::robot::DriveKind;
doubles! {
    register_world World "here" Here {};
    register_sensor Sensor "laser" Laser { produces: vec![Kind::LaserScan], max_rate_hz: Some(37.5) };
    register_sensor Sensor "encoders" Encoders { produces: vec![Kind::Odometry] };
    register_sensor Sensor "camera" Camera { produces: vec![Kind::DepthImage] };
    register_sensor Sensor "depth_to_scan" DepthToScan {
        consumes: vec![vec![Kind::DepthImage]], produces: vec![Kind::LaserScan], is_virtual: true };
    register_sensor Sensor "smoother" Smoother {
        consumes: vec![vec![Kind::LaserScan]], produces: vec![Kind::LaserScan], is_virtual: true };
    register_map_builder MapBuilder "grid_map" GridMap { gives_layers: vec![Layer::Grid] };
    register_map_builder MapBuilder "line_map" LineMap {
        needs_layers: vec![Layer::Grid], gives_layers: vec![Layer::Lines] };
    register_map_builder MapBuilder "overlay" Overlay {
        needs_layers: vec![Layer::Grid], gives_layers: vec![Layer::Grid], overlays: true };
    register_localizer Localizer "dead" Dead { consumes: vec![vec![Kind::Odometry]] };
    register_localizer Localizer "walls" Walls {
        needs_layers: vec![Layer::Lines], consumes: vec![vec![Kind::LaserScan, Kind::RangeRing]] };
    register_localizer Localizer "scans" Scans { consumes: vec![vec![Kind::LaserScan]] };
    register_slam Slam "both" Both { gives_layers: vec![Layer::Grid] };
    register_planner Planner "way" Way { needs_layers: vec![Layer::Grid] };
    register_avoider Avoider "push" Push { drives: vec![DriveKind::Differential, DriveKind::Omnidirectional] };
}

const GOOD: &str = "
[world]
plugin = 'here'
[[sensor]]
name = 'front'
plugin = 'laser'
rate_hz = 10
mount = { x_m = 1.0, yaw_deg = 90 }
[[sensor]]
name = 'wheels'
plugin = 'encoders'
[map_builder]
plugin = 'grid_map'
[localizer]
plugin = 'dead'
[planner]
plugin = 'way'
size_m = 2
[avoider]
plugin = 'push'
rate_hz = 20
[mission]
waypoints = [{ x_m = 1.5, y_m = 1.5 }]
[[test]]
name = 'arrives'
expect = { arrives_within_s = 10, reason = 'arrived' }
";

fn load(text: &str, sets: &[&str]) -> Loaded {
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    let registry = Registry::linked().unwrap();
    let mut loaded = Loaded::from_text(FilePath::new("p.toml"), text, &sets, &registry);
    loaded.check();
    loaded
}

/// The faults of the good pipeline after a change.
fn faults(find: &str, replace: &str) -> Vec<String> {
    assert!(GOOD.contains(find), "{find}");
    load(&GOOD.replacen(find, replace, 1), &[]).lines()
}

#[test]
fn a_good_file_is_a_pipeline_that_an_engine_is_built_from() {
    let loaded = load(GOOD, &[]);
    assert_eq!(loaded.lines(), Vec::<String>::new());
    let pipeline = loaded.sound().unwrap();
    assert_eq!((pipeline.name.as_str(), pipeline.seed), ("p", 0));
    assert_eq!(pipeline.sensors[0].stage.rate, Some(Rate::Hz(10.0)));
    let tip = pipeline.sensors[0].base_from_sensor * crate::frames::Point3::new(1.0, 0.0, 0.0);
    assert!((tip - crate::frames::Point3::new(1.0, 1.0, 0.0)).norm() < 1e-12);
    assert_eq!(pipeline.planner.as_ref().unwrap().configured.parameters()["size_m"].as_float(), Some(2.0));
    assert_eq!(pipeline.tests[0].expect.arrives_within_s, Some(10.0));
    assert!(crate::engine::Engine::build(pipeline).is_ok());
}

#[test]
fn faults_of_all_sections_come_at_once_and_in_the_order_of_the_file() {
    let text = GOOD
        .replace("rate_hz = 10", "rate_hz = 100")
        .replace("'encoders'", "'encodres'")
        .replace("size_m = 2", "size = 2\nsize_m = -1")
        .replace("rate_hz = 20", "rate_hz = 0.5")
        .replace("y_m = 1.5", "y = nan");
    assert_eq!(
        load(&text, &["seed=x", "planer.x=1"]).lines(),
        [
            "p.toml:7:11 sensor.front.rate_hz: asks for 100 a second, but the device gives at most 37.5",
            "p.toml:11:10 sensor.wheels.plugin: no sensor is called `encodres`, did you mean encoders?",
            "p.toml:18:1 planner.size: unknown key, units are in the key: size_m",
            "p.toml:19:10 planner.size_m: is -1, expected at least 0",
            "p.toml:22:11 avoider.rate_hz: makes 0.500 commands a second, expected at least 1",
            "p.toml:24:14 mission.waypoints[0].y_m: is missing, expected a number",
            "p.toml:24:27 mission.waypoints[0].y: unknown key, units are in the key: y_m",
            "p.toml:24:31 mission.waypoints[0].y: is NaN, expected a finite number",
            "--set seed=x:1:6 seed: is \"x\", expected a whole number",
            "--set planer.x=1:1:1 planer: unknown key, did you mean planner?",
        ]
    );
}

#[test]
fn missing_layers_and_observations_name_who_could_give_them() {
    assert_eq!(
        faults("[map_builder]\nplugin = 'grid_map'", ""),
        ["p.toml:16:10 planner: needs the map layer grid, which nothing in this pipeline gives; \
          [map_builder] could be grid_map"]
    );
    assert_eq!(
        faults("[[sensor]]\nname = 'wheels'\nplugin = 'encoders'", ""),
        ["p.toml:13:10 localizer: needs odometry, which no sensor makes; a [[sensor]] could be encoders"]
    );
    let later = "[[map_builder]]\nplugin = 'line_map'\n[[map_builder]]\nplugin = 'grid_map'";
    assert_eq!(
        faults("[map_builder]\nplugin = 'grid_map'", later),
        [
            "p.toml:13:10 map_builder[0]: needs the map layer grid, which a later map builder gives; put that first"
        ]
    );
}

#[test]
fn a_seat_has_one_owner() {
    let second = "plugin = 'encoders'\n[[sensor]]\nname = 'more'\nplugin = 'encoders'";
    let said = faults("plugin = 'encoders'", second);
    assert_eq!(said.len(), 1);
    assert!(said[0].contains("sensor.more: says where the base went, and so does sensor.wheels"), "{said:?}");
    let fused = format!("{second}\n[odometer]\nplugin = 'dead'");
    assert_eq!(faults("plugin = 'encoders'", &fused), Vec::<String>::new());
    let said = faults("[localizer]", "[slam]\nplugin = 'both'\n[localizer]");
    assert_eq!(said.len(), 2, "{said:#?}");
    assert!(said.iter().any(|line| line.contains("localizer: the plugin in [slam] finds the robot too")));
    assert!(
        said.iter().any(|line| line.contains("map_builder: writes the map layer grid, and so does slam"))
    );
    let overlay = "[[map_builder]]\nplugin = 'grid_map'\n[[map_builder]]\nplugin = 'overlay'";
    assert_eq!(faults("[map_builder]\nplugin = 'grid_map'", overlay), Vec::<String>::new());
    let twice = "[[map_builder]]\nplugin = 'grid_map'\n[[map_builder]]\nplugin = 'grid_map'\nname = 'b'";
    assert!(faults("[map_builder]\nplugin = 'grid_map'", twice)[0].contains("only one may"));
}

#[test]
fn the_odometer_is_where_others_get_odometry_from() {
    let without_wheels = GOOD.replacen("[[sensor]]\nname = 'wheels'\nplugin = 'encoders'", "", 1);
    assert!(load(&without_wheels, &[]).lines()[0].contains("localizer: needs odometry"));
    assert_eq!(load(&without_wheels, &["odometer.plugin=scans"]).lines(), Vec::<String>::new());
}

#[test]
fn a_stage_whose_section_is_wrong_is_not_built() {
    let said = faults("size_m = 2", "size_m = -2\nbroken = true");
    assert_eq!(said, ["p.toml:18:10 planner.size_m: is -2, expected at least 0"]);
}

#[test]
fn virtual_sensors_come_after_their_inputs_and_never_in_a_circle() {
    let chain = "[[sensor]]\nname = 's'\nplugin = 'smoother'\ninputs = ['d']\n\
        [[sensor]]\nname = 'd'\nplugin = 'depth_to_scan'\ninputs = ['c']\n\
        [[sensor]]\nname = 'c'\nplugin = 'camera'\n[[sensor]]\nname = 'front'";
    let loaded = load(&GOOD.replacen("[[sensor]]\nname = 'front'", chain, 1), &[]);
    assert_eq!(loaded.lines(), Vec::<String>::new());
    let sensors = &loaded.pipeline.as_ref().unwrap().sensors;
    let names: Vec<&str> = sensors.iter().map(|sensor| sensor.stage.name.as_str()).collect();
    assert_eq!(names, ["c", "d", "s", "front", "wheels"]);
    assert_eq!((&sensors[1].inputs, &sensors[2].inputs), (&vec![0], &vec![1]));
    let circle = chain.replace("'depth_to_scan'\ninputs = ['c']", "'smoother'\ninputs = ['s']");
    let said = faults("[[sensor]]\nname = 'front'", &circle);
    assert_eq!(said, ["p.toml:7:10 sensor.s.inputs: derives from itself in a circle: s <- d <- s"]);
    let itself =
        "[[sensor]]\nname = 's'\nplugin = 'smoother'\ninputs = ['s', 'frnt']\n[[sensor]]\nname = 'front'";
    let said = faults("[[sensor]]\nname = 'front'", itself);
    assert_eq!(
        said,
        [
            "p.toml:7:11 sensor.s.inputs[0]: a sensor cannot derive from itself",
            "p.toml:7:16 sensor.s.inputs[1]: no sensor is called `frnt`, did you mean front?",
        ]
    );
    let none = "[[sensor]]\nname = 's'\nplugin = 'smoother'\n[[sensor]]\nname = 'front'\ninputs = ['s']";
    let said = faults("[[sensor]]\nname = 'front'", none);
    assert!(said[0].contains("sensor.s: derives its observations from other sensors"), "{said:?}");
    assert!(said[1].contains("sensor.front.inputs: this plugin reads the world"), "{said:?}");
    let wrong =
        "[[sensor]]\nname = 's'\nplugin = 'depth_to_scan'\ninputs = ['front']\n[[sensor]]\nname = 'front'";
    assert!(
        faults("[[sensor]]\nname = 'front'", wrong)[0]
            .contains("needs depth_image, which none of its inputs")
    );
}

#[test]
fn a_sensor_may_sit_on_another_but_not_in_a_circle() {
    let on = "plugin = 'encoders'\nmount = { frame = 'front', x_m = 2.0 }";
    let loaded = load(&GOOD.replacen("plugin = 'encoders'", on, 1), &[]);
    let pose = loaded.sound().unwrap().sensors[1].base_from_sensor;
    let expected = nalgebra::Vector3::new(1.0, 2.0, 0.0);
    assert!((pose.translation.vector - expected).norm() < 1e-12, "turned with the sensor that it sits on");
    let said = faults("plugin = 'encoders'", "plugin = 'encoders'\nmount = { frame = 'mast' }");
    assert_eq!(
        said,
        [
            "p.toml:12:19 sensor.wheels.mount.frame: no frame is called `mast`, expected base_link or the name of a sensor"
        ]
    );
    let circle =
        GOOD.replacen("x_m = 1.0, yaw", "frame = 'wheels', yaw", 1).replacen("plugin = 'encoders'", on, 1);
    assert!(load(&circle, &[]).lines()[0].contains("sit on one another in a circle"));
}

#[test]
fn a_drive_that_a_plugin_cannot_steer_is_refused() {
    let tricycle = "[robot]\ndrive = { kind = 'tricycle', wheelbase_m = 1.0, track_m = 0.5, max_steer_deg = 60, \
        max_steer_rate_deg_s = 90 }\n[avoider]";
    let said = faults("[avoider]", tricycle);
    assert_eq!(said.len(), 1, "{said:#?}");
    assert!(said[0].contains("avoider: cannot steer the drive tricycle of [robot], only differential, omni"));
}

#[test]
fn parts_that_cannot_be_missing_are_named() {
    let said = load("", &[]).lines();
    assert_eq!(said.len(), 2, "{said:#?}");
    assert!(said[0].starts_with("the pipeline has no [localizer] and no [slam]"), "{said:#?}");
    assert!(said[1].starts_with("the pipeline has no [world]"), "{said:#?}");
    let said = faults("[avoider]\nplugin = 'push'\nrate_hz = 20", "");
    assert!(said[0].contains("mission.waypoints: the robot has somewhere to go, but without [avoider]"));
    let said = faults("[planner]", "[planner_fallback]");
    assert!(said[0].contains("planner_fallback: is asked when [planner] has no answer"), "{said:?}");
    let said = faults("waypoints = [{ x_m = 1.5, y_m = 1.5 }]", "");
    assert!(
        said[0].contains("test[0].expect.arrives_within_s: expects the robot to arrive, but"),
        "{said:?}"
    );
}

#[test]
fn what_a_plugin_says_when_it_is_built_comes_with_its_place_for_all_plugins_at_once() {
    let text = GOOD
        .replace("plugin = 'way'", "plugin = 'way'\nbroken = true")
        .replace("plugin = 'grid_map'", "plugin = 'grid_map'\nbroken = true")
        .replace("plugin = 'laser'", "plugin = 'laser'\nbroken = true");
    assert_eq!(
        load(&text, &[]).lines(),
        [
            "p.toml:7:10 sensor.front.broken: is broken; mend it",
            "p.toml:15:10 map_builder.broken: is broken; mend it",
            "p.toml:20:10 planner.broken: is broken; mend it",
        ]
    );
}

#[test]
fn goals_on_walls_and_off_the_map_are_refused_before_anything_moves() {
    let goals = "x_m = 1.5, y_m = 7.5 }, { x_m = 30.0, y_m = 1.5";
    let said = faults("x_m = 1.5, y_m = 1.5", goals);
    assert_eq!(said.len(), 2, "{said:#?}");
    assert!(said[0].starts_with("p.toml:23:14 mission.waypoints[0]: (1.50, 7.50) m is unknown"), "{said:#?}");
    assert!(
        said[1].starts_with("p.toml:23:40 mission.waypoints[1]: (30.00, 1.50) m lies outside"),
        "{said:#?}"
    );
}

#[test]
fn a_swap_takes_the_keys_of_its_variant_and_every_variant_is_checked() {
    let variants = "plugin = 'dead'\nsize_m = 1\n[localizer.variants.walls]\nsize_m = 7\n\
        [localizer.variants.dead]\nbroken = false\nsize_m = 3";
    let text = GOOD.replacen("plugin = 'dead'", variants, 1);
    let size = |loaded: &Loaded| {
        loaded.pipeline.as_ref().unwrap().localizer.as_ref().unwrap().configured.parameters()["size_m"]
            .as_float()
    };
    let loaded = load(&text, &[]);
    assert_eq!((loaded.lines().len(), size(&loaded)), (0, Some(1.0)), "the section wins over its variant");
    let loaded = load(&text, &["localizer.plugin=walls"]);
    assert_eq!(size(&loaded), Some(7.0));
    assert!(loaded.lines()[0].contains("localizer: needs the map layer lines"), "{:?}", loaded.lines());
    let said = faults("plugin = 'dead'", "plugin = 'dead'\n[localizer.variants.walls]\nsize = 7");
    assert_eq!(
        said,
        ["p.toml:17:1 localizer.variants.walls.size: unknown key, units are in the key: size_m"]
    );
    let said = faults("plugin = 'dead'", "plugin = 'dead'\n[localizer.variants.laser]\nsize_m = 7");
    assert!(said[0].contains("`laser` is for [sensor], not for [localizer]"), "{said:?}");
}

#[test]
fn shapes_of_sections_are_checked() {
    let cases = [
        ("[world]", "[[world]]", "world: is a list"),
        ("[[test]]", "[test]", "test: is one table, expected a list: write [[test]]"),
        ("name = 'wheels'\n", "", "sensor[1].name: is missing"),
        ("name = 'wheels'", "name = 'front'", "two parts are called \"front\""),
        ("name = 'wheels'", "name = 'planner'", "which is the name of a section"),
        ("plugin = 'dead'", "", "localizer.plugin: is missing, expected one of dead, scans, walls"),
        ("plugin = 'dead'", "plugin = 5", "localizer.plugin: is 5, expected text in quotes"),
        ("plugin = 'dead'", "plugin = 'dead'\nmount = {}", "localizer.mount: means nothing in [localizer]"),
        ("rate_hz = 20", "rate_hz = 20\nevery_s = 0.1", "avoider.every_s: says again what rate_hz says"),
        ("rate_hz = 20", "rate_hz = 0", "avoider.rate_hz: is 0, expected above 0"),
        ("reason = 'arrived'", "reason = 'arived'", "test[0].expect.reason: is \"arived\", which is no end"),
        ("[mission]", "[mission]\narrival_radius_m = 0", "mission.arrival_radius_m: is 0, expected above 0"),
        ("[world]", "schema = 9\n[world]", "schema: is 9, this program reads pipeline files of version 1"),
        (
            "[world]",
            "[robot]\nradius_m = -1\n[world]",
            "robot.radius_m: is -1, expected a finite number above",
        ),
    ];
    for (find, replace, expected) in cases.into_iter() {
        let said = faults(find, replace);
        assert!(said.iter().any(|line| line.contains(expected)), "{expected}: {said:#?}");
    }
}

#[test]
fn the_effective_file_names_every_default_and_reads_back_as_the_same_pipeline() {
    let text = GOOD.replacen("plugin = 'dead'", "plugin = 'dead'\nvariants.dead.size_m = 3", 1);
    let loaded = load(&text, &["planner.size_m=4"]);
    let printed = crate::document::to_commented_toml(&loaded.effective(), &loaded.document.sources);
    for line in [
        "size_m = 4 # --set",
        "broken = false # default",
        "drive.kind = \"differential\" # default",
        "size_m = 3 # p.toml:16",
        "arrival_radius_m = 0.1 # default",
    ] {
        assert!(printed.contains(line), "{line}\n{printed}");
    }
    let again = load(&printed, &[]);
    assert_eq!(again.lines(), Vec::<String>::new(), "{printed}");
    let values = |loaded: &Loaded| loaded.effective().as_table().unwrap().to_toml();
    assert_eq!(values(&again), values(&loaded));
}

#[test]
fn the_schema_accepts_what_the_loader_accepts_and_refuses_what_it_refuses() {
    let registry = Registry::linked().unwrap();
    let schema = schema(&registry);
    let check = |text: &str| crate::document::schema_faults(&schema, text);
    assert_eq!(check(GOOD), Vec::<String>::new());
    let wrong = GOOD.replace("size_m = 2", "size = 2").replace("x_m = 1.0", "x_m = 'a'");
    let said = check(&wrong);
    assert!(said.iter().any(|line| line.contains("planner.size: unknown key")), "{said:?}");
    assert!(said.iter().any(|line| line.contains("mount.x_m: is \"a\"")), "{said:?}");
    let text = schema.to_string();
    assert!(
        text.contains("At least zero.") && text.contains("\"default\":0.5"),
        "documentation and defaults"
    );
}
