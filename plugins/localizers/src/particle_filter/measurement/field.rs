//! `model = "likelihood_field"`: readings should end near an obstacle.

use super::{MeasurementModel, Obstacles, ScanLikelihood, no_share, not_positive};
use crate::particle_filter::beams::ScanBeams;
use rumbo_kit::grid_poses::GridPoses;
use rumbo_kit::likelihood_field::{EndPoints, FieldShape, LikelihoodField};
use serde::{Deserialize, Serialize};

/// Likelihood field: see [`rumbo_kit::likelihood_field`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FieldModel {
    /// Longer distances from an obstacle count as this one, meters.
    pub likelihood_max_dist_m: f64,
    /// Standard deviation of readings that hit something on the map, meters.
    pub sigma_hit_m: f64,
    /// Share of these.
    pub z_hit: f64,
    /// Share of readings that can be anything.
    pub z_rand: f64,
    /// Readings at and beyond this range say nothing, meters.
    pub z_max_range_m: f64,
}

impl Default for FieldModel {
    fn default() -> Self {
        FieldModel {
            likelihood_max_dist_m: 2.0,
            sigma_hit_m: 0.2,
            z_hit: 0.95,
            z_rand: 0.05,
            z_max_range_m: 30.0,
        }
    }
}

#[typetag::serde(name = "likelihood_field")]
impl MeasurementModel for FieldModel {
    fn on_map(&self, obstacles: &Obstacles<'_>) -> Box<dyn ScanLikelihood> {
        let shape = FieldShape {
            max_distance_m: self.likelihood_max_dist_m,
            sigma_hit_m: self.sigma_hit_m,
            z_hit: self.z_hit,
            z_rand: self.z_rand,
            z_max_range_m: self.z_max_range_m,
        };
        let Obstacles { size, resolution_m, occupied } = *obstacles;
        let field = LikelihoodField::new(size, resolution_m, occupied, shape);
        let (model, ends) = (*self, EndPoints::default());
        Box::new(FieldOnMap { model, field, resolution_m, ends })
    }

    fn faults(&self) -> Vec<(&'static str, String)> {
        let mut faults = not_positive(&[
            ("likelihood_max_dist_m", self.likelihood_max_dist_m),
            ("sigma_hit_m", self.sigma_hit_m),
            ("z_max_range_m", self.z_max_range_m),
        ]);
        faults.extend(no_share(&[("z_hit", self.z_hit), ("z_rand", self.z_rand)]));
        if self.z_rand == 0.0 {
            let message =
                "is 0, expected a share above 0: else one person in the way rules out the true place";
            faults.push(("z_rand", message.to_owned()));
        }
        faults
    }

    fn boxed_clone(&self) -> Box<dyn MeasurementModel> {
        Box::new(*self)
    }
}

struct FieldOnMap {
    model: FieldModel,
    field: LikelihoodField,
    resolution_m: f64,
    ends: EndPoints,
}

impl FieldOnMap {
    /// A beam is explained when it ends within so many standard deviations of an obstacle.
    const EXPLAINED_SIGMAS: f64 = 2.0;

    /// Where the usable beams end, cells.
    fn ends_from<'a>(
        &self,
        beams: &'a ScanBeams,
        [x, y, heading]: [f64; 3],
    ) -> impl Iterator<Item = [f64; 2]> + 'a {
        let ((sin, cos), cell_m) = (heading.sin_cos(), self.resolution_m);
        let end =
            move |[a, b]: [f64; 2]| [x + (cos * a - sin * b) / cell_m, y + (sin * a + cos * b) / cell_m];
        beams.end_points(self.model.z_max_range_m).map(end)
    }
}

impl ScanLikelihood for FieldOnMap {
    fn add_ln(&mut self, beams: &ScanBeams, poses: &GridPoses, ln_p: &mut [f64]) -> usize {
        let in_cells = |point: [f64; 2]| point.map(|v| v / self.resolution_m);
        self.ends.set(beams.end_points(self.model.z_max_range_m).map(in_cells));
        if self.ends.n_beams() > 0 {
            self.field.add_ln(poses, &self.ends, ln_p);
        }
        self.ends.n_beams()
    }

    fn exact_ln(&self, beams: &ScanBeams, pose: [f64; 3]) -> f64 {
        self.ends_from(beams, pose).map(|[x, y]| self.field.exact_ln(x, y)).sum()
    }

    fn explained(&self, beams: &ScanBeams, pose: [f64; 3]) -> [usize; 2] {
        // Half a cell: distances are between middles of cells.
        let reach_m = Self::EXPLAINED_SIGMAS * self.model.sigma_hit_m + self.resolution_m / 2.0;
        self.ends_from(beams, pose).fold([0, 0], |[near, all], [x, y]| {
            [near + usize::from(self.field.distance_m(x, y) <= reach_m), all + 1]
        })
    }
}
