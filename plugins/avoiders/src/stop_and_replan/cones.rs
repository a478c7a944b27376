//! The cones of a sonar ring as they lie in the map when it was read.

use rumbo_core::frames::{Point2, Point3, Pose2, Pose3, wrap_angle};
use rumbo_core::messages::RangeRing;

/// One transducer's cone, and what it heard.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    /// The transducer in the map.
    pub tip: Point2,
    /// Direction of the axis in the map, radians.
    pub axis_rad: f64,
    /// Half of the opening, radians.
    pub half_rad: f64,
    /// Way to the nearest echo, meters; infinite where nothing is within reach.
    pub range_m: f64,
}

impl Cone {
    /// Whether a direction of the map lies within the cone, widened by so much on both sides.
    pub fn covers(&self, direction_rad: f64, widened_rad: f64) -> bool {
        wrap_angle(direction_rad - self.axis_rad).abs() <= self.half_rad + widened_rad
    }

    /// Points at the echo's distance, over the whole cone and not farther apart than this: it may come from any of them.
    pub fn arc(&self, spacing_m: f64) -> impl Iterator<Item = Point2> + use<> {
        const MOST: f64 = 1000.0;
        let Cone { tip, axis_rad, half_rad, range_m } = *self;
        let n_steps = (half_rad * range_m / spacing_m).ceil().clamp(1.0, MOST) as i32;
        (-n_steps..=n_steps).map(move |step| {
            let angle_rad = axis_rad + half_rad * f64::from(step) / f64::from(n_steps);
            tip + nalgebra::Vector2::new(angle_rad.cos(), angle_rad.sin()) * range_m
        })
    }
}

/// The cones with a reading whose axes are within `within_rad` of straight ahead.
pub fn cones_ahead(
    ring: &RangeRing,
    base_from_sensor: Pose3,
    map_from_base: Pose2,
    within_rad: f64,
) -> impl Iterator<Item = Cone> {
    let in_base = move |bearing_rad: f64, distance_m: f64| {
        let (sin, cos) = bearing_rad.sin_cos();
        (base_from_sensor * Point3::new(distance_m * cos, distance_m * sin, 0.0)).xy()
    };
    let (step_rad, first_rad) = (ring.bearing_step_rad, ring.first_bearing_rad);
    ring.ranges_m.iter().enumerate().filter_map(move |(idx, range)| {
        let range_m = heard_m(*range, ring)?;
        let bearing_rad = first_rad + step_rad * idx as f64;
        let tip = in_base(bearing_rad, ring.ring_radius_m);
        let along = in_base(bearing_rad, ring.ring_radius_m + 1.0) - tip;
        let axis_in_base_rad = along.y.atan2(along.x);
        let is_ahead = axis_in_base_rad.abs() <= within_rad + 1e-9;
        is_ahead.then(|| Cone {
            tip: map_from_base * tip,
            axis_rad: wrap_angle(axis_in_base_rad + map_from_base.rotation.angle()),
            half_rad: ring.cone_rad / 2.0,
            range_m,
        })
    })
}

/// The range of a reading, infinite without an echo; none for a reading that says nothing.
fn heard_m(range: f32, ring: &RangeRing) -> Option<f64> {
    if range > ring.max_range_m {
        return Some(f64::INFINITY);
    }
    (range >= ring.min_range_m).then_some(f64::from(range))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_core::boundary::Buffer;
    use rumbo_core::frames::{lift, pose2};
    use std::f64::consts::{FRAC_PI_2, PI};

    fn ring(ranges: &[f32]) -> RangeRing {
        RangeRing {
            first_bearing_rad: 0.0,
            bearing_step_rad: PI / 4.0,
            cone_rad: 0.4,
            ring_radius_m: 0.2,
            min_range_m: 0.15,
            max_range_m: 6.0,
            ranges_m: Buffer::from(ranges),
        }
    }

    #[test]
    fn cones_stand_where_the_transducers_were_and_say_what_they_heard() {
        let heard = [0.5, 7.0, f32::NAN, 1.0, 1.0, 1.0, 0.1, f32::INFINITY];
        let here = pose2(1.0, 2.0, FRAC_PI_2);
        let cones: Vec<Cone> = cones_ahead(&ring(&heard), Pose3::identity(), here, 1.6).collect();
        assert_eq!(cones.len(), 3, "{cones:?}: behind, not a number and too near are left out");
        assert!((cones[0].tip - Point2::new(1.0, 2.2)).norm() < 1e-12);
        assert!((cones[0].axis_rad - FRAC_PI_2).abs() < 1e-12 && (cones[0].range_m - 0.5).abs() < 1e-6);
        assert!(cones[1].range_m.is_infinite() && cones[2].range_m.is_infinite());
        assert!(
            (cones[2].axis_rad - FRAC_PI_2 / 2.0).abs() < 1e-12,
            "the right one of a robot that looks left"
        );
        // A ring that is mounted backwards hears with its hindmost transducer what is ahead.
        let turned: Vec<Cone> =
            cones_ahead(&ring(&heard), lift(&pose2(-0.1, 0.0, PI)), pose2(0.0, 0.0, 0.0), 0.1).collect();
        assert_eq!(turned.len(), 1);
        assert!((turned[0].tip - Point2::new(0.1, 0.0)).norm() < 1e-12 && turned[0].range_m == 1.0);
    }

    #[test]
    fn the_arc_spans_the_cone_without_gaps() {
        let cone = Cone { tip: Point2::new(1.0, -1.0), axis_rad: 3.0, half_rad: 0.2, range_m: 0.8 };
        let points: Vec<Point2> = cone.arc(0.025).collect();
        assert!(points.iter().all(|point| ((point - cone.tip).norm() - 0.8).abs() < 1e-12));
        assert!(points.windows(2).all(|pair| (pair[1] - pair[0]).norm() <= 0.025 + 1e-12));
        let span = (points[points.len() - 1] - points[0]).norm();
        assert!((span - 2.0 * 0.8 * 0.2f64.sin()).abs() < 1e-12);
        let off = |point: &Point2| (point - cone.tip).y.atan2((point - cone.tip).x);
        assert!(points.iter().all(|point| cone.covers(off(point), 1e-9)));
        assert!(
            !cone.covers(2.79, 0.0) && cone.covers(2.79, 0.02) && !cone.covers(-3.0, 0.0),
            "over the half turn"
        );
    }
}
