//! `--record`: writes a run down as it happens, so that it can be looked at and repeated.

use crate::exit::Failure;
use crate::load::Ready;
use crate::terminal::make_folder_of;
use rumbo_core::engine::{Engine, Observer, RunEnd, StepView};
use rumbo_core::pipeline::Pipeline;
use rumbo_core::time::{Span, Time};
use rumbo_kit::recording::layout::{END, PACKED_STEP, RUN};
use rumbo_kit::recording::{
    BagWriter, RunHeader, StepEncoder, StepPacker, TopicId, ViewerCopies, hash_of, put_end, put_header,
};
use std::fs::File;
use std::io::{self, Write};
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

/// A recording that grows. What goes wrong is kept until the end: a full disk stops no robot.
pub struct RunRecording<W: Write = File> {
    bag: BagWriter<W>,
    steps: TopicId,
    encoder: StepEncoder,
    packer: StepPacker,
    viewers: ViewerCopies,
    sensors: Vec<String>,
    last_step: Option<u64>,
    last_now: Time,
    fault: Option<String>,
}

impl RunRecording {
    /// Begins a recording in a file.
    pub fn create(path: &Path, header: &RunHeader) -> Result<RunRecording, Failure> {
        make_folder_of(path)?;
        let begun = BagWriter::create(path).and_then(|bag| RunRecording::new(bag, header));
        begun.map_err(|fault| Failure::Internal(format!("cannot write {}: {fault}", path.display())))
    }
}

impl<W: Write> RunRecording<W> {
    /// What a world that only computes may lose when the program is killed: running it again brings it back.
    const LONGEST_COMPUTED: Span = Span(60_000_000_000);

    /// Begins a recording in a bag.
    pub fn new(mut bag: BagWriter<W>, header: &RunHeader) -> io::Result<RunRecording<W>> {
        if !header.is_real_time {
            bag = bag.close_after(Self::LONGEST_COMPUTED);
        }
        let run = bag.topic("/rumbo/run", &RUN)?;
        bag.write_with(run, header.started, |cdr| put_header(cdr, header))?;
        let steps = bag.topic("/rumbo/step", &PACKED_STEP)?;
        Ok(RunRecording {
            bag,
            steps,
            encoder: StepEncoder::default(),
            packer: StepPacker::default(),
            viewers: ViewerCopies::default(),
            sensors: header.sensors.clone(),
            last_step: None,
            last_now: header.started,
            fault: None,
        })
    }

    /// Closes the recording; `view` is how the run left the engine.
    pub fn finish(mut self, end: &RunEnd, view: &StepView<'_>) -> Result<W, Failure> {
        let closed = match self.fault.take() {
            Some(fault) => Err(fault),
            None => self.close(end, view).map_err(|fault| fault.to_string()),
        };
        closed.map_err(|fault| Failure::Internal(format!("the recording is incomplete: {fault}")))
    }

    /// Closes the recording of a run that stands in the middle of a step: the map is in its hands.
    pub fn cut_off(self, end: &RunEnd) -> io::Result<W> {
        finish_bag(self.bag, end, self.last_now)
    }

    fn close(self, end: &RunEnd, view: &StepView<'_>) -> io::Result<W> {
        let RunRecording { mut bag, steps, mut encoder, mut packer, mut viewers, .. } = self;
        bag.write_with(steps, view.now, |cdr| {
            encoder.map(view.map, &mut |said, message| packer.add(said, message, None, cdr));
            packer.finish(cdr);
        })?;
        viewers.map(&mut bag, view)?;
        finish_bag(bag, end, view.now)
    }

    fn write(&mut self, view: &StepView<'_>) -> io::Result<()> {
        self.last_now = view.now;
        let RunRecording { bag, encoder, packer, viewers, .. } = self;
        let is_new = self.last_step.replace(view.step) != Some(view.step);
        // Readings are written for viewers first: the step says where they stand.
        if is_new {
            viewers.observations(bag, view, &self.sensors)?;
        }
        bag.write_with(self.steps, view.now, |cdr| {
            encoder.encode_beside(viewers.copies(), view, &mut |said, message, copy| {
                packer.add(said, message, copy, cdr);
            });
            packer.finish(cdr);
        })?;
        if is_new {
            viewers.write(bag, view)?
        } else {
            viewers.events(bag, view)?
        }
        bag.rest(view.now)
    }
}

/// Writes how the run ended, and closes the bag.
fn finish_bag<W: Write>(mut bag: BagWriter<W>, end: &RunEnd, now: Time) -> io::Result<W> {
    let topic = bag.topic("/rumbo/end", &END)?;
    let (reason, detail) = (end.reason.to_string(), end.detail.as_deref().unwrap_or_default());
    bag.write_with(topic, now, |cdr| put_end(cdr, &reason, detail))?;
    bag.finish()
}

impl<W: Write> Observer for RunRecording<W> {
    fn on_step(&mut self, view: &StepView<'_>) {
        if self.fault.is_none() {
            self.fault = self.write(view).err().map(|fault| fault.to_string());
        }
    }
}
