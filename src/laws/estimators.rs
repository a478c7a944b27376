//! What localizers and SLAM plugins have in common: they are started, and say where the robot is.

use super::drive::{Drive, Frame};
use super::law::{Trouble, expect};
use super::subject::Subject;
use super::turn::Turn;
use nalgebra::Matrix3;
use rumbo_core::map::{Layer, Map};
use rumbo_core::messages::{Check, Estimate, Observation, Prior, Seen, StampedPose};
use rumbo_core::registry::Stage;
use rumbo_core::stages::{BuildContext, Cx, Localizer, Slam, SlamError};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;

/// A localizer or a SLAM plugin with its map.
pub struct Tracker {
    stage: Either,
    /// The hall for a localizer; what it has made of it for a SLAM plugin.
    pub map: Map,
    trace: Trace,
}

enum Either {
    Localizer(Box<dyn Localizer>),
    Slam(Box<dyn Slam>),
}

impl Tracker {
    /// A new one for this drive.
    pub fn new(subject: &Subject, drive: &Drive) -> Result<Tracker, Trouble> {
        Tracker::new_in(subject, drive, &subject.context())
    }

    /// The same, built in a context of the law's own.
    pub fn new_in(subject: &Subject, drive: &Drive, context: &BuildContext) -> Result<Tracker, Trouble> {
        subject.sees_enough()?;
        let trace = Trace::unwatched();
        if subject.entry.stage == Stage::Slam {
            subject.needs_only(&[])?;
            let stage = Either::Slam(subject.build_in(context)?);
            return Ok(Tracker { stage, map: Map::default(), trace });
        }
        subject.needs_only(&[Layer::Grid, Layer::Lines, Layer::Landmarks])?;
        let stage = Either::Localizer(subject.build_in(context)?);
        Ok(Tracker { stage, map: drive.world.map(), trace })
    }

    /// Begins anew.
    pub fn start(&mut self, prior: &Prior) -> Result<(), String> {
        match &mut self.stage {
            Either::Localizer(stage) => stage.start(prior, &self.map).map_err(|error| error.to_string()),
            Either::Slam(stage) => stage.start(prior, &mut self.map).map_err(|error| error.to_string()),
        }
    }

    /// Takes in what was seen.
    pub fn update(&mut self, now: Time, seen: &[Observation]) -> Result<Estimate, String> {
        let mut cx = Cx { now, trace: &self.trace };
        let seen = Seen::sorted(seen);
        match &mut self.stage {
            Either::Localizer(stage) => {
                stage.update(&mut cx, seen, &self.map).map_err(|error| error.to_string())
            }
            Either::Slam(stage) => {
                stage.update(&mut cx, seen, &mut self.map).map_err(|error| error.to_string())
            }
        }
    }

    /// What a SLAM plugin saves; none where it cannot.
    pub fn save(&self) -> Option<Vec<u8>> {
        match &self.stage {
            Either::Localizer(_) => None,
            Either::Slam(stage) => stage.save().ok(),
        }
    }

    /// What a SLAM plugin knows of its way; none for a localizer.
    pub fn trajectory(&self) -> Option<Result<Vec<StampedPose>, String>> {
        match &self.stage {
            Either::Localizer(_) => None,
            Either::Slam(stage) => Some(stage.trajectory().map_err(|error| error.to_string())),
        }
    }

    /// Tells a SLAM plugin where the robot is; none where it cannot be told.
    pub fn relocate(&mut self, prior: &Prior) -> Option<Result<(), String>> {
        match &mut self.stage {
            Either::Localizer(_) => None,
            Either::Slam(stage) => match stage.relocate(prior, &mut self.map) {
                Err(SlamError::CannotRelocate) => None,
                told => Some(told.map_err(|error| error.to_string())),
            },
        }
    }

    /// Begins where the drive begins.
    pub fn start_at(&mut self, frame: &Frame) -> Result<(), Trouble> {
        self.start(&prior_of(frame)).map_err(|error| {
            Trouble::broken(format!("it does not start: {error}"), "a start from a pose that is known")
        })
    }

    /// Takes in one frame, which surely is fine.
    pub fn follow(&mut self, frame: &Frame) -> Result<Estimate, Trouble> {
        self.update(frame.now, &frame.seen).map_err(|error| {
            Trouble::broken(format!("after {:.1} s: {error}", frame.now.as_secs()), "an estimate")
        })
    }

    /// The estimates of a whole drive.
    pub fn follow_all(&mut self, drive: &Drive) -> Result<Vec<Estimate>, Trouble> {
        if let Some(first) = drive.frames.first() {
            self.start_at(first)?;
        }
        drive.frames.iter().map(|frame| self.follow(frame)).collect()
    }
}

/// The estimates of a new tracker on the drive seen from this side.
pub fn estimates(subject: &Subject, turn: Turn) -> Result<(Drive, Vec<Estimate>), Trouble> {
    let drive = Drive::seen_from(turn)?;
    let estimates = Tracker::new(subject, &drive)?.follow_all(&drive)?;
    Ok((drive, estimates))
}

/// What an operator would say at the start.
pub fn prior_of(frame: &Frame) -> Prior {
    Prior::Pose {
        map_from_base: frame.map_from_base,
        odom_from_base: frame.odom_from_base,
        covariance: Matrix3::identity() * 1e-3,
    }
}

/// The numbers of an estimate can be used: finite, of the past, scores that add up, a covariance that is one.
pub fn sane(what: &str, estimate: &Estimate, now: Time) -> Result<(), Trouble> {
    numbers_are_sane(what, estimate, now)?;
    covariance_is_sane(what, estimate)
}

/// Everything but the covariance's shape.
pub fn numbers_are_sane(what: &str, estimate: &Estimate, now: Time) -> Result<(), Trouble> {
    estimate.check().map_err(|fault| Trouble::broken(format!("{what}: {fault}"), "finite numbers"))?;
    let found = || format!("{what}: it is of {:.3} s, at {:.3} s", estimate.stamp.as_secs(), now.as_secs());
    expect(estimate.stamp <= now, found, "an estimate of the present or the past")?;
    let scores: f64 = estimate.candidates.iter().map(|candidate| candidate.score).sum();
    let adds_up = estimate.candidates.is_empty() || (scores - 1.0).abs() < 1e-6;
    expect(adds_up, || format!("{what}: the candidates' scores add up to {scores}"), "a sum of 1")
}

/// The covariance is symmetric and positive semi-definite.
pub fn covariance_is_sane(what: &str, estimate: &Estimate) -> Result<(), Trouble> {
    const SHARE: f64 = 1e-9;
    let covariance = &estimate.covariance;
    let scale = covariance.amax().max(1e-12);
    let asymmetry = (covariance - covariance.transpose()).amax();
    let found = || format!("{what}: entries across the diagonal differ by {asymmetry:e}, of {scale:e}");
    expect(asymmetry <= SHARE * scale, found, "a symmetric covariance")?;
    let least = ((covariance + covariance.transpose()) * 0.5).symmetric_eigenvalues().min();
    let found = || format!("{what}: an eigenvalue of {least:e}, of {scale:e}");
    expect(least >= -SHARE * scale, found, "no negative eigenvalue")
}
