//! What refinement made of a plan, as counters.

use super::checkpoints::{Point, least_clearance, length};
use super::grid_dp::DpPlan;
use rumbo_core::frames::wrap_angle;
use rumbo_core::trace::Trace;
use rumbo_kit::proximity::ProximityMap;

/// Turns of a way at its points, added up, radians.
pub fn turning_rad(points: &[Point]) -> f64 {
    let headings = points.windows(2).map(|leg| (leg[1][1] - leg[0][1]).atan2(leg[1][0] - leg[0][0]));
    let mut last = None;
    headings.map(|heading| last.replace(heading).map_or(0.0, |last| wrap_angle(heading - last).abs())).sum()
}

/// Counts points, length, turning and least clearance before and after.
pub fn tell(trace: &Trace, proximity: &ProximityMap, plan: &DpPlan, resolution_m: f64) {
    if !trace.is_counting() {
        return;
    }
    let of = |points: &[Point], names: [&'static str; 4]| {
        let values = [
            points.len() as f64,
            length(points) * resolution_m,
            turning_rad(points).to_degrees(),
            least_clearance(proximity, points) * resolution_m,
        ];
        names.into_iter().zip(values).for_each(|(name, value)| trace.count(name, value));
    };
    let before = [
        "points_before_refinement",
        "length_before_refinement_m",
        "turning_before_refinement_deg",
        "clearance_before_refinement_m",
    ];
    of(&plan.checkpoints, before);
    of(&plan.refined, ["points", "length_m", "turning_deg", "clearance_m"]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_to_both_sides_add_up() {
        let points = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (2.0, 1.0)].map(Point::from);
        assert!((turning_rad(&points).to_degrees() - 180.0).abs() < 1e-9);
        assert_eq!(turning_rad(&points[..2]), 0.0);
    }
}
