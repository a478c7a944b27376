//! `--worlds 'GLOB'`: the places and the missions in them.

use super::draw::Rules;
use super::fingerprint::Fingerprint;
use super::free_space::FreeSpace;
use super::range::SetRange;
use super::study::{Scene, Study, parsed};
use rumbo_core::pipeline::{Expect, Mission};
use rumbo_kit::world_file::load_world;
use serde::Deserialize;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A place with its missions.
#[derive(Debug, Clone)]
pub struct Place {
    /// As tables call it.
    pub name: String,
    /// The world or map file; none for the pipeline's own.
    pub file: Option<PathBuf>,
    /// What to do there.
    pub missions: Missions,
    /// Of everything that is read from files.
    pub fingerprint: u64,
    /// What a study says of it.
    pub by_study: ByStudy,
}

/// What a study adds to a place.
#[derive(Debug, Clone, Default)]
pub struct ByStudy {
    /// What each seed draws.
    pub rules: Option<Rules>,
    /// As for `--set`.
    pub sets: Vec<String>,
    /// As for `--set-range`.
    pub ranges: Vec<SetRange>,
    /// What counts as success.
    pub expect: Option<Expect>,
}

/// Where missions come from.
#[derive(Debug, Clone)]
pub enum Missions {
    /// The pipeline's own.
    Own,
    /// The one in a file, as arguments of `--set`.
    Given(Vec<String>),
    /// So many for each seed.
    Drawn(Arc<FreeSpace>, u32),
}

impl Missions {
    /// How many for each seed.
    pub fn n_missions(&self) -> u32 {
        match self {
            Missions::Own | Missions::Given(_) => 1,
            Missions::Drawn(_, n) => *n,
        }
    }
}

impl Place {
    /// The pipeline's own world and mission.
    pub fn own() -> Place {
        Place {
            name: "its own".to_owned(),
            file: None,
            missions: Missions::Own,
            fingerprint: 0,
            by_study: ByStudy::default(),
        }
    }

    /// The pipeline's own world with drawn missions.
    pub fn own_world(file: &Path, radius_m: f64, n: u32) -> Result<Place, String> {
        let mut place = Place::of(file, radius_m, n)?;
        place.name = "its own".to_owned();
        place.file = None;
        Ok(place)
    }

    fn of(file: &Path, radius_m: f64, n_missions: u32) -> Result<Place, String> {
        let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let scene = load_world(file).map_err(|error| error.to_string())?;
        let mut print = Fingerprint::default();
        let maps = [scene.map.as_deref(), scene.robot_map.as_deref()];
        for path in std::iter::once(file).chain(maps.into_iter().flatten()) {
            print.file(path)?;
        }
        let beside = file.with_file_name(format!("{name}.mission.toml"));
        let missions = if beside.is_file() {
            print.file(&beside)?;
            Missions::Given(read_mission(&beside)?)
        } else {
            let space = FreeSpace::of(&scene, radius_m)
                .map_err(|message| format!("{}: {message}", file.display()))?;
            space.note(&mut print);
            Missions::Drawn(Arc::new(space), n_missions)
        };
        let file = std::path::absolute(file).map_err(|error| format!("{}: {error}", file.display()))?;
        let (file, fingerprint) = (Some(file), print.value());
        Ok(Place { name, file, missions, fingerprint, by_study: ByStudy::default() })
    }
}

/// The places as a study has them: each in every scene.
pub fn in_scenes(places: &[Place], study: &Study) -> Vec<Place> {
    let scenes: Vec<_> = match study.scene.as_slice() {
        [] => vec![None],
        scenes => scenes.iter().map(Some).collect(),
    };
    let in_scene = |(place, scene): (&Place, Option<&Scene>)| {
        let here = study.world.get(&place.name);
        let rules = study.rules(&place.name, scene);
        let sets =
            here.into_iter().flat_map(|here| &here.set).chain(scene.into_iter().flat_map(|it| &it.set));
        let by_study = ByStudy {
            rules: (rules != Rules::default()).then_some(rules),
            sets: sets.cloned().collect(),
            ranges: scene.into_iter().flat_map(|scene| parsed(&scene.set_range)).collect(),
            expect: scene.and_then(|scene| scene.success.clone()).or_else(|| study.success.clone()),
        };
        let name =
            scene.map_or_else(|| place.name.clone(), |scene| format!("{}: {}", place.name, scene.name));
        Place { name, by_study, ..place.clone() }
    };
    places.iter().flat_map(|place| scenes.iter().map(move |scene| (place, *scene))).map(in_scene).collect()
}

