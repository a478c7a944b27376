//! What grows while scans do not show which way the robot goes, as between bare walls.

use nalgebra::{Matrix2, Matrix3};
use rumbo_kit::scan_match::Observability;

/// A robot whose motion nobody sees may be so much slower or faster than it is thought to be, m/s.
const UNSEEN_M_S: f64 = 0.5;
/// Wheels that have said nothing for so long do not tell how the robot moves, seconds.
pub(crate) const SILENT_S: f64 = 0.5;
/// Wheels that turn by less between two scans stand, meters and radians.
pub(crate) const STANDING: f64 = 1e-4;
/// Who did not know his way is sure again where he sees no less than this share of a scan on what was seen before.
pub(crate) const SURE_OVERLAP: f64 = 0.95;
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

/// A covariance after a scan that tells where the robot is against what was drawn since nobody knew the way: on the rest of the map
/// its place is along no direction known better than before.
pub(crate) fn not_sharper(by_scan: &Matrix3<f64>, before: &Matrix3<f64>) -> Matrix3<f64> {
    let place = |covariance: &Matrix3<f64>| covariance.fixed_view::<2, 2>(0, 0).into_owned();
    let more = (place(before) - place(by_scan)).symmetric_eigen();
    let directions = more.eigenvectors;
    let lost =
        directions * Matrix2::from_diagonal(&more.eigenvalues.map(|v| v.max(0.0))) * directions.transpose();
    let mut blunt = *by_scan;
    blunt.fixed_view_mut::<2, 2>(0, 0).copy_from(&(place(by_scan) + lost));
    blunt
}

/// Who is not sure of its place may be this far from where it seems to be, meters: twice the larger deviation of x and y.
pub(crate) fn reach_m(covariance: &Matrix3<f64>) -> f64 {
    2.0 * covariance.diagonal().xy().max().max(0.0).sqrt()
}

/// The place is not known well enough to say that the robot is tracked.
pub(crate) fn is_unsure(covariance: &Matrix3<f64>) -> bool {
    let place = covariance.fixed_view::<2, 2>(0, 0).into_owned();
    place.symmetric_eigenvalues().max() > SURE_M * SURE_M
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Around a corner of bare walls: the next leg tells what the last one did not, but on what was drawn since.
    #[test]
    fn no_direction_is_known_better_than_before() {
        let turn = nalgebra::Rotation3::from_axis_angle(&nalgebra::Vector3::z_axis(), 0.4);
        let turned = |x: f64, y: f64, yaw: f64| {
            let axes = Matrix3::from_diagonal(&nalgebra::Vector3::new(x, y, yaw));
            turn.matrix() * axes * turn.matrix().transpose()
        };
        let (before, by_scan) = (turned(2.25, 0.01, 0.1), turned(0.0001, 1.2, 0.002));
        let after = not_sharper(&by_scan, &before);
        assert!((after - turned(2.25, 1.2, 0.002)).amax() < 1e-9, "{after}");
        assert!((not_sharper(&before, &by_scan) - turned(2.25, 1.2, 0.1)).amax() < 1e-9);
    }
}
