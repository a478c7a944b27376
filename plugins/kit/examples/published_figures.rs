//! Errors of public trajectories and of public solutions of laser logs, against the figures that are known of them: evo
//! 1.38.1 for trajectories, the metric of Kuemmerle et al. (2009) for logs. Fails where a printed digit differs.
//!
//! `cargo run --release -p rumbo-kit --example published_figures DATA`, with the folders `trajectories` and `carmen`
//! below DATA.
#![allow(clippy::print_stdout)]

use nalgebra::{Quaternion, Translation3, UnitQuaternion};
use rumbo_core::frames::Pose3;
use rumbo_core::time::{Span, Time};
use rumbo_kit::relations::{CorrectedOdometry, pose_near, read_relations, relation_errors};
use rumbo_kit::spread::Spread;
use rumbo_kit::trajectory::{
    Alignment, PairChoice, StampedPose, Step, Trajectory, TrajectoryFormat, absolute_errors, align,
    index_pairs, pose_pairs, read_trajectory, relative_errors,
};
use serde_json::Value;
use std::error::Error;
use std::path::{Path, PathBuf};

/// The gap that evo allows between stamps unless told otherwise.
const MAX_GAP: Span = Span(10_000_000);
/// Stamps in relations are rounded to five decimals.
const TOLERANCE: Span = Span(50_000);

/// Truth, estimate; ATE rmse as is, aligned, aligned and scaled; RPE rmse of one frame.
const PAIRS: [(&str, &str, [f64; 4]); 4] = [
    ("freiburg1_xyz-groundtruth", "freiburg1_xyz-rgbdslam", [0.020079, 0.013470, 0.013389, 0.005764]),
    ("freiburg1_xyz-groundtruth", "freiburg1_xyz-rgbdslam_drift", [0.134185, 0.013470, 0.013389, 0.005764]),
    ("fr2_desk_groundtruth", "fr2_desk_ORB", [3.173994, 0.008119, 0.006123, 0.003490]),
    ("KITTI_00_gt", "KITTI_00_ORB", [7.790289, 1.303450, 0.937709, 0.028120]),
];

/// Number of relations, then mean and standard deviation in meters and in degrees.
type Known = (usize, [f64; 4]);

/// Building, log; odometry, graph, filter with odometry between.
const LOGS: [(&str, &str, Known, Known, Option<Known>); 4] = [
    (
        "intel",
        "intel.clf.gz",
        (2984, [7.37, 14.35, 39.2, 53.8]),
        (301, [0.029, 0.019, 0.39, 0.34]),
        Some((2984, [0.036, 0.028, 1.73, 1.44])),
    ),
    (
        "fr079",
        "fr079.clf.gz",
        (1685, [6.50, 13.66, 30.3, 45.5]),
        (136, [0.043, 0.026, 0.52, 0.46]),
        Some((1685, [0.058, 0.042, 0.71, 0.69])),
    ),
    (
        "mit-csail",
        "mit-csail.clf.gz",
        (1172, [1.68, 5.29, 5.07, 8.24]),
        (1172, [0.004, 0.009, 0.05, 0.09]),
        Some((1172, [0.049, 0.056, 3.03, 3.27])),
    ),
    (
        "mit-killian",
        "mit-killian-keyframes.clf.gz",
        (658, [22.6, 95.1, 3.94, 12.95]),
        (658, [0.039, 0.033, 0.40, 0.34]),
        None,
    ),
];

fn main() -> Result<(), Box<dyn Error>> {
    let data = std::env::args_os().nth(1).map(PathBuf::from).ok_or("name the folder of the data sets")?;
    let mut n_different = 0;
    for (truth, estimate, known) in PAIRS {
        n_different += trajectory_pair(&data.join("trajectories"), truth, estimate, known)?;
    }
    n_different += extract(&data.join("trajectories"))?;
    for (building, log, odometry, graph, filter) in LOGS {
        n_different +=
            building_log(&data.join("carmen").join(building), building, log, odometry, graph, filter)?;
    }
    if n_different > 0 {
        return Err(format!("{n_different} figures differ").into());
    }
    println!("all figures are those known");
    Ok(())
}

