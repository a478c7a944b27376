//! Walks that are tried one after the other: as given, smaller, and with charges that go the other way.
//!
//! The published lengths are those of a hall: the robot comes to rest a meter from walls, so it gets neither through a door
//! nor to a goal beside a wall. With a conic attraction the method has no length of its own: where `d_obs` and `ψ` shrink by
//! a factor, `η` by its cube and `K_c` by its power `m_c + 1`, every walk shrinks by that factor. So a smaller walk is the
//! published one in a hall that is larger by as much, with as many charges for its larger floor.
//!
//! A fading of the repulsion near the goal: Ge and Cui, "New potential functions for mobile robot path planning" (2000).
//! Not in the sources: walks from the goal to the start. What traps a robot on its way out of a room does not on its way in.

use super::descent::ChargeRules;
use rumbo_kit::potential::{Attraction, ChargeLaw, Repulsion};

/// The smallest walk comes to rest this much farther from a wall than the clearance that it keeps, meters.
const ROOM_M: f64 = 0.05;
/// Scales of the first walks, as powers of the smallest.
const SHRINKING: [f64; 3] = [0.0, 0.5, 1.0];
/// Share of the charges of further walks that go to the other side.
const STRAY_SHARE: f64 = 0.2;
/// The repulsion fades within this many times the distance at which the smallest walk comes to rest.
const FADING: f64 = 2.0;

/// What one walk goes by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Attempt {
    /// Its lengths by those that are given.
    pub scale: f64,
    /// From the goal to the start.
    pub is_backward: bool,
    /// What obstacles push with.
    pub repulsion: Repulsion,
    /// Within this distance of where it leads they push less, meters.
    pub goal_scaling_m: Option<f64>,
    /// Charges, where there are any.
    pub charges: Option<ChargeRules>,
}

impl Attempt {
    /// The first `n` walks: this one as it is, smaller ones, then smallest ones to and fro, with charges that stray. A
    /// walk comes to rest where obstacles push as much as the goal draws.
    pub fn followed_by(
        self,
        attraction: &Attraction,
        minimum_clearance_m: f64,
        n: usize,
    ) -> impl Iterator<Item = Attempt> {
        let Repulsion { influence_m, inflation_m, .. } = self.repulsion;
        let rest_m = self.repulsion.distance_of_push_m(attraction.slope(influence_m));
        let least_rest_m = minimum_clearance_m + ROOM_M;
        let scale = (least_rest_m - inflation_m) / (rest_m - inflation_m);
        // A hull that fills the clearance leaves nothing to shrink to.
        let smallest = if scale > 0.0 { scale.min(1.0) } else { 1.0 };
        (0..n).map(move |k| match SHRINKING.get(k) {
            _ if k == 0 => self,
            Some(power) => self.shrunk(smallest.powf(*power), FADING * least_rest_m),
            None => self.shrunk(smallest, FADING * least_rest_m).straying(k % 2 == 1),
        })
    }

    fn shrunk(self, scale: f64, fading_m: f64) -> Attempt {
        let Repulsion { strength, influence_m, .. } = self.repulsion;
        let repulsion = Repulsion {
            strength: strength * scale.powi(3),
            influence_m: influence_m * scale,
            ..self.repulsion
        };
        let charges = self.charges.map(|rules| ChargeRules {
            law: ChargeLaw {
                strength: rules.law.strength * scale.powf(rules.law.exponent + 1.0),
                range_m: rules.law.range_m * scale,
                ..rules.law
            },
            distance_m: rules.distance_m * scale,
            max_charges: (rules.max_charges as f64 / scale.powi(2)).ceil() as usize,
            ..rules
        });
        let goal_scaling_m = self.goal_scaling_m.or(Some(fading_m));
        Attempt { scale, repulsion, goal_scaling_m, charges, ..self }
    }

