//! Where has the robot come back to? What was seen lately is laid on what was seen there before, wherever it may fit.
//!
//! Some tens of guesses cannot cover how far a robot may be off after hundreds of meters, so places are also looked for
//! where no guess is: Olson, "Real-time correlative scan matching" (2009), over as much room as the way may have drifted. A
//! place that could be several is none.

use super::archive::Archive;
use crate::graph_slam::nearest::NearestTable;
use crate::graph_slam::registration::{Expected, Registered, RegistrationSettings, register};
use crate::graph_slam::surface::{SurfaceLimits, SurfacePoint, Turn, surface_of};
use nalgebra::Matrix3;
use rumbo_core::frames::{Point2, Pose2, pose2};
use rumbo_kit::GridSize;
use rumbo_kit::correlative::{Apart, CorrelativeSearch, FitTable, SearchWindow, turn_step_rad};

/// How places are recognized.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClosingSettings {
    /// Share of the way since a place was seen that the robot may be off.
    pub drift_share: f64,
    /// At most so far is looked, meters; 0 looks nowhere.
    pub most_reach_m: f64,
    /// Places that fit less are none, 0 to 1.
    pub least_score: f64,
    pub(crate) limits: SurfaceLimits,
    pub(crate) registration: RegistrationSettings,
    pub(crate) least_overlap: f64,
    pub(crate) least_agreement: f64,
}

/// A place that the robot has come back to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Recognized {
    /// The step that saw it first.
    pub place: usize,
    /// The newest step, seen from there.
    pub place_from_here: Pose2,
    /// What the pairs of points say of x, y, turn, in the axes of the place.
    pub information: Matrix3<f64>,
    score: f64,
}

/// Places to which there is a shorter way than this need no search, meters.
const TRUSTED_WAY_M: f64 = 15.0;
/// At least so far is looked, meters, and so far to each side turned, radians.
const LEAST_REACH_M: f64 = 1.0;
const REACH_RAD: f64 = 30.0 * std::f64::consts::PI / 180.0;
/// A place elsewhere must fit less than this share of the best one, ...
const MOST_RIVAL: f64 = 0.9;
/// ... where elsewhere is at least so far from it, meters and radians.
const ELSEWHERE: [f64; 2] = [1.0, 0.4];
/// Steps that what was seen lately consists of.
const N_LATELY: usize = 12;
/// Steps of a place lie at most this far from its middle, meters, and come at most so many before or after it.
const PLACE_REACH_M: f64 = 4.0;
const PLACE_STEPS: usize = 12;
/// Places that are this far apart are looked at separately, meters, and at most so many.
const PLACES_APART_M: f64 = 4.0;
const MOST_PLACES: usize = 8;
/// Edge of the cells that are laid on each other, how near a point must lie to fit, and one point is enough so far around,
/// meters.
const CELL_M: f64 = 0.1;
const SIGMA_M: f64 = 0.12;
const THINNED_TO_M: f32 = 0.15;
const N_LEVELS: usize = 8;
const MOST_NODES: usize = 400_000;
/// A registration that moves a place farther than this is of another one, meters and radians.
const MOST_REFINED: [f64; 2] = [0.4, 0.1];

/// Looks for places, and keeps its memory.
#[derive(Debug, Default)]
pub struct Closing {
    search: CorrelativeSearch,
    table: NearestTable,
}

impl Closing {
    /// The place of an earlier visit that fits best what the robot has seen lately, among those that may be here although
    /// only a long way leads to them; `way` is where the robot was at all steps.
    pub fn find(
        &mut self,
        archive: &Archive,
        way: &[Pose2],
        settings: &ClosingSettings,
    ) -> Option<Recognized> {
        let here = way.len().checked_sub(1)?;
        let ways_m = archive.ways_from(here, way);
        let reach_of = |way_m: f64| (LEAST_REACH_M + settings.drift_share * way_m).min(settings.most_reach_m);
        let places = places(archive, way, &ways_m, &reach_of);
        if places.is_empty() {
            return None;
        }
        let oldest = way.len().saturating_sub(N_LATELY);
        let lately = thinned(&surfaces(archive, way, oldest..way.len(), here, &settings.limits));
        let mut best: Option<Recognized> = None;
        for place in places {
            let (Some(from), Some(to)) = (way.get(place), way.get(here)) else { continue };
            let way_m = ways_m.get(place).copied().unwrap_or(f64::INFINITY);
            let window = SearchWindow {
                grid_from_base: from.inverse() * to,
                reach_m: reach_of(way_m),
                reach_rad: REACH_RAD,
                step_rad: 0.0,
                least_score: best.map_or(settings.least_score, |best| best.score),
                most_nodes: MOST_NODES,
            };
            best = self.look(archive, way, place, &lately, &window, settings).or(best);
        }
        best
    }