/// The worlds that match, sorted by their path.
pub fn find(patterns: &[String], radius_m: f64, n_missions: u32) -> Result<Vec<Place>, String> {
    let mut files = Vec::new();
    for pattern in patterns {
        let found = glob::glob(pattern).map_err(|error| format!("--worlds {pattern}: {error}"))?;
        let n_before = files.len();
        for path in found {
            let path = path.map_err(|error| format!("--worlds {pattern}: {error}"))?;
            if is_world(&path) {
                files.push(path);
            }
        }
        if files.len() == n_before {
            return Err(format!(
                "--worlds {pattern}: no world matches, expected .toml or .yaml files; put the pattern in quotes"
            ));
        }
    }
    files.sort();
    files.dedup();
    let mut places: Vec<Place> =
        files.iter().map(|file| Place::of(file, radius_m, n_missions)).collect::<Result<_, _>>()?;
    let names: Vec<String> = places.iter().map(|place| place.name.clone()).collect();
    for (place, file) in places.iter_mut().zip(&files) {
        if names.iter().filter(|name| **name == place.name).count() > 1 {
            place.name = file.display().to_string().replace('\\', "/");
        }
    }
    Ok(places)
}

fn is_world(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let is_named = [".toml", ".yaml", ".yml"].iter().any(|ending| name.ends_with(ending));
    is_named && !name.ends_with(".mission.toml") && path.is_file()
}

/// A mission beside a world: the keys of `[mission]`, and `[world] start`, as in a pipeline.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MissionFile {
    world: MissionStart,
    mission: toml::Table,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MissionStart {
    start: toml::Table,
}

/// Reads it, as arguments of `--set`.
fn read_mission(path: &Path) -> Result<Vec<String>, String> {
    let text = std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let trouble = |error: toml::de::Error| format!("{}: {error}", path.display());
    let file: MissionFile = toml::from_str(&text).map_err(trouble)?;
    let mission: Mission = file.mission.clone().try_into().map_err(trouble)?;
    if mission.waypoints.is_empty() {
        return Err(format!("{}: mission.waypoints is empty, expected at least one", path.display()));
    }
    let start = format!("world.start={}", toml::Value::Table(file.world.start));
    let keys = file.mission.iter().map(|(key, value)| format!("mission.{key}={value}"));
    Ok(std::iter::once(start).chain(keys).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mission_file_has_the_keys_of_a_pipeline_and_no_others() {
        let folder = std::env::temp_dir().join(format!("rumbo-mission-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("a.mission.toml");
        let read = |text: &str| {
            std::fs::write(&path, text).unwrap();
            read_mission(&path)
        };
        let good =
            "[world]\nstart = { x_m = 1.0, y_m = 2.0 }\n[mission]\nwaypoints = [{ x_m = 3.0, y_m = 4.0 }]\n";
        let sets = read(good).unwrap();
        assert_eq!(sets[0], "world.start={ x_m = 1.0, y_m = 2.0 }");
        assert_eq!(sets[1], "mission.waypoints=[{ x_m = 3.0, y_m = 4.0 }]");
        for (text, words) in [
            (good.replace("waypoints", "waypoint"), "unknown field `waypoint`"),
            (good.replace("start", "begin"), "unknown field `begin`"),
            (good.replace("{ x_m = 3.0, y_m = 4.0 }", ""), "is empty"),
            ("[mission]\n".to_owned(), "missing field `world`"),
        ] {
            let message = read(&text).unwrap_err();
            assert!(message.contains(words), "{message}");
        }
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