/// Forty pairs of freiburg1_xyz and the whole sequence, with errors to twelve digits.
fn extract(folder: &Path) -> Result<usize, Box<dyn Error>> {
    const DIGIT: f64 = 1e-9;
    let text = std::fs::read_to_string(folder.join("tum_fr1_xyz_extract.json"))?;
    let extract: Value = serde_json::from_str(&text)?;
    let lines = |stamps: &str, poses: &str| -> Option<Vec<StampedPose>> {
        let rows = extract[stamps].as_array()?.iter().zip(extract[poses].as_array()?);
        rows.map(|(stamp, row)| {
            let [tx, ty, tz, qx, qy, qz, qw] =
                std::array::from_fn(|idx| row[idx].as_f64().unwrap_or(f64::NAN));
            let rotation = UnitQuaternion::new_normalize(Quaternion::new(qw, qx, qy, qz));
            let world_from_body = Pose3::from_parts(Translation3::new(tx, ty, tz), rotation);
            Some(StampedPose { stamp: Time::from_secs(stamp.as_f64()?), world_from_body })
        })
        .collect()
    };
    let (truth, estimate) = lines("stamps_gt", "ground_truth")
        .zip(lines("stamps_est", "estimate"))
        .ok_or("the extract has other keys")?;
    let gap = Span::from_secs(0.02);
    let few = pose_pairs(&Trajectory::of(truth).0, &Trajectory::of(estimate).0, gap);
    let read = |name: &str| read_trajectory(&folder.join(format!("freiburg1_xyz-{name}.txt.gz")), None, None);
    let all = pose_pairs(&read("groundtruth")?.trajectory, &read("rgbdslam")?.trajectory, gap);
    println!("extract: {} pairs; whole sequence: {} pairs", few.len(), all.len());
    let mut n = usize::from(few.len() != 40) + usize::from(all.len() != 786);
    let mut check = |name: &str, errors: Vec<f64>, known: &Value| {
        let found =
            Spread::of(errors).map_or([f64::NAN; 6], |s| [s.rmse, s.mean, s.median, s.std, s.min, s.max]);
        for (key, found) in ["rmse", "mean", "median", "std_population", "min", "max"].iter().zip(found) {
            n += differs(&format!("{name}, {key}"), found, known[*key].as_f64().unwrap_or(f64::NAN), DIGIT);
        }
    };
    for (name, pairs, known, steps) in [
        ("extract", &few, &extract, "rpe_delta_1_entry"),
        ("sequence", &all, &extract["full_sequence_reference"], "rpe_1_frame"),
    ] {
        let alignment = align(pairs, Alignment::Se3)?;
        check(&format!("{name} ATE"), absolute_errors(pairs, &alignment), &known["ate"]);
        let relative =
            |choice| relative_errors(pairs, &alignment, &index_pairs(pairs, Step::Frames(1), choice));
        let step = relative(PairChoice::Consecutive);
        check(&format!("{name} RPE, m"), step.translation_m, &known[steps]["translation_m"]);
        if name == "extract" {
            check("extract RPE, rad", step.rotation_rad, &known[steps]["rotation_rad"]);
            let every = relative(PairChoice::All);
            check(
                "extract RPE of all pairs, m",
                every.translation_m,
                &known["rpe_all_pairs"]["translation_m"],
            );
            check(
                "extract RPE of all pairs, rad",
                every.rotation_rad,
                &known["rpe_all_pairs"]["rotation_rad"],
            );
        }
    }
    Ok(n)
}

/// Says a figure; one where it differs in a digit that the known one has.
fn differs(what: &str, found: f64, known: f64, unit_in_last_place: f64) -> usize {
    // Half a unit by rounding; the rest is for binary fractions.
    let is_same = (found - known).abs() <= 0.500_001 * unit_in_last_place;
    println!("{} {what}: {found:.9}, known {known}", if is_same { "  " } else { "!!" });
    usize::from(!is_same)
}

