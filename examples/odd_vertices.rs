//! Long check: a localizer on a recorded log, against poses that the map was not made from.
//!
//! `cargo run --release --example odd_vertices -- FOLDER [LOG...] [--set KEY=VALUE]`, where FOLDER holds
//! `LOG/LOG.clf.gz` with `LOG/LOG-graph-poses.txt.gz` beside it (`t x y theta` of an optimized pose graph). The map is
//! made from the scans of every second pose; the localizer then runs over the whole log, told where the robot is at the
//! first pose only, and its estimate at every other pose is compared with that pose. Ends with an error when a mean
//! error is above 0.10 m or 2 degrees.
#![allow(clippy::print_stdout)]

use rumbo_core::engine::{Engine, Order, Stepped};
use rumbo_core::frames::{Pose2, wrap_angle};
use rumbo_core::messages::Data;
use rumbo_core::pipeline::Loaded;
use rumbo_core::registry::Registry;
use rumbo_core::time::{Span, Time};
use rumbo_kit::log_file::{BeamOverride, PoseTrack, Timeline, read_poses};
use rumbo_kit::map_file::{MapImage, PictureFormat, SavedAs, save_map};
use std::error::Error;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

type Fault = Box<dyn Error>;

/// Stamps of pose files are rounded to 10 µs.
const SAME: Span = Span(100_000);
const BAR_M: f64 = 0.10;
const BAR_DEG: f64 = 2.0;

struct Log {
    file: PathBuf,
    /// Poses at stamps of the run.
    poses: Vec<(Time, Pose2)>,
    origin: Time,
}

impl Log {
    fn read(folder: &Path, name: &str) -> Result<Log, Fault> {
        let folder = folder.join(name).canonicalize()?;
        let file = folder.join(format!("{name}.clf.gz"));
        let absolute = read_poses(&folder.join(format!("{name}-graph-poses.txt.gz")))?.track;
        let origin = Timeline::open(&file, BeamOverride::default())?.origin();
        let relative = |(stamp, pose): (Time, Pose2)| (Time::ZERO + (stamp - origin), pose);
        Ok(Log { file, poses: absolute.iter().map(relative).collect(), origin })
    }

    fn world(&self) -> String {
        format!(
            "[world]\nplugin = \"log\"\nfile = {:?}\n\
             [[sensor]]\nname = \"front_laser\"\nplugin = \"laser_2d\"\nmount = {{ z_m = 0.3 }}\n\
             [[sensor]]\nname = \"odometry\"\nplugin = \"wheel_encoders\"\nclaimed_distance = 0.05\nclaimed_turn = 0.1\n",
            self.file.display().to_string()
        )
    }

    /// A map of the scans at every second pose.
    fn map_of_even_poses(&self, folder: &Path, registry: &Registry) -> Result<PathBuf, Fault> {
        let mut lines = String::new();
        for (stamp, pose) in self.poses.iter().step_by(2) {
            let stamp = self.origin + (*stamp - Time::ZERO);
            let (x, y) = (pose.translation.x, pose.translation.y);
            writeln!(lines, "{:.6} {x:.6} {y:.6} {:.6}", stamp.as_secs(), pose.rotation.angle())?;
        }
        let poses = folder.join("even.txt");
        std::fs::write(&poses, lines)?;
        let text = format!(
            "{}[localizer]\nplugin = \"recorded_pose\"\nfile = {:?}\nonly_exact = true\n\
             [mission]\ninitial_pose = \"unknown\"\n\
             [map_builder]\nplugin = \"occupancy_grid\"\nlevels = 1\nmax_pose_age_s = 0.0\nmap_with_known_poses = true\n",
            self.world(),
            poses.display().to_string()
        );
        let mut engine = engine(&text, &[], registry)?;
        while engine.step() == Stepped::Went {}
        let grid = engine.view().map.grid.as_ref().ok_or("no grid")?;
        let image = MapImage::of_grid(grid, SavedAs::Trinary).ok_or("the map is empty")?;
        let yaml = folder.join("even.yaml");
        save_map(&yaml, &image, SavedAs::Trinary, PictureFormat::Png)?;
        Ok(yaml)
    }

