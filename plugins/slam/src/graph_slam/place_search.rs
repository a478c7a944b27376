//! Lays what was seen lately on the surroundings of a place, wherever it may fit, and registers it there.

use super::nearest::NearestTable;
use super::point_table::{RESOLUTION_M, points_of, table_of};
use super::registration::{Expected, Registered, RegistrationSettings, register};
use super::surface::SurfacePoint;
use nalgebra::Matrix3;
use rumbo_core::frames::Pose2;
use rumbo_kit::correlative::{Apart, CorrelativeSearch, SearchWindow, turn_step_rad};

/// An answer elsewhere is at least this far from the best one, meters and radians.
const ELSEWHERE: [f64; 2] = [1.0, 0.4];
/// A registration that moves a place farther than this is of another one, meters and radians.
const MOST_REFINED: [f64; 2] = [0.4, 0.1];

/// Which registrations are believed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Belief {
    pub registration: RegistrationSettings,
    pub least_overlap: f64,
    pub least_agreement: f64,
}

/// What was seen lately, in its place.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Found {
    pub registered: Registered,
    /// How well it fits, 0 to 1.
    pub score: f64,
}

/// Poses near this one are the same answer.
pub(crate) fn apart_from(best: &Pose2) -> Apart {
    let [distance_m, turn_rad] = ELSEWHERE;
    Apart { grid_from_base: *best, distance_m, turn_rad }
}

/// Searches places, and keeps its memory.
#[derive(Debug, Default)]
pub(crate) struct PlaceSearch {
    search: CorrelativeSearch,
    table: NearestTable,
}

impl PlaceSearch {
    /// Where the points fit best on the sheet of a place; the window is seen from the place. With a share, none may fit
    /// elsewhere by more than that share of the best.
    pub fn find(
        &mut self,
        sheet: &[SurfacePoint],
        lately: &[SurfacePoint],
        window: &SearchWindow,
        most_rival: Option<f64>,
        belief: &Belief,
    ) -> Option<Found> {
        let (table, grid_from_place) = table_of(sheet)?;
        let points = points_of(lately);
        let window = SearchWindow {
            grid_from_base: grid_from_place * window.grid_from_base,
            step_rad: turn_step_rad(&points, RESOLUTION_M).max(0.008),
            ..*window
        };
        let best = self.search.best(&table, &points, &window, None).ok()??;
        if let Some(share) = most_rival {
            let rival = SearchWindow { least_score: share * best.score, ..window };
            let apart = apart_from(&best.grid_from_base);
            // A search that gives up has seen too many that fit about as well.
            if self.search.best(&table, &points, &rival, Some(&apart)).ok()?.is_some() {
                return None;
            }
        }
        self.table.fill(sheet.iter().copied());
        let expected = Expected {
            reference_from_scan: grid_from_place.inverse() * best.grid_from_base,
            information: Matrix3::zeros(),
            half_at: 1.0,
            first_gate_m: 0.4,
            // Of several scans together.
            shape: None,
            least_pairs: 0.0,
        };
        let registered = register(&self.table, lately, &expected, &belief.registration)?;
        let off = expected.reference_from_scan.inverse() * registered.reference_from_scan;
        let is_believed = registered.overlap >= belief.least_overlap
            && registered.agreement >= belief.least_agreement
            && off.translation.vector.norm() < MOST_REFINED[0]
            && off.rotation.angle().abs() < MOST_REFINED[1];
        is_believed.then_some(Found { registered, score: best.score })
    }
}
