//! `rumbo eval relations`: how well poses keep known relations.

use super::{Format, figures, not_negative, note, read};
use crate::exit::{Exit, Failure};
use crate::terminal::Terminal;
use rumbo_core::time::{Span, Time};
use rumbo_kit::log_file::{BeamOverride, Timeline};
use rumbo_kit::relations::{
    CorrectedOdometry, Relation, RelationErrors, pose_near, read_relations, relation_errors,
};
use rumbo_kit::spread::Spread;
use rumbo_kit::trajectory::{StampedPose, Trajectory};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Errors of poses against known relations between them (Kuemmerle et al. 2009)
///
/// Relations are lines of `t1 t2 x y z roll pitch yaw`: the true motion from the pose at t1 to the one at t2. Only those
/// with a pose at both stamps count; with --odometry the odometer leads to every stamp from the nearest pose.
#[derive(clap::Args)]
pub struct Args {
    /// Poses: TUM, `t x y theta` or a robot log, plain or gzip
    poses: PathBuf,
    /// The relations, plain or gzip
    relations: PathBuf,
    /// A robot log whose odometry lies between the poses
    #[arg(long, value_name = "LOG")]
    odometry: Option<PathBuf>,
    /// Stamps of the poses count from the first of this log, as those of a run on it do (`rumbo run --poses`)
    #[arg(long, value_name = "LOG")]
    since: Option<PathBuf>,
    /// Format of the poses, instead of looking; `odometry` judges the raw odometry of a log
    #[arg(long, value_enum)]
    format: Option<Format>,
    /// Stamps this close are the same
    #[arg(long, value_name = "SECONDS", default_value = "0.00005", value_parser = not_negative)]
    max_gap: f64,
    /// Print the figures as one JSON object
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Figures {
    n_relations: usize,
    /// Those between two scans of the log that the poses are of, where it was named.
    n_between_scans: Option<usize>,
    n_used: usize,
    n_poses: usize,
    translation_m: Spread,
    rotation_rad: Spread,
    translation_squared_m2: Spread,
    rotation_squared_rad2: Spread,
}

/// Does it.
pub fn run(args: &Args, terminal: &Terminal) -> Result<Exit, Failure> {
    let (relations, notes) =
        read_relations(&args.relations).map_err(|error| Failure::Usage(error.to_string()))?;
    note(&args.relations, &notes, terminal);
    let mut poses = read(&args.poses, args.format, None, terminal)?;
    if !poses.has_stamps {
        let path = args.poses.display();
        return Err(Failure::Usage(format!("{path} has no stamps, and relations are between stamps")));
    }
    let mut n_scanned = None;
    if let Some(log) = &args.since {
        poses.trajectory = Trajectory::of(in_time_of(log, poses.trajectory.poses())?).0;
        n_scanned = Some(n_scanned_in(log, &relations, Span::from_secs(args.max_gap), terminal)?);
    }
    let tolerance = Span::from_secs(args.max_gap);
    let errors = match &args.odometry {
        None => relation_errors(&relations, |stamp| pose_near(&poses.trajectory, stamp, tolerance)),
        Some(log) => {
            let odometry = read(log, Some(Format::Odometry), None, terminal)?;
            let corrected =
                CorrectedOdometry { poses: &poses.trajectory, odometry: &odometry.trajectory, tolerance };
            relation_errors(&relations, |stamp| corrected.pose_at(stamp))
        }
    };
    let n_poses = poses.trajectory.poses().len();
    let figures =
        judged(errors, relations.len(), n_poses).ok_or_else(|| none_found(&relations, &poses.trajectory))?;
    let figures = Figures { n_between_scans: n_scanned, ..figures };
    if args.json {
        terminal.json(&figures)?;
    } else {
        say(args, &figures, terminal);
    }
    Ok(Exit::Success)
}

/// The same poses with the stamps that the log has.
pub(super) fn in_time_of(log: &Path, poses: &[StampedPose]) -> Result<Vec<StampedPose>, Failure> {
    let timeline = Timeline::open(log, BeamOverride::default());
    let origin = timeline.map_err(|error| Failure::Usage(error.to_string()))?.origin();
    let moved = |pose: &StampedPose| StampedPose { stamp: origin + (pose.stamp - Time::ZERO), ..*pose };
    Ok(poses.iter().map(moved).collect())
}

/// Relations between two scans of the log: no run on it can have poses for the others.
fn n_scanned_in(
    log: &Path,
    relations: &[Relation],
    tolerance: Span,
    terminal: &Terminal,
) -> Result<usize, Failure> {
    let scans = read(log, Some(Format::Log), None, terminal)?.trajectory;
    let is_scan = |stamp| pose_near(&scans, stamp, tolerance).is_some();
    Ok(relations.iter().filter(|relation| is_scan(relation.from) && is_scan(relation.to)).count())
}

fn judged(errors: RelationErrors, n_relations: usize, n_poses: usize) -> Option<Figures> {
    let squared = |errors: &[f64]| Spread::of(errors.iter().map(|error| error * error).collect());
    Some(Figures {
        n_relations,
        n_between_scans: None,
        n_used: n_relations - errors.n_missed,
        n_poses,
        translation_squared_m2: squared(&errors.translation_m)?,
        rotation_squared_rad2: squared(&errors.rotation_rad)?,
        translation_m: Spread::of(errors.translation_m)?,
        rotation_rad: Spread::of(errors.rotation_rad)?,
    })
}

fn none_found(relations: &[Relation], poses: &Trajectory) -> Failure {
    let stamps = || relations.iter().flat_map(|relation| [relation.from, relation.to]);
    let range = |range: Option<(Time, Time)>| match range {
        Some((from, to)) => format!("from {:.6} s to {:.6} s", from.as_secs(), to.as_secs()),
        None => "without stamps".to_owned(),
    };
    Failure::Usage(format!(
        "none of {} relations has a pose at both of its stamps\n  relations: {}\n  poses: {}\n  are both of the same \
         log? --odometry LOG leads from the poses to other stamps, a larger --max-gap takes poses that are farther off",
        relations.len(),
        range(stamps().min().zip(stamps().max())),
        range(poses.time_range())
    ))
}

fn say(args: &Args, figures: &Figures, terminal: &Terminal) {
    let title = format!("{} against {}", args.poses.display(), args.relations.display());
    let between = args.odometry.as_ref().map_or("", |_| ", odometry between them");
    let scans =
        figures.n_between_scans.map_or_else(String::new, |n| format!(", {n} are between scans of the log"));
    let rows = [
        ("relations", format!("{} of {} have both poses{scans}", figures.n_used, figures.n_relations)),
        ("poses", format!("{}{between}", figures.n_poses)),
        ("translation", mean_and_std(&figures.translation_m, 1.0, "m")),
        ("rotation", mean_and_std(&figures.rotation_rad, 1.0_f64.to_degrees(), "deg")),
        ("translation squared", mean_and_std(&figures.translation_squared_m2, 1.0, "m²")),
        (
            "rotation squared",
            mean_and_std(&figures.rotation_squared_rad2, 1.0_f64.to_degrees().powi(2), "deg²"),
        ),
    ];
    figures::lines(&title, &rows, terminal);
}

fn mean_and_std(spread: &Spread, factor: f64, unit: &str) -> String {
    format!("{:.5} +- {:.5} {unit}", spread.mean * factor, spread.std * factor)
}
