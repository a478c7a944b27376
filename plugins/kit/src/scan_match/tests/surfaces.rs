//! Surfaces against a slow twin that keeps every line, finite differences, and the pose that a scan was made from.

use super::super::*;
use super::scenes::Scene;
use nalgebra::{Matrix3, Vector3};
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use rumbo_core::frames::{Point2, Pose2, pose2};

/// Counts lines by the cells of their ends, in double precision.
struct Twin {
    cell_m: f64,
    level_from_map: Pose2,
    /// End (cells), normal, weight.
    lines: Vec<([f64; 2], [f64; 2], f64)>,
}

impl Twin {
    /// Weighted mean of squared distances, m², the Hessian and the descent of what lies around a point; none where nothing
    /// does. Without doubt, and with the same share for corners.
    fn fit(&self, points: &ScanPoints, pose: &Pose2) -> SurfaceFit {
        let mut fit = SurfaceFit::default();
        for [x, y, weight] in points.iter() {
            let point = Point2::new(x.into(), y.into());
            let at = self.level_from_map * pose * point;
            let near = self.lines.iter().filter(|(end, ..)| {
                let apart = |axis: usize| (at[axis] / self.cell_m).floor() - end[axis].floor();
                apart(0).abs() <= 1.0 && apart(1).abs() <= 1.0
            });
            let (mut sum, mut cost, mut form, mut descent) = (0.0, 0.0, Matrix3::zeros(), Vector3::zeros());
            let turned = self.level_from_map.rotation * pose.rotation * point.coords;
            for (end, normal, line_weight) in near {
                let distance =
                    normal[0] * (at.x - end[0] * self.cell_m) + normal[1] * (at.y - end[1] * self.cell_m);
                let in_map = self.level_from_map.rotation.inverse() * nalgebra::Vector2::from(*normal);
                let row = Vector3::new(in_map.x, in_map.y, normal[1] * turned.x - normal[0] * turned.y);
                form += row * row.transpose() * *line_weight;
                descent -= row * distance * *line_weight;
                cost += line_weight * distance * distance;
                sum += line_weight;
            }
            if sum > 0.0 {
                let plane = form.fixed_view::<2, 2>(0, 0) / sum;
                let straight = (1.0 - 4.0 * plane.determinant() / 0.3).max(0.0);
                let w = f64::from(weight) * straight;
                fit.hessian += form * (w / sum);
                fit.descent += descent * (w / sum);
                fit.cost_m2 += cost * (w / sum);
                fit.weight += w;
                fit.n_used += usize::from(w > 0.0);
            }
        }
        fit
    }
}

/// A room seen from some poses, with noise along the beams.
fn seen(room: &Scene, pose: &Pose2, sigma_m: f64, seed: u64) -> ScanPoints {
    let mut rng = rumbo_core::rng::stream(seed, "surfaces");
    let mut noisy = ScanPoints::default();
    for [x, y, weight] in room.seen_from(pose, 361).iter() {
        let normal: f64 = StandardNormal.sample(&mut rng);
        let farther = (1.0 + sigma_m * normal / f64::from(x.hypot(y))) as f32;
        noisy.push(x * farther, y * farther, weight);
    }
    noisy
}

/// Where the scans of a map were taken.
fn places() -> impl Iterator<Item = Pose2> {
    (0..12).map(|k| f64::from(k) * 0.5).map(|t| pose2(0.8 * t.cos(), 0.7 * t.sin(), 2.0 * t))
}

fn mapped(room: &Scene, level_from_map: Pose2, sigma_m: f64) -> SurfaceMap {
    let mut surfaces = SurfaceMap::new(0.05, level_from_map);
    for (k, pose) in places().enumerate() {
        surfaces.insert(&seen(room, &pose, sigma_m, k as u64), &pose);
    }
    surfaces
}

