//! The walk down the potential: sections 3.1 and 3.2 of the source.

use super::placement::{Minimum, Placement, Side, SideRule};
use super::trail::Trail;
use nalgebra::Vector2;
use rumbo_core::frames::Point2;
use rumbo_core::rng::{Rng, RngExt};
use rumbo_kit::potential::{ChargeLaw, Field, ON_A_LINE_M, Sample, without_approach};

/// How long the steps are (`l`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepRule {
    /// Always the same, as published.
    Constant {
        /// Meters.
        step_m: f64,
    },
    /// A fifth of the room to the nearest obstacle within these bounds, and half as long after every turn back, so that the
    /// robot settles in a valley instead of jumping to and fro across it.
    Adaptive {
        /// Shortest step, meters.
        least_m: f64,
        /// Longest step, meters.
        most_m: f64,
    },
}

impl StepRule {
    /// No step is longer, meters.
    pub fn longest_m(&self) -> f64 {
        match *self {
            StepRule::Constant { step_m } => step_m,
            StepRule::Adaptive { most_m, .. } => most_m,
        }
    }
}

/// Share of the room to the nearest obstacle that an adaptive step takes.
const ROOM_SHARE: f64 = 0.2;
/// What an adaptive step shrinks by after a turn back, and grows by after every other step.
const SHRINK: f64 = 0.5;
const GROW: f64 = 1.1;
/// A step takes at most this share of the room to the nearest obstacle, so that it never crosses one.
const MOST_OF_ROOM: f64 = 0.5;
/// Charges that are left this far behind may be forgotten, meters.
const FORGOTTEN_BEYOND_M: f64 = 3.0;

/// How a descent goes and when it ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DescentRules {
    /// Lengths of steps.
    pub step: StepRule,
    /// `F_0`: a force below this is a minimum.
    pub minimum_force: f64,
    /// Arrived within this distance, meters.
    pub goal_tolerance_m: f64,
    /// Within this distance of the goal nothing is a minimum, meters.
    pub goal_capture_m: f64,
    /// Standing still is told over so many steps.
    pub stall_window: usize,
    /// Share of the way of those steps that the net displacement must reach.
    pub stall_ratio: f64,
    /// Steps and charges after which the descent ends.
    pub max_steps: usize,
    /// Nearer than this to obstacles the force is not followed into them, meters.
    pub minimum_clearance_m: f64,
}

/// How charges are placed, and what they do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChargeRules {
    /// Potential and force.
    pub law: ChargeLaw,
    /// `ψ`, meters.
    pub distance_m: f64,
    /// How the distance is meant.
    pub placement: Placement,
    /// On which side.
    pub side: SideRule,
    /// Chance that a charge goes to the other side than the rule says: what another walk tries.
    pub stray_share: f64,
    /// More are not placed.
    pub max_charges: usize,
    /// Steps whose net displacement is the heading.
    pub heading_window: usize,
    /// Charges have no effect any more once the robot is nearer to the goal than when they were placed, and far from them.
    pub forget: bool,
}

/// A charge and how it came about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedCharge {
    /// Where it is.
    pub at: Point2,
    /// Where the robot was.
    pub detected_at: Point2,
    /// On which side of the way to the goal.
    pub side: Side,
}

/// How a descent ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End {
    /// At the goal.
    Arrived,
    /// In a minimum, with this force left.
    Minimum {
        /// Its size.
        force: f64,
    },
    /// In a minimum, with all charges placed.
    TooManyCharges,
    /// After all steps.
    OutOfSteps,
    /// The start lies on an obstacle.
    StartInObstacle,
    /// Nearer to an obstacle than the robot may come: obstacles are looked for within less than a step of where they push.
    ClearanceLost {
        /// How near, meters.
        clearance_m: f64,
    },
    /// Nobody waits any more.
    GivenUp,
}

/// What a descent did.
#[derive(Clone, Debug, PartialEq)]
pub struct Walk {
    /// Every place, the start first.
    pub points: Vec<Point2>,
    /// Every charge that was placed, in order.
    pub charges: Vec<PlacedCharge>,
    /// Length of the way, meters.
    pub length_m: f64,
    /// Smallest distance to an obstacle, meters; infinite where none was ever within reach.
    pub clearance_m: f64,
    /// How it ended.
    pub end: End,
}

/// Walks from `start` down the field, with charges where there are rules for them. Looks at `give_up` every few hundred
/// steps.
pub fn descend(
    field: &Field<'_>,
    rules: &DescentRules,
    charge_rules: Option<&ChargeRules>,
    start: Point2,
    rng: &mut Rng,
    give_up: &mut dyn FnMut() -> bool,
) -> Walk {
    let mut descent = Descent {
        field,
        rules,
        charge_rules,
        trail: Trail::from(start),
        placed: Vec::new(),
        active: Vec::new(),
        steps_since_charge: 0,
        clearance_m: f64::INFINITY,
        floor_m: None,
        pace: 1.0,
        last_force: Vector2::zeros(),
    };
    let mut end = End::OutOfSteps;
    for n_done in 0..rules.max_steps {
        if n_done % STEPS_BETWEEN_LOOKS == 0 && give_up() {
            end = End::GivenUp;
            break;
        }
        if let Some(ended) = descent.go_on(rng) {
            end = ended;
            break;
        }
    }
    let Descent { trail, placed, clearance_m, .. } = descent;
    Walk { length_m: trail.length_m(), points: trail.into_points(), charges: placed, clearance_m, end }
}

/// `give_up` is looked at this often.
const STEPS_BETWEEN_LOOKS: usize = 256;

