//! Debug drawings and counters of a stage: free when nobody looks.

use crate::frames::Point2;
use std::cell::RefCell;

/// Something to draw in the map's frame.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Drawing {
    /// A chain of straight pieces.
    Polyline {
        /// What it shows.
        name: &'static str,
        /// Its points.
        points: Vec<Point2>,
    },
    /// Single points.
    Points {
        /// What they show.
        name: &'static str,
        /// The points.
        points: Vec<Point2>,
    },
}

/// What a stage wants to show of its insides.
#[derive(Debug, Default)]
pub struct Trace {
    watched: bool,
    counting: bool,
    drawings: RefCell<Vec<Drawing>>,
    counters: RefCell<Vec<(&'static str, f64)>>,
}

impl Trace {
    /// A trace that keeps nothing.
    pub fn unwatched() -> Trace {
        Trace::default()
    }

    /// A trace that keeps everything until it is taken.
    pub fn watched() -> Trace {
        Trace { watched: true, counting: true, ..Trace::default() }
    }

    /// A trace that keeps counters and no drawings.
    pub fn counting() -> Trace {
        Trace { counting: true, ..Trace::default() }
    }

    /// A trace like this one, with nothing in it.
    pub fn fresh(&self) -> Trace {
        Trace { watched: self.watched, counting: self.counting, ..Trace::default() }
    }

    /// Somebody looks: worth preparing drawings.
    pub fn is_watched(&self) -> bool {
        self.watched
    }

    /// Counters are kept.
    pub fn is_counting(&self) -> bool {
        self.counting
    }

    /// Keeps what `drawing` makes, if somebody looks.
    pub fn draw(&self, drawing: impl FnOnce() -> Drawing) {
        if self.watched {
            self.drawings.borrow_mut().push(drawing());
        }
    }

    /// Keeps a number, if somebody looks.
    pub fn count(&self, name: &'static str, value: f64) {
        if self.counting {
            self.counters.borrow_mut().push((name, value));
        }
    }

    /// Takes everything out.
    pub fn take(&self) -> (Vec<Drawing>, Vec<(&'static str, f64)>) {
        (self.drawings.take(), self.counters.take())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unwatched_trace_never_calls_the_drawing() {
        Trace::unwatched().draw(|| panic!("called"));
        let trace = Trace::watched();
        trace.draw(|| Drawing::Points { name: "hits", points: vec![Point2::new(1.0, 2.0)] });
        trace.count("n", 3.0);
        let (drawings, counters) = trace.take();
        assert_eq!((drawings.len(), counters), (1, vec![("n", 3.0)]));
        assert!(trace.take().0.is_empty());
        let trace = Trace::counting();
        trace.draw(|| panic!("called"));
        trace.count("n", 4.0);
        assert_eq!(trace.take(), (vec![], vec![("n", 4.0)]));
    }
}
