use super::*;
use nalgebra::Vector2;
use rand::RngExt;
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::pose2;
use rumbo_core::rng::{self, Rng};
use std::f64::consts::{FRAC_PI_2, TAU};

const PERIOD_S: f64 = 0.2;

/// What beams can meet: discs, and straight walls.
#[derive(Default, Clone)]
struct Scene {
    discs: Vec<(Point2, f64)>,
    walls: Vec<(Point2, Point2)>,
}

impl Scene {
    /// Way to the nearest thing along a ray.
    fn cast(&self, eye: Point2, along: Vector2<f64>) -> f64 {
        let disc = |(center, radius): &(Point2, f64)| {
            let to = center - eye;
            let (ahead, off) = (to.dot(&along), to.x * along.y - to.y * along.x);
            let half = radius.powi(2) - off.powi(2);
            if half < 0.0 || ahead < 0.0 { f64::INFINITY } else { ahead - half.sqrt() }
        };
        let wall = |(from, to): &(Point2, Point2)| {
            let (piece, start) = (to - from, from - eye);
            let across = along.x * piece.y - along.y * piece.x;
            let way = (start.x * piece.y - start.y * piece.x) / across;
            let share = (start.x * along.y - start.y * along.x) / across;
            if way >= 0.0 && (0.0..=1.0).contains(&share) { way } else { f64::INFINITY }
        };
        self.discs.iter().map(disc).chain(self.walls.iter().map(wall)).fold(f64::INFINITY, f64::min)
    }

    /// Half a degree over the half circle ahead, within ±15 mm.
    fn scan(&self, pose: &Pose2, rng: &mut Rng) -> LaserScan {
        let step_rad = 0.5f64.to_radians();
        let eye = Point2::from(pose.translation.vector);
        let ranges: Vec<f32> = (0..361)
            .map(|idx| {
                let bearing = -FRAC_PI_2 + step_rad * f64::from(idx) + pose.rotation.angle();
                let way = self.cast(eye, Vector2::new(bearing.cos(), bearing.sin()));
                if way > 8.0 { f32::INFINITY } else { (way + rng.random_range(-0.015..0.015)) as f32 }
            })
            .collect();
        LaserScan {
            first_bearing_rad: -FRAC_PI_2,
            bearing_step_rad: step_rad,
            min_range_m: 0.05,
            max_range_m: 8.0,
            ranges_m: Buffer::from(&ranges[..]),
            ..LaserScan::default()
        }
    }

    /// Legs of somebody who has walked so far.
    fn with_legs(&self, middle: Point2, heading_rad: f64, walked_m: f64) -> Scene {
        let ahead = Vector2::new(heading_rad.cos(), heading_rad.sin());
        let left = Vector2::new(-ahead.y, ahead.x) * 0.125;
        let step = ahead * ((TAU * walked_m / 1.4).sin() * 0.35);
        let mut scene = self.clone();
        scene.discs.extend([(middle + left + step, 0.0625), (middle - left - step, 0.0625)]);
        scene
    }
}

/// A room with a box.
fn room() -> Scene {
    let mut scene = Scene::default();
    let corners = [(-3.0, -4.0), (7.0, -4.0), (7.0, 4.0), (-3.0, 4.0)].map(|(x, y)| Point2::new(x, y));
    scene.walls.extend((0..4).map(|k| (corners[k], corners[(k + 1) % 4])));
    let sides = [(5.0, -3.5), (5.5, -3.5), (5.5, -3.0), (5.0, -3.0)].map(|(x, y)| Point2::new(x, y));
    scene.walls.extend((0..4).map(|k| (sides[k], sides[(k + 1) % 4])));
    scene
}

/// A room with things of all kinds that stand, none of which a map explains: also a chair, another box, a pillar, and a
/// door that stands open.
fn furnished() -> Scene {
    let mut scene = room();
    let legs = [(2.0, 1.0), (2.4, 1.0), (2.4, 1.4), (2.0, 1.4)].map(|(x, y)| (Point2::new(x, y), 0.02));
    scene.discs.extend(legs);
    let sides = [(3.0, -1.5), (3.5, -1.5), (3.5, -1.0), (3.0, -1.0)].map(|(x, y)| Point2::new(x, y));
    scene.walls.extend((0..4).map(|k| (sides[k], sides[(k + 1) % 4])));
    scene.discs.push((Point2::new(1.2, -1.2), 0.2));
    scene.walls.push((Point2::new(4.5, 4.0), Point2::new(4.2, 3.2)));
    scene
}

