//! A recording of a run, step by step.

use super::bag::{BagChannel, BagEnd, BagError, BagMessage, BagReader};
use super::cdr::{CdrError, CdrReader};
use super::header::{HeaderError, RunHeader, read_end, read_header};
use super::layout::{COMMAND, END, EVENT, Layout, ORDER, PACKED_STEP, RUN, STEP, observation_kind};
use super::observation::read_observation;
use super::order_code::read_order;
use super::outputs::{RecordedEvent, StepMark, read_command, read_event, read_step};
use super::packed_step::StepUnpacker;
use super::ros::layout::{LASER_SCAN, POINT_CLOUD};
use super::step_encoder::Said;
use rumbo_core::engine::Order;
use rumbo_core::messages::Observation;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

/// Why a recording cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RecordingError {
    /// The file is no bag.
    #[error(transparent)]
    Bag(#[from] BagError),
    /// The bag is not one of ours.
    #[error("{path}: this bag was not recorded by rumbo: {found}")]
    Foreign {
        /// The file.
        path: String,
        /// What was found.
        found: String,
    },
    /// Its beginning is not understood.
    #[error("{path}: {error}")]
    Header {
        /// The file.
        path: String,
        /// Why.
        error: HeaderError,
    },
}

/// One step as it was recorded.
#[derive(Debug, Clone, Default)]
pub struct RecordedStep {
    /// What closed it; none for what the world said after the last step.
    pub mark: Option<StepMark>,
    /// Orders from outside.
    pub orders: Vec<Order>,
    /// What came in, derived observations too.
    pub observations: Vec<Observation>,
    /// The world did what the command said; none where there was no command.
    pub is_actuated: Option<bool>,
    /// What happened.
    pub events: Vec<RecordedEvent>,
    /// Every message of the step in the order in which it was written, viewers' copies left out.
    pub messages: Vec<BagMessage>,
}

/// A recording on its way: memory holds one step.
#[derive(Debug)]
pub struct RecordingReader {
    bag: BagReader,
    header: RunHeader,
    unpacker: StepUnpacker,
    channels: BTreeMap<Said, Arc<BagChannel>>,
    end: Option<(String, String)>,
    fault: Option<CdrError>,
}

/// The layout of a message is this one.
pub fn is_of(message: &BagMessage, layout: &Layout) -> bool {
    message.channel.schema == layout.name
}

impl RecordingReader {
    /// Opens a recording and reads what was run.
    pub fn open(path: &Path) -> Result<RecordingReader, RecordingError> {
        RecordingReader::new(BagReader::open(path)?)
    }

    /// Reads what was run from a bag at its beginning.
    pub fn new(mut bag: BagReader) -> Result<RecordingReader, RecordingError> {
        let name = bag.name().to_owned();
        let place = || name.clone();
        let Some(first) = bag.next() else {
            let found = match bag.end() {
                Some(BagEnd::Whole) => "it has no messages".to_owned(),
                Some(BagEnd::Damaged(reason)) => format!("it is damaged at once: {reason}"),
                _ => "it ends before the first message".to_owned(),
            };
            return Err(RecordingError::Foreign { path: place(), found });
        };
        if !is_of(&first, &RUN) {
            let found = format!("its first message is a {} on {}", first.channel.schema, first.channel.topic);
            return Err(RecordingError::Foreign { path: place(), found });
        }
        let header = read_header(&first.data);
        let header = header.map_err(|error| RecordingError::Header { path: place(), error })?;
        Ok(RecordingReader {
            bag,
            header,
            unpacker: StepUnpacker::default(),
            channels: BTreeMap::new(),
            end: None,
            fault: None,
        })
    }

    /// What was run.
    pub fn header(&self) -> &RunHeader {
        &self.header
    }

    /// How the run ended, a word and more for people; none before the end, and in a file that was cut off.
    pub fn run_end(&self) -> Option<&(String, String)> {
        self.end.as_ref()
    }

    /// What is wrong with the file, once it was read: it was cut off, or it is damaged.
    pub fn damage(&self) -> Option<String> {
        match (&self.fault, self.bag.end()) {
            (Some(fault), _) => Some(format!("a message is damaged: {fault}")),
            (None, Some(BagEnd::Damaged(reason))) => Some(format!("the file is damaged: {reason}")),
            (None, Some(BagEnd::Cut)) => Some("the file is cut off".to_owned()),
            (None, Some(BagEnd::Whole)) if self.end.is_none() => {
                Some("the end of the run is missing".to_owned())
            }
            _ => None,
        }
    }

    /// The next step. What stands behind the last mark of a file that was cut off belongs to no step and is left out.
    pub fn next_step(&mut self) -> Option<RecordedStep> {
        let (mut step, mut copies) = (RecordedStep::default(), Vec::new());
        while self.fault.is_none() && self.end.is_none() {
            let message = self.bag.next()?;
            let taken = if is_of(&message, &PACKED_STEP) {
                self.unpack(&message, &std::mem::take(&mut copies), &mut step)
            } else if is_of(&message, &LASER_SCAN) || is_of(&message, &POINT_CLOUD) {
                copies.push(message.data);
                Ok(())
            } else {
                self.take(message, &mut step)
            };
            self.fault = taken.err();
            if step.mark.is_some() {
                return Some(step);
            }
        }
        (self.fault.is_none() && !step.messages.is_empty()).then_some(step)
    }

    /// Reads all messages of a step.
    fn unpack(
        &mut self,
        packed: &BagMessage,
        copies: &[Vec<u8>],
        step: &mut RecordedStep,
    ) -> Result<(), CdrError> {
        let (mut unpacker, log_time) = (std::mem::take(&mut self.unpacker), packed.log_time);
        let mut cdr = CdrReader::new(&packed.data)?;
        let unpacked = unpacker.unpack(cdr.octets()?, copies, |said, data| {
            let channel = self.channel(said);
            self.take(BagMessage { channel, log_time, data }, step)
        });
        self.unpacker = unpacker;
        unpacked
    }

    /// The topic that a message of a packed step would have alone.
    fn channel(&mut self, said: Said) -> Arc<BagChannel> {
        let sensors = &self.header.sensors;
        let new = || {
            let (topic, schema) = (said.topic(sensors), said.layout().name.to_owned());
            Arc::new(BagChannel { topic, schema, encoding: "cdr".to_owned() })
        };
        self.channels.entry(said).or_insert_with(new).clone()
    }

    /// Reads a message into the step if it belongs to one.
    fn take(&mut self, message: BagMessage, step: &mut RecordedStep) -> Result<(), CdrError> {
        let (schema, data) = (message.channel.schema.as_str(), &message.data);
        if let Some(kind) = observation_kind(schema) {
            step.observations.push(read_observation(kind, data)?);
        } else if schema == COMMAND.name {
            step.is_actuated = Some(read_command(data)?.1);
        } else if schema == EVENT.name {
            step.events.push(read_event(data)?);
        } else if schema == ORDER.name {
            step.orders.push(read_order(data)?);
        } else if schema == STEP.name {
            step.mark = Some(read_step(data)?);
        } else if schema == END.name {
            self.end = Some(read_end(data)?);
            return Ok(());
        }
        if schema.starts_with("rumbo_msgs/") {
            step.messages.push(message);
        }
        Ok(())
    }
}
