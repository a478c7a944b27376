//! From observed landmarks to the places of the map that fit them: filter, relaxation, least squares.

use super::match_score::{heading_rad, heading_scatter_rad, headings_rad, squared_error_m2};
use super::relaxation::{RelationTolerance, Relations, best, relax};
use rumbo_core::frames::{Pose2, wrap_angle};
use rumbo_core::map::Grid;
use rumbo_kit::landmark_model::{
    CellScore, Filter, LandmarkModel, Look, ModelSettings, Similarity, Surroundings, Tracer,
};
use rumbo_kit::landmarks::Landmark;

/// What is known of a map.
#[derive(Debug)]
pub struct Knowledge {
    /// Its cells.
    pub grid: Grid,
    /// Scans on it.
    pub surroundings: Surroundings,
    /// What its cells see.
    pub model: LandmarkModel,
}

impl Knowledge {
    /// Ranges that a scanner at a pose on the map would read along these directions of its own frame, meters: infinite where
    /// nothing is met within `reach_m`, not-a-number where nobody knows.
    pub fn scan(
        &self,
        map_from_sensor: &Pose2,
        directions: &[[f64; 2]],
        reach_m: f64,
        ranges_m: &mut Vec<f64>,
    ) {
        let grid_from_sensor = self.grid.grid_from_map() * map_from_sensor;
        let cell_m = self.surroundings.cell_m();
        let origin = [grid_from_sensor.translation.x / cell_m, grid_from_sensor.translation.y / cell_m];
        let heading_rad = grid_from_sensor.rotation.angle();
        self.surroundings.scan(origin, heading_rad, directions, reach_m, ranges_m);
    }
}

/// When landmarks are the same.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MatchSettings {
    /// How the model was made.
    pub model: ModelSettings,
    /// When two landmarks look alike.
    pub alike: Similarity,
    /// When two pairs of them lie alike.
    pub relation: RelationTolerance,
    /// Several headings of one cell are told apart (not in the source).
    pub tells_headings: bool,
}

/// A cell with a heading.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// The robot there.
    pub map_from_base: Pose2,
    /// Valid assignments (n in the source).
    pub n_matches: usize,
    /// Their sum of squares, m² (E).
    pub squared_error_m2: f64,
    /// Standard deviation of the heading by one assignment, radians.
    pub heading_scatter_rad: f64,
}

/// At least so many valid assignments are needed (section 7.2.2 of the source).
pub const LEAST_MATCHES: usize = 2;
/// Places nearer to each other than this are one, meters.
pub const APART_M: f64 = 0.30;

/// Finds places; keeps its memory.
#[derive(Debug)]
pub struct Matcher {
    settings: MatchSettings,
    filter: Filter,
    tracer: Tracer,
}

impl Matcher {
    /// A matcher with these settings.
    pub fn new(settings: MatchSettings) -> Matcher {
        Matcher { settings, filter: Filter::default(), tracer: Tracer::new(settings.model) }
    }

    /// Cells that see something like the observed.
    pub fn cells(&mut self, known: &Knowledge, observed: &[Landmark]) -> Vec<CellScore> {
        self.filter.pass(&known.model, &Look::around(observed), &self.settings.alike).to_vec()
    }

    /// How many parts of the map the last filter looked at, and of how many.
    pub fn n_parts(&self) -> [usize; 2] {
        self.filter.n_parts()
    }

    /// The places of these cells that are fitted by at least two landmarks, best first: most matches, then smallest error.
    /// Of places nearer than 0.30 m to each other only the best is kept.
    pub fn places(&mut self, known: &Knowledge, cells: &[CellScore], observed: &[Landmark]) -> Vec<Place> {
        let relations = Relations::of(observed);
        let mut places: Vec<Place> = cells
            .iter()
            .flat_map(|score| self.places_of(known, score.cell, (observed, &relations)))
            .collect();
        places.sort_by(|a, b| {
            b.n_matches.cmp(&a.n_matches).then(a.squared_error_m2.total_cmp(&b.squared_error_m2))
        });
        let mut apart: Vec<Place> = Vec::new();
        for place in places {
            let is_known = |better: &Place| {
                let (one, other) = (&place.map_from_base, &better.map_from_base);
                if self.settings.tells_headings { is_one(one, other) } else { is_near(one, other) }
            };
            if !apart.iter().any(is_known) {
                apart.push(place);
            }
        }
        apart
    }

    fn places_of(
        &mut self,
        known: &Knowledge,
        cell: usize,
        (observed, relations): (&[Landmark], &Relations),
    ) -> Vec<Place> {
        let MatchSettings { alike, relation, tells_headings, .. } = self.settings;
        let model = self.tracer.landmarks_of(&known.surroundings, cell);
        let allowed = relax((observed, relations), (model, &Relations::of(model)), &alike, &relation);
        let matched = best(&allowed, observed, model);
        if matched.len() < LEAST_MATCHES {
            return Vec::new();
        }
        let headings = match tells_headings {
            true => headings_rad(&allowed, observed, model),
            false => vec![heading_rad(&matched, observed, model)],
        };
        let center = known.grid.center_of(known.grid.cell_of(cell));
        let grid_heading_rad = known.grid.map_from_grid().rotation.angle();
        let place = |heading: f64| Place {
            map_from_base: Pose2::new(center.coords, wrap_angle(grid_heading_rad + heading)),
            n_matches: matched.len(),
            squared_error_m2: squared_error_m2(&matched, observed, model),
            heading_scatter_rad: heading_scatter_rad(&matched, observed, model),
        };
        headings.into_iter().map(place).collect()
    }
}

/// Two poses are the same place: near each other, and turned alike.
pub fn is_one(a: &Pose2, b: &Pose2) -> bool {
    /// Headings of one place differ by less, radians (20 degrees).
    const TURNED_RAD: f64 = 0.35;
    is_near(a, b) && wrap_angle(a.rotation.angle() - b.rotation.angle()).abs() <= TURNED_RAD
}

fn is_near(a: &Pose2, b: &Pose2) -> bool {
    (a.translation.vector - b.translation.vector).norm() <= APART_M
}
