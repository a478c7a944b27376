//! How sure a tracker may be of itself.

use rumbo_core::messages::Status;

/// When a robot counts as lost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurenessRules {
    /// A position that is less sure than this finds its landmarks no more, meters.
    pub deviation_m: f64,
    /// A scan that agrees with the map on a smaller share of its beams is from elsewhere.
    pub least_explained: f64,
}

/// What a scan gave.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    /// Landmarks that are related to known ones and may be what they seem.
    pub n_related: usize,
    /// Share of beams that the map explains; none where the map says nothing.
    pub explained: Option<f64>,
    /// Largest standard deviation of the position afterwards, meters.
    pub deviation_m: f64,
}

/// What was seen lately.
#[derive(Debug, Clone, PartialEq)]
pub struct Sureness {
    rules: SurenessRules,
    n_starved: u32,
    n_starved_ever: u64,
    n_unlike: u32,
    is_lost: bool,
}

/// Fewer related landmarks than this fix no pose (section 5.5 of the source).
pub const LEAST_RELATED: usize = 2;
/// So many starved scans in a row, and tracking is degraded.
const DEGRADED_AFTER: u32 = 3;
/// So many starved scans in a row, and an unsure position is none.
const LOST_AFTER_STARVED: u32 = 10;
/// So many scans in a row that are unlike the map, and the robot is elsewhere: a crowd has gone by then.
const LOST_AFTER_UNLIKE: u32 = 20;

impl Sureness {
    /// Nothing seen yet.
    pub fn new(rules: SurenessRules) -> Sureness {
        Sureness { rules, n_starved: 0, n_starved_ever: 0, n_unlike: 0, is_lost: false }
    }

    /// Takes in what a scan gave. A lost robot stays lost: what it takes for landmarks may be others.
    pub fn judge(&mut self, look: &Look) {
        let is_starved = look.n_related < LEAST_RELATED;
        self.n_starved = if is_starved { self.n_starved.saturating_add(1) } else { 0 };
        self.n_starved_ever += u64::from(is_starved);
        if let Some(share) = look.explained {
            let is_unlike = share < self.rules.least_explained;
            self.n_unlike = if is_unlike { self.n_unlike.saturating_add(1) } else { 0 };
        }
        let is_adrift = self.n_starved >= LOST_AFTER_STARVED && look.deviation_m > self.rules.deviation_m;
        self.is_lost |= is_adrift || self.n_unlike >= LOST_AFTER_UNLIKE;
    }

    /// Scans ever that had fewer than two related landmarks.
    pub fn n_starved_ever(&self) -> u64 {
        self.n_starved_ever
    }

    /// The pose comes from the odometry alone for some time (converging: the next landmarks decide), or is no more.
    pub fn status(&self) -> Status {
        match self.is_lost {
            true => Status::Lost,
            false if self.n_starved >= DEGRADED_AFTER => Status::Converging,
            false => Status::Tracking,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RULES: SurenessRules = SurenessRules { deviation_m: 0.3, least_explained: 0.3 };

    fn after(n: u32, look: &Look) -> Sureness {
        let mut sureness = Sureness::new(RULES);
        (0..n).for_each(|_| sureness.judge(look));
        sureness
    }

    #[test]
    fn three_starved_scans_in_a_row_degrade_tracking_and_ten_lose_a_position_that_is_unsure() {
        let starved = Look { n_related: 1, explained: None, deviation_m: 0.1 };
        let fed = Look { n_related: 2, ..starved };
        assert_eq!(after(2, &starved).status(), Status::Tracking);
        assert_eq!(after(3, &starved).status(), Status::Converging);
        assert_eq!(after(50, &starved).status(), Status::Converging, "the odometry is still good");
        let mut sureness = after(5, &starved);
        sureness.judge(&fed);
        assert_eq!((sureness.status(), sureness.n_starved_ever()), (Status::Tracking, 5));
        let unsure = Look { deviation_m: 0.31, ..starved };
        assert_eq!(after(9, &unsure).status(), Status::Converging);
        let mut lost = after(10, &unsure);
        lost.judge(&fed);
        assert_eq!(lost.status(), Status::Lost, "until it is told where it is");
    }

    #[test]
    fn scans_unlike_the_map_lose_the_robot_unless_one_in_between_is_like_it() {
        let unlike = Look { n_related: 5, explained: Some(0.2), deviation_m: 0.01 };
        assert_eq!(after(LOST_AFTER_UNLIKE - 1, &unlike).status(), Status::Tracking);
        assert_eq!(after(LOST_AFTER_UNLIKE, &unlike).status(), Status::Lost);
        let mut sureness = after(LOST_AFTER_UNLIKE - 1, &unlike);
        sureness.judge(&Look { explained: Some(0.4), ..unlike });
        sureness.judge(&Look { explained: None, ..unlike });
        sureness.judge(&unlike);
        assert_eq!(sureness.status(), Status::Tracking);
    }
}
