//! Plugins that keep what they are given where the test can look, and answer what the test laid out.

use rumbo_core::frames::{Point2, Twist};
use rumbo_core::map::Map;
use rumbo_core::messages::{Estimate, Observation, Observations, Obstacle, Path, Prior, Seen, StampedPose};
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::robot::Robot;
use rumbo_core::stages::*;
use rumbo_core::trace::Drawing;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::cell::RefCell;

/// What a double was given last, and what it shall answer: one for each test's thread.
#[derive(Default)]
pub struct Desk {
    pub map: Option<Map>,
    pub seen: Vec<Observation>,
    pub prior: Option<Prior>,
    pub estimate: Option<Estimate>,
    pub robot: Option<Robot>,
    pub obstacles: Vec<Obstacle>,
    pub path: Option<Path>,
    pub trajectory: Vec<StampedPose>,
    pub answers: Vec<String>,
    pub cells_at: usize,
    pub kept: Option<Vec<u8>>,
    pub estimate_to_give: Option<Estimate>,
    pub observations_to_give: Vec<Observation>,
    pub steering_to_give: Option<Steering>,
    pub plan_error: Option<PlanError>,
    pub context: Option<BuildContext>,
    pub random: Vec<u64>,
    pub dropped: u32,
}

thread_local! {
    static DESK: RefCell<Desk> = RefCell::default();
}

pub fn desk<T>(look: impl FnOnce(&mut Desk) -> T) -> T {
    DESK.with_borrow_mut(look)
}

/// How a double misbehaves.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct DoubleParams {
    /// Panics when it is made.
    pub panic_in_create: bool,
    /// Panics when it is called.
    pub panic_in_call: bool,
    /// Panics when it is dropped.
    pub panic_in_drop: bool,
    /// Weights of nothing.
    pub weights: Vec<f64>,
}

impl Params for DoubleParams {
    fn check(&self) -> Vec<BuildError> {
        let negative = self.weights.iter().position(|w| *w < 0.0);
        let fault = |idx| {
            BuildError::at(format!("weights[{idx}]"), "is negative, expected at least 0").help("leave it out")
        };
        negative.map(fault).into_iter().collect()
    }
}

struct Double {
    params: DoubleParams,
}

impl Double {
    fn made(params: &DoubleParams, context: &BuildContext) -> Double {
        assert!(!params.panic_in_create, "made to panic in create");
        use rand::Rng as _;
        let mut rng = context.rng();
        desk(|desk| {
            desk.context = Some(context.clone());
            desk.random = (0..3).map(|_| rng.next_u64()).collect();
        });
        Double { params: params.clone() }
    }

    fn called(&self, cx: Option<&Cx<'_>>) {
        if let Some(cx) = cx {
            cx.trace.count("calls", 1.0);
            cx.trace.draw(|| Drawing::Points { name: "dots", points: vec![Point2::new(1.0, 2.0)] });
        }
        assert!(!self.params.panic_in_call, "made to panic in a call");
    }
}

impl Drop for Double {
    fn drop(&mut self) {
        desk(|desk| desk.dropped += 1);
        assert!(!self.params.panic_in_drop, "made to panic in drop");
    }
}

macro_rules! double {
    ($params:ident, $stage:ident, $register:ident, $name:literal, $manifest:expr) => {
        #[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
        #[serde(transparent)]
        struct $params(DoubleParams);
        impl Params for $params {
            fn check(&self) -> Vec<BuildError> {
                self.0.check()
            }
        }
        impl Plugin<dyn $stage> for $params {
            fn manifest(&self) -> Manifest {
                $manifest
            }
            fn build(&self, context: &BuildContext) -> Result<Box<dyn $stage>, BuildError> {
                Ok(Box::new(Double::made(&self.0, context)))
            }
        }
        rumbo_core::$register!($params, $name, "a double");
    };
}
double!(PlannerParams, Planner, register_planner, "double", Manifest::default());
double!(AvoiderParams, Avoider, register_avoider, "double", Manifest::default());
double!(LocalizerParams, Localizer, register_localizer, "double", Manifest::default());
double!(BuilderParams, MapBuilder, register_map_builder, "double", Manifest::default());
double!(SlamParams, Slam, register_slam, "double", Manifest::default());
double!(SensorParams, Sensor, register_sensor, "double", Manifest::default());

impl Planner for Double {
    fn plan(&mut self, request: &PlanRequest) -> Result<Path, PlanError> {
        self.called(None);
        request.trace.count("expansions", 12.0);
        desk(|desk| {
            desk.map = Some(request.map.clone());
            desk.cells_at = request.grid.as_ref().map_or(0, |grid| grid.cells.as_ptr().addr());
            desk.robot = Some(request.robot.as_ref().clone());
            desk.obstacles.clone_from(&request.obstacles);
            desk.answers = vec![format!(
                "{} {:?} {:?} {}",
                request.stamp,
                request.start,
                request.goal,
                request.give_up.is_raised()
            )];
            match desk.plan_error.clone() {
                Some(error) => Err(error),
                None => desk.path.clone().ok_or(PlanError::GivenUp),
            }
        })
    }
}