#[test]
fn the_fast_sums_are_those_of_a_twin_that_keeps_every_line() {
    let room = Scene::room(0.05);
    for level_from_map in [Pose2::identity(), pose2(3.3, -700.0, 2.2)] {
        let mut surfaces = SurfaceMap::new(0.05, level_from_map);
        let mut twin = Twin { cell_m: 0.05, level_from_map, lines: Vec::new() };
        for (k, pose) in places().take(3).enumerate() {
            let points = seen(&room, &pose, 0.01, k as u64);
            surfaces.insert(&points, &pose);
            let mut normals = surface_normals::SurfaceNormals::default();
            normals.find(&points, 0.05);
            let turn = level_from_map.rotation * pose.rotation;
            for ([x, y, _], facing) in points.iter().zip(&normals.facings).filter(|(_, f)| f.share > 0.0) {
                let end = (level_from_map * pose * Point2::new(x.into(), y.into())).coords / 0.05;
                let normal = turn * nalgebra::Vector2::from(facing.normal.map(f64::from));
                twin.lines.push((end.into(), normal.into(), facing.share.into()));
            }
        }
        let points = seen(&room, &pose2(0.1, 0.2, 0.3), 0.01, 99);
        for pose in [pose2(0.1, 0.2, 0.3), pose2(0.12, 0.17, 0.31), pose2(-0.5, 0.3, 1.0)] {
            let (fast, slow) = (fit_surfaces(&surfaces, &points, &pose, 1e6), twin.fit(&points, &pose));
            assert!(slow.n_used > 30 && fast.n_used.abs_diff(slow.n_used) <= 2, "{fast:?} {slow:?}");
            let size = slow.hessian.amax();
            assert!((fast.hessian - slow.hessian).amax() < 1e-2 * size, "{} {}", fast.hessian, slow.hessian);
            let length = slow.descent.amax();
            assert!(
                (fast.descent - slow.descent).amax() < 1e-2 * length,
                "{} {}",
                fast.descent,
                slow.descent
            );
            assert!((fast.cost_m2 / slow.cost_m2 - 1.0).abs() < 1e-2, "{fast:?} {slow:?}");
        }
    }
}

/// The cells say it to a part of a cell, the surfaces to the noise's share of 361 points.
#[test]
fn a_match_that_is_polished_is_right_to_two_millimeters() {
    let room = Scene::room(0.05);
    let surfaces = mapped(&room, pose2(6.0, 5.0, 0.0), 0.01);
    let settings = MatchSettings::default();
    let (mut before, mut after) = (Vec::new(), Vec::new());
    for k in 0..40 {
        let t = f64::from(k) * 0.3;
        let truth = pose2(0.5 * t.cos(), 0.4 * t.sin(), t);
        let points = seen(&room, &truth, 0.01, 100 + k as u64);
        let start = truth * pose2(0.06 * (3.0 * t).sin(), 0.06 * t.cos(), 0.03 * (2.0 * t).cos());
        let mut found = match_scan(&[room.level()], &points, &start, None, &settings).unwrap();
        let off = |pose: &Pose2| (truth.inverse() * pose).translation.vector.norm();
        before.push(off(&found.map_from_base));
        assert!(PolishSettings::default().polish(&mut found, &surfaces, &points, None, &settings.covariance));
        after.push(off(&found.map_from_base));
        let deviations = found.covariance.diagonal().map(f64::sqrt);
        // The floor of 5 mm and what the distances say.
        assert!(deviations.x > 0.005 && deviations.x < 0.007 && deviations.z < 0.003, "{deviations}");
    }
    for errors in [&mut before, &mut after] {
        errors.sort_by(f64::total_cmp);
    }
    assert!(after[20] < 0.002 && after[38] < 0.004, "{after:?}");
    assert!(before[20] > 2.0 * after[20], "the cells alone are as good: {before:?}");
}

#[test]
fn along_a_corridor_polishing_moves_nothing() {
    let corridor = Scene::corridor(0.05);
    let mut surfaces = SurfaceMap::new(0.05, Pose2::identity());
    for k in 0..5 {
        let pose = pose2(0.2 * f64::from(k), 0.0, 0.0);
        surfaces.insert(&seen(&corridor, &pose, 0.01, k as u64), &pose);
    }
    let truth = pose2(0.1, 0.1, 0.05);
    let points = seen(&corridor, &truth, 0.01, 50);
    let prior = PosePrior {
        map_from_base: pose2(0.3, 0.08, 0.05),
        information: Matrix3::from_diagonal(&Vector3::new(100.0, 100.0, 400.0)),
        residual_variance: 0.15,
    };
    for prior in [None, Some(&prior)] {
        let settings = MatchSettings::default();
        let start = pose2(0.3, 0.08, 0.05);
        let mut found = match_scan(&[corridor.level()], &points, &start, prior, &settings).unwrap();
        assert_eq!(found.seen.blind_axes(), BlindAxes { x: true, y: false, yaw: false });
        let before = found.map_from_base;
        assert!(PolishSettings::default().polish(
            &mut found,
            &surfaces,
            &points,
            prior,
            &settings.covariance
        ));
        let after = found.map_from_base;
        assert!((after.translation.x - before.translation.x).abs() < 1e-3, "{before} {after}");
        assert!((after.translation.y - 0.1).abs() < 0.003, "{after}");
        assert!((after.rotation.angle() - 0.05).abs() < 0.002, "{after}");
        assert!(found.covariance[(0, 0)] > 0.9, "{}", found.covariance);
    }
}

