//! A pipeline before it runs: the map, where the robot starts, where it goes, and what its sensors see.

use crate::load::Ready;
use crate::record::{Recorder, RunRecord, SeenRegion};
use rumbo_core::engine::{Engine, EngineError, Observer as _, StepView};
use rumbo_core::frames::{Point2, flatten};
use rumbo_core::messages::{Data, LaserScan, Observation};

/// The first step of the pipeline, seen from above.
pub fn preview(ready: &Ready, file: &str) -> Result<RunRecord, EngineError> {
    let mut engine = Engine::build(&ready.pipeline)?;
    let mut recorder = Recorder::default();
    // A world that is over before its first step still has a map.
    let _ = engine.step();
    recorder.on_step(&engine.view());
    let view = engine.view();
    let seen = seen(&view, ready);
    let mut record = recorder.finish(&ready.pipeline, file, view.map, ready.config.clone());
    record.seen = seen;
    record.events.clear();
    engine.shut_down();
    Ok(record)
}

fn seen(view: &StepView<'_>, ready: &Ready) -> Vec<SeenRegion> {
    let map_from_base = view.truth.map_or(view.map_from_base, |truth| flatten(&truth.map_from_base));
    let region = |observation: &Observation| {
        let Data::LaserScan(scan) = &observation.data else { return None };
        let map_from_sensor = map_from_base * flatten(&observation.base_from_sensor);
        let sensor = ready.pipeline.sensors.get(usize::from(observation.sensor.0))?;
        let to_map = |point: Point2| {
            let point = map_from_sensor * point;
            [point.x, point.y]
        };
        let outline = outline(scan).into_iter().map(to_map).collect();
        Some(SeenRegion { sensor: sensor.stage.name.clone(), outline })
    };
    view.observations.iter().filter_map(region).collect()
}

/// The region that a scan covers, in the sensor's frame.
fn outline(scan: &LaserScan) -> Vec<Point2> {
    let beams = scan.ranges_m.iter().enumerate().map(|(idx, range)| {
        let reach = if range.is_nan() { 0.0 } else { range.min(scan.max_range_m) };
        let bearing_rad = scan.bearing_rad(idx);
        Point2::new(bearing_rad.cos(), bearing_rad.sin()) * f64::from(reach)
    });
    std::iter::once(Point2::origin()).chain(beams).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_beam_into_nothing_ends_at_the_reach_of_the_device() {
        let scan = LaserScan {
            bearing_step_rad: std::f64::consts::FRAC_PI_2,
            max_range_m: 8.0,
            ranges_m: vec![2.0, f32::INFINITY, f32::NAN].into(),
            ..LaserScan::default()
        };
        let outline = outline(&scan);
        let expected = [[0.0, 0.0], [2.0, 0.0], [0.0, 8.0], [0.0, 0.0]];
        for (point, [x, y]) in outline.iter().zip(expected) {
            assert!((point - Point2::new(x, y)).norm() < 1e-9, "{outline:?}");
        }
    }
}