impl Avoider for Double {
    fn steer(&mut self, cx: &mut Cx<'_>, input: &AvoidInput<'_>) -> Result<Steering, AvoidError> {
        self.called(Some(cx));
        desk(|desk| {
            desk.map = Some(input.map.clone());
            desk.cells_at = input.grid.map_or(0, |grid| grid.cells.as_ptr().addr());
            desk.seen = input.seen.iter().cloned().collect();
            desk.estimate = Some(input.estimate.clone());
            desk.path = input.path.cloned();
            desk.obstacles = input.obstacles.to_vec();
            desk.answers = vec![format!("{:?} {:?}", input.map_from_base, input.twist)];
            Ok(desk.steering_to_give.clone().unwrap_or(Steering::Drive(Twist::ZERO)))
        })
    }
}

impl Localizer for Double {
    fn start(&mut self, prior: &Prior, map: &Map) -> Result<(), LocalizeError> {
        desk(|desk| (desk.prior, desk.map) = (Some(prior.clone()), Some(map.clone())));
        Ok(())
    }

    fn update(&mut self, cx: &mut Cx<'_>, seen: Seen<'_>, map: &Map) -> Result<Estimate, LocalizeError> {
        self.called(Some(cx));
        desk(|desk| {
            desk.seen = seen.iter().cloned().collect();
            desk.map = Some(map.clone());
            desk.estimate_to_give.clone().ok_or(LocalizeError::NotStarted)
        })
    }
}

/// What builders do to a map: each layer is changed in place.
fn change(map: &mut Map) {
    if let Some(grid) = &mut map.grid {
        desk(|desk| desk.cells_at = grid.cells.as_ptr().addr());
        grid.cells.make_mut()[0] += 1.0;
    }
    for grid in &mut map.coarse_grids {
        grid.cells.make_mut()[0] += 1.0;
    }
    if let Some(voxels) = &mut map.voxels {
        voxels.chunks.reverse();
    }
    map.touch();
}

impl MapBuilder for Double {
    fn start(&mut self, map: &mut Map) -> Result<(), MapError> {
        desk(|desk| *map = desk.map.clone().unwrap_or_default());
        Ok(())
    }

    fn insert(&mut self, cx: &mut Cx<'_>, input: &MapInput<'_>, map: &mut Map) -> Result<(), MapError> {
        desk(|desk| {
            desk.seen = input.seen.iter().cloned().collect();
            desk.estimate = Some(input.estimate.clone());
        });
        change(map);
        self.called(Some(cx));
        Ok(())
    }

    fn save(&self, map: &mut Map) -> Result<Option<Vec<u8>>, MapError> {
        change(map);
        Ok(desk(|desk| desk.kept.clone()))
    }
}

impl Slam for Double {
    fn start(&mut self, prior: &Prior, map: &mut Map) -> Result<(), SlamError> {
        desk(|desk| desk.prior = Some(prior.clone()));
        map.grid = None;
        Ok(())
    }

    fn update(&mut self, cx: &mut Cx<'_>, seen: Seen<'_>, map: &mut Map) -> Result<Estimate, SlamError> {
        self.called(Some(cx));
        desk(|desk| desk.seen = seen.iter().cloned().collect());
        change(map);
        desk(|desk| desk.estimate_to_give.clone()).ok_or(SlamError::Other("nothing laid out".into()))
    }

    fn relocate(&mut self, prior: &Prior, map: &mut Map) -> Result<(), SlamError> {
        change(map);
        desk(|desk| desk.prior = Some(prior.clone()));
        if *prior == Prior::Unknown { Err(SlamError::CannotRelocate) } else { Ok(()) }
    }

    fn trajectory(&self) -> Result<Vec<StampedPose>, SlamError> {
        assert!(!self.params.panic_in_call, "made to panic in a call");
        Ok(desk(|desk| desk.trajectory.clone()))
    }

    fn save_map(&self, map: &mut Map) -> Result<(), SlamError> {
        change(map);
        desk(|desk| if desk.map.is_some() { Ok(()) } else { Err(SlamError::Other("nothing to draw".into())) })
    }

    fn save(&self) -> Result<Vec<u8>, SlamError> {
        Ok(vec![1, 2, 250])
    }
}

impl Sensor for Double {
    fn poll(
        &mut self,
        cx: &mut Cx<'_>,
        world: &mut dyn World,
        out: &mut Observations,
    ) -> Result<(), SensorError> {
        self.called(Some(cx));
        let asked = crate::worlds::ask_everything(world);
        let lent = out.buffer(7);
        desk(|desk| {
            desk.answers = asked;
            desk.answers.push(format!("lent {:?}", lent.as_slice()));
            for observation in &desk.observations_to_give {
                out.push(observation.clone());
            }
        });
        Ok(())
    }

    fn derive(
        &mut self,
        _: &mut Cx<'_>,
        inputs: Seen<'_>,
        out: &mut Observations,
    ) -> Result<(), SensorError> {
        for observation in inputs.iter() {
            out.push(observation.clone());
        }
        Ok(())
    }
}