fn at(k: usize) -> Time {
    Time::from_secs(PERIOD_S * k as f64)
}

/// A robot that drives and turns as a slow one does, pushed about by 2 mm.
fn on_the_way(k: usize) -> Pose2 {
    let time_s = PERIOD_S * k as f64;
    let (turning, driving) = ((time_s % 20.0).min(10.0), (time_s % 20.0 - 10.0).max(0.0));
    pose2(0.15 * driving, 0.002 * (k % 3) as f64, -0.7 + turning * 8.5f64.to_radians())
}

#[test]
fn what_stands_never_moves_while_the_robot_drives_and_turns() {
    for seed in 0..5 {
        let mut rng = rng::stream(seed, "still");
        let mut moving = MovingClusters::new(MoverTuning::default());
        let scene = furnished().with_legs(Point2::new(1.5, 2.5), 0.4, 0.2);
        for k in 0..300 {
            let pose = on_the_way(k);
            moving.see(at(k), &scene.scan(&pose, &mut rng), &pose, |_| false);
            let found: Vec<Mover> = moving.movers(at(k)).collect();
            assert!(found.is_empty(), "seed {seed}, scan {k}: {found:?}");
        }
    }
}

/// Mean errors of position and velocity of the one who walks, and the time until he is known.
fn follow(speed_m_s: f64, heading_rad: f64, seed: u64, drives: bool) -> (f64, f64, f64) {
    let mut rng = rng::stream(seed, "walker");
    let mut moving = MovingClusters::new(MoverTuning::default());
    let velocity = Vector2::new(heading_rad.cos(), heading_rad.sin()) * speed_m_s;
    let start = Point2::new(3.0, 0.0) - velocity * 2.0;
    let (mut known_s, mut errors) = (f64::INFINITY, Vec::new());
    for k in 0..20 {
        let time_s = PERIOD_S * k as f64;
        let middle = start + velocity * time_s;
        let pose = if drives { pose2(0.2 * time_s, 0.0, 0.1 * time_s) } else { pose2(0.0, 0.0, 0.0) };
        let scene = room().with_legs(middle, heading_rad, speed_m_s * time_s);
        moving.see(at(k), &scene.scan(&pose, &mut rng), &pose, |_| false);
        for mover in moving.movers(at(k)) {
            known_s = known_s.min(time_s);
            assert!((mover.position - middle).norm() < 0.8, "nobody else moves: {mover:?} at {middle}");
            errors.push(((mover.position - middle).norm(), (mover.velocity - velocity).norm()));
        }
    }
    let mean = |pick: fn(&(f64, f64)) -> f64| errors.iter().map(pick).sum::<f64>() / errors.len() as f64;
    (known_s, mean(|e| e.0), mean(|e| e.1))
}

#[test]
fn who_walks_is_found_with_the_speed_that_he_has() {
    for drives in [false, true] {
        for (idx, speed_m_s) in [0.5, 0.8, 1.2].into_iter().enumerate() {
            let mut means = [0.0; 3];
            for direction in 0..8 {
                let heading_rad = TAU * f64::from(direction) / 8.0;
                let (known_s, off_m, off_m_s) =
                    follow(speed_m_s, heading_rad, direction as u64 + idx as u64, drives);
                assert!(known_s <= 2.4, "{speed_m_s} m/s to {heading_rad}: known after {known_s} s");
                for (mean, value) in means.iter_mut().zip([known_s, off_m, off_m_s]) {
                    *mean += value / 8.0;
                }
            }
            assert!(means[1] < 0.2 && means[2] < 0.35, "{speed_m_s} m/s: {means:?}");
        }
    }
}

/// Numbers of who is followed at each scan while somebody walks behind a pillar at 1 m/s.
fn behind_a_pillar(radius_m: f64) -> Vec<Vec<u64>> {
    let mut rng = rng::stream(1, "pillar");
    let mut moving = MovingClusters::new(MoverTuning::default());
    let here = pose2(0.0, 0.0, 0.0);
    let mut pillar = Scene::default();
    pillar.discs.push((Point2::new(1.5, 0.0), radius_m));
    let numbers = (0..35).map(|k| {
        let walked_m = PERIOD_S * f64::from(k);
        let scene = pillar.with_legs(Point2::new(3.0, -3.0 + walked_m), FRAC_PI_2, walked_m);
        let stamp = at(k as usize);
        moving.see(stamp, &scene.scan(&here, &mut rng), &here, |_| false);
        moving.movers(stamp).map(|mover| mover.number).collect()
    });
    numbers.collect()
}

