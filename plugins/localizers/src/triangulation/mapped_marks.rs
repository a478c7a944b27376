//! Places on the map that landmarks come from, and how far the true ones are from them.
//!
//! A grid says only in which cell a wall begins: the wall itself stands up to half a cell away, and does so from wherever
//! it is seen. Such an error does not average out over scans, so each wall, corner and edge keeps its own.

use nalgebra::Vector2;
use rumbo_core::frames::{Point2, Pose2, wrap_angle};
use rumbo_kit::landmarks::{Landmark, LandmarkKind};

/// A landmark where the map has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MappedMark {
    /// A wall; else a point.
    pub is_wall: bool,
    /// The point, or the middle of the wall, on the map, meters.
    pub place: Point2,
    /// Direction of a wall's normal away from where it is seen, radians on the map.
    pub normal_rad: f64,
    /// A wall reaches this far from its middle; a point may be this far from its place. Meters.
    pub reach_m: f64,
}

/// Two views of one wall differ by no more than this in direction, radians (3 degrees), and across, meters.
const SAME_WALL: (f64, f64) = (0.052, 0.025);
/// Pieces of one line that are farther apart than this are two walls, meters.
const GAP_M: f64 = 0.15;
/// What lies farther along a wall than this is a place of its own, meters: its direction is off by too little to say how
/// far a wall is off there.
const LONGEST_M: f64 = 6.0;
/// Two views of one point differ by no more than this, meters, or by what beams leave open.
const SAME_POINT_M: f64 = 0.08;

impl MappedMark {
    /// A landmark seen from a place on the map; `ends` are its outer readings in the sensor's frame.
    pub fn of(mark: &Landmark, ends: [[f64; 2]; 2], map_from_sensor: &Pose2) -> MappedMark {
        let normal_rad = wrap_angle(mark.bearing_rad + map_from_sensor.rotation.angle());
        match mark.kind {
            LandmarkKind::Wall { .. } => {
                let (sin, cos) = mark.bearing_rad.sin_cos();
                let [a, b] = ends.map(|[x, y]| y * cos - x * sin);
                let (middle, foot) = ((a + b) / 2.0, mark.distance_m);
                let place = Point2::new(foot * cos - middle * sin, foot * sin + middle * cos);
                MappedMark {
                    is_wall: true,
                    place: map_from_sensor * place,
                    normal_rad,
                    reach_m: (b - a).abs() / 2.0,
                }
            }
            LandmarkKind::Corner { spacing_m } | LandmarkKind::Discontinuity { spacing_m, .. } => {
                let place = map_from_sensor * Point2::from(mark.position());
                MappedMark { is_wall: false, place, normal_rad, reach_m: spacing_m }
            }
        }
    }

    /// How far another lies along and across this wall, meters.
    fn along_across(&self, other: &Point2) -> [f64; 2] {
        let (sin, cos) = self.normal_rad.sin_cos();
        let way = other - self.place;
        [way.y * cos - way.x * sin, way.x * cos + way.y * sin]
    }

    /// Both are views of the same thing.
    fn is_same(&self, other: &MappedMark) -> bool {
        if self.is_wall || other.is_wall {
            return self.goes_on_as(other) && self.along_across(&other.place)[0].abs() <= LONGEST_M;
        }
        (self.place - other.place).norm() <= SAME_POINT_M.max(other.reach_m)
    }

    /// Both are pieces of one wall without a gap.
    fn goes_on_as(&self, other: &MappedMark) -> bool {
        let [along, across] = self.along_across(&other.place);
        self.is_wall
            && other.is_wall
            && wrap_angle(self.normal_rad - other.normal_rad).abs() <= SAME_WALL.0
            && across.abs() <= SAME_WALL.1
            && along.abs() <= self.reach_m + other.reach_m + GAP_M
    }

    fn distance_m(&self, other: &MappedMark) -> f64 {
        if self.is_wall {
            self.along_across(&other.place)[1].abs()
        } else {
            (self.place - other.place).norm()
        }
    }

    fn extend(&mut self, other: &MappedMark) {
        if self.is_wall {
            let [along, _] = self.along_across(&other.place);
            self.reach_m = self.reach_m.max(along.abs() + other.reach_m);
        }
    }
}

/// A place with how far the true one is from it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KnownMark {
    /// Where the map has it.
    pub mapped: MappedMark,
    /// Of a wall: outwards (meters) and counter-clockwise (radians); of a point: x and y on the map (meters).
    pub offset: Vector2<f64>,
    /// In which scan it was last seen.
    pub last_scan: u64,
}

/// Places that were seen lately, as many as are worth their memory.
#[derive(Debug, Clone, Default)]
pub struct MappedMarks {
    marks: Vec<KnownMark>,
}

/// What became of a place that was looked up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Slot {
    /// It is known.
    Known(usize),
    /// It is new, at the end.
    Added(usize),
    /// It is new, in place of another that was not seen for longest.
    Replaced(usize),
    /// All places belong to this scan.
    Full,
}

impl MappedMarks {
    /// Places that are kept.
    pub const MOST: usize = 48;

    /// All of them.
    pub fn all(&self) -> &[KnownMark] {
        &self.marks
    }

    /// One of them.
    pub fn get(&self, idx: usize) -> Option<&KnownMark> {
        self.marks.get(idx)
    }

    /// What is known of an offset.
    pub fn set_offset(&mut self, idx: usize, offset: Vector2<f64>) {
        if let Some(mark) = self.marks.get_mut(idx) {
            mark.offset = offset;
        }
    }

    /// Takes over offsets, in order.
    pub fn set_offsets(&mut self, offsets: impl Iterator<Item = Vector2<f64>>) {
        for (mark, offset) in self.marks.iter_mut().zip(offsets) {
            mark.offset = offset;
        }
    }

    /// A known piece of the wall that this is a piece of.
    pub fn piece_beside(&self, mapped: &MappedMark) -> Option<usize> {
        let beside = self.marks.iter().enumerate().filter(|(_, mark)| mark.mapped.goes_on_as(mapped));
        let along = |mark: &KnownMark| mark.mapped.along_across(&mapped.place)[0].abs();
        beside.min_by(|(_, a), (_, b)| along(a).total_cmp(&along(b))).map(|(idx, _)| idx)
    }

    /// Finds what was seen in scan number `scan` among the known places, or adds it.
    pub fn find_or_add(&mut self, mapped: MappedMark, scan: u64) -> Slot {
        let known = self.marks.iter().enumerate().filter(|(_, mark)| mark.mapped.is_same(&mapped));
        let nearest = known
            .min_by(|(_, a), (_, b)| a.mapped.distance_m(&mapped).total_cmp(&b.mapped.distance_m(&mapped)));
        if let Some(idx) = nearest.map(|(idx, _)| idx)
            && let Some(mark) = self.marks.get_mut(idx)
        {
            mark.mapped.extend(&mapped);
            mark.last_scan = scan;
            return Slot::Known(idx);
        }
        let fresh = KnownMark { mapped, offset: Vector2::zeros(), last_scan: scan };
        if self.marks.len() < Self::MOST {
            self.marks.push(fresh);
            return Slot::Added(self.marks.len() - 1);
        }
        let oldest = self.marks.iter_mut().enumerate().min_by_key(|(_, mark)| mark.last_scan);
        match oldest.filter(|(_, mark)| mark.last_scan < scan) {
            Some((idx, mark)) => {
                *mark = fresh;
                Slot::Replaced(idx)
            }
            None => Slot::Full,
        }
    }
}
