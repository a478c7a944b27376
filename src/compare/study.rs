//! Study files: everything that `rumbo compare` would be told on the command line, and what each seed draws, in one file.

use super::draw::Rules;
use super::range::{self, SetRange};
use super::swap::{self, Swap};
use rumbo_core::pipeline::Expect;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A study, read from a file.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Study {
    /// What is studied, for the report.
    pub title: String,
    /// The pipeline that the alternatives are made of.
    pub pipeline: PathBuf,
    /// World or map files, as patterns.
    pub worlds: Vec<String>,
    /// Seeds for each alternative in each world.
    pub seeds: Option<u32>,
    /// Values for all alternatives, as for `--set`.
    pub set: Vec<String>,
    /// As for `--swap`.
    pub swap: Vec<String>,
    /// As for `--set-range`.
    pub set_range: Vec<String>,
    /// Alternatives with a name and any values.
    pub alternative: Vec<Named>,
    /// Situations in each world.
    pub scene: Vec<Scene>,
    /// What each seed draws.
    pub draw: Rules,
    /// The same for one world, over `draw`; with values as for `--set`.
    pub world: BTreeMap<String, InWorld>,
    /// What counts as success, in place of arriving.
    pub success: Option<Expect>,
    /// Figures and counters that are shown for each world by itself.
    pub show: Vec<String>,
}

/// An alternative with a name.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Named {
    /// As tables call it.
    pub name: String,
    /// As for `--set`.
    #[serde(default)]
    pub set: Vec<String>,
}

/// A situation.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// As tables call it.
    pub name: String,
    /// What each seed draws, over the study's.
    #[serde(default)]
    pub draw: Rules,
    /// As for `--set`.
    #[serde(default)]
    pub set: Vec<String>,
    /// As for `--set-range`.
    #[serde(default)]
    pub set_range: Vec<String>,
    /// What counts as success, in place of the study's.
    pub success: Option<Expect>,
}

/// What is special in one world.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct InWorld {
    /// What each seed draws, over the study's.
    pub draw: Rules,
    /// As for `--set`.
    pub set: Vec<String>,
}

impl Study {
    /// The study in a file; none where the file is a pipeline, which has no key `pipeline`.
    pub fn read(path: &Path) -> Result<Option<Study>, String> {
        // A file that cannot be read, or that is no TOML, is told by whoever reads it as a pipeline.
        let Ok(text) = std::fs::read_to_string(path) else { return Ok(None) };
        if !text.parse::<toml::Table>().is_ok_and(|table| table.contains_key("pipeline")) {
            return Ok(None);
        }
        let trouble = |message: String| format!("{}: {message}", path.display());
        let mut study: Study = toml::from_str(&text).map_err(|error| trouble(error.to_string()))?;
        let faults = study.faults();
        if !faults.is_empty() {
            return Err(trouble(faults.join("\n")));
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        study.pipeline = folder.join(&study.pipeline);
        for pattern in &mut study.worlds {
            *pattern = folder.join(&*pattern).display().to_string();
        }
        Ok(Some(study))
    }

    /// There is none: what a pipeline by itself gives.
    pub fn is_none(&self) -> bool {
        self.pipeline.as_os_str().is_empty()
    }

    fn faults(&self) -> Vec<String> {
        let of = |place: String, rules: &Rules| {
            let faults = rules.faults().into_iter();
            faults.map(move |(key, message)| format!("{place}draw.{key}: {message}")).collect::<Vec<_>>()
        };
        let scenes =
            self.scene.iter().flat_map(|scene| of(format!("scene \"{}\": ", scene.name), &scene.draw));
        let worlds = self.world.iter().flat_map(|(name, world)| of(format!("world.{name}."), &world.draw));
        let swaps = self.swap.iter().filter_map(|text| swap::parse(text).err());
        let of_scenes = self.scene.iter().flat_map(|scene| &scene.set_range);
        let ranges = self.set_range.iter().chain(of_scenes).filter_map(|text| range::parse(text).err());
        of(String::new(), &self.draw)
            .into_iter()
            .chain(scenes)
            .chain(worlds)
            .chain(swaps)
            .chain(ranges)
            .collect()
    }

    /// What its `swap` says.
    pub fn swaps(&self) -> impl Iterator<Item = Swap> {
        self.swap.iter().filter_map(|text| swap::parse(text).ok())
    }

    /// What its `set_range` says.
    pub fn ranges(&self) -> impl Iterator<Item = SetRange> {
        parsed(&self.set_range)
    }

    /// What is drawn in a world and a scene.
    pub fn rules(&self, world: &str, scene: Option<&Scene>) -> Rules {
        let here = self.world.get(world).map_or_else(|| self.draw.clone(), |of| self.draw.with(&of.draw));
        scene.map_or_else(|| here.clone(), |scene| here.with(&scene.draw))
    }
}

/// Ranges that were looked at when the file was read.
pub fn parsed(ranges: &[String]) -> impl Iterator<Item = SetRange> {
    ranges.iter().filter_map(|text| range::parse(text).ok())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::worlds::{find, in_scenes};

    #[test]
    fn every_shipped_study_is_read_and_finds_its_pipeline_and_worlds() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines/studies");
        let files: Vec<PathBuf> =
            std::fs::read_dir(folder).unwrap().map(|file| file.unwrap().path()).collect();
        assert!(files.len() >= 6);
        for file in files {
            let study = Study::read(&file).unwrap().unwrap();
            assert!(study.pipeline.is_file() && !study.title.is_empty(), "{}", file.display());
            let places = in_scenes(&find(&study.worlds, 0.2, 1).unwrap(), &study);
            assert!(places.len() >= study.scene.len().max(1), "{}", file.display());
            let known = |name: &String| places.iter().any(|place| place.name.starts_with(name.as_str()));
            assert!(study.world.keys().all(known), "{}: {:?}", file.display(), study.world.keys());
        }
    }

    #[test]
    fn faults_of_a_study_come_together_and_a_pipeline_is_none() {
        let folder = std::env::temp_dir().join(format!("rumbo-study-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("study.toml");
        let read = |text: &str| {
            std::fs::write(&path, text).unwrap();
            Study::read(&path)
        };
        assert!(read("name = 'a pipeline'\n").unwrap().is_none());
        let faulty = "pipeline = 'p.toml'\nswap = ['planner']\n[draw]\nmoved_furniture = 2.0\n[[scene]]\nname = 'a'\n\
                      draw = { way_m = [2.0, 1.0] }\n";
        let message = read(faulty).unwrap_err();
        for words in ["moved_furniture", "scene \"a\": draw.way_m", "planner=dp,a_star"] {
            assert!(message.contains(words), "{message}");
        }
        assert!(read("pipeline = 'p.toml'\nseed = 3\n").unwrap_err().contains("unknown field `seed`"));
        let study = read("pipeline = 'p.toml'\nworlds = ['w/*.toml']\n").unwrap().unwrap();
        assert_eq!(
            (study.pipeline, study.worlds),
            (folder.join("p.toml"), vec![folder.join("w/*.toml").display().to_string()])
        );
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
