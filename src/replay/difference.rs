//! What a replay found, stage by stage.

use rumbo_kit::recording::{Said, first_difference, sensor_name};
use serde::Serialize;

/// Where a stage first said something else.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Difference {
    /// The stage.
    pub stage: String,
    /// The step of the recording, or of the replay where the recording has none.
    pub step: u64,
    /// When, seconds.
    pub time_s: f64,
    /// The field of its message.
    pub field: String,
    /// What was recorded.
    pub recorded: String,
    /// What the replay says.
    pub replayed: String,
}

impl std::fmt::Display for Difference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{} at {:.3} s (step {}): {} was {}, now {}",
            self.stage, self.time_s, self.step, self.field, self.recorded, self.replayed
        )
    }
}

/// One message of a step.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Message {
    /// What it says.
    pub said: Said,
    /// In bytes.
    pub bytes: Vec<u8>,
}

/// Who speaks, in the words of a pipeline.
pub fn stage_of(said: Said, sensors: &[String]) -> String {
    match said {
        Said::Order => "orders".to_owned(),
        Said::Observation(sensor, _) => format!("sensor {}", sensor_name(sensors, sensor)),
        Said::Map => "map_builder".to_owned(),
        Said::Estimate => "localizer".to_owned(),
        Said::Path => "planner".to_owned(),
        Said::Command => "avoider".to_owned(),
        Said::Event => "events".to_owned(),
        Said::Step => "engine".to_owned(),
    }
}

/// How the messages of one step differ: the first field of each stage, in the order of the data.
pub fn differences<'a>(
    recorded: &'a [Message],
    replayed: &'a [Message],
) -> impl Iterator<Item = (Said, String, String, String)> + 'a {
    let mut all: Vec<Said> = recorded.iter().chain(replayed).map(|message| message.said).collect();
    all.sort_unstable();
    all.dedup();
    all.into_iter().filter_map(move |said| {
        let of = |messages: &'a [Message]| messages.iter().filter(move |message| message.said == said);
        let (mut first, mut second) = (of(recorded), of(replayed));
        loop {
            let found = match (first.next(), second.next()) {
                (None, None) => return None,
                (Some(a), Some(b)) => first_difference(&said.layout(), &a.bytes, &b.bytes),
                (Some(_), None) => return Some((said, "a message".into(), "there".into(), "missing".into())),
                (None, Some(_)) => return Some((said, "a message".into(), "missing".into(), "there".into())),
            };
            if let Some(found) = found {
                return Some((said, found.field, found.first, found.second));
            }
        }
    })
}
