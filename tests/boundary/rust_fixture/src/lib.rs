//! Planners (and a SLAM) for tests: they panic, hang, talk nonsense, and tell what reached them.
#![allow(clippy::panic)]

mod tracker;

use rumbo_core::frames::Point2;
use rumbo_core::messages::Path;
use rumbo_core::registry::{Params, Plugin};
use rumbo_core::rng::{Rng, RngExt};
use rumbo_core::stages::{BuildContext, BuildError, PlanError, PlanRequest, Planner};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::time::Duration;

/// What the planner does.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Act {
    /// It goes straight to the goal.
    #[default]
    Straight,
    /// It tells the address of the grid's cells in an error.
    Address,
    /// It tells everything that was asked in an error.
    Echo,
    /// It tells three numbers of its random stream in an error.
    Dice,
    /// Its path is not a number.
    NotANumber,
    /// It panics when it is made.
    PanicInCreate,
    /// It panics when it plans.
    PanicInPlan,
    /// It panics when it goes.
    PanicInDrop,
    /// It works until it is asked to give up.
    Loop,
    /// It works for ever.
    Deaf,
}

/// A planner that does what it is told.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
struct ActorParams {
    /// What it does.
    act: Act,
    /// How far it is from the truth, meters.
    distance_m: f64,
}

impl Params for ActorParams {
    fn check(&self) -> Vec<BuildError> {
        if self.distance_m >= 0.0 {
            return Vec::new();
        }
        vec![BuildError::at("distance_m", format!("is {}, expected 0 or more", self.distance_m))]
    }
}

impl Plugin<dyn Planner> for ActorParams {
    fn build(&self, context: &BuildContext) -> Result<Box<dyn Planner>, BuildError> {
        assert!(self.act != Act::PanicInCreate, "made to panic in create");
        Ok(Box::new(Actor { act: self.act, rng: context.rng() }))
    }
}

struct Actor {
    act: Act,
    rng: Rng,
}

impl Planner for Actor {
    fn plan(&mut self, request: &PlanRequest) -> Result<Path, PlanError> {
        let told = |text: String| Err(PlanError::Other(text));
        match self.act {
            Act::Straight | Act::PanicInCreate | Act::PanicInDrop => straight(request, 0.0),
            Act::NotANumber => straight(request, f64::NAN),
            Act::Address => {
                told(request.grid.as_ref().map_or(String::new(), |grid| format!("{:p}", grid.cells.as_ptr())))
            }
            Act::Echo => told(format!(
                "{:?} {:?} {:?} {:?} {:?} {:?}",
                request.stamp,
                request.start,
                request.goal,
                request.robot,
                request.obstacles,
                request
                    .grid
                    .as_ref()
                    .map(|grid| (grid.header(), grid.cells.iter().map(|v| f64::from(*v)).sum::<f64>())),
            )),
            Act::Dice => told(format!("{:?}", [(); 3].map(|()| self.rng.random::<u64>()))),
            Act::PanicInPlan => panic!("made to panic in plan"),
            Act::Loop => {
                while !request.give_up.is_raised() {
                    std::thread::sleep(Duration::from_millis(1));
                }
                Err(PlanError::GivenUp)
            }
            Act::Deaf => loop {
                std::thread::sleep(Duration::from_secs(1));
            },
        }
    }
}

impl Drop for Actor {
    fn drop(&mut self) {
        assert!(self.act != Act::PanicInDrop, "made to panic in drop");
    }
}

fn straight(request: &PlanRequest, off_m: f64) -> Result<Path, PlanError> {
    let start: Point2 = request.start.translation.vector.into();
    let goal = request.goal.position;
    Path::through([start, Point2::new(goal.x + off_m, goal.y)], 1.0)
        .ok_or_else(|| PlanError::Other("no points".to_owned()))
}

rumbo_core::register_planner!(ActorParams, "fixture_actor", "does what it is told, for tests");

rumbo_core::export_plugins!();
