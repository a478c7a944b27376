//! What was seen a moment ago where no sensor looks now: a robot with one camera ahead turns beside what it cannot see.
//!
//! Valverde Moreno (2015), section 6, names the blind sides of its robot as what makes it touch things; here what left the
//! view is kept for some seconds in the odometer's frame, and dropped where a sensor looks again. What a sensor looks at and
//! cannot read any more counts as seen: depth cameras read nothing nearer than about half a meter, which is where a robot
//! must turn.

use crate::near_points::NearPoint;
use crate::view::{Viewed, Word};
use rumbo_core::frames::{Point2, Pose2};
use rumbo_core::time::{Span, Time};

/// A point that left the view.
#[derive(Debug, Clone, Copy)]
struct Remembered {
    in_odom: Point2,
    stamp: Time,
    is_sound: bool,
    /// A sensor looks there and has no reading.
    is_unread: bool,
}

/// Points that left the view.
#[derive(Debug)]
pub struct ShortMemory {
    keep: Span,
    keep_m: f64,
    points: Vec<Remembered>,
}

impl ShortMemory {
    /// Points that are nearer to each other are one, meters.
    const APART_M: f64 = 0.04;
    /// More points than this are not kept; the oldest go first.
    const MOST: usize = 512;

    /// Nothing remembered; points are kept for `keep` and within `keep_m` of the base.
    pub fn new(keep: Span, keep_m: f64) -> ShortMemory {
        ShortMemory { keep, keep_m, points: Vec::with_capacity(Self::MOST) }
    }

    /// A sensor looks: what it sees, or sees through, needs no memory, and what it cannot read is as good as seen. Sound
    /// misses what light sees, and the other way around, so that each judges its own.
    pub fn look(&mut self, stamp: Time, viewed: &Viewed<'_>, base_from_odom: &Pose2, is_sound: bool) {
        self.points.retain_mut(|old| {
            if old.is_sound != is_sound {
                return true;
            }
            let word = viewed.says_of(base_from_odom * old.in_odom);
            old.is_unread = word == Word::Unread;
            old.stamp = if old.is_unread { old.stamp.max(stamp) } else { old.stamp };
            word != Word::Told
        });
    }

    /// A point of the reading before: kept where the new reading does not show what became of it.
    pub fn leave(
        &mut self,
        in_odom: Point2,
        stamp: Time,
        viewed: &Viewed<'_>,
        base_from_odom: &Pose2,
        is_sound: bool,
    ) {
        let word = viewed.says_of(base_from_odom * in_odom);
        if self.keep <= Span::from_secs(0.0) || word == Word::Told {
            return;
        }
        let is_unread = word == Word::Unread;
        let old = self.points.iter_mut().find(|old| {
            old.is_sound == is_sound && (old.in_odom - in_odom).norm_squared() < Self::APART_M.powi(2)
        });
        if let Some(old) = old {
            (old.stamp, old.is_unread) = (old.stamp.max(stamp), is_unread);
            return;
        }
        if self.points.len() == Self::MOST {
            let oldest = self.points.iter().enumerate().min_by_key(|(_, old)| old.stamp);
            if let Some((at, _)) = oldest {
                self.points.swap_remove(at);
            }
        }
        self.points.push(Remembered { in_odom, stamp, is_sound, is_unread });
    }

    /// Drops what is old or far.
    pub fn age(&mut self, now: Time, base_from_odom: &Pose2) {
        let (keep, keep_m) = (self.keep, self.keep_m);
        self.points
            .retain(|old| now - old.stamp <= keep && (base_from_odom * old.in_odom).coords.norm() <= keep_m);
    }

    /// What is remembered, in the base frame: what a sensor looks at and cannot read, or the rest.
    pub fn points<'a>(
        &'a self,
        base_from_odom: &'a Pose2,
        is_unread: bool,
    ) -> impl Iterator<Item = NearPoint> + 'a {
        let points = self.points.iter().filter(move |old| old.is_unread == is_unread);
        points.map(move |old| NearPoint {
            in_base: base_from_odom * old.in_odom,
            stamp: old.stamp,
            is_remembered: !is_unread,
        })
    }
}