    /// Lays points on the surroundings of a place; the window is seen from it.
    fn look(
        &mut self,
        archive: &Archive,
        way: &[Pose2],
        place: usize,
        lately: &[SurfacePoint],
        window: &SearchWindow,
        settings: &ClosingSettings,
    ) -> Option<Recognized> {
        let sheet = surfaces(archive, way, around(archive, way, place), place, &settings.limits);
        let (table, grid_from_place) = table_of(&sheet)?;
        let points: Vec<Point2> =
            lately.iter().map(|point| Point2::new(point.at[0].into(), point.at[1].into())).collect();
        let window = SearchWindow {
            grid_from_base: grid_from_place * window.grid_from_base,
            step_rad: turn_step_rad(&points, CELL_M).max(0.008),
            ..*window
        };
        let best = self.search.best(&table, &points, &window, None).ok()??;
        let [distance_m, turn_rad] = ELSEWHERE;
        let apart = Apart { grid_from_base: best.grid_from_base, distance_m, turn_rad };
        let rival = SearchWindow { least_score: MOST_RIVAL * best.score, ..window };
        // A search that gives up has seen too many that fit about as well.
        if self.search.best(&table, &points, &rival, Some(&apart)).ok()?.is_some() {
            return None;
        }
        self.table.fill(sheet.into_iter());
        let expected = Expected {
            reference_from_scan: grid_from_place.inverse() * best.grid_from_base,
            information: Matrix3::zeros(),
            half_at: 1.0,
            first_gate_m: 0.4,
        };
        let found = register(&self.table, lately, &expected, &settings.registration)?;
        is_believed(&found, &expected.reference_from_scan, settings).then_some(Recognized {
            place,
            place_from_here: found.reference_from_scan,
            information: found.information,
            score: best.score,
        })
    }
}

fn is_believed(found: &Registered, place_from_guess: &Pose2, settings: &ClosingSettings) -> bool {
    let off = place_from_guess.inverse() * found.reference_from_scan;
    found.overlap >= settings.least_overlap
        && found.agreement >= settings.least_agreement
        && off.translation.vector.norm() < MOST_REFINED[0]
        && off.rotation.angle().abs() < MOST_REFINED[1]
}

/// Steps in the middle of places that may be here, nearest first.
fn places(archive: &Archive, way: &[Pose2], ways_m: &[f64], reach_of: &dyn Fn(f64) -> f64) -> Vec<usize> {
    let Some(here) = way.last() else { return Vec::new() };
    let off_m = |pose: &Pose2| (pose.translation.vector - here.translation.vector).norm();
    let mut near: Vec<(u64, usize)> = Vec::new();
    for (step, ((pose, way_m), taken)) in way.iter().zip(ways_m).zip(&archive.taken).enumerate() {
        if taken.is_drawn && *way_m > TRUSTED_WAY_M && off_m(pose) < reach_of(*way_m) + 1.0 {
            near.push(((off_m(pose) * 1e6) as u64, step));
        }
    }
    near.sort_unstable();
    let mut middles: Vec<(usize, &Pose2)> = Vec::new();
    for (_, step) in near {
        let Some(pose) = way.get(step) else { continue };
        let apart_m = |other: &Pose2| (other.translation.vector - pose.translation.vector).norm();
        if middles.len() < MOST_PLACES && middles.iter().all(|(_, other)| apart_m(other) >= PLACES_APART_M) {
            middles.push((step, pose));
        }
    }
    middles.into_iter().map(|(step, _)| step).collect()
}

/// Steps of the same visit around a place.
fn around<'a>(archive: &'a Archive, way: &'a [Pose2], place: usize) -> impl Iterator<Item = usize> + 'a {
    let middle = way.get(place).map_or_else(Default::default, |pose| pose.translation.vector);
    let end = (place + PLACE_STEPS + 1).min(archive.len());
    (place.saturating_sub(PLACE_STEPS)..end).filter(move |step| {
        way.get(*step).is_some_and(|pose| (pose.translation.vector - middle).norm() < PLACE_REACH_M)
    })
}

/// The surfaces that some steps saw, seen from one of them.
fn surfaces(
    archive: &Archive,
    way: &[Pose2],
    steps: impl Iterator<Item = usize>,
    seen_from: usize,
    limits: &SurfaceLimits,
) -> Vec<SurfacePoint> {
    let Some(here) = way.get(seen_from).map(Pose2::inverse) else { return Vec::new() };
    let mut points = Vec::new();
    for step in steps {
        let (Some(taken), Some(pose)) = (archive.taken.get(step), way.get(step)) else { continue };
        if taken.is_drawn {
            let turn = Turn::new(&(here * pose));
            let surface = surface_of(&taken.scan, &taken.base_from_sensor, limits);
            points.extend(surface.iter().map(|point| point.seen_from(&turn)));
        }
    }
    points
}

/// One point a small square.
fn thinned(points: &[SurfacePoint]) -> Vec<SurfacePoint> {
    let square = |point: &SurfacePoint| point.at.map(|v| (v / THINNED_TO_M).floor() as i32);
    let mut by_square: Vec<([i32; 2], SurfacePoint)> =
        points.iter().map(|point| (square(point), *point)).collect();
    by_square.sort_by_key(|(square, _)| *square);
    by_square.dedup_by_key(|(square, _)| *square);
    by_square.into_iter().map(|(_, point)| point).collect()
}

/// A table around the points, and where its grid lies.
fn table_of(points: &[SurfacePoint]) -> Option<(FitTable, Pose2)> {
    let (mut low, mut high) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
    for (axis, (low, high)) in low.iter_mut().zip(&mut high).enumerate() {
        for point in points {
            (*low, *high) = (low.min(point.at[axis]), high.max(point.at[axis]));
        }
    }
    if low[0] > high[0] {
        return None;
    }
    let corner = low.map(|v| f64::from(v) - 0.5);
    let cells = |axis: usize| ((f64::from(high[axis]) + 0.5 - corner[axis]) / CELL_M) as usize + 1;
    let size = GridSize::new(cells(0), cells(1));
    let mut marks = vec![0; size.n_cells()];
    for point in points {
        let at = [0, 1].map(|axis| ((f64::from(point.at[axis]) - corner[axis]) / CELL_M) as usize);
        marks.iter_mut().skip(size.index(at[0], at[1])).take(1).for_each(|mark| *mark = 1);
    }
    let table = FitTable::around_marks(size, CELL_M, &marks, SIGMA_M, N_LEVELS);
    Some((table, pose2(-corner[0], -corner[1], 0.0)))
}
