//! `rumbo test`: runs the tests that pipelines carry.

pub mod expect;
mod find;

use crate::exit::{Exit, Failure};
use crate::outcome::Outcome;
use crate::queue::in_order;
use crate::report;
use crate::terminal::{Terminal, write_file};
use find::Case;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Run the tests that pipelines carry
///
/// Folders stand for the pipelines directly inside them.
#[derive(clap::Args)]
pub struct Args {
    /// Pipelines, or folders of pipelines
    #[arg(required = true)]
    paths: Vec<PathBuf>,
    /// Change a value, for example --set planner.plugin=a_star
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
    /// Only tests whose name contains this
    #[arg(long, value_name = "TEXT")]
    filter: Option<String>,
    /// Tests that run at the same time
    #[arg(long, default_value_t = 2, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: u16,
    /// Write the report of each test into this folder
    #[arg(long, value_name = "FOLDER")]
    reports: Option<PathBuf>,
    /// Print results as JSON
    #[arg(long)]
    json: bool,
}

/// What became of one test.
#[derive(Serialize)]
struct Verdict {
    file: String,
    name: String,
    passed: bool,
    failures: Vec<String>,
    outcome: Option<Outcome>,
}

/// Does it.
pub fn run(args: &Args, terminal: &Terminal) -> Result<Exit, Failure> {
    let found = find::cases(&args.paths, &args.sets, args.filter.as_deref(), args.json, terminal)?;
    if found.cases.is_empty() && !found.has_faults {
        return Err(Failure::Usage(match &args.filter {
            Some(part) => format!("there is nothing to test: no [[test]] here has `{part}` in its name"),
            None => "there is nothing to test: no pipeline here has a [[test]]".into(),
        }));
    }
    let mut verdicts = Vec::new();
    let mut trouble = None;
    in_order(
        &found.cases,
        args.threads.into(),
        |case| judge(case, args.reports.as_deref()),
        |verdict| match verdict {
            Ok(verdict) => {
                show(&verdict, args.json, terminal);
                verdicts.push(verdict);
            }
            Err(failure) => trouble = Some(failure),
        },
    );
    if let Some(failure) = trouble {
        return Err(failure);
    }
    let n_failed = verdicts.iter().filter(|verdict| !verdict.passed).count();
    let n_passed = verdicts.len() - n_failed;
    if args.json {
        terminal.json(&serde_json::json!({ "passed": n_passed, "failed": n_failed, "tests": verdicts }))?;
    } else {
        terminal.say(format!("{n_passed} passed, {n_failed} failed"));
    }
    Ok(match (found.has_faults, n_failed) {
        (true, _) => Exit::Faults,
        (false, 0) => Exit::Success,
        (false, _) => Exit::NoSuccess,
    })
}

fn judge(case: &Case, reports: Option<&Path>) -> Result<Verdict, Failure> {
    let (file, name) = (case.file.clone(), case.test.name.clone());
    let record = match case.drive() {
        Ok(record) => record,
        Err(error) => {
            return Ok(Verdict {
                file,
                name,
                passed: false,
                failures: vec![error.to_string()],
                outcome: None,
            });
        }
    };
    if let Some(folder) = reports {
        let page = folder.join(case.report_name());
        write_file(&page, report::html(&record).as_bytes())?;
    }
    let failures =
        record.outcome.as_ref().map(|o| expect::failures(&case.test.expect, o)).unwrap_or_default();
    Ok(Verdict { file, name, passed: failures.is_empty(), failures, outcome: record.outcome })
}

fn show(verdict: &Verdict, json: bool, terminal: &Terminal) {
    if json {
        return;
    }
    let word = if verdict.passed { terminal.good("ok  ") } else { terminal.bad("FAIL") };
    terminal.say(format!("{word} {}: {}", verdict.file, verdict.name));
    for failure in &verdict.failures {
        terminal.say(format!("       {failure}"));
    }
    if let Some(detail) = verdict.outcome.as_ref().filter(|_| !verdict.passed).and_then(|o| o.detail.as_ref())
    {
        terminal.say(format!("       the run said: {detail}"));
    }
}
