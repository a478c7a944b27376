use std::path::Path;

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rumbo_kit::world_file::parse_world;

use super::*;

fn terrain(text: &str) -> Terrain {
    let scene = parse_world(&format!("bounds = [0, 0, 9, 9]\n{text}"), Path::new("hills.toml")).unwrap();
    Terrain::new(&scene, &Pose2::identity(), 1.0)
}

const HILL: &str = "[[ramp]]\ncenter = [3, 2]\nsize = [2, 3]\nyaw_deg = 30\nz_from_m = 0.1\nz_to_m = 0.9\n\
                    [[step]]\ncenter = [5, 2]\nsize = [2.5, 2]\nyaw_deg = -20\nheight_m = 0.5\n";

/// The slow twin walks along the ray in steps of a tenth of a millimeter.
#[test]
fn rays_meet_the_floor_where_a_walk_along_them_does() {
    let terrain = terrain(HILL);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
    let mut n_hits = 0;
    for _ in 0..600 {
        let from = Point::new(rng.random_range(0.0..8.0), rng.random_range(-1.0..5.0));
        let (sin, cos) = rng.random_range(-3.2..3.2f64).sin_cos();
        let z = rng.random_range(0.0..1.5);
        let ray = Ray { from, along: Vector::new(cos, sin), z, slope: rng.random_range(-0.5..0.5) };
        let is_below = |way: f64| {
            let height = terrain.height_m(ray.from + ray.along * way);
            height > 0.0 && ray.z + ray.slope * way <= height
        };
        let walked = (0..100_000).map(|step| f64::from(step) * 1e-4).find(|way| is_below(*way));
        let found = terrain.hit(&ray).filter(|way| *way < 9.99);
        match (walked, found) {
            (Some(walked), Some(found)) => {
                // A ray may graze a corner for less than a step.
                assert!(walked - found < 2e-4 && found - walked < 1e-9, "{walked} {found} {ray:?}");
                n_hits += 1;
            }
            (None, Some(found)) => {
                assert!(!is_below(found + 2e-4) || !is_below(found - 2e-4), "{found} {ray:?}")
            }
            (Some(walked), None) => panic!("missed at {walked}: {ray:?}"),
            (None, None) => {}
        }
    }
    assert!(n_hits > 80, "{n_hits}");
}

/// The slow twin tries every point below the ball.
#[test]
fn a_ball_rests_where_none_of_its_points_is_in_the_floor() {
    let terrain = terrain(HILL);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(4);
    for _ in 0..200 {
        let middle = Point::new(rng.random_range(0.0..8.0), rng.random_range(-1.0..5.0));
        let radius = 0.3;
        let mut slow = radius;
        for (col, row) in (-150..=150).flat_map(|row| (-150..=150).map(move |col| (col, row))) {
            let offset = Vector::new(f64::from(col), f64::from(row)) * (radius / 150.0);
            if offset.norm() <= radius {
                let lift = (radius * radius - offset.norm_squared()).sqrt();
                slow = slow.max(terrain.height_m(middle + offset) + lift);
            }
        }
        let exact = terrain.ball_center_m(middle, radius);
        // A point of the lattice lies within 1.5 mm of the one that bears; the ball is steep at its rim.
        assert!(exact > slow - 1e-9 && exact < slow + 0.03, "{exact} {slow} at {middle}");
    }
}

#[test]
fn on_a_long_incline_a_ball_stands_off_by_its_radius() {
    let terrain = terrain("[[ramp]]\ncenter = [5, 0]\nsize = [10, 4]\nz_to_m = 10\n");
    let found = terrain.ball_center_m(Point::new(5.0, 0.3), 0.25);
    assert!((found - (5.0 + 0.25 * 2f64.sqrt())).abs() < 1e-12, "{found}");
}

#[test]
fn high_edges_and_steep_slopes_bar_the_way_and_what_adjoins_does_not() {
    // A ramp of 0.4 m over 2 m, and a platform that adjoins it.
    let hill = terrain(
        "[[ramp]]\ncenter = [1, 0]\nsize = [2, 2]\nz_to_m = 0.4\n[[step]]\ncenter = [3, 0]\nsize = [2, 2]\nheight_m = 0.4\n",
    );
    let barriers = hill.barriers(0.1, 45f64.to_radians());
    let length = |[from, to]: &[Point; 2]| (to - from).norm();
    // Both long sides of the ramp from where it is 0.1 m high, and three sides of the platform.
    let total_m: f64 = barriers.iter().map(length).sum();
    assert!((total_m - (1.5 + 1.5 + 6.0)).abs() < 0.05, "{total_m} of {barriers:?}");
    assert!(hill.barriers(0.4, 45f64.to_radians()).is_empty());
    // At most 10 degrees: all four sides of the ramp.
    let total_m: f64 = hill.barriers(0.4, 10f64.to_radians()).iter().map(length).sum();
    assert!((total_m - 8.0).abs() < 1e-9, "{total_m}");
}
