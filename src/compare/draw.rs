//! What a study draws for each seed: start and goal, and what stands and walks around.

mod blocker;
mod furniture;
mod people;
mod rules;

pub use rules::Rules;

use super::free_space::{Ends, FreeSpace};
use super::range::unit;
use rumbo_core::rng::{Rng, stream};
use rumbo_kit::world_file::SolidBox;
use toml::{Table, Value};

/// A world that was changed for one run.
#[derive(Debug, Clone, Default)]
struct Scenery {
    boxes: Vec<SolidBox>,
    persons: Vec<Table>,
    without: Vec<String>,
}

/// The draw of one run, as arguments of `--set`.
///
/// # Errors
/// The world has no room for what the rules want.
pub fn draw(space: &FreeSpace, rules: &Rules, seed: u64, number: u32) -> Result<Vec<String>, String> {
    let mut rng = stream(seed, &format!("compare.draw.{number}"));
    // A draw may leave no room for what is wanted: then others are drawn.
    let drawn = (0..MOST_DRAWS).find_map(|_| attempt(space, rules, seed, &mut rng));
    let (ends, scenery) = drawn.ok_or_else(|| {
        format!("{MOST_DRAWS} draws found no room for what the study wants in this world; see its `draw`")
    })?;
    Ok(sets(rules, &ends, scenery))
}

const MOST_DRAWS: usize = 200;

fn attempt(space: &FreeSpace, rules: &Rules, seed: u64, rng: &mut Rng) -> Option<(Ends, Scenery)> {
    let start = space.place(rng);
    let yaw_deg = (unit(rng) * 360.0 - 180.0).round();
    let mut scenery = Scenery::default();
    let mut ends = Ends { start, yaw_deg, goal: start };
    if rules.moved_furniture > 0.0 {
        furniture::move_some(space, rules.moved_furniture, start, rng, &mut scenery);
    }
    if let Some(clutter) =
        rules.clutter.filter(|clutter| seed.saturating_sub(1).is_multiple_of(clutter.every))
    {
        furniture::clutter(&clutter, start, rng, &mut scenery);
    }
    let ground = space.with(&scenery.boxes);
    if !rules.without_goal {
        let field = ground.ways_from(start)?;
        let reach = rules.way_m.unwrap_or([space.least_way_m(), f64::INFINITY]);
        let way = ground.goal(&field, reach, rng)?;
        ends.goal = way.last().copied()?;
        if let Some(rule) = &rules.in_the_way {
            let way = ground.refined(&way);
            blocker::put((space, &ground), rule, &ends, &way, rng, &mut scenery)?;
        }
    }
    if let Some(rule) = &rules.people {
        people::put(&ground, rule, start, rng, &mut scenery);
    }
    Some((ends, scenery))
}

fn sets(rules: &Rules, ends: &Ends, scenery: Scenery) -> Vec<String> {
    let ([x, y], [goal_x, goal_y], yaw) = (ends.start, ends.goal, ends.yaw_deg);
    let mut sets = vec![format!("world.start={{ x_m = {x:?}, y_m = {y:?}, yaw_deg = {yaw:?} }}")];
    if !rules.without_goal {
        sets.push(format!("mission.waypoints=[{{ x_m = {goal_x:?}, y_m = {goal_y:?} }}]"));
    }
    let mut add = Table::new();
    let list = |tables: Vec<Table>| Value::Array(tables.into_iter().map(Value::Table).collect());
    if !scenery.boxes.is_empty() {
        add.insert("box".into(), list(scenery.boxes.iter().map(table_of).collect()));
    }
    if !scenery.persons.is_empty() {
        add.insert("person".into(), list(scenery.persons));
    }
    if !add.is_empty() {
        sets.push(format!("world.add={}", Value::Table(add)));
    }
    if !scenery.without.is_empty() {
        sets.push(format!("world.without={:?}", scenery.without));
    }
    sets
}

fn table_of(solid: &SolidBox) -> Table {
    let numbers = |values: [f64; 2]| Value::Array(values.map(Value::Float).into());
    let mut table = Table::new();
    table.insert("name".into(), Value::String(solid.name.clone()));
    table.insert("center".into(), numbers(solid.center));
    table.insert("size".into(), numbers(solid.size));
    table.insert("yaw_deg".into(), Value::Float(solid.yaw_rad.to_degrees()));
    table.insert("z_min_m".into(), Value::Float(solid.z_min_m));
    table.insert("z_max_m".into(), Value::Float(solid.z_max_m));
    if solid.material == rumbo_kit::world_file::Material::Glass {
        table.insert("material".into(), Value::String("glass".into()));
    }
    table
}

/// Uniform between two numbers.
fn between([low, high]: [f64; 2], rng: &mut Rng) -> f64 {
    low + (high - low) * unit(rng)
}

/// From `from` so far in a direction.
fn along([x, y]: [f64; 2], direction_rad: f64, way_m: f64) -> [f64; 2] {
    [x + way_m * direction_rad.cos(), y + way_m * direction_rad.sin()]
}

#[cfg(test)]
mod tests;
