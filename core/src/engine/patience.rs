//! Before a goal is given up: whoever walks by closes the way for some seconds only.

use crate::time::{Span, Time};

/// How long the robot has been standing without a way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Patience {
    limit: Span,
    since: Option<Time>,
    ask_at: Option<Time>,
}

impl Patience {
    /// Between two questions, seconds.
    const ASK_AGAIN_S: f64 = 1.0;

    /// Waits this long, seconds.
    pub fn of(limit_s: f64) -> Patience {
        Patience { limit: Span::from_secs(limit_s), since: None, ask_at: None }
    }

    /// There is a way, or another goal.
    pub fn renew(&mut self) {
        (self.since, self.ask_at) = (None, None);
    }

    /// No way was found. Since when there has been none, while it is worth to ask again.
    pub fn no_way(&mut self, now: Time) -> Option<Time> {
        let since = *self.since.get_or_insert(now);
        let is_patient = now - since < self.limit;
        self.ask_at = is_patient.then(|| now + Span::from_secs(Self::ASK_AGAIN_S));
        is_patient.then_some(since)
    }

    /// It is time to ask again: since when there has been no way.
    pub fn take_due(&mut self, now: Time) -> Option<Time> {
        self.ask_at.take_if(|at| *at <= now)?;
        self.since
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_asks_every_second_until_the_limit_and_a_way_renews_it() {
        let at = Time::from_secs;
        let mut patience = Patience::of(2.5);
        assert_eq!(patience.take_due(at(1.0)), None, "nobody waits");
        assert_eq!(patience.no_way(at(5.0)), Some(at(5.0)));
        assert_eq!((patience.take_due(at(5.9)), patience.take_due(at(6.0))), (None, Some(at(5.0))));
        assert_eq!(patience.take_due(at(6.0)), None, "once");
        assert_eq!(patience.no_way(at(6.0)), Some(at(5.0)));
        patience.renew();
        assert_eq!((patience.take_due(at(9.0)), patience.no_way(at(9.0))), (None, Some(at(9.0))));
        assert_eq!((patience.no_way(at(11.5)), patience.take_due(at(20.0))), (None, None));
        assert_eq!(Patience::of(0.0).no_way(at(1.0)), None);
    }
}
