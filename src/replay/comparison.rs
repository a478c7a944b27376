//! The observer that holds a replay against its recording.

use super::difference::{Difference, Message, differences, stage_of};
use super::figures::Figures;
use super::world::Follow;
use rumbo_core::engine::{Observer, RunEnd, StepView};
use rumbo_core::map::Map;
use rumbo_core::messages::SensorId;
use rumbo_core::time::Time;
use rumbo_kit::recording::layout::{self, observation_kind};
use rumbo_kit::recording::{BagMessage, RecordedStep, RecordingReader, Said, StepEncoder};

/// Compares step by step; memory holds one step of each.
pub struct Comparison {
    reader: RecordingReader,
    ahead: Option<RecordedStep>,
    follow: Follow,
    encoder: StepEncoder,
    last: (u64, Time),
    n_steps: u64,
    /// What the world said after the last step.
    epilogue: Vec<Message>,
    differences: Vec<Difference>,
    figures: Figures,
    n_messages: u64,
}

/// What a comparison found.
#[derive(Debug)]
pub struct Compared {
    /// Where each stage first said something else, earliest first.
    pub differences: Vec<Difference>,
    /// How far they went from each other.
    pub figures: Figures,
    /// Steps of the replay.
    pub n_steps: u64,
    /// Messages that were compared.
    pub n_messages: u64,
    /// How the recorded run ended.
    pub recorded_end: Option<(String, String)>,
    /// What is wrong with the file.
    pub damage: Option<String>,
}

impl Comparison {
    /// A comparison with a recording from its first step.
    pub fn new(mut reader: RecordingReader, follow: Follow) -> Comparison {
        let ahead = reader.next_step();
        Comparison {
            reader,
            ahead,
            follow,
            encoder: StepEncoder::default(),
            last: (0, Time::ZERO),
            n_steps: 0,
            epilogue: Vec::new(),
            differences: Vec::new(),
            figures: Figures::default(),
            n_messages: 0,
        }
    }

    fn compare(&mut self, step: u64, now: Time, recorded: &[Message], replayed: &[Message]) {
        self.n_messages += replayed.len() as u64;
        self.figures.count(recorded, replayed);
        if recorded == replayed {
            return;
        }
        let sensors = self.reader.header().sensors.clone();
        for (said, field, recorded, replayed) in differences(recorded, replayed) {
            // Steps are counted anew where another pipeline takes others.
            if said == Said::Step && self.follow == Follow::Times {
                continue;
            }
            let stage = stage_of(said, &sensors);
            if !self.differences.iter().any(|known| known.stage == stage) {
                let time_s = now.as_secs();
                self.differences.push(Difference { stage, step, time_s, field, recorded, replayed });
            }
        }
    }

    /// The recorded step of this moment; those before it that the replay did not take are held against nothing.
    fn recorded_at(&mut self, now: Time) -> Vec<Message> {
        loop {
            let Some(mark) = self.ahead.as_ref().and_then(|step| step.mark) else { return Vec::new() };
            if self.follow == Follow::Times && mark.now > now {
                return Vec::new();
            }
            let step = std::mem::replace(&mut self.ahead, self.reader.next_step()).unwrap_or_default();
            let recorded = messages_of(&step);
            if self.follow == Follow::Steps || mark.now == now {
                return recorded;
            }
            self.compare(mark.step, mark.now, &recorded, &[]);
        }
    }

    /// Compares what is left when the run is over.
    pub fn finish(mut self, end: &RunEnd, map: &Map) -> Compared {
        let mut last = std::mem::take(&mut self.epilogue);
        self.encoder.map(map, &mut |said, bytes| last.push(Message { said, bytes: bytes.to_vec() }));
        while let Some(step) = std::mem::replace(&mut self.ahead, self.reader.next_step()) {
            let recorded = messages_of(&step);
            match step.mark {
                Some(mark) => self.compare(mark.step, mark.now, &recorded, &[]),
                None => {
                    // A file that was cut off does not say how the run left the map.
                    let is_whole = self.reader.run_end().is_some();
                    last.retain(|message| is_whole || message.said != Said::Map);
                    let (step, now) = self.last;
                    self.compare(step, now, &recorded, &std::mem::take(&mut last));
                }
            }
        }
        let recorded_end = self.reader.run_end().cloned();
        self.compare_ends(recorded_end.as_ref(), end);
        Compared {
            damage: self.reader.damage(),
            differences: self.differences,
            figures: self.figures,
            n_steps: self.n_steps,
            n_messages: self.n_messages,
            recorded_end,
        }
    }

    fn compare_ends(&mut self, recorded: Option<&(String, String)>, end: &RunEnd) {
        let Some((reason, detail)) = recorded else { return };
        // Somebody's hand or a clock on the wall ended the run: that does not happen again.
        if matches!(reason.as_str(), "interrupted" | "stalled") {
            return;
        }
        let shown = |reason: &str, detail: &str| format!("{reason} {detail}").trim_end().to_owned();
        let recorded = shown(reason, detail);
        let replayed = shown(&end.reason.to_string(), end.detail.as_deref().unwrap_or_default());
        if recorded != replayed {
            let (step, now) = self.last;
            let (stage, field, time_s) = ("end of the run".to_owned(), "reason".to_owned(), now.as_secs());
            self.differences.push(Difference { stage, step, time_s, field, recorded, replayed });
        }
    }
}

impl Observer for Comparison {
    fn on_step(&mut self, view: &StepView<'_>) {
        let mut replayed = Vec::new();
        self.encoder.encode(view, &mut |said, bytes| replayed.push(Message { said, bytes: bytes.to_vec() }));
        if self.n_steps > 0 && self.last.0 == view.step {
            self.epilogue.append(&mut replayed);
            return;
        }
        self.last = (view.step, view.now);
        self.n_steps += 1;
        let recorded = self.recorded_at(view.now);
        self.compare(view.step, view.now, &recorded, &replayed);
    }
}

/// The messages of a recorded step; what cannot be told apart is left out.
fn messages_of(step: &RecordedStep) -> Vec<Message> {
    let said = |message: &BagMessage| {
        let schema = message.channel.schema.as_str();
        let fixed =
            [Said::Order, Said::Map, Said::Estimate, Said::Path, Said::Command, Said::Event, Said::Step];
        let known = fixed.into_iter().find(|said| said.layout().name == schema);
        known.or_else(|| {
            observation_kind(schema).map(|kind| Said::Observation(sensor_of(&message.data), kind))
        })
    };
    let message = |message: &BagMessage| Some(Message { said: said(message)?, bytes: message.data.clone() });
    step.messages.iter().filter_map(message).collect()
}

/// Every observation begins with the number of its sensor.
fn sensor_of(message: &[u8]) -> SensorId {
    let number = rumbo_kit::recording::cdr::CdrReader::new(message).and_then(|mut cdr| cdr.u16());
    SensorId(number.unwrap_or_default())
}

// Messages of schema 2 are those of schema 1, packed.
const _: () = assert!(layout::SCHEMA == 2, "a new schema needs a look at how old recordings are compared");