struct Descent<'a> {
    field: &'a Field<'a>,
    rules: &'a DescentRules,
    charge_rules: Option<&'a ChargeRules>,
    trail: Trail,
    placed: Vec<PlacedCharge>,
    /// Places of the charges that push.
    active: Vec<Point2>,
    steps_since_charge: usize,
    clearance_m: f64,
    /// The descent comes no nearer to obstacles than this, meters: a robot that starts nearer may leave.
    floor_m: Option<f64>,
    /// Share of an adaptive step.
    pace: f64,
    last_force: Vector2<f64>,
}

impl Descent<'_> {
    /// One step, or one charge without motion.
    fn go_on(&mut self, rng: &mut Rng) -> Option<End> {
        let at = self.trail.last();
        let goal_distance_m = (self.field.goal - at).norm();
        if goal_distance_m <= self.rules.goal_tolerance_m {
            return Some(End::Arrived);
        }
        let sample = self.field.sample(at);
        self.clearance_m = self.clearance_m.min(sample.clearance_m);
        if let Some(end) = self.too_near(&sample) {
            return Some(end);
        }
        let force = self.force(at, &sample);
        let size = force.norm();
        let is_captured = goal_distance_m <= self.rules.goal_capture_m;
        if !is_captured && (size < self.rules.minimum_force || self.is_stalled()) {
            let Some(rules) = self.charge_rules else { return Some(End::Minimum { force: size }) };
            return self.place(rules, at, &sample, rng);
        }
        if size <= 0.0 {
            return Some(End::Minimum { force: size });
        }
        let step_m = self.step_m(force, sample.clearance_m).min(goal_distance_m);
        self.trail.push(at + force * (step_m / size));
        self.steps_since_charge += 1;
        self.last_force = force;
        self.forget(at, goal_distance_m);
        None
    }

    fn too_near(&mut self, sample: &Sample) -> Option<End> {
        if self.trail.n_steps() == 0 && sample.clearance_m < ON_A_LINE_M {
            return Some(End::StartInObstacle);
        }
        let floor_m = *self.floor_m.get_or_insert(self.rules.minimum_clearance_m.min(sample.clearance_m));
        let is_lost = sample.clearance_m < floor_m - 0.5 * self.least_step_m();
        is_lost.then_some(End::ClearanceLost { clearance_m: sample.clearance_m })
    }

    fn force(&self, at: Point2, sample: &Sample) -> Vector2<f64> {
        let pushed =
            self.charge_rules.map_or_else(Vector2::zeros, |rules| rules.law.force_at(at, &self.active));
        let force = sample.force + pushed;
        // One step further out than the clearance: the step itself ends no nearer than it.
        let kept_m = self.rules.minimum_clearance_m + self.least_step_m();
        if sample.clearance_m < kept_m {
            without_approach(force, at, self.field.obstacles, kept_m)
        } else {
            force
        }
    }

    fn least_step_m(&self) -> f64 {
        match self.rules.step {
            StepRule::Constant { step_m } => step_m,
            StepRule::Adaptive { least_m, .. } => least_m,
        }
    }

    fn step_m(&mut self, force: Vector2<f64>, clearance_m: f64) -> f64 {
        let wanted_m = match self.rules.step {
            StepRule::Constant { step_m } => step_m,
            StepRule::Adaptive { least_m, most_m } => {
                let turns_back = force.dot(&self.last_force) < 0.0;
                self.pace = if turns_back { self.pace * SHRINK } else { (self.pace * GROW).min(1.0) };
                let room_m =
                    (ROOM_SHARE * clearance_m).min(clearance_m - self.rules.minimum_clearance_m - least_m);
                (self.pace * room_m.min(most_m)).max(least_m)
            }
        };
        wanted_m.min(MOST_OF_ROOM * clearance_m)
    }

    fn is_stalled(&self) -> bool {
        let n = self.rules.stall_window;
        if self.trail.n_steps() < n || self.steps_since_charge < n {
            return false;
        }
        let (net, way_m) = self.trail.since(n);
        net.norm() < self.rules.stall_ratio * way_m.max(n as f64 * self.least_step_m())
    }

    fn place(&mut self, rules: &ChargeRules, at: Point2, sample: &Sample, rng: &mut Rng) -> Option<End> {
        if self.placed.len() >= rules.max_charges {
            return Some(End::TooManyCharges);
        }
        let heading = self.trail.heading(rules.heading_window, 0.25 * self.least_step_m());
        let minimum = Minimum { at, goal: self.field.goal, repulsion: sample.repulsion, heading };
        let ruled = rules.side.side(&minimum, rng);
        let side =
            if rules.stray_share > 0.0 && rng.random_bool(rules.stray_share) { ruled.other() } else { ruled };
        let charge = minimum.charge(side, rules.placement, rules.distance_m);
        self.placed.push(PlacedCharge { at: charge, detected_at: at, side });
        self.active.push(charge);
        self.steps_since_charge = 0;
        self.pace = 1.0;
        None
    }

    fn forget(&mut self, at: Point2, goal_distance_m: f64) {
        if !self.charge_rules.is_some_and(|rules| rules.forget) || self.active.is_empty() {
            return;
        }
        let (goal, placed) = (self.field.goal, &self.placed);
        self.active.retain(|charge| {
            let origin = placed.iter().find(|placed| placed.at == *charge);
            let is_passed = origin.is_some_and(|origin| goal_distance_m < (goal - origin.detected_at).norm());
            !(is_passed && (at - charge).norm() > FORGOTTEN_BEYOND_M)
        });
    }
}
