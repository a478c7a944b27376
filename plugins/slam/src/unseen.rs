//! What grows while scans do not show which way the robot goes, as between bare walls.

use nalgebra::Matrix3;
use rumbo_kit::scan_match::Observability;

/// A robot whose motion nobody sees may be so much slower or faster than it is thought to be, m/s.
const UNSEEN_M_S: f64 = 0.5;
/// Wheels that have said nothing for so long do not tell how the robot moves, seconds.
pub(crate) const SILENT_S: f64 = 0.5;
/// Wheels that turn by less between two scans stand, meters and radians.
pub(crate) const STANDING: f64 = 1e-4;
/// A point lies on something that is drawn where that is this near, meters.
pub(crate) const KNOWN_M: f64 = 0.1;
/// Who knows its place no better than this along some direction (standard deviation) is not sure of it, meters.
const SURE_M: f64 = 0.5;

/// Who knows the way that scans did not show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Told {
    /// Wheels, this well: errors of measurements add up as squares.
    ByWheels { deviation_m: f64 },
    /// Nobody for so long: what a velocity is off by it is off by in the next step, too.
    ByNobody { seconds: f64 },
}

impl Told {
    /// Wheels know.
    pub fn by_wheels(self) -> bool {
        matches!(self, Told::ByWheels { .. })
    }
}

/// A covariance of x, y, yaw after a scan: along directions that it did not show what it was before, and more.
pub(crate) fn kept(
    seen: &Observability,
    by_scan: &Matrix3<f64>,
    before: &Matrix3<f64>,
    told: Told,
) -> Matrix3<f64> {
    if seen.is_complete() {
        return *by_scan;
    }
    let known_m = seen.blind_deviation_m(before);
    let deviation_m = match told {
        Told::ByWheels { deviation_m } => known_m.hypot(deviation_m),
        Told::ByNobody { seconds } => known_m + UNSEEN_M_S * seconds.max(0.0),
    };
    seen.with_blind(by_scan, |_| deviation_m * deviation_m)
}

/// The same after a scan that tells all directions, but only against what was drawn since nobody knew the way: the place on the
/// rest of the map is known no better than before.
pub(crate) fn not_sharper(by_scan: &Matrix3<f64>, before: &Matrix3<f64>) -> Matrix3<f64> {
    let place = |covariance: &Matrix3<f64>| covariance.fixed_view::<2, 2>(0, 0).into_owned();
    let (now, then) = (place(by_scan), place(before));
    if now.trace() >= then.trace() {
        return *by_scan;
    }
    let mut blunt = Matrix3::zeros();
    blunt.fixed_view_mut::<2, 2>(0, 0).copy_from(&then);
    blunt[(2, 2)] = by_scan[(2, 2)];
    blunt
}

/// The place is not known well enough to say that the robot is tracked.
pub(crate) fn is_unsure(covariance: &Matrix3<f64>) -> bool {
    let place = covariance.fixed_view::<2, 2>(0, 0).into_owned();
    place.symmetric_eigenvalues().max() > SURE_M * SURE_M
}
