//! Numbers a message must not carry.

use crate::frames::{Pose2, Pose3, is_finite2, is_finite3};

/// A message that must not go on.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{message}.{field} is {found}, expected {expected}")]
pub struct MessageFault {
    /// Kind of message.
    pub message: &'static str,
    /// Field of the message.
    pub field: &'static str,
    /// What it holds.
    pub found: String,
    /// What it should hold.
    pub expected: &'static str,
}

/// A message that can say whether its numbers make sense.
pub trait Check {
    /// The first field that holds something impossible.
    fn check(&self) -> Result<(), MessageFault>;
}

/// Collects the tests of one message, in the order of its fields.
pub(crate) struct Checker(pub &'static str);

impl Checker {
    fn fail<T>(&self, field: &'static str, found: String, expected: &'static str) -> Result<T, MessageFault> {
        Err(MessageFault { message: self.0, field, found, expected })
    }

    pub fn finite(&self, field: &'static str, values: &[f64]) -> Result<(), MessageFault> {
        match values.iter().find(|v| !v.is_finite()) {
            Some(v) => self.fail(field, v.to_string(), "a finite number"),
            None => Ok(()),
        }
    }

    pub fn positive(&self, field: &'static str, value: f64) -> Result<(), MessageFault> {
        if value > 0.0 && value.is_finite() {
            return Ok(());
        }
        self.fail(field, value.to_string(), "a finite number above zero")
    }

    pub fn not_negative(&self, field: &'static str, value: f64) -> Result<(), MessageFault> {
        if value >= 0.0 && value.is_finite() {
            return Ok(());
        }
        self.fail(field, value.to_string(), "a finite number of at least zero")
    }

    /// Ranges follow REP-117: infinity is "nothing within reach", not-a-number is "no reading".
    pub fn ranges(&self, field: &'static str, ranges: &[f32]) -> Result<(), MessageFault> {
        match ranges.iter().find(|r| **r < 0.0) {
            Some(r) => self.fail(
                field,
                r.to_string(),
                "ranges of at least zero, +inf for nothing seen, NaN for none",
            ),
            None => Ok(()),
        }
    }

    pub fn equal(&self, field: &'static str, found: usize, wanted: usize) -> Result<(), MessageFault> {
        if found == wanted {
            return Ok(());
        }
        self.fail(
            field,
            format!("{found} elements where the header says {wanted}"),
            "as many as the header says",
        )
    }

    pub fn pose2(&self, field: &'static str, pose: &Pose2) -> Result<(), MessageFault> {
        if is_finite2(pose) { Ok(()) } else { self.fail(field, told2(pose), "finite numbers") }
    }

    pub fn pose3(&self, field: &'static str, pose: &Pose3) -> Result<(), MessageFault> {
        if is_finite3(pose) { Ok(()) } else { self.fail(field, told3(pose), "finite numbers") }
    }
}

/// A pose on one line.
fn told2(pose: &Pose2) -> String {
    let (t, r) = (&pose.translation, &pose.rotation);
    format!("at ({}, {}) m with the heading ({}, {})", t.x, t.y, r.re, r.im)
}

/// A pose on one line.
fn told3(pose: &Pose3) -> String {
    let (t, q) = (&pose.translation, &pose.rotation);
    format!("at ({}, {}, {}) m with the quaternion ({}, {}, {}, {})", t.x, t.y, t.z, q.i, q.j, q.k, q.w)
}
