//! Walks among obstacles that a test names.

use rumbo_core::frames::Point2;
use rumbo_core::rng::stream;
use rumbo_kit::potential::{Field, Group, Obstacles};
use rumbo_planners::fictitious_charges::FictitiousChargesParams;
use rumbo_planners::field_descent::FieldSettings;
use rumbo_planners::field_descent::descent::{ChargeRules, DescentRules, End, Walk, descend};
use rumbo_planners::potential_field::PotentialFieldParams;

/// Obstacles and a goal.
pub struct Scene {
    pub groups: Vec<Group>,
    pub goal: Point2,
}

impl Scene {
    pub fn warehouse() -> Scene {
        Scene { groups: super::warehouse::groups(), goal: super::warehouse::goal() }
    }

    pub fn plain(&self, params: &PotentialFieldParams, start: Point2) -> Walk {
        self.walk(&params.rules(), None, start, 0)
    }

    pub fn charged(&self, params: &FictitiousChargesParams, start: Point2) -> Walk {
        self.charged_by(params, start, 0)
    }

    /// With the random stream of a seed.
    pub fn charged_by(&self, params: &FictitiousChargesParams, start: Point2, seed: u64) -> Walk {
        let (settings, charges) = params.rules();
        self.walk(&settings, Some(&charges), start, seed)
    }

    fn walk(
        &self,
        settings: &FieldSettings,
        charges: Option<&ChargeRules>,
        start: Point2,
        seed: u64,
    ) -> Walk {
        let obstacles = Obstacles::new(&self.groups, settings.repulsion.reach_m()).unwrap();
        let field = Field {
            goal: self.goal,
            attraction: settings.attraction,
            obstacles: &obstacles,
            repulsion: settings.repulsion,
            goal_scaling_m: settings.goal_scaling_m,
        };
        let minimum_clearance_m = settings.minimum_clearance_m.unwrap_or(0.3);
        let rules = DescentRules { minimum_clearance_m, ..settings.descent };
        descend(&field, &rules, charges, start, &mut stream(seed, "planner"), &mut || false)
    }
}

pub fn has_arrived(walk: &Walk) -> bool {
    walk.end == End::Arrived
}
