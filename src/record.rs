//! What a run leaves behind for reports and pictures.

mod recorder;

pub use recorder::{Recorder, way};

use crate::outcome::Outcome;
use crate::picture::MapImage;
use rumbo_core::robot::Hull;
use serde::{Deserialize, Serialize};

/// The version of saved runs that this program writes.
pub const SCHEMA: u32 = 1;

/// One moment of a run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// When, seconds.
    pub time_s: f64,
    /// Where the robot really was: x, y in meters, yaw in radians.
    pub truth: Option<[f64; 3]>,
    /// Where it thought it was.
    pub estimate: [f64; 3],
    /// Covariance xx, xy, yy of the estimate's position, m².
    pub covariance: [f64; 3],
    /// The estimate means something: the robot was not lost.
    pub is_located: bool,
    /// Hull to the nearest obstacle, meters.
    pub clearance_m: Option<f64>,
    /// Commanded speed, m/s.
    pub speed_m_s: f64,
    /// Commanded turn, rad/s.
    pub turn_rad_s: f64,
}

impl Sample {
    /// Estimate to truth, meters.
    pub fn error_m(&self) -> Option<f64> {
        let [x, y, _] = self.truth.filter(|_| self.is_located)?;
        Some((x - self.estimate[0]).hypot(y - self.estimate[1]))
    }
}

/// A path that the robot was given.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PathRecord {
    /// When, seconds.
    pub time_s: f64,
    /// Its points in the map's frame, meters.
    pub points: Vec<[f64; 2]>,
}

/// Something that happened.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EventRecord {
    /// When, seconds.
    pub time_s: f64,
    /// What, in words.
    pub text: String,
    /// It is trouble, not progress.
    pub is_trouble: bool,
    /// Worth a line on the terminal: what the world had to tell, and stages that failed.
    #[serde(default)]
    pub is_notice: bool,
}

/// What a sensor sees from the start.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SeenRegion {
    /// Name of the sensor.
    pub sensor: String,
    /// The outline of the region in the map's frame, meters.
    pub outline: Vec<[f64; 2]>,
}

/// What a planner drew of its last plan.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlanDrawing {
    /// What it shows, in the planner's words.
    pub name: String,
    /// Single points, not a chain.
    pub is_points: bool,
    /// Places in the map's frame, meters.
    pub points: Vec<[f64; 2]>,
}

/// A whole run, made small.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RunRecord {
    /// Version of this format.
    pub schema: u32,
    /// Name of the pipeline.
    pub name: String,
    /// The pipeline's file.
    pub file: String,
    /// The figures; absent where nothing ran.
    pub outcome: Option<Outcome>,
    /// The robot's outline in its own frame, meters.
    pub hull: Vec<[f64; 2]>,
    /// Distance at which a goal counts as reached, meters.
    pub arrival_radius_m: f64,
    /// Where the world puts the robot: x, y in meters, yaw in radians.
    pub start: Option<[f64; 3]>,
    /// Where to go, meters.
    pub goals: Vec<[f64; 2]>,
    /// Moments, evenly spaced.
    pub samples: Vec<Sample>,
    /// The way as `[slam]` knows it at the end, meters; empty where it keeps none.
    #[serde(default)]
    pub known_way: Vec<[f64; 2]>,
    /// Paths, oldest first.
    pub paths: Vec<PathRecord>,
    /// Obstacles that the map does not show: x, y, radius, meters.
    pub obstacles: Vec<[f64; 3]>,
    /// Events, oldest first.
    pub events: Vec<EventRecord>,
    /// Events that found no room.
    pub n_events_left_out: usize,
    /// The map at the end.
    pub map: Option<MapImage>,
    /// Walls of the map at the end, as pieces from end to end in the map's frame, meters.
    #[serde(default)]
    pub walls: Vec<[[f64; 2]; 2]>,
    /// What the sensors see, where that was asked for.
    #[serde(default)]
    pub seen: Vec<SeenRegion>,
    /// What the planner drew of its last plan, also where that failed.
    #[serde(default)]
    pub plan_drawings: Vec<PlanDrawing>,
    /// The effective pipeline.
    pub config: String,
}

/// Why a saved run cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// It is not what a run saves.
    #[error("this is no saved run: {0}; write one with `rumbo run PIPELINE --save-run FILE`")]
    Format(#[from] serde_json::Error),
    /// It comes from a later program.
    #[error("the saved run has schema {found}, this program reads up to {SCHEMA}; use a newer rumbo")]
    Schema {
        /// What it says.
        found: u32,
    },
}

impl RunRecord {
    /// Reads a saved run.
    pub fn from_json(text: &str) -> Result<RunRecord, RecordError> {
        let record: RunRecord = serde_json::from_str(text)?;
        if record.schema > SCHEMA { Err(RecordError::Schema { found: record.schema }) } else { Ok(record) }
    }

