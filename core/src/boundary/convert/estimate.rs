//! Estimates and priors.
#![allow(unsafe_code)]

use super::BadView;
use super::array::{CArray, Hold};
use super::basic::{pose2_from, pose3_from, read, rumbo_pose2_of, rumbo_pose3_of};
use super::observation::slice;
use crate::boundary::abi::*;
use crate::frames::Pose2;
use crate::messages::{Candidate, Estimate, Prior, StampedPose, Status, Wish};
use crate::time::Time;
use nalgebra::{Matrix3, Matrix6};

/// Storage for the view of an estimate, kept from call to call.
#[derive(Default)]
pub(crate) struct EstimateLoan {
    candidates: Vec<rumbo_candidate>,
}

impl EstimateLoan {
    /// A view that holds until the next call.
    pub fn lend(&mut self, estimate: &Estimate) -> rumbo_estimate {
        self.candidates.clear();
        self.candidates.extend(estimate.candidates.iter().map(candidate_of));
        let (wish_kind, wish) = match estimate.wish {
            None => (RUMBO_WISH_NONE, 0.0),
            Some(Wish::HoldStill) => (RUMBO_WISH_HOLD_STILL, 0.0),
            Some(Wish::TurnBy(by)) => (RUMBO_WISH_TURN_BY, by),
            Some(Wish::MoveBy(by)) => (RUMBO_WISH_MOVE_BY, by),
        };
        let mut covariance = [0.0; 36];
        for (to, from) in covariance.iter_mut().zip(estimate.covariance.transpose().iter()) {
            *to = *from;
        }
        rumbo_estimate {
            size: size_of::<rumbo_estimate>(),
            stamp_ns: estimate.stamp.0,
            map_from_odom: rumbo_pose3_of(&estimate.map_from_odom),
            map_from_base: rumbo_pose3_of(&estimate.map_from_base),
            covariance,
            status: match estimate.status {
                Status::Lost => RUMBO_LOST,
                Status::Converging => RUMBO_CONVERGING,
                Status::Tracking => RUMBO_TRACKING,
                Status::Ambiguous => RUMBO_AMBIGUOUS,
            },
            wish_kind,
            wish,
            n_candidates: self.candidates.len(),
            candidates: self.candidates.as_ptr(),
        }
    }

    /// The candidates of the last view.
    pub fn candidates(&self) -> &[rumbo_candidate] {
        &self.candidates
    }
}

fn candidate_of(candidate: &Candidate) -> rumbo_candidate {
    rumbo_candidate { map_from_base: rumbo_pose2_of(&candidate.map_from_base), score: candidate.score }
}

/// A place at a time, to the bit.
pub(crate) fn stamped_pose_of(pose: &StampedPose) -> rumbo_stamped_pose {
    rumbo_stamped_pose { stamp_ns: pose.stamp.0, map_from_base: rumbo_pose3_of(&pose.map_from_base) }
}

/// The place behind a view.
pub(crate) fn stamped_pose_from(pose: &rumbo_stamped_pose) -> Result<StampedPose, BadView> {
    let map_from_base = pose3_from(&pose.map_from_base, "map_from_base")?;
    Ok(StampedPose { stamp: Time(pose.stamp_ns), map_from_base })
}

/// The candidates behind a view, appended to `out`.
///
/// # Safety
/// `first` points to `len` candidates.
pub(crate) unsafe fn candidates_from(
    first: *const rumbo_candidate,
    len: usize,
    out: &mut Vec<Candidate>,
) -> Result<(), BadView> {
    // SAFETY: as promised by the caller.
    for candidate in unsafe { slice(first, len)? } {
        let map_from_base = pose2_from(&candidate.map_from_base, "candidates.map_from_base")?;
        out.push(Candidate { map_from_base, score: candidate.score });
    }
    Ok(())
}

