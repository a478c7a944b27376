//! What a stage is given: once when it is built, and at every call.

use super::GiveUp;
use crate::frames::Pose3;
use crate::map::Layer;
use crate::rng::{self, Rng};
use crate::robot::Robot;
use crate::time::{Span, Time};
use crate::trace::Trace;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, TryRecvError, channel};
use std::time::Duration;

/// What every call gets: the time, and somewhere to draw.
#[derive(Debug)]
pub struct Cx<'a> {
    /// The time it is: the only clock a plugin may read.
    pub now: Time,
    /// Debug drawings and counters.
    pub trace: &'a Trace,
}

/// What a stage may know when it is built.
#[derive(Debug, Clone)]
pub struct BuildContext {
    /// Name of this instance: the sensor's name, else the section's.
    pub name: String,
    /// Which sensor this is, in the order of the file; zero for other stages.
    pub sensor: crate::messages::SensorId,
    /// The robot.
    pub robot: Arc<Robot>,
    /// Where a sensor sits.
    pub base_from_sensor: Pose3,
    /// How often the stage will run; absent where the engine decides from event to event.
    pub rate_hz: Option<f64>,
    /// Seed of the run; use [`rng`](Self::rng).
    pub seed: u64,
    /// Folder that relative paths start from: the pipeline file's.
    pub folder: PathBuf,
    /// The map that belongs to the world.
    pub world_map: Option<PathBuf>,
    /// The recording that the world plays.
    pub world_recording: Option<PathBuf>,
    /// Layers that some stage of this pipeline needs.
    pub wanted_layers: Vec<Layer>,
    /// A check only: touch no device and start no thread.
    pub dry_run: bool,
    /// Runs slow work beside the step.
    pub background: Background,
}

impl BuildContext {
    /// A context for a plugin built outside a pipeline: tests, examples, benches.
    pub fn bare(name: &str) -> BuildContext {
        BuildContext {
            name: name.to_owned(),
            sensor: crate::messages::SensorId(0),
            robot: Arc::new(Robot::default()),
            base_from_sensor: Pose3::identity(),
            rate_hz: None,
            seed: 0,
            folder: PathBuf::from("."),
            world_map: None,
            world_recording: None,
            wanted_layers: Vec::new(),
            dry_run: false,
            background: Background::inline(Span::ZERO),
        }
    }

    /// This instance's own random stream.
    pub fn rng(&self) -> Rng {
        rng::stream(self.seed, &self.name)
    }

    /// A path as the pipeline file means it.
    pub fn resolve(&self, path: impl AsRef<Path>) -> PathBuf {
        self.folder.join(path)
    }
}

/// Why a plugin cannot be built: which of its keys, what is wrong, what to do.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct BuildError {
    /// Key inside the plugin's section, such as `weights[2]`; empty for the section itself.
    pub path: String,
    /// What was found and what was expected.
    pub message: String,
    /// What to do.
    pub help: Option<String>,
}

impl BuildError {
    /// A fault of one key.
    pub fn at(path: impl Into<String>, message: impl Into<String>) -> BuildError {
        BuildError { path: path.into(), message: message.into(), help: None }
    }

    /// The same with advice.
    pub fn help(mut self, help: impl Into<String>) -> BuildError {
        self.help = Some(help.into());
        self
    }
}

/// Where slow work runs: at once and in the step where time is simulated, on a thread of its own where time is real.
#[derive(Debug, Clone)]
pub struct Background {
    threaded: bool,
    latency: Span,
    abort: GiveUp,
}

impl Background {
    /// Work is done at once; its result is held back for `latency` of virtual time.
    pub fn inline(latency: Span) -> Background {
        Background { threaded: false, latency, abort: GiveUp::default() }
    }

    /// Work runs on its own thread.
    pub fn threaded() -> Background {
        Background { threaded: true, latency: Span::ZERO, abort: GiveUp::default() }
    }

    /// The same, with all its jobs given up when `abort` is raised.
    pub fn under(mut self, abort: &GiveUp) -> Background {
        self.abort = abort.clone();
        self
    }

    /// Work runs on its own thread.
    pub(crate) fn is_threaded(&self) -> bool {
        self.threaded
    }

    /// How long inline results are held back.
    pub(crate) fn latency(&self) -> Span {
        self.latency
    }

