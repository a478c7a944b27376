//! Which landmark is which: predicted by odometry, checked by geometry. Hernández Alamilla (2005), section 5.2.

use rumbo_core::frames::{Point2, Pose2, wrap_angle};
use rumbo_kit::landmarks::{Landmark, LandmarkKind};
use std::f64::consts::PI;
use std::mem::discriminant;

/// One landmark seen from two places.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Relation {
    /// From the earlier place, A in the source.
    pub known: Landmark,
    /// From the later place, B.
    pub seen: Landmark,
    /// Distance of what was seen from what was predicted, meters.
    pub off_m: f64,
}

/// What may differ between two views of the same landmarks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerances {
    /// From the predicted place to what was seen, meters.
    pub search_m: f64,
    /// Between distances of two landmarks, meters.
    pub distance_m: f64,
    /// Between angles of two walls, radians.
    pub angle_rad: f64,
}

/// How the landmark looks from a place that is `a_from_b` away.
pub fn predicted(mark: &Landmark, a_from_b: &Pose2) -> Landmark {
    let turn_rad = a_from_b.rotation.angle();
    if mark.is_wall() {
        let [x, y] = [a_from_b.translation.x, a_from_b.translation.y];
        let (sin, cos) = mark.bearing_rad.sin_cos();
        let distance = mark.distance_m - (x * cos + y * sin);
        // Beyond the wall its normal points the other way.
        let bearing = mark.bearing_rad - turn_rad + if distance < 0.0 { PI } else { 0.0 };
        return Landmark { distance_m: distance.abs(), bearing_rad: wrap_angle(bearing), ..*mark };
    }
    let place = a_from_b.inverse() * Point2::from(mark.position());
    Landmark { distance_m: place.coords.norm(), bearing_rad: wrap_angle(place.y.atan2(place.x)), ..*mark }
}

fn apart_m(a: &Landmark, b: &Landmark) -> f64 {
    let ([ax, ay], [bx, by]) = (a.position(), b.position());
    (ax - bx).hypot(ay - by)
}

/// Pairs each known landmark with the nearest of its kind around where the odometry says it should be, and drops pairs
/// that do not fit the others. What was seen keeps its nearest partner only.
pub fn relate(known: &[Landmark], seen: &[Landmark], a_from_b: &Pose2, within: &Tolerances) -> Vec<Relation> {
    let mut nearest: Vec<Option<Relation>> = vec![None; seen.len()];
    for known in known {
        let expected = predicted(known, a_from_b);
        let same_kind =
            |(_, seen): &(usize, &Landmark)| discriminant(&seen.kind) == discriminant(&known.kind);
        let candidates = seen.iter().enumerate().filter(same_kind);
        let best = candidates
            .map(|(idx, seen)| {
                (idx, Relation { known: *known, seen: *seen, off_m: apart_m(&expected, seen) })
            })
            .min_by(|(_, a), (_, b)| a.off_m.total_cmp(&b.off_m));
        let Some((idx, relation)) = best.filter(|(_, relation)| relation.off_m <= within.search_m) else {
            continue;
        };
        if let Some(partner) = nearest.get_mut(idx)
            && partner.is_none_or(|other| relation.off_m < other.off_m)
        {
            *partner = Some(relation);
        }
    }
    let mut relations = nearest.into_iter().flatten().collect();
    keep_consistent(&mut relations, within);
    relations
}

/// Drops the relation that disagrees with most others, and of these the one farthest from its prediction, until all agree.
/// Landmarks on a person who walks by go this way.
pub fn keep_consistent(relations: &mut Vec<Relation>, within: &Tolerances) {
    loop {
        let n_against = |a: &Relation| relations.iter().filter(|b| !agree(a, b, within)).count();
        let worst = relations
            .iter()
            .enumerate()
            .map(|(idx, relation)| (idx, n_against(relation), relation.off_m))
            .max_by(|a, b| a.1.cmp(&b.1).then(a.2.total_cmp(&b.2)));
        match worst {
            Some((idx, n, _)) if n > 0 => relations.remove(idx),
            _ => return,
        };
    }
}

/// What two landmarks are to each other does not depend on where they are seen from. Differs from the source, which
/// compares distances of the feet of walls' normals: those move with the robot.
fn agree(a: &Relation, b: &Relation, within: &Tolerances) -> bool {
    match (a.known.is_wall(), b.known.is_wall()) {
        (true, true) => {
            let between = |a: &Landmark, b: &Landmark| b.bearing_rad - a.bearing_rad;
            let off = wrap_angle(between(&a.known, &b.known) - between(&a.seen, &b.seen));
            // A wall that was passed has its normal turned round.
            off.abs() <= within.angle_rad || (PI - off.abs()) <= within.angle_rad
        }
        (true, false) => is_kept(ahead_of_wall(&a.known, &b.known), ahead_of_wall(&a.seen, &b.seen), within),
        (false, true) => is_kept(ahead_of_wall(&b.known, &a.known), ahead_of_wall(&b.seen, &a.seen), within),
        (false, false) => is_kept(apart_m(&a.known, &b.known), apart_m(&a.seen, &b.seen), within),
    }
}

fn is_kept(known_m: f64, seen_m: f64, within: &Tolerances) -> bool {
    (known_m - seen_m).abs() <= within.distance_m
}

/// Distance of a point from a wall.
fn ahead_of_wall(wall: &Landmark, point: &Landmark) -> f64 {
    let (sin, cos) = wall.bearing_rad.sin_cos();
    let [x, y] = point.position();
    wall.distance_m - (x * cos + y * sin)
}

/// Whether a landmark is a discontinuity or corner.
pub fn is_point(mark: &Landmark) -> bool {
    !matches!(mark.kind, LandmarkKind::Wall { .. })
}