    fn straying(self, is_backward: bool) -> Attempt {
        let charges = self.charges.map(|rules| ChargeRules { stray_share: STRAY_SHARE, ..rules });
        Attempt { charges, is_backward, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::super::descent::{DescentRules, End, StepRule, Walk, descend};
    use super::super::placement::{Placement, SideRule};
    use super::*;
    use rumbo_core::frames::Point2;
    use rumbo_core::rng::stream;
    use rumbo_kit::potential::{ChargeForce, Field, Form, Obstacles, Piece};

    const ATTRACTION: Attraction = Attraction { form: Form::Conic, strength: 1.0 };

    fn published() -> Attempt {
        let law = ChargeLaw {
            strength: 8.0,
            exponent: 2.0,
            force: ChargeForce::Consistent,
            range_m: f64::INFINITY,
        };
        let charges = ChargeRules {
            law,
            distance_m: 1.0,
            placement: Placement::Unit,
            side: SideRule::LeastTurn,
            stray_share: 0.0,
            max_charges: 40,
            heading_window: 50,
            forget: false,
        };
        Attempt {
            scale: 1.0,
            is_backward: false,
            repulsion: Repulsion { strength: 1.0, influence_m: 2.0, inflation_m: 0.0 },
            goal_scaling_m: None,
            charges: Some(charges),
        }
    }

    /// Around a rack of 8 m by 1 m, with every length times `unit_m`.
    fn walk(attempt: &Attempt, unit_m: f64) -> Walk {
        let p = |x: f64, y: f64| Point2::new(x, y) * unit_m;
        let corners = [p(-4.0, 6.0), p(4.0, 6.0), p(4.0, 7.0), p(-4.0, 7.0)];
        let rack = (0..4).map(|k| Piece::between(corners[k], corners[(k + 1) % 4])).collect();
        let obstacles = Obstacles::new(&[rack], 2.0 * unit_m).unwrap();
        let field = Field {
            goal: p(0.5, 12.0),
            attraction: ATTRACTION,
            obstacles: &obstacles,
            repulsion: attempt.repulsion,
            goal_scaling_m: attempt.goal_scaling_m,
        };
        let rules = DescentRules {
            step: StepRule::Constant { step_m: 0.02 * unit_m },
            minimum_force: 0.04,
            goal_tolerance_m: 0.05 * unit_m,
            goal_capture_m: 0.0,
            stall_window: 50,
            stall_ratio: 0.1,
            max_steps: 5000,
            minimum_clearance_m: 0.3 * unit_m,
        };
        descend(&field, &rules, attempt.charges.as_ref(), p(0.0, 0.0), &mut stream(1, "test"), &mut || false)
    }

    /// A half is exact in binary numbers: so is the half of a walk.
    #[test]
    fn a_smaller_walk_is_the_given_one_in_a_smaller_hall_bit_by_bit() {
        let given = Attempt { goal_scaling_m: Some(2.0), ..published() };
        let half = Attempt { goal_scaling_m: Some(1.0), ..given.shrunk(0.5, 1.0) };
        let (large, small) = (walk(&given, 1.0), walk(&half, 0.5));
        assert_eq!((large.end, small.end), (End::Arrived, End::Arrived));
        assert!(large.charges.len() > 1);
        let halved: Vec<Point2> = large.points.iter().map(|at| at * 0.5).collect();
        assert_eq!(small.points, halved);
    }

    #[test]
    fn walks_shrink_to_the_clearance_and_then_go_to_and_fro() {
        let all: Vec<Attempt> = published().followed_by(&ATTRACTION, 0.2, 6).collect();
        assert_eq!(all[0], published());
        // It rests at 1 m from a wall, and the smallest walk at 0.25 m.
        let scales: Vec<f64> = all.iter().map(|attempt| attempt.scale).collect();
        let expected = [1.0, 0.5, 0.25, 0.25, 0.25, 0.25];
        assert!(scales.iter().zip(expected).all(|(found, scale)| (found - scale).abs() < 1e-9), "{scales:?}");
        assert!((all[2].repulsion.distance_of_push_m(0.5) - 0.25).abs() < 1e-9);
        assert_eq!(all[2].charges.unwrap().max_charges, 40 * 16);
        assert_eq!(
            all.iter().map(|attempt| attempt.is_backward).collect::<Vec<_>>(),
            [false, false, false, true, false, true]
        );
        let strays = |attempt: &Attempt| attempt.charges.unwrap().stray_share > 0.0;
        assert!(!all[..3].iter().any(strays) && all[3..].iter().all(strays));
    }

    #[test]
    fn nothing_grows_where_there_is_nothing_to_shrink() {
        let wide = Repulsion { inflation_m: 0.6, ..published().repulsion };
        for (repulsion, clearance_m) in [(published().repulsion, 1.5), (wide, 0.3)] {
            let attempt = Attempt { repulsion, ..published() };
            for attempt in attempt.followed_by(&ATTRACTION, clearance_m, 5) {
                assert_eq!((attempt.scale, attempt.repulsion), (1.0, repulsion));
            }
        }
    }
}