/// What lies elsewhere is not looked for: the match stays as the cells found it.
#[test]
fn a_match_far_from_all_surfaces_stays_as_it_is() {
    let room = Scene::room(0.05);
    let surfaces = mapped(&room, Pose2::identity(), 0.01);
    let points = seen(&room, &Pose2::identity(), 0.01, 7);
    let settings = MatchSettings::default();
    let found = match_scan(&[room.level()], &points, &Pose2::identity(), None, &settings).unwrap();
    for (away, on) in [
        (pose2(0.3, 0.3, 0.0), &surfaces),
        (pose2(1e12, 0.0, 0.0), &surfaces),
        (pose2(0.0, 0.0, 0.0), &SurfaceMap::new(0.05, Pose2::identity())),
    ] {
        let mut moved = ScanMatch { map_from_base: found.map_from_base * away, ..found.clone() };
        let before = ScanMatch { n_evaluations: 0, ..moved.clone() };
        assert!(
            !PolishSettings::default().polish(&mut moved, on, &points, None, &settings.covariance),
            "{away}"
        );
        assert_eq!(ScanMatch { n_evaluations: 0, ..moved }, before);
    }
}

#[test]
fn points_that_are_out_of_reach_add_nothing_and_tiles_that_are_saved_come_back() {
    let room = Scene::room(0.05);
    let mut surfaces = mapped(&room, pose2(1.0, 2.0, 0.5), 0.01);
    let mut points = seen(&room, &Pose2::identity(), 0.01, 7);
    let before = fit_surfaces(&surfaces, &points, &Pose2::identity(), 0.03);
    for (x, y) in [(1e6, 0.0), (-5000.0, 3.0), (3e38, -3e38), (3e38, 3e38)] {
        points.push(x, y, 1.0);
    }
    let after = fit_surfaces(&surfaces, &points, &Pose2::identity(), 0.03);
    assert_eq!(before.n_used, after.n_used);
    assert!((before.hessian - after.hessian).amax() < 1e-3 && after.descent.iter().all(|v| v.is_finite()));
    let n_tiles = surfaces.tiles().count();
    let mut far = ScanPoints::default();
    for (x, y) in [(3e38, -3e38), (3e38, 3e37), (2e37, -3e38)] {
        far.push(x, y, 1.0);
    }
    surfaces.insert(&far, &pose2(0.0, 0.0, 0.1));
    assert_eq!(surfaces.tiles().count(), n_tiles);
    let mut again = SurfaceMap::new(surfaces.resolution_m(), surfaces.level_from_map());
    for (tile, cells) in surfaces.tiles() {
        assert!(again.put_tile(tile, cells));
    }
    assert_eq!(fit_surfaces(&again, &points, &Pose2::identity(), 0.03), after);
    let (tile, cells) = surfaces.tiles().next().unwrap();
    assert!(!again.put_tile([i32::MAX, 0], cells) && !again.put_tile(tile, &cells[1..]));
    assert!(!again.put_tile(tile, &vec![[f32::NAN; 8]; cells.len()]));
}

/// Normals of straight walls are theirs; across an edge there is none that mixes both sides.
#[test]
fn normals_are_those_of_the_walls() {
    let mut rng = rumbo_core::rng::stream(4, "walls");
    let mut normals = surface_normals::SurfaceNormals::default();
    for _ in 0..50 {
        let angle = rng.random::<f64>() * 6.3;
        let (along, across) = ([angle.cos(), angle.sin()], [-angle.sin(), angle.cos()]);
        let mut points = ScanPoints::default();
        // Two walls, the second half a meter and more behind.
        for (from_m, away_m) in [(-1.0, 2.0), (0.02, 3.0)] {
            for k in 0..30 {
                let s = from_m + 0.033 * f64::from(k);
                let [x, y] = [0, 1].map(|i| s * along[i] + away_m * across[i]);
                points.push(x as f32, y as f32, 1.0);
            }
        }
        normals.find(&points, 0.05);
        assert_eq!(normals.facings.len(), 60);
        for facing in &normals.facings {
            let cosine = facing.normal.map(f64::from).iter().zip(across).map(|(a, b)| a * b).sum::<f64>();
            assert!((cosine.abs() - 1.0).abs() < 1e-4, "{angle}: {facing:?}");
            assert!((facing.share - 0.66).abs() < 0.01, "{facing:?}");
        }
    }
    let mut few = ScanPoints::default();
    for (x, y) in [(1.0, 0.0), (1.0, 0.1), (1.0, 5.0)] {
        few.push(x, y, 1.0);
    }
    normals.find(&few, 0.05);
    assert!(normals.facings.iter().all(|facing| facing.share == 0.0 && facing.normal == [0.0; 2]));
}
