//! Sound: everything but glass returns it; glass does so only when met squarely, and mirrors it otherwise
//! (Hernández Alamilla 2005, section 6.2, on why sonar misses most panes).
//!
//! A decision: opaque surfaces return sound at any angle. Smooth walls mirror it as well when it comes aslant; but edges,
//! frames and furniture answer in most cones of a furnished room, and the source names panes alone as what sonar misses.

use super::lattice::Lattice;
use super::solid::{Ray, Solid};

/// Largest angle between ray and pane normal at which a pane returns an echo.
const SQUARE_RAD: f64 = 6.0 * std::f64::consts::PI / 180.0;
/// After so many mirrors the echo is lost.
const MOST_BOUNCES: usize = 3;
/// A mirrored ray starts this far off the pane, in cells, so that it does not meet it again at once.
const OFF_PANE: f64 = 1e-6;

/// Length of the way, in cells, to what returns the sound; bounces included, as the transducer cannot tell.
pub fn echo(lattice: &Lattice, movers: &[Solid], mut ray: Ray, reach: f64) -> Option<f64> {
    let mut way = 0.0;
    for _ in 0..=MOST_BOUNCES {
        let fixed = lattice.cast(&ray, reach - way);
        let mut hit = fixed.map(|hit| (hit.way, hit.solid.map(|idx| &lattice.solids[idx as usize])));
        for mover in movers {
            if let Some(to_mover) = mover.hit(&ray)
                && hit.is_none_or(|(nearest, _)| to_mover < nearest)
            {
                hit = Some((to_mover, Some(mover)));
            }
        }
        let (to_hit, solid) = hit?;
        way += to_hit;
        if way > reach {
            return None;
        }
        let Some(pane) = solid.filter(|solid| solid.is_glass) else { return Some(way) };
        let at = ray.from + ray.along * to_hit;
        let normal = pane.footprint.normal(at);
        let into_pane = ray.along.dot(&normal);
        if into_pane.abs() >= SQUARE_RAD.cos() {
            return Some(way);
        }
        ray.along -= normal * (2.0 * into_pane);
        ray.from = at + ray.along * OFF_PANE;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sim::solid::{Footprint, Point, Vector};

    fn pane(from: [f64; 2], to: [f64; 2]) -> Solid {
        let footprint = Footprint::Segment { from: from.into(), to: to.into() };
        Solid { footprint, z_min: 0.0, z_max: 9.0, is_glass: true }
    }

    fn shot(lattice: &Lattice, x: f64, degrees: f64) -> Option<f64> {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let ray = Ray::level(Point::new(x, 20.0), Vector::new(cos, sin), 1.0);
        echo(lattice, &[], ray, 1000.0)
    }

    /// A pane at x = 15 and a wall of cells along the bottom, y < 1.
    #[test]
    fn a_pane_answers_only_when_met_squarely() {
        let lattice = Lattice::new((40, 40), 9.0, vec![pane([15.0, 0.0], [15.0, 40.0])], |_, row| row == 0);
        assert_eq!(shot(&lattice, 5.0, 0.0), Some(10.0));
        assert!((shot(&lattice, 5.0, 5.9).unwrap() - 10.0 / 5.9f64.to_radians().cos()).abs() < 1e-9);
        assert!((shot(&lattice, 5.0, -5.9).unwrap() - 10.0 / 5.9f64.to_radians().cos()).abs() < 1e-9);
        // Mirrored to the wall at y = 1: 19 down at 45 degrees, whatever it meets on its way.
        assert!((shot(&lattice, 5.0, -45.0).unwrap() - 19.0 * 2f64.sqrt()).abs() < 1e-5);
        // Mirrored out of the world.
        assert_eq!(shot(&lattice, 5.0, 6.1), None);
    }

    #[test]
    fn sound_is_lost_after_three_mirrors() {
        let panes = |top: f64| vec![pane([25.0, 0.0], [25.0, top]), pane([11.0, 0.0], [11.0, top])];
        // At 45 degrees from (15, 20): x = 25 at y = 30, x = 11 at 44, x = 25 at 58, x = 11 at 72; ceiling at y = 80.
        let lattice = |top| Lattice::new((40, 90), 9.0, panes(top), |_, row| row == 80);
        assert_eq!(shot(&lattice(90.0), 15.0, 45.0), None);
        assert!((shot(&lattice(60.0), 15.0, 45.0).unwrap() - 60.0 * 2f64.sqrt()).abs() < 1e-5);
    }
}
