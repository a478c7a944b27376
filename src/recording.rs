//! `--record`: writes a run down as it happens, so that it can be looked at and repeated.

use crate::exit::Failure;
use crate::load::Ready;
use crate::terminal::make_folder_of;
use rumbo_core::engine::{Engine, Observer, RunEnd, StepView};
use rumbo_core::pipeline::Pipeline;
use rumbo_core::time::Time;
use rumbo_kit::recording::cdr::CdrWriter;
use rumbo_kit::recording::layout::{END, RUN};
use rumbo_kit::recording::{
    BagWriter, RunHeader, Said, StepEncoder, TopicId, ViewerCopies, hash_of, put_end, put_header,
};
use std::fmt::Display;
use std::fs::File;
use std::io::{BufWriter, Seek, Write};
use std::path::{Path, PathBuf};

/// Name and version of this program.
pub const PROGRAM: &str = concat!("rumbo ", env!("CARGO_PKG_VERSION"));

/// What is run, from what was loaded and built.
pub fn header_of(ready: &Ready, file: &Path, duration_s: Option<f64>, engine: &Engine) -> RunHeader {
    let world = engine.world();
    let map_file = world.map_file().map(PathBuf::from);
    RunHeader {
        program: PROGRAM.to_owned(),
        file: file.display().to_string(),
        pipeline: ready.config.clone(),
        plugins: plugins_of(&ready.pipeline),
        sensors: ready.pipeline.sensors.iter().map(|sensor| sensor.stage.name.clone()).collect(),
        duration_s,
        started: world.now(),
        is_recording: world.next_recorded().is_some(),
        is_real_time: world.is_real_time(),
        start: world.start(),
        map_file_hash: map_file.as_deref().map_or(0, file_hash),
        map_file,
        recording_file: world.recording_file().map(PathBuf::from),
    }
}

/// Tells whether a file is still the same; zero where it cannot be read.
pub fn file_hash(path: &Path) -> u64 {
    std::fs::read(path).map_or(0, |bytes| hash_of(&bytes))
}

/// Every plugin of the pipeline with its version.
pub fn plugins_of(pipeline: &Pipeline) -> Vec<String> {
    let world = std::iter::once(&pipeline.world);
    world.chain(pipeline.stages()).map(|stage| format!("{}: {:?}", stage.name, stage.entry)).collect()
}

/// A bag and the topics that were opened in it.
struct Topics<W: Write + Seek> {
    bag: BagWriter<W>,
    sensors: Vec<String>,
    open: Vec<(Said, TopicId)>,
}

impl<W: Write + Seek> Topics<W> {
    /// Writes one message; its topic is opened when it is first used.
    fn say(&mut self, said: Said, now: Time, message: &[u8]) -> Result<(), String> {
        let known = self.open.iter().find(|(known, _)| *known == said).map(|(_, topic)| *topic);
        let topic = match known {
            Some(topic) => topic,
            None => {
                let topic = self.bag.topic(&said.topic(&self.sensors), &said.layout()).map_err(in_words)?;
                self.open.push((said, topic));
                topic
            }
        };
        self.bag.write(topic, now, message).map_err(in_words)
    }
}

fn in_words(error: impl Display) -> String {
    error.to_string()
}

/// A recording that grows. What goes wrong is kept until the end: a full disk stops no robot.
pub struct RunRecording<W: Write + Seek = BufWriter<File>> {
    topics: Topics<W>,
    encoder: StepEncoder,
    viewers: ViewerCopies,
    last_step: Option<u64>,
    fault: Option<String>,
}

impl RunRecording {
    /// Begins a recording in a file.
    pub fn create(path: &Path, header: &RunHeader) -> Result<RunRecording, Failure> {
        make_folder_of(path)?;
        let bag = BagWriter::create(path).map_err(in_words);
        let begun = bag.and_then(|bag| RunRecording::new(bag, header));
        begun.map_err(|fault| Failure::Internal(format!("cannot write {}: {fault}", path.display())))
    }
}

impl<W: Write + Seek> RunRecording<W> {
    /// Begins a recording in a bag.
    pub fn new(mut bag: BagWriter<W>, header: &RunHeader) -> Result<RunRecording<W>, String> {
        let mut cdr = CdrWriter::default();
        put_header(&mut cdr, header);
        let run = bag.topic("/rumbo/run", &RUN).map_err(in_words)?;
        bag.write(run, header.started, cdr.bytes()).map_err(in_words)?;
        Ok(RunRecording {
            topics: Topics { bag, sensors: header.sensors.clone(), open: Vec::new() },
            encoder: StepEncoder::default(),
            viewers: ViewerCopies::default(),
            last_step: None,
            fault: None,
        })
    }

    /// Closes the recording; `view` is how the run left the engine.
    pub fn finish(mut self, end: &RunEnd, view: &StepView<'_>) -> Result<W, Failure> {
        let closed = match self.fault.take() {
            Some(fault) => Err(fault),
            None => self.close(end, view),
        };
        closed.map_err(|fault| Failure::Internal(format!("the recording is incomplete: {fault}")))
    }

    fn close(self, end: &RunEnd, view: &StepView<'_>) -> Result<W, String> {
        let RunRecording { mut topics, mut encoder, mut viewers, .. } = self;
        let mut kept = Ok(());
        encoder.map(view.map, &mut |said, message| kept = topics.say(said, view.now, message));
        kept?;
        viewers.map(&mut topics.bag, view).map_err(in_words)?;
        let mut cdr = CdrWriter::default();
        put_end(&mut cdr, &end.reason.to_string(), end.detail.as_deref().unwrap_or_default());
        let topic = topics.bag.topic("/rumbo/end", &END).map_err(in_words)?;
        topics.bag.write(topic, view.now, cdr.bytes()).map_err(in_words)?;
        topics.bag.finish().map_err(in_words)
    }

    fn write(&mut self, view: &StepView<'_>) -> Result<(), String> {
        let (topics, mut kept) = (&mut self.topics, Ok(()));
        self.encoder.encode(view, &mut |said, message| {
            if kept.is_ok() {
                kept = topics.say(said, view.now, message);
            }
        });
        kept?;
        let Topics { bag, sensors, .. } = topics;
        let is_new = self.last_step.replace(view.step) != Some(view.step);
        let copied =
            if is_new { self.viewers.write(bag, view, sensors) } else { self.viewers.events(bag, view) };
        copied.and_then(|()| bag.rest(view.now)).map_err(in_words)
    }
}

impl<W: Write + Seek> Observer for RunRecording<W> {
    fn on_step(&mut self, view: &StepView<'_>) {
        if self.fault.is_none() {
            self.fault = self.write(view).err();
        }
    }
}