/// The estimate behind a view, with its candidates.
///
/// # Safety
/// `view` points to a view whose parts are alive.
pub(crate) unsafe fn estimate_from(view: *const rumbo_estimate) -> Result<Estimate, BadView> {
    // SAFETY: as promised by the caller.
    let view = unsafe { read(view) }.ok_or_else(|| BadView::new("the estimate points nowhere"))?;
    let mut candidates = Vec::new();
    // SAFETY: as promised by the caller.
    unsafe { candidates_from(view.candidates, view.n_candidates, &mut candidates)? };
    let status = match view.status {
        RUMBO_LOST => Status::Lost,
        RUMBO_CONVERGING => Status::Converging,
        RUMBO_TRACKING => Status::Tracking,
        RUMBO_AMBIGUOUS => Status::Ambiguous,
        other => return Err(BadView::new(format!("estimate.status is {other}, expected 0 to 3"))),
    };
    let wish = match view.wish_kind {
        RUMBO_WISH_NONE => None,
        RUMBO_WISH_HOLD_STILL => Some(Wish::HoldStill),
        RUMBO_WISH_TURN_BY => Some(Wish::TurnBy(view.wish)),
        RUMBO_WISH_MOVE_BY => Some(Wish::MoveBy(view.wish)),
        other => return Err(BadView::new(format!("estimate.wish_kind is {other}, expected 0 to 3"))),
    };
    Ok(Estimate {
        stamp: Time(view.stamp_ns),
        map_from_odom: pose3_from(&view.map_from_odom, "estimate.map_from_odom")?,
        map_from_base: pose3_from(&view.map_from_base, "estimate.map_from_base")?,
        covariance: Matrix6::from_row_slice(&view.covariance),
        status,
        candidates,
        wish,
    })
}

/// A view of a prior.
pub(crate) fn lend_prior(prior: &Prior) -> rumbo_prior {
    let nowhere = rumbo_pose2_of(&Pose2::identity());
    let mut view = rumbo_prior {
        size: size_of::<rumbo_prior>(),
        kind: RUMBO_PRIOR_UNKNOWN,
        reserved: 0,
        map_from_base: nowhere,
        odom_from_base: nowhere,
        covariance: [0.0; 9],
        saved: CArray::nothing(),
    };
    match prior {
        Prior::Unknown => {}
        Prior::Pose { map_from_base, odom_from_base, covariance } => {
            view.kind = RUMBO_PRIOR_POSE;
            view.map_from_base = rumbo_pose2_of(map_from_base);
            view.odom_from_base = rumbo_pose2_of(odom_from_base);
            for (to, from) in view.covariance.iter_mut().zip(covariance.transpose().iter()) {
                *to = *from;
            }
        }
        Prior::Saved(bytes) => {
            view.kind = RUMBO_PRIOR_SAVED;
            view.saved = CArray::lend(bytes);
        }
    }
    view
}

/// The prior behind a view.
///
/// # Safety
/// `view` points to a view whose parts are alive.
pub(crate) unsafe fn prior_from(view: *const rumbo_prior) -> Result<Prior, BadView> {
    // SAFETY: as promised by the caller.
    let view = unsafe { read(view) }.ok_or_else(|| BadView::new("the prior points nowhere"))?;
    match view.kind {
        RUMBO_PRIOR_UNKNOWN => Ok(Prior::Unknown),
        RUMBO_PRIOR_POSE => Ok(Prior::Pose {
            map_from_base: pose2_from(&view.map_from_base, "prior.map_from_base")?,
            odom_from_base: pose2_from(&view.odom_from_base, "prior.odom_from_base")?,
            covariance: Matrix3::from_row_slice(&view.covariance),
        }),
        RUMBO_PRIOR_SAVED => {
            // SAFETY: as promised by the caller.
            let bytes = unsafe { view.saved.take(Hold::Lent) };
            bytes.map(Prior::Saved).map_err(|bad| BadView::new(bad.to_string()))
        }
        other => Err(BadView::new(format!("prior.kind is {other}, which this plugin is too old for"))),
    }
}
