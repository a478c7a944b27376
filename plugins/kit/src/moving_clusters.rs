//! What moves among the things that a level scanner sees: people, mostly.
//!
//! Hits that nothing static explains fall into segments; segments near each other follow one track, a Kalman filter of
//! constant velocity (Bar-Shalom, Li, Kirubarajan 2001, *Estimation with Applications to Tracking and Navigation*,
//! section 6.2.2). A pair of legs is one track, since all segments near its prediction belong to it.
//!
//! A speed alone does not tell who moves: of a thing that stands, a robot that passes sees other parts from moment to
//! moment, and their middle wanders. So a track moves only where its place was swapped with the air as well: light now
//! goes through where it was, or went through where it is. Light never goes through what stands.

mod filter;
mod past;
mod segments;
mod track;

use past::Past;
use rumbo_core::frames::{Point2, Pose2};
use rumbo_core::messages::LaserScan;
use rumbo_core::time::{Span, Time};
use segments::{Segment, segments};
use track::Track;

/// Numbers of the search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MoverTuning {
    /// Hits farther than this from the scanner are of no interest, meters.
    pub reach_m: f64,
    /// What is seen wider than this in one piece is no person, meters.
    pub widest_m: f64,
    /// A segment this near to where a track is predicted belongs to it, meters: a stride must fit.
    pub gate_m: f64,
    /// Slower is standing, m/s.
    pub least_speed_m_s: f64,
    /// Standing for so long, seconds, is not moving any more.
    pub stands_after_s: f64,
    /// A track that nothing has seen for so long is dropped, seconds.
    pub forget_after_s: f64,
    /// Standard deviation of a segment's middle from the body's, meters: legs swing.
    pub middle_deviation_m: f64,
    /// Intensity of the white acceleration, (m/s²)²·s.
    pub agility_m2_s3: f64,
}

impl Default for MoverTuning {
    fn default() -> Self {
        MoverTuning {
            reach_m: 7.0,
            widest_m: 0.8,
            gate_m: 0.6,
            least_speed_m_s: 0.2,
            stands_after_s: 0.8,
            forget_after_s: 1.5,
            middle_deviation_m: 0.12,
            agility_m2_s3: 0.2,
        }
    }
}

/// Something that moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mover {
    /// The same thing has the same number as long as it is followed.
    pub number: u64,
    /// Its middle, in the frame of the scans.
    pub position: Point2,
    /// Its velocity there, m/s.
    pub velocity: nalgebra::Vector2<f64>,
    /// When it was last seen.
    pub seen: Time,
    /// It moves now; else it did and has stopped.
    pub is_moving: bool,
}

impl Mover {
    /// Where it is so much later, if it goes on like this.
    pub fn after(&self, seconds: f64) -> Point2 {
        self.position + self.velocity * seconds
    }
}

/// All that is followed.
#[derive(Debug)]
pub struct MovingClusters {
    tuning: MoverTuning,
    tracks: Vec<Track>,
    past: Past,
    segments: Vec<Segment>,
    n_tracks: u64,
    stamp: Option<Time>,
}

impl MovingClusters {
    /// No more than this is followed: what stands and is on no map is followed too.
    const MOST: usize = 100;
    /// Segments this near to each other begin one track, meters.
    const ONE_BODY_M: f64 = 0.5;
    /// Two tracks nearer than this follow the same body, meters.
    const SAME_M: f64 = 0.3;
    /// Without scans for so long everything is forgotten, seconds.
    const LONGEST_GAP_S: f64 = 2.0;

    /// Nothing seen yet.
    pub fn new(tuning: MoverTuning) -> MovingClusters {
        MovingClusters {
            tuning,
            tracks: Vec::new(),
            past: Past::default(),
            segments: Vec::new(),
            n_tracks: 0,
            stamp: None,
        }
    }