fn rmse(errors: Vec<f64>) -> f64 {
    Spread::of(errors).map_or(f64::NAN, |spread| spread.rmse)
}

fn trajectory_pair(
    folder: &Path,
    truth: &str,
    estimate: &str,
    known: [f64; 4],
) -> Result<usize, Box<dyn Error>> {
    const DIGIT: f64 = 1e-6;
    let read = |name: &str| read_trajectory(&folder.join(format!("{name}.txt.gz")), None, None);
    let pairs = pose_pairs(&read(truth)?.trajectory, &read(estimate)?.trajectory, MAX_GAP);
    println!("{estimate}: {} pairs", pairs.len());
    let [as_is, rigid, scaled, step] = known;
    let mut n = 0;
    for (how, name, known) in [
        (Alignment::None, "ATE as is", as_is),
        (Alignment::Se3, "ATE aligned", rigid),
        (Alignment::Sim3, "ATE aligned and scaled", scaled),
    ] {
        n += differs(name, rmse(absolute_errors(&pairs, &align(&pairs, how)?)), known, DIGIT);
    }
    let plain = align(&pairs, Alignment::None)?;
    let relative = |step| {
        let compared = index_pairs(&pairs, step, PairChoice::Consecutive);
        rmse(relative_errors(&pairs, &plain, &compared).translation_m)
    };
    n += differs("RPE of 1 frame", relative(Step::Frames(1)), step, DIGIT);
    if truth.starts_with("KITTI") {
        // evo takes the matrices of the file as they are; made orthonormal they give one more in the sixth decimal.
        n += differs("RPE of 100 m", relative(Step::Meters(100.0)), 1.193976, 3.0 * DIGIT);
    }
    Ok(n)
}

fn building_log(
    folder: &Path,
    building: &str,
    log: &str,
    odometry_known: Known,
    graph_known: Known,
    filter_known: Option<Known>,
) -> Result<usize, Box<dyn Error>> {
    let (relations, _) = read_relations(&folder.join(format!("{building}.relations.gz")))?;
    let read = |name: String, format| {
        Ok::<Trajectory, Box<dyn Error>>(read_trajectory(&folder.join(name), format, None)?.trajectory)
    };
    let odometry = read(log.to_owned(), Some(TrajectoryFormat::Odometry))?;
    let graph = read(format!("{building}-graph-poses.txt.gz"), None)?;
    let direct = |poses: &Trajectory| relation_errors(&relations, |stamp| pose_near(poses, stamp, TOLERANCE));
    let mut cases =
        vec![("odometry", direct(&odometry), odometry_known), ("graph", direct(&graph), graph_known)];
    if let Some(known) = filter_known {
        let poses = read(format!("{building}-rbpf-poses.txt.gz"), None)?;
        let corrected = CorrectedOdometry { poses: &poses, odometry: &odometry, tolerance: TOLERANCE };
        cases.push(("filter", relation_errors(&relations, |stamp| corrected.pose_at(stamp)), known));
    }
    let mut n = 0;
    for (name, errors, (n_known, known)) in cases {
        let n_used = relations.len() - errors.n_missed;
        println!("{building}, {name}: {n_used} relations, known {n_known}");
        n += usize::from(n_used != n_known);
        let of = |errors: Vec<f64>| Spread::of(errors).ok_or("no relation has both poses");
        let (meters, radians) = (of(errors.translation_m)?, of(errors.rotation_rad)?);
        let found = [meters.mean, meters.std, radians.mean.to_degrees(), radians.std.to_degrees()];
        for ((what, found), known) in
            ["mean, m", "std, m", "mean, deg", "std, deg"].iter().zip(found).zip(known)
        {
            n += differs(what, found, known, last_place(known, what.ends_with("deg")));
        }
    }
    Ok(n)
}

/// The table has meters below 1 with three decimals, above 20 with one, and degrees below 20 with two.
fn last_place(known: f64, is_angle: bool) -> f64 {
    match known {
        _ if known > 20.0 => 0.1,
        _ if known < 1.0 && !is_angle => 0.001,
        _ => 0.01,
    }
}
