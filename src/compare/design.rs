//! The full factorial design: every alternative in every world, with every seed and mission.

use super::draw;
use super::fingerprint::Fingerprint;
use super::range::SetRange;
use super::swap::Alternative;
use super::worlds::{Missions, Place};
use crate::load::{self, Ready, Refused};
use rumbo_core::pipeline::Expect;
use rumbo_core::registry::Registry;
use serde_json::Value;
use std::path::PathBuf;

/// Everything that decides what the runs give.
#[derive(Debug)]
pub struct Design {
    /// What the study calls itself; empty without one.
    pub title: String,
    /// The pipeline that all alternatives are made of.
    pub base: PathBuf,
    /// Arguments of `--set`.
    pub sets: Vec<String>,
    /// Values that each seed draws.
    pub ranges: Vec<SetRange>,
    /// What is compared.
    pub alternatives: Vec<Alternative>,
    /// Where.
    pub places: Vec<Place>,
    /// With which seeds.
    pub seeds: Vec<u64>,
    /// What is shown of each world by itself.
    pub show: Vec<String>,
}

/// One run of the design.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Run {
    /// Position in [`Design::alternatives`].
    pub alternative: usize,
    /// Position in [`Design::places`].
    pub place: usize,
    /// Its seed.
    pub seed: u64,
    /// Number of the mission in this place, from 0.
    pub mission: u32,
}

impl Run {
    /// What it has in common with the run of another alternative that it is compared with.
    pub fn setting(&self) -> (usize, u64, u32) {
        (self.place, self.seed, self.mission)
    }
}

impl Design {
    /// All runs in the order of their execution: seed by seed, so that a sweep that was stopped early is balanced.
    pub fn runs(&self) -> Vec<Run> {
        let mut runs = Vec::new();
        for &seed in &self.seeds {
            for (place, with) in self.places.iter().enumerate() {
                for mission in 0..with.missions.n_missions() {
                    let of = |alternative| Run { alternative, place, seed, mission };
                    runs.extend((0..self.alternatives.len()).map(of));
                }
            }
        }
        runs
    }

    /// Name of a run's alternative.
    pub fn alternative_name(&self, run: &Run) -> String {
        self.alternatives.get(run.alternative).map(Alternative::name).unwrap_or_default()
    }

    /// Name of a run's world.
    pub fn place_name(&self, run: &Run) -> &str {
        self.places.get(run.place).map_or("", |place| &place.name)
    }

    /// Reads the pipeline as this run has it, with what was drawn for it.
    pub fn load(&self, run: &Run, drawn: &[String], registry: &Registry) -> Result<Ready, Refused> {
        let mut sets = self.sets_but_chance(run);
        sets.extend_from_slice(drawn);
        sets.push(format!("seed={}", run.seed));
        load::load(&self.base, &sets, registry)
    }

    /// A number in hexadecimal digits that changes when the same seed could give another result: of the effective
    /// pipelines, ranges, world files, plugin libraries and the version. More or fewer seeds and missions leave it as it is.
    pub fn fingerprint(&self, registry: &Registry) -> String {
        let mut print = Fingerprint::default();
        print.text(env!("CARGO_PKG_VERSION"));
        self.ranges.iter().for_each(|range| print.text(&format!("{range:?}")));
        for (place, with) in self.places.iter().enumerate() {
            print.text(&with.name);
            print.text(&with.fingerprint.to_string());
            print.text(&format!("{:?}", with.by_study));
            for alternative in 0..self.alternatives.len() {
                let run = Run { alternative, place, seed: 0, mission: 0 };
                print.text(&self.alternative_name(&run));
                let mut sets = self.sets_but_chance(&run);
                sets.push("seed=0".to_owned());
                match load::load(&self.base, &sets, registry) {
                    Ok(ready) => {
                        print.text(&effective(&ready).to_string());
                        ready.libraries().iter().for_each(|library| print.text(library));
                    }
                    Err(refused) => print.text(&refused.to_json().to_string()),
                }
            }
        }
        format!("{:016x}", print.value())
    }

    /// What is drawn for a run, as arguments of `--set`.
    ///
    /// # Errors
    /// The world has no room for what the study wants.
    pub fn drawn(&self, run: &Run) -> Result<Vec<String>, String> {
        let place = self.places.get(run.place);
        let of_scene = place.into_iter().flat_map(|place| &place.by_study.ranges);
        let ranges = self.ranges.iter().chain(of_scene).map(|range| range.set(run.seed));
        let mission = self.mission_sets(run)?;
        Ok(ranges.chain(mission).collect())
    }

