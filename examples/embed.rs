//! Rumbo inside another program: a pipeline from a text, stepped by hand, with orders through the one door.
//!
//! `cargo run --release --example embed`
#![allow(clippy::print_stdout)]

use rumbo_core::engine::{Engine, Order, State, Stepped};
use rumbo_core::frames::Point2;
use rumbo_core::messages::Goal;
use rumbo_core::pipeline::Loaded;
use std::path::Path;

const PIPELINE: &str = r#"
world = { plugin = "sim", map = "worlds/office-20m.yaml", start = { x_m = 3.0, y_m = 4.5, yaw_deg = 90.0 } }
sensor = [{ name = "laser", plugin = "lms200" }, { name = "wheels", plugin = "wheel_encoders" }]
map_builder = { plugin = "static_map" }
localizer = { plugin = "odometry" }
planner = { plugin = "dp" }
avoider = { plugin = "stop_and_replan" }
"#;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let registry = rumbo::registry()?;
    // Relative paths in the text start from the folder of this name.
    let name = Path::new("pipelines/embedded.toml");
    let loaded = Loaded::from_text(name, PIPELINE, &[], &registry);
    let pipeline = loaded.sound().ok_or_else(|| loaded.lines().join("\n"))?;
    let mut engine = Engine::build(pipeline)?;
    let goal = Goal { position: Point2::new(3.1, 8.0), yaw_rad: None };
    let mut asked = false;
    loop {
        match engine.step() {
            Stepped::Went => {}
            Stepped::Ended => break,
            Stepped::Failed(error) => return Err(error.into()),
        }
        let view = engine.view();
        for event in view.events {
            println!("{} {}", event.stamp, event.kind);
        }
        let state = view.state;
        if state == State::Waiting && asked {
            break;
        }
        if state == State::Waiting {
            engine.command(Order::GoTo(vec![goal]));
            asked = true;
        }
    }
    let at = engine.map_from_base().translation;
    println!("the robot stands at ({:.2}, {:.2}) m", at.x, at.y);
    Ok(())
}