    /// Takes in a scan that was made at `frame_from_sensor`, in a frame that does not jump, such as the odometer's.
    /// `is_static` says which of the frame's points the map explains. A scan that is not newer than the last is no news.
    pub fn see(
        &mut self,
        stamp: Time,
        scan: &LaserScan,
        frame_from_sensor: &Pose2,
        is_static: impl Fn(Point2) -> bool,
    ) {
        let since_s = self.stamp.map_or(0.0, |last| (stamp - last).as_secs());
        if self.stamp.is_some_and(|last| stamp <= last) {
            return;
        }
        if since_s > Self::LONGEST_GAP_S {
            self.tracks.clear();
            self.past.clear();
        }
        self.stamp = Some(stamp);
        self.past.keep(stamp, scan, frame_from_sensor);
        segments(scan, frame_from_sensor, &self.tuning, is_static, &mut self.segments);
        let tuning = self.tuning;
        self.tracks.iter_mut().for_each(|track| track.predict(since_s, &tuning));
        self.associate(stamp);
        self.begin(stamp);
        self.merge();
        let past = &self.past;
        self.tracks.iter_mut().for_each(|track| track.judge(stamp, past, &tuning));
        self.tracks.retain(|track| track.is_alive(stamp, &tuning));
    }

    /// What moves, where it is at `now`; what is hidden for a moment is carried on.
    pub fn movers(&self, now: Time) -> impl Iterator<Item = Mover> {
        self.everybody(now).filter(|mover| mover.is_moving)
    }

    /// What moves, and what did and has stopped.
    pub fn everybody(&self, now: Time) -> impl Iterator<Item = Mover> {
        let ahead_s = self.stamp.map_or(0.0, |stamp| (now - stamp).as_secs().max(0.0));
        let longest = Span::from_secs(self.tuning.forget_after_s);
        self.tracks.iter().filter(move |track| track.has_moved && now - track.seen <= longest).map(
            move |track| {
                let mover = track.mover();
                Mover { position: mover.after(ahead_s), ..mover }
            },
        )
    }

    /// Gives every segment to the nearest track, and every track the middle of its segments.
    fn associate(&mut self, stamp: Time) {
        for segment in &mut self.segments {
            let gate_m = self.tuning.gate_m;
            let off_m = |track: &Track| (track.position() - segment.middle).norm();
            let nearest = self.tracks.iter_mut().min_by(|a, b| off_m(a).total_cmp(&off_m(b)));
            let Some(track) = nearest.filter(|track| (track.position() - segment.middle).norm() <= gate_m)
            else {
                continue;
            };
            track.take(segment.middle);
            segment.is_taken = true;
        }
        let deviation_m = self.tuning.middle_deviation_m;
        self.tracks.iter_mut().for_each(|track| track.update(stamp, deviation_m));
    }

    /// Tracks of what nobody follows yet.
    fn begin(&mut self, stamp: Time) {
        while let Some(idx) = self.segments.iter().position(|segment| !segment.is_taken) {
            let Some(first) = self.segments.get(idx).map(|segment| segment.middle) else { return };
            let mut track = Track::new(self.n_tracks, stamp, first, &self.tuning);
            for segment in self.segments.iter_mut().filter(|segment| !segment.is_taken) {
                if (segment.middle - first).norm() <= Self::ONE_BODY_M {
                    track.take(segment.middle);
                    segment.is_taken = true;
                }
            }
            track.center();
            self.n_tracks += 1;
            if self.tracks.len() < Self::MOST {
                self.tracks.push(track);
            }
        }
    }

    /// Drops the younger of two tracks of one body; tracks are in the order of their age.
    fn merge(&mut self) {
        let mut idx = 1;
        while idx < self.tracks.len() {
            let (older, younger) = self.tracks.split_at(idx);
            let is_double = younger.first().is_some_and(|young| {
                older.iter().any(|old| (old.position() - young.position()).norm() < Self::SAME_M)
            });
            if is_double {
                self.tracks.remove(idx);
            } else {
                idx += 1;
            }
        }
    }
}

#[cfg(test)]
mod tests;