#[test]
fn who_goes_behind_a_pillar_is_carried_on_and_behind_a_thin_one_stays_the_same() {
    let thin = behind_a_pillar(0.08);
    assert!(thin[8..].iter().all(|found| *found == thin[8] && found.len() == 1), "{thin:?}");
    let broad = behind_a_pillar(0.2);
    assert!(broad[8..].iter().all(|found| !found.is_empty()), "{broad:?}");
    assert_eq!(broad[34].len(), 1, "whoever came out is one again");
}

#[test]
fn who_stops_stands_and_who_is_gone_is_forgotten() {
    let mut rng = rng::stream(2, "stops");
    let mut moving = MovingClusters::new(MoverTuning::default());
    let here = pose2(0.0, 0.0, 0.0);
    let mut moves = Vec::new();
    for k in 0..40 {
        let walked_m = (0.8 * PERIOD_S * k as f64).min(2.0);
        let scene = Scene::default().with_legs(Point2::new(2.5, -1.0 + walked_m), FRAC_PI_2, walked_m);
        moving.see(at(k), &scene.scan(&here, &mut rng), &here, |_| false);
        moves.push(moving.movers(at(k)).count());
    }
    // Stops at 2.5 s.
    assert_eq!((moves[10], moves[23], moves[39]), (1, 0, 0), "{moves:?}");
    assert_eq!(moving.everybody(at(39)).count(), 1, "and is still known as somebody who walked");
    let mut moving = MovingClusters::new(MoverTuning::default());
    for k in 0..20 {
        let walked_m = 0.8 * PERIOD_S * k as f64;
        let scene = if k < 10 {
            Scene::default().with_legs(Point2::new(2.5, -1.0 + walked_m), FRAC_PI_2, walked_m)
        } else {
            Scene::default()
        };
        moving.see(at(k), &scene.scan(&here, &mut rng), &here, |_| false);
        assert!(
            k < 13 || moving.movers(at(k)).count() == 0,
            "light goes through where he would be, scan {k}"
        );
    }
}

#[test]
fn what_the_map_explains_is_not_followed() {
    let mut rng = rng::stream(3, "map");
    let mut moving = MovingClusters::new(MoverTuning::default());
    let here = pose2(0.0, 0.0, 0.0);
    for k in 0..15 {
        let scene =
            Scene::default().with_legs(Point2::new(2.5, -1.0 + 0.16 * k as f64), FRAC_PI_2, 0.16 * k as f64);
        moving.see(at(k), &scene.scan(&here, &mut rng), &here, |point| point.x > 2.0);
        assert_eq!(moving.movers(at(k)).count(), 0);
    }
}

#[test]
fn scans_without_a_number_and_without_beams_change_nothing() {
    let mut rng = rng::stream(4, "odd");
    let mut moving = MovingClusters::new(MoverTuning::default());
    let here = pose2(0.0, 0.0, 0.0);
    let odd = |ranges: &[f32]| LaserScan {
        bearing_step_rad: 0.01,
        max_range_m: 8.0,
        ranges_m: Buffer::from(ranges),
        ..LaserScan::default()
    };
    let none =
        [odd(&[]), odd(&[f32::NAN; 361]), odd(&[f32::INFINITY; 9]), odd(&[-1.0; 9]), LaserScan::default()];
    for (k, scan) in none.iter().enumerate() {
        moving.see(at(k), scan, &here, |_| false);
        assert_eq!(moving.movers(at(k)).count(), 0);
    }
    // Amid them somebody is found all the same, and the same scan twice is no news.
    for k in 10..30 {
        let walked_m = 0.8 * PERIOD_S * (k - 10) as f64;
        let scan = Scene::default()
            .with_legs(Point2::new(2.5, -1.0 + walked_m), FRAC_PI_2, walked_m)
            .scan(&here, &mut rng);
        moving.see(at(k), if k % 5 == 4 { &none[1] } else { &scan }, &here, |_| false);
        let before: Vec<Mover> = moving.movers(at(k)).collect();
        moving.see(at(k), &scan, &here, |_| false);
        assert_eq!(before, moving.movers(at(k)).collect::<Vec<_>>());
    }
    assert_eq!(moving.movers(at(29)).count(), 1);
    assert_eq!(moving.movers(Time::from_secs(60.0)).count(), 0, "nobody goes on for a minute unseen");
}
