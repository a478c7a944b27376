//! What the thread that owns a device's port tells the sensor: readings, or why there are none.

use std::collections::VecDeque;
use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, MutexGuard, PoisonError};

use rumbo_core::time::{Span, Time};

/// Readings that wait for the sensor to be polled; the oldest go first. More than devices give in three seconds.
const MOST_WAITING: usize = 256;

/// After so long without readings the sensor does not only say so once, but fails each time that it is asked: the run
/// ends, if nobody mends it. Finding a device that was unplugged takes less.
const PATIENCE: Span = Span(10_000_000_000);

/// What thread and sensor share.
#[derive(Debug)]
pub(crate) struct Shared<T> {
    /// The thread shall end.
    pub shall_stop: AtomicBool,
    news: Mutex<News<T>>,
}

impl<T> Default for Shared<T> {
    fn default() -> Self {
        Self { shall_stop: AtomicBool::new(false), news: Mutex::new(News::default()) }
    }
}

impl<T> Shared<T> {
    pub fn news(&self) -> MutexGuard<'_, News<T>> {
        // Nothing is left half done in there when somebody panics.
        self.news.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// What there is to tell.
#[derive(Debug)]
pub(crate) struct News<T> {
    waiting: VecDeque<T>,
    /// Why no readings come; nothing while they do.
    trouble: Option<Trouble>,
}

impl<T> Default for News<T> {
    fn default() -> Self {
        Self { waiting: VecDeque::new(), trouble: None }
    }
}

#[derive(Debug, Clone)]
struct Trouble {
    since: Time,
    reason: String,
    is_told: bool,
}

impl<T> News<T> {
    /// A reading has come, and all is well.
    pub fn deliver(&mut self, reading: T) {
        self.trouble = None;
        if self.waiting.len() >= MOST_WAITING {
            self.waiting.pop_front();
        }
        self.waiting.push_back(reading);
    }

    /// Takes what has come, oldest first.
    pub fn take(&mut self) -> VecDeque<T> {
        std::mem::take(&mut self.waiting)
    }

    /// Why no readings come.
    pub fn note(&mut self, now: Time, reason: String) {
        match &mut self.trouble {
            Some(trouble) if trouble.reason == reason => {}
            Some(trouble) => (trouble.reason, trouble.is_told) = (reason, false),
            None => self.trouble = Some(Trouble { since: now, reason, is_told: false }),
        }
    }

    /// What the sensor has to say about it now.
    pub fn complaint(&mut self, now: Time) -> Option<String> {
        let trouble = self.trouble.as_mut()?;
        let is_due = !std::mem::replace(&mut trouble.is_told, true) || now - trouble.since > PATIENCE;
        is_due.then(|| trouble.reason.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trouble_is_told_once_and_again_when_it_lasts() {
        let mut news = News::<u8>::default();
        let at = Time::from_secs;
        assert_eq!(news.complaint(at(0.0)), None);
        news.note(at(1.0), "no port".to_owned());
        assert_eq!(news.complaint(at(1.0)).as_deref(), Some("no port"));
        news.note(at(2.0), "no port".to_owned());
        assert_eq!(news.complaint(at(2.0)), None);
        news.note(at(3.0), "silent".to_owned());
        assert_eq!(news.complaint(at(3.0)).as_deref(), Some("silent"));
        assert_eq!(news.complaint(at(11.0)), None);
        for seconds in [11.1, 11.2] {
            assert_eq!(news.complaint(at(seconds)).as_deref(), Some("silent"), "since 1 s");
        }
        // Scans have come in between.
        news.trouble = None;
        news.note(at(12.0), "silent".to_owned());
        assert!(news.complaint(at(12.0)).is_some() && news.complaint(at(12.1)).is_none());
    }

    #[test]
    fn the_oldest_readings_go_when_nobody_asks() {
        let mut news = News::default();
        (0..300).for_each(|k| news.deliver(k));
        assert_eq!(news.take(), (44..300).collect::<VecDeque<i32>>());
        assert!(news.take().is_empty());
    }
}