    /// What counts as success of a run, where a study says so.
    pub fn expect(&self, run: &Run) -> Option<&Expect> {
        self.places.get(run.place)?.by_study.expect.as_ref()
    }

    fn sets_but_chance(&self, run: &Run) -> Vec<String> {
        let mut sets = self.sets.clone();
        sets.extend(self.alternatives.get(run.alternative).into_iter().flat_map(Alternative::sets));
        let file = self.places.get(run.place).and_then(|place| place.file.as_ref());
        sets.extend(file.map(|file| format!("world.map={:?}", file.display().to_string())));
        let of_place = self.places.get(run.place).into_iter().flat_map(|place| &place.by_study.sets);
        sets.extend(of_place.cloned());
        sets
    }

    fn mission_sets(&self, run: &Run) -> Result<Vec<String>, String> {
        let Some(place) = self.places.get(run.place) else { return Ok(Vec::new()) };
        Ok(match (&place.missions, &place.by_study.rules) {
            (Missions::Own, _) => Vec::new(),
            (Missions::Given(sets), _) => sets.clone(),
            (Missions::Drawn(space, _), Some(rules)) => draw::draw(space, rules, run.seed, run.mission)?,
            (Missions::Drawn(space, _), None) => {
                let ends = space.draw(run.seed, run.mission);
                let ([x, y], [goal_x, goal_y], yaw) = (ends.start, ends.goal, ends.yaw_deg);
                vec![
                    format!("world.start={{ x_m = {x:?}, y_m = {y:?}, yaw_deg = {yaw:?} }}"),
                    format!("mission.waypoints=[{{ x_m = {goal_x:?}, y_m = {goal_y:?} }}]"),
                ]
            }
        })
    }
}

/// The pipeline as it takes effect, without origins.
pub fn effective(ready: &Ready) -> Value {
    ready.to_json().get("pipeline").cloned().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::{range, swap};

    fn design(n_seeds: u64) -> Design {
        Design {
            title: String::new(),
            base: PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("pipelines/office.toml"),
            sets: vec!["mission.time_limit_s=9.0".into()],
            ranges: vec![range::parse("world.slip.speed=0.0..0.04").unwrap()],
            alternatives: swap::alternatives(&[swap::parse("planner=dp,a_star").unwrap()], &[]),
            places: vec![Place::own()],
            seeds: (1..=n_seeds).collect(),
            show: Vec::new(),
        }
    }

    #[test]
    fn every_alternative_meets_every_setting_once_and_the_same_chance() {
        let (design, registry) = (design(3), crate::registry().unwrap());
        let runs = design.runs();
        assert_eq!(runs.len(), 6);
        let load = |run: &Run| {
            let drawn = design.drawn(run).unwrap();
            design.load(run, &drawn, &registry).ok().unwrap()
        };
        let slip = |run: &Run| {
            let pipeline = effective(&load(run));
            (pipeline["world"]["slip"]["speed"].as_f64().unwrap(), pipeline["seed"].as_u64().unwrap())
        };
        assert_eq!(slip(&runs[0]), slip(&runs[1]));
        assert_ne!(slip(&runs[0]).0, slip(&runs[2]).0);
        let a_star = effective(&load(&runs[1]));
        // The variant's key, and none of the plugin before it.
        assert_eq!(a_star["planner"]["clearance_m"].as_f64(), Some(0.35));
        assert!(a_star["planner"].get("preferred_clearance_m").is_none());
    }

    #[test]
    fn the_fingerprint_is_that_of_what_decides_results_and_not_of_how_many_there_are() {
        let registry = crate::registry().unwrap();
        let print = design(3).fingerprint(&registry);
        assert_eq!(print, design(4).fingerprint(&registry));
        let changed = [
            Design { sets: vec!["mission.time_limit_s=8.0".into()], ..design(3) },
            Design { ranges: Vec::new(), ..design(3) },
            Design { alternatives: vec![Alternative::default()], ..design(3) },
            Design { places: vec![Place { fingerprint: 1, ..Place::own() }], ..design(3) },
        ];
        for other in changed {
            assert_ne!(print, other.fingerprint(&registry));
        }
    }
}
