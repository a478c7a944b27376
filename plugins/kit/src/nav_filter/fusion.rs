//! Measurements of the plane put together with the state: planar poses, the anchor, dead reckoning.

use super::aids::{Aid, yaw_by_errors};
use super::filter::LEAST;
use super::intersection::{PlanarPose, intersect, intersect_pose};
use super::model::{ATTITUDE, AnchorCross, Covariance, NavState, POSITION, VELOCITY};
use super::moment::{Moment, Tally};
use super::settings::{Intersected, NavSettings};
use super::update::{CHI2_95, joseph};
use nalgebra::{Matrix3, Rotation2, SMatrix, UnitQuaternion, Vector3};
use rumbo_core::frames::{Pose2, Twist, is_finite2, wrap_angle};
use rumbo_core::time::Time;
/// The pose on the floor.
pub(super) fn planar(state: &NavState) -> Pose2 {
    Pose2::new(state.position_m.xy(), state.yaw_rad())
}

/// How errors change x, y and yaw.
pub(super) fn planar_rows(state: &NavState) -> SMatrix<f64, 3, 15> {
    let mut c = SMatrix::<f64, 3, 15>::zeros();
    c[(0, POSITION)] = 1.0;
    c[(1, POSITION + 1)] = 1.0;
    c.fixed_view_mut::<1, 3>(2, ATTITUDE).copy_from(&yaw_by_errors(state).transpose());
    c
}

/// How a step over the floor becomes part of the state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fusion {
    /// Its errors have nothing to do with those of the state: it is what scans say and nothing else.
    Alone,
    /// It is partly what the state said before: covariance intersection.
    Intersected,
}

/// A planar pose as a measurement of the state; none where it is no pose, or its covariance is none.
fn measurement(moment: &mut Moment, measured: &PlanarPose, tally: &mut Tally) -> Option<Aid<3>> {
    let r = (measured.covariance + measured.covariance.transpose()) * 0.5;
    let is_number = is_finite2(&measured.pose) && r.iter().all(|v| v.is_finite());
    if !is_number {
        tally.n_rejected += 1;
        return None;
    }
    if r.cholesky().is_none() {
        moment.covariance *= 2.0;
        tally.n_not_positive += 1;
        return None;
    }
    let expected = planar(&moment.state);
    let way = measured.pose.translation.vector - expected.translation.vector;
    let turn = wrap_angle(measured.pose.rotation.angle() - expected.rotation.angle());
    Some(Aid { innovation: Vector3::new(way.x, way.y, turn), h: planar_rows(&moment.state), r })
}

/// A planar pose whose errors have nothing to do with those of the state. One that is too far off counts less, by as much as
/// brings it to the gate: scans that are right must in the end convince a filter that is wrong.
pub(super) fn take_alone(moment: &mut Moment, measured: &PlanarPose, tally: &mut Tally) -> bool {
    let Some(mut aid) = measurement(moment, measured, tally) else { return false };
    let Some(updated) = joseph(&moment.covariance, &aid.h, &aid.r, &aid.innovation) else {
        return moment.adopt(None, tally);
    };
    let excess = updated.mahalanobis2 / CHI2_95[2];
    if excess <= 1.0 {
        return moment.take(Some(&updated), &aid.h, &aid.r, tally);
    }
    tally.n_rejected += 1;
    let expected = aid.h * moment.covariance * aid.h.transpose() + aid.r;
    aid.r += expected * (excess - 1.0);
    let updated = joseph(&moment.covariance, &aid.h, &aid.r, &aid.innovation);
    moment.take(updated.as_ref(), &aid.h, &aid.r, tally)
}

/// Covariance intersection with a planar pose in the state's frame.
pub(super) fn fuse(
    moment: &mut Moment,
    measured: &PlanarPose,
    settings: &NavSettings,
    tally: &mut Tally,
) -> bool {
    let Some(Aid { innovation, h: c, r }) = measurement(moment, measured, tally) else { return false };
    let before = c * moment.covariance * c.transpose();
    let Some(omega) = settings.omega.weight(&before, &r) else { return moment.adopt(None, tally) };
    let updated = match settings.intersected {
        Intersected::Pose => intersect_pose(&moment.covariance, &c, &r, &innovation, omega),
        Intersected::Everything => intersect(&moment.covariance, &c, &r, &innovation, omega),
    };
    if omega > 0.0 {
        moment.take(updated.as_ref(), &c, &(r / omega), tally)
    } else {
        moment.adopt(updated.as_ref(), tally)
    }
}

/// From one anchor to the next.
#[derive(Debug, Clone, Copy)]
pub(super) struct Anchored {
    /// The new one, in the frame of the old one.
    pub pose: Pose2,
    /// Its covariance.
    pub covariance: Matrix3<f64>,
    /// What its errors have in common with those of the old one.
    pub with_anchor: Matrix3<f64>,
    /// And with those of the state.
    pub with_state: AnchorCross,
}

/// Makes where the robot stands the origin of the state's frame, and its yaw the x axis: both are certain then. What the state
/// has in common with the old anchor stays.
pub(super) fn anchor(moment: &mut Moment) -> Anchored {
    let state = &mut moment.state;
    let (pose, c, by_yaw) = (planar(state), planar_rows(state), yaw_by_errors(state));
    let by_state = c * moment.covariance;
    let (before, with_anchor) = (by_state * c.transpose(), moment.by_anchor * c.transpose());
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -state.yaw_rad());
    state.nav_from_body = turn * state.nav_from_body;
    state.velocity_m_s = turn * state.velocity_m_s;
    state.position_m.x = 0.0;
    state.position_m.y = 0.0;
    let up = state.nav_from_body.inverse() * Vector3::z();
    let mut t = Covariance::identity();
    t[(POSITION, POSITION)] = 0.0;
    t[(POSITION + 1, POSITION + 1)] = 0.0;
    t.fixed_view_mut::<3, 3>(ATTITUDE, ATTITUDE).copy_from(&(Matrix3::identity() - up * by_yaw.transpose()));
    t.fixed_view_mut::<3, 3>(VELOCITY, VELOCITY).copy_from(turn.to_rotation_matrix().matrix());
    let swung = Vector3::z().cross(&state.velocity_m_s);
    t.fixed_view_mut::<3, 3>(VELOCITY, ATTITUDE).copy_from(&(-swung * by_yaw.transpose()));
    let mut covariance = t * moment.covariance * t.transpose();
    covariance[(POSITION, POSITION)] += LEAST;
    covariance[(POSITION + 1, POSITION + 1)] += LEAST;
    let certain = covariance.fixed_view::<3, 3>(ATTITUDE, ATTITUDE) + up * up.transpose() * LEAST;
    covariance.fixed_view_mut::<3, 3>(ATTITUDE, ATTITUDE).copy_from(&certain);
    moment.covariance = (covariance + covariance.transpose()) * 0.5;
    moment.by_anchor *= t.transpose();
    let covariance = (before + before.transpose()) * 0.5;
    Anchored { pose, covariance, with_anchor, with_state: by_state * t.transpose() }
}

/// Goes on by the velocity and the turn between two moments, without what measurements corrected.
pub(super) fn reckoned(from: &Pose2, before: &NavState, next: &Moment, since: Time) -> Pose2 {
    let seconds = (next.stamp - since).as_secs();
    let rate = before.nav_from_body * (next.sample.rates_rad_s - before.gyro_bias_rad_s);
    let floor = Rotation2::new(-before.yaw_rad()) * before.velocity_m_s.xy();
    from * Twist { forward_m_s: floor.x, left_m_s: floor.y, turn_rad_s: rate.z }.integrate(seconds)
}