    /// The most important figures in one line.
    pub fn headline(&self) -> String {
        let Some(outcome) = &self.outcome else { return self.file.clone() };
        let mut line =
            format!("{} after {:.1} s, {:.1} m driven", outcome.reason, outcome.time_s, outcome.path_m);
        if let Some(error_m) = outcome.rms_error_m {
            line += &format!(", {:.1} cm rms error", error_m * 100.0);
        }
        if let Some(clearance_m) = outcome.min_clearance_m {
            line += &format!(", {clearance_m:.2} m least clearance");
        }
        line
    }
}

/// A hull as corners.
pub fn outline_of(hull: &Hull) -> Vec<[f64; 2]> {
    match hull {
        Hull::Polygon(corners) => corners.iter().map(|corner| [corner.x, corner.y]).collect(),
        Hull::Disc { radius_m } => (0..32)
            .map(|k| std::f64::consts::TAU * f64::from(k) / 32.0)
            .map(|angle| [radius_m * angle.cos(), radius_m * angle.sin()])
            .collect(),
    }
}

/// A small run for tests: three seconds along x in a room.
#[cfg(test)]
pub fn test_record() -> RunRecord {
    use rumbo_core::engine::{EndReason, Part};
    let sample = |k: u32| {
        let x = f64::from(k) * 0.1;
        Sample {
            time_s: f64::from(k) * 0.1,
            truth: Some([x, 0.5, 0.0]),
            estimate: [x + 0.01, 0.52, 0.0],
            covariance: [0.01, 0.002, 0.02],
            is_located: true,
            clearance_m: Some(0.4 - 0.01 * f64::from(k)),
            speed_m_s: 0.2,
            turn_rad_s: 0.0,
        }
    };
    let gray = (0..40 * 30).map(|i| if i % 40 == 0 { 0x22 } else { 0xff }).collect();
    RunRecord {
        schema: SCHEMA,
        name: "a room & <its> robot".into(),
        file: "room.toml".into(),
        outcome: Some(Outcome {
            pipeline: "a room".into(),
            seed: 7,
            arrived: true,
            reason: EndReason::Arrived,
            detail: None,
            time_s: 3.0,
            path_m: 3.0,
            goal_error_m: Some(0.05),
            final_error_m: Some(0.022),
            final_error_x_m: Some(0.01),
            final_error_y_m: Some(0.015),
            counters: Default::default(),
            final_heading_error_deg: Some(0.1),
            rms_error_m: Some(0.022),
            p95_error_m: Some(0.023),
            rms_heading_error_deg: Some(0.4),
            turn_deg_m: Some(12.0),
            min_clearance_m: Some(0.1),
            contacts: Some(0),
            driven_contacts: Some(0),
            first_contact_s: None,
            first_blocked_s: Some(1.0),
            replans: 1,
            guard_interventions: 0,
            stage_failures: 0,
            tracked_share: Some(1.0),
            map_free_m2: Some(11.7),
            steps: 60,
            realtime_factor: Some(1234.5),
            cpu: Part::ALL.into_iter().map(|part| (format!("cpu_{}_s", part.name()), 0.25)).collect(),
        }),
        hull: outline_of(&Hull::Disc { radius_m: 0.2 }),
        arrival_radius_m: 0.1,
        start: None,
        goals: vec![[3.0, 0.5]],
        samples: (0..=30).map(sample).collect(),
        paths: vec![
            PathRecord { time_s: 0.0, points: vec![[0.0, 0.5], [3.0, 0.5]] },
            PathRecord { time_s: 1.0, points: vec![[1.0, 0.5], [2.0, 0.8], [3.0, 0.5]] },
        ],
        obstacles: vec![[2.0, 0.5, 0.05]],
        events: vec![EventRecord {
            time_s: 1.0,
            text: "blocked by <1> obstacle".into(),
            is_trouble: true,
            is_notice: false,
        }],
        n_events_left_out: 0,
        map: Some(MapImage { width: 40, height: 30, pixel_m: 0.1, origin: [-0.5, -1.0, 0.0], gray }),
        walls: vec![[[-0.4, -0.9], [3.2, -0.9]]],
        seen: Vec::new(),
        known_way: Vec::new(),
        plan_drawings: Vec::new(),
        config: "name = \"a room & <its> robot\"\n".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_saved_run_comes_back_and_a_later_one_is_refused() {
        let record = test_record();
        let mut json = serde_json::to_value(&record).unwrap();
        assert_eq!(RunRecord::from_json(&json.to_string()).unwrap(), record);
        json["schema"] = 99.into();
        assert!(RunRecord::from_json(&json.to_string()).unwrap_err().to_string().contains("99"));
        assert!(RunRecord::from_json("[").unwrap_err().to_string().contains("--save-run"));
    }
}
