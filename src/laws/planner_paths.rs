//! Laws of planners: what a path is.

use super::law::{Trouble, Verdict, expect};
use super::planners::OnAWay;
use super::subject::Subject;
use super::text_world::TextWorld;
use rumbo_core::frames::{Point2, pose2};
use rumbo_core::map::CellClass;
use rumbo_core::messages::{Check, Path};

/// Steps in which a path is looked at, meters.
const STEP_M: f64 = 0.005;

pub fn joins_start_and_goal(subject: &Subject) -> Verdict {
    let mut way = OnAWay::new(subject)?;
    let mut world = way.world.clone();
    // A start beside the middle of its cell tells those who begin at the middle.
    world.start *= pose2(0.013, -0.017, 0.3);
    let path = way.asked.path(&world)?;
    let start: Point2 = world.start.translation.vector.into();
    let Some(first) = path.points().first() else {
        return Err(Trouble::broken("a path without points", "at least one point"));
    };
    let (off_start_m, off_goal_m) =
        ((first.position - start).norm(), (path.end().position - world.goal.position).norm());
    expect(
        off_start_m <= 1e-6,
        || format!("it begins {off_start_m:.6} m from the start"),
        "a beginning at the start",
    )?;
    let cell_m = world.grid.resolution_m();
    let found = || format!("it ends {off_goal_m:.3} m from the goal");
    expect(off_goal_m <= cell_m, found, format!("an end within {cell_m} m of the goal"))?;
    way.told(format!("ends {off_goal_m:.3} m from the goal"))
}

pub fn touches_nothing(subject: &Subject) -> Verdict {
    let mut way = OnAWay::new(subject)?;
    let world = way.world.clone();
    let path = way.asked.path(&world)?;
    for at in places(&path) {
        let class = world.grid.cell_at(at).map(|cell| world.grid.class(cell));
        let found = || {
            let what = match class {
                Some(CellClass::Occupied) => "through a wall",
                Some(_) => "where nobody knows",
                None => "outside the map",
            };
            format!("it leads {what} at ({:.2}, {:.2}) m", at.x, at.y)
        };
        expect(class == Some(CellClass::Free), found, "free cells only")?;
    }
    way.told(format!("{:.2} m", path.length_m()))
}

pub fn keeps_the_clearance(subject: &Subject) -> Verdict {
    let mut way = OnAWay::new(subject)?;
    let world = way.world.clone();
    let path = way.asked.path(&world)?;
    let parameters = subject.parameters();
    let own_m = ["minimum_clearance_m", "clearance_m"]
        .iter()
        .find_map(|key| parameters.get(*key).and_then(toml::Value::as_float));
    let needed_m = own_m.unwrap_or(0.0).max(subject.robot().hull().outer_radius_m());
    // Planners measure from the middles of cells, the law from their edges.
    let allowed_m = needed_m - world.grid.resolution_m();
    let mut least_m = f64::INFINITY;
    for at in places(&path).step_by(4) {
        least_m = least_m.min(world.clearance_m(at));
        let found = || format!("{least_m:.3} m to a wall at ({:.2}, {:.2}) m", at.x, at.y);
        expect(least_m >= allowed_m, found, format!("at least {needed_m:.2} m, less one cell"))?;
    }
    way.told(format!("{least_m:.2} m at the least, {needed_m:.2} m wanted"))
}

pub fn is_finite(subject: &Subject) -> Verdict {
    let mut way = OnAWay::new(subject)?;
    let world = way.world.clone();
    let mut paths = vec![way.asked.path(&world)?];
    for world in [TextWorld::coarse_rooms()?, TextWorld::hall()?] {
        if way.why_not_rooms.is_empty() {
            paths.push(way.asked.path(&world)?);
        } else {
            let request = way.asked.request(&world);
            paths.extend(way.asked.planner.plan(&request));
        }
    }
    for path in paths {
        path.check().map_err(|fault| Trouble::broken(fault.to_string(), "finite numbers"))?;
    }
    way.told(String::new())
}

pub fn passes_the_heading_on(subject: &Subject) -> Verdict {
    let mut way = OnAWay::new(subject)?;
    let mut world = way.world.clone();
    world.goal.yaw_rad = Some(1.0);
    let yaw_rad = way.asked.path(&world)?.end().yaw_rad;
    expect(yaw_rad == Some(1.0), || format!("the last point's heading is {yaw_rad:?}"), "Some(1.0)")?;
    way.told(String::new())
}

/// Places along a path. A path with numbers that are none has no places: another law says so.
fn places(path: &Path) -> impl Iterator<Item = Point2> + '_ {
    path.points().iter().zip(path.points().iter().skip(1)).flat_map(|(from, to)| {
        let (from, way) = (from.position, to.position - from.position);
        let n_steps = (way.norm() / STEP_M).ceil().min(1e6) as usize;
        (0..=n_steps).map(move |k| from + way * (k as f64 / n_steps.max(1) as f64))
    })
}
