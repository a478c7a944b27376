//! Particles that take the odometer for wrong: wheels slip, and some odometers count backward motion forward.

use super::particles::Particles;
use nalgebra::UnitComplex;
use rand::RngExt;
use rumbo_core::frames::{Pose2, wrap_angle};
use rumbo_core::rng::Rng;

/// What slipping wheels leave of the way: none of it, too much of it, or the reverse.
const SLIPPED_WAY: std::ops::Range<f64> = -1.5..1.5;

/// Some particles, where they were before a motion.
#[derive(Debug, Default)]
pub struct Slipping(Vec<(usize, [f64; 3], f64)>);

impl Slipping {
    /// Draws this share of the particles before they are moved.
    pub fn draw(particles: &Particles, share: f64, rng: &mut Rng) -> Slipping {
        if share <= 0.0 {
            return Slipping::default();
        }
        let slipping = particles.iter().enumerate().filter_map(|(idx, pose)| {
            let slips = rng.random::<f64>() < share;
            slips.then(|| (idx, pose, rng.random_range(SLIPPED_WAY)))
        });
        Slipping(slipping.collect())
    }

    /// Puts them where their own share of the way leads to; the turn is as the odometer says.
    pub fn put(self, way: &Pose2, particles: &mut Particles) {
        for (idx, [x, y, yaw], share) in self.0 {
            let ahead = UnitComplex::new(yaw) * way.translation.vector * share;
            particles.put(idx, [x + ahead.x, y + ahead.y, wrap_angle(yaw + way.rotation.angle())]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_core::frames::pose2;

    #[test]
    fn the_asked_share_goes_its_own_way_forward_and_back() {
        let mut particles = Particles::default();
        (0..4000).for_each(|_| particles.push([1.0, 2.0, std::f64::consts::FRAC_PI_2]));
        let slipping = Slipping::draw(&particles, 0.1, &mut rumbo_core::rng::stream(1, "slip"));
        let n = slipping.0.len() as f64;
        assert!((n - 400.0).abs() < 5.0 * 360f64.sqrt(), "{n}");
        slipping.put(&pose2(0.4, 0.0, 0.2), &mut particles);
        let moved: Vec<[f64; 3]> = particles.iter().filter(|[_, _, yaw]| *yaw > 1.7).collect();
        assert_eq!(moved.len() as f64, n);
        assert!(moved.iter().all(|[x, y, _]| (x - 1.0).abs() < 1e-12 && (1.4..2.6).contains(y)));
        assert!(moved.iter().any(|[_, y, _]| *y < 1.6) && moved.iter().any(|[_, y, _]| *y > 2.5));
        assert!(Slipping::draw(&particles, 0.0, &mut rumbo_core::rng::stream(1, "slip")).0.is_empty());
    }
}