    /// Raised when all jobs shall stop.
    pub(crate) fn abort(&self) -> &GiveUp {
        &self.abort
    }

    /// Starts `work` at the time `now`.
    pub fn run<T: Send + 'static>(
        &self,
        now: Time,
        work: impl FnOnce(&GiveUp) -> T + Send + 'static,
    ) -> BackgroundJob<T> {
        let give_up = self.abort.child();
        if !self.threaded {
            let due = now + self.latency;
            return BackgroundJob {
                give_up: give_up.clone(),
                state: State::Held { due, result: Some(work(&give_up)) },
            };
        }
        let (sender, receiver) = channel();
        let flag = give_up.clone();
        let thread = std::thread::spawn(move || {
            // Nobody listens any more when the job was dropped: then the result is not wanted either.
            let _ = sender.send(work(&flag));
        });
        BackgroundJob { give_up, state: State::Running { receiver, thread: Some(thread) } }
    }
}

/// Work that was asked to stop is waited for this long.
const LONGEST_STOP: Duration = Duration::from_secs(5);

/// Slow work on its way.
#[derive(Debug)]
pub struct BackgroundJob<T> {
    give_up: GiveUp,
    state: State<T>,
}

#[derive(Debug)]
enum State<T> {
    Held { due: Time, result: Option<T> },
    Running { receiver: Receiver<T>, thread: Option<std::thread::JoinHandle<()>> },
}

impl<T> BackgroundJob<T> {
    /// The result, once, when it is due; an error when the work panicked.
    pub fn poll(&mut self, now: Time) -> Result<Option<T>, JobPanicked> {
        match &mut self.state {
            State::Held { due, result } => Ok(if now >= *due { result.take() } else { None }),
            State::Running { receiver, .. } => match receiver.try_recv() {
                Ok(result) => Ok(Some(result)),
                Err(TryRecvError::Empty) => Ok(None),
                Err(TryRecvError::Disconnected) => Err(JobPanicked),
            },
        }
    }

    /// When an inline result is due.
    pub fn due(&self) -> Option<Time> {
        match &self.state {
            State::Held { due, result: Some(_) } => Some(*due),
            _ => None,
        }
    }

    /// Asks the work to stop.
    pub fn give_up(&self) {
        self.give_up.raise();
    }

    /// Goes on without work that does not stop: nobody waits for its thread, which ends with the process.
    pub fn abandon(mut self) {
        if let State::Running { thread, .. } = &mut self.state {
            *thread = None;
        }
    }
}

impl<T> Drop for BackgroundJob<T> {
    fn drop(&mut self) {
        self.give_up.raise();
        if let State::Running { thread, receiver } = &mut self.state
            && let Some(thread) = thread.take()
        {
            // Work that does not stop must not keep a run from ending: its thread ends with the process.
            let has_ended = !matches!(receiver.recv_timeout(LONGEST_STOP), Err(RecvTimeoutError::Timeout));
            if has_ended {
                // A panic inside was either reported by `poll` or is of no interest to anybody now.
                let _ = thread.join();
            }
        }
    }
}

/// The work of a background job panicked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the background work panicked")]
pub struct JobPanicked;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_inline_result_arrives_after_its_latency_and_only_once() {
        let mut job = Background::inline(Span::from_secs(0.5)).run(Time::from_secs(1.0), |_| 42);
        assert_eq!(job.poll(Time::from_secs(1.4)), Ok(None));
        assert_eq!(job.due(), Some(Time::from_secs(1.5)));
        assert_eq!(job.poll(Time::from_secs(1.5)), Ok(Some(42)));
        assert_eq!(job.poll(Time::from_secs(2.0)), Ok(None));
    }

    #[test]
    fn threaded_work_obeys_give_up_and_is_joined_when_dropped() {
        let mut job = Background::threaded().run(Time::ZERO, |give_up| {
            while !give_up.is_raised() {
                std::thread::yield_now();
            }
            7
        });
        assert_eq!(job.poll(Time::ZERO), Ok(None));
        job.give_up();
        let found = loop {
            if let Some(found) = job.poll(Time::ZERO).unwrap() {
                break found;
            }
            std::thread::yield_now();
        };
        assert_eq!(found, 7);
        drop(Background::threaded().run(Time::ZERO, |give_up| while !give_up.is_raised() {}));
    }
}
