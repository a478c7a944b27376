//! The laws of each stage: what every plugin keeps, whoever wrote it.
//!
//! `rumbo plugins verify` asks plugins for them, and `tests/laws` asks every one that is shipped. A law looks at a plugin
//! from outside only: it builds it through its entry, as a pipeline does, calls it, and judges what comes back. Worlds,
//! scans and files are made up here, so that nothing else is needed.

mod avoider_faults;
mod avoiders;
mod closed_loop;
mod depth_picture;
mod drive;
mod estimate_faults;
mod estimates;
mod estimators;
mod law;
mod map_builders;
mod memory;
mod odd_world;
mod parameters;
mod planner_faults;
mod planner_paths;
mod planners;
mod props;
mod ranges;
mod report;
mod runner;
mod sensor_readings;
mod sensors;
mod slam;
mod stopwatch;
mod subject;
mod text_world;
mod turn;
mod worlds;

pub use law::{Law, Trouble, Verdict};
pub use report::{Finding, Outcome, PluginReport, Report};

use props::Props;
use rumbo_core::registry::{Entry, Stage};
use runner::guarded;
use std::sync::{Arc, Mutex, PoisonError};
use subject::Subject;

/// How plugins are asked.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Keys that the plugins are built with; everything else has its default.
    pub keys: toml::Table,
}

/// The memory of the process is one of the things that laws look at, so only one plugin is asked at a time.
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

/// Every law of every one of these plugins, at their defaults.
pub fn verify<'e>(entries: impl Iterator<Item = &'e Arc<Entry>>) -> Report {
    verify_with(entries, &Options::default(), |_| {})
}

/// As [`verify`], with options; `show` gets the report on each plugin as soon as it is there.
pub fn verify_with<'e>(
    entries: impl Iterator<Item = &'e Arc<Entry>>,
    options: &Options,
    mut show: impl FnMut(&PluginReport),
) -> Report {
    let _alone = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
    let props = Arc::new(Props::make());
    let mut report = Report::default();
    for entry in entries {
        let plugin = verify_one(entry, options, &props);
        show(&plugin);
        report.plugins.push(plugin);
    }
    report
}

fn verify_one(entry: &Arc<Entry>, options: &Options, props: &Arc<Props>) -> PluginReport {
    let mut report = PluginReport::new(entry);
    let subject = Subject::new(entry.clone(), options.keys.clone(), props.clone());
    for law in parameters::LAWS {
        report.findings.push(ask(law, &subject));
    }
    let build = parameters::BUILDS;
    let first = subject.clone();
    let settled = guarded(build.patience, move || first.settle());
    let (finding, settled) = match settled {
        Ok(Ok((settled, note))) => (Finding::of(build, Ok(Ok(note))), Some(settled)),
        Ok(Err(trouble)) => (Finding::of(build, Ok(Err(trouble))), None),
        Err(ended) => (Finding::of(build, Err(ended)), None),
    };
    report.findings.push(finding);
    for law in of_stage(entry.stage) {
        report.findings.push(match &settled {
            Some(subject) => ask(law, subject),
            None => Finding::not_applicable(law, "it could not be built, see above"),
        });
    }
    report
}

fn ask(law: &'static Law, subject: &Subject) -> Finding {
    let (subject, check) = (subject.clone(), law.check);
    Finding::of(law, guarded(law.patience, move || check(&subject)))
}

/// What plugins of this stage keep beside the laws of parameters.
fn of_stage(stage: Stage) -> &'static [Law] {
    match stage {
        Stage::World => worlds::LAWS,
        Stage::Sensor => sensors::LAWS,
        Stage::MapBuilder => map_builders::LAWS,
        Stage::Localizer => estimates::LOCALIZER_LAWS,
        Stage::Slam => estimates::SLAM_LAWS,
        Stage::Planner => planners::LAWS,
        Stage::Avoider => avoiders::LAWS,
        // A stage that this program does not know has no laws here.
        _ => &[],
    }
}

/// Every law that a plugin of this stage is asked for, in the order of the report.
pub fn laws_of(stage: Stage) -> impl Iterator<Item = &'static Law> {
    parameters::LAWS.iter().chain([parameters::BUILDS]).chain(of_stage(stage))
}