    /// Errors at every other pose: meters and degrees.
    fn follow(&self, map: &Path, sets: &[String], registry: &Registry) -> Result<Vec<[f64; 2]>, Fault> {
        let text = format!(
            "{}[map_builder]\nplugin = \"static_map\"\nfile = {:?}\n[localizer]\nplugin = \"particle_filter\"\n\
             [mission]\ninitial_pose = {{ x_m = 0.0, y_m = 0.0 }}\n",
            self.world(),
            map.display().to_string()
        );
        let mut engine = engine(&text, sets, registry)?;
        let mut odd = PoseTrack::default();
        self.poses.iter().skip(1).step_by(2).for_each(|(stamp, pose)| odd.push(*stamp, *pose));
        let (first_stamp, first_pose) = *self.poses.first().ok_or("no poses")?;
        let (mut is_told, mut errors) = (false, Vec::new());
        while engine.step() == Stepped::Went {
            let view = engine.view();
            let scans = view.observations.iter().filter(|o| matches!(o.data, Data::LaserScan(_)));
            for truth in scans.filter_map(|scan| odd.exact(scan.stamp, SAME)) {
                let off = view.map_from_base.translation.vector - truth.translation.vector;
                let turn = wrap_angle(view.map_from_base.rotation.angle() - truth.rotation.angle());
                errors.push([off.norm(), turn.to_degrees().abs()]);
            }
            let is_time = view.now >= first_stamp;
            if is_time && !is_told {
                is_told = true;
                let deviation = nalgebra::Vector3::new(0.05, 0.05, 0.02);
                let covariance = nalgebra::Matrix3::from_diagonal(&deviation.component_mul(&deviation));
                engine.command(Order::SetPose { map_from_base: first_pose, covariance });
            }
        }
        Ok(errors)
    }
}

fn engine(text: &str, sets: &[String], registry: &Registry) -> Result<Engine, Fault> {
    let loaded = Loaded::from_text(Path::new("odd_vertices.toml"), text, sets, registry);
    let pipeline = loaded.sound().ok_or_else(|| loaded.lines().join("\n"))?;
    Ok(Engine::build(pipeline)?)
}

fn mean_and_95(errors: &[[f64; 2]], part: usize) -> [f64; 2] {
    let mut sorted: Vec<f64> = errors.iter().map(|error| error[part]).collect();
    sorted.sort_by(f64::total_cmp);
    let rank = ((0.95 * sorted.len() as f64).ceil() as usize).saturating_sub(1);
    let mean = sorted.iter().sum::<f64>() / sorted.len().max(1) as f64;
    [mean, sorted.get(rank).copied().unwrap_or(f64::NAN)]
}

fn main() -> Result<(), Fault> {
    let mut arguments = std::env::args().skip(1);
    let folder =
        PathBuf::from(arguments.next().ok_or("usage: odd_vertices FOLDER [LOG...] [--set KEY=VALUE]")?);
    let (mut names, mut sets) = (Vec::new(), Vec::new());
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--set" => sets.push(arguments.next().ok_or("--set needs KEY=VALUE")?),
            _ => names.push(argument),
        }
    }
    if names.is_empty() {
        names = ["intel", "fr079", "mit-csail"].map(str::to_owned).to_vec();
    }
    let registry = rumbo::registry()?;
    let scratch = std::env::temp_dir().join(format!("rumbo-odd-vertices-{}", std::process::id()));
    std::fs::create_dir_all(&scratch)?;
    let mut n_missed = 0;
    for name in names {
        let log = Log::read(&folder, &name)?;
        let map = log.map_of_even_poses(&scratch, &registry)?;
        let errors = log.follow(&map, &sets, &registry)?;
        let ([mean_m, most_m], [mean_deg, most_deg]) = (mean_and_95(&errors, 0), mean_and_95(&errors, 1));
        println!(
            "{name:12} {:5} poses  mean {mean_m:.3} m {mean_deg:.2} deg   95 % {most_m:.3} m {most_deg:.2} deg",
            errors.len()
        );
        n_missed += usize::from(errors.is_empty() || mean_m > BAR_M || mean_deg > BAR_DEG);
    }
    std::fs::remove_dir_all(&scratch)?;
    if n_missed > 0 {
        return Err(format!("{n_missed} logs miss the bar of {BAR_M} m and {BAR_DEG} degrees").into());
    }
    Ok(())
}
