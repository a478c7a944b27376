//! The last step of a match: from the pose at which the scan lies best on the cells to that at which it lies best on the
//! surfaces in them.

use super::covariance::{CovarianceSettings, moved};
use super::matcher::ScanMatch;
use super::observability::Observability;
use super::points::ScanPoints;
use super::step::PosePrior;
use super::surface_fit::{SurfaceFit, fit_surfaces};
use super::surface_map::SurfaceMap;
use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::Pose2;

/// How to polish.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PolishSettings {
    /// Steps at most.
    pub iterations: u32,
    /// A point this far from the surface counts half, meters.
    pub doubt_m: f64,
    /// Standard deviation of a point's distance, against the prior, meters.
    pub deviation_m: f64,
    /// The farthest from what the cells say, cells; farther away something is wrong, and the cells are believed.
    pub farthest_cells: f64,
    /// Share of the points that must lie by a surface.
    pub least_share: f64,
    /// A shorter step is the last, meters.
    pub converge_m: f64,
    /// With a smaller turn, radians.
    pub converge_rad: f64,
}

impl Default for PolishSettings {
    fn default() -> Self {
        PolishSettings {
            iterations: 5,
            doubt_m: 0.03,
            deviation_m: 0.025,
            farthest_cells: 1.5,
            least_share: 0.3,
            converge_m: 5e-4,
            converge_rad: 2e-4,
        }
    }
}

impl PolishSettings {
    /// Moves a match onto the surfaces, with its covariance. Along directions that the cells do not show it stays where it
    /// is. Returns whether the match changed.
    pub fn polish(
        &self,
        found: &mut ScanMatch,
        surfaces: &SurfaceMap,
        points: &ScanPoints,
        prior: Option<&PosePrior>,
        covariance: &CovarianceSettings,
    ) -> bool {
        let start = found.map_from_base;
        let (mut pose, mut fit) = (start, None);
        for _ in 0..self.iterations {
            found.n_evaluations += 1;
            let here = fit_surfaces(surfaces, points, &pose, self.doubt_m);
            if (here.n_used as f64) < self.least_share * points.len() as f64 {
                return false;
            }
            let Some(change) = self.change(&here, &found.seen, &pose, prior) else { return false };
            pose = moved(&pose, &change);
            fit = Some(here);
            if change.xy().norm() < self.converge_m && change.z.abs() < self.converge_rad {
                break;
            }
        }
        let Some(fit) = fit else { return false };
        let step = start.inverse() * pose;
        let farthest_m = self.farthest_cells * surfaces.resolution_m();
        let at_points_m = step.rotation.angle().abs() * found.seen.extent_m;
        if !(step.translation.vector.norm() <= farthest_m && at_points_m <= farthest_m) {
            return false;
        }
        found.map_from_base = pose;
        if let Some(of_surfaces) = self.covariance(&fit, &found.seen, covariance) {
            found.covariance = of_surfaces;
        }
        true
    }

    /// A Gauss-Newton step.
    fn change(
        &self,
        fit: &SurfaceFit,
        seen: &Observability,
        pose: &Pose2,
        prior: Option<&PosePrior>,
    ) -> Option<Vector3<f64>> {
        let (hessian, descent) = seen.only_seen(&fit.hessian, &fit.descent);
        let (system, right) = match prior {
            Some(prior) => {
                let information = self.deviation_m.powi(-2);
                let toward = prior.difference_from(pose);
                (
                    hessian * information + prior.information,
                    descent * information + prior.information * toward,
                )
            }
            None => (hessian, descent),
        };
        let change = if seen.is_complete() {
            system.cholesky()?.solve(&right)
        } else {
            seen.seen_part(&(system + seen.blind_identity()).cholesky()?.solve(&right))
        };
        change.iter().all(|v| v.is_finite()).then_some(change)
    }

    /// `σ² H^-1` by the distances that are left, with the floor.
    fn covariance(
        &self,
        fit: &SurfaceFit,
        seen: &Observability,
        settings: &CovarianceSettings,
    ) -> Option<Matrix3<f64>> {
        let variance_m2 = fit.cost_m2 / (fit.weight - 3.0).max(1.0);
        seen.is_complete().then_some(())?;
        let inverse = fit.hessian.cholesky()?.inverse();
        Some(settings.with_floor(inverse * variance_m2))
    }
}
