//! What closes the way and the least that would open it, in words: what the map shows and what was found on the way are
//! told apart, since a door that somebody shut can be opened again.

use super::found::{Group, groups, near};
use super::obstruction::Obstruction;
use crate::plan_grid::PlanGrid;
use rumbo_core::map::{CellClass, Grid};

/// What the words are made from.
pub struct Explanation<'a> {
    grid: &'a PlanGrid<'a>,
    /// Found on the way.
    found: Vec<Group>,
    needed_m: f64,
    hull_radius_m: f64,
}

/// More obstacles than this are counted, not named.
const MOST_NAMED: usize = 4;

impl<'a> Explanation<'a> {
    /// Compares the plan's grid with the map's, which lacks what was found on the way.
    pub fn new(
        grid: &'a PlanGrid<'a>,
        on_map: Option<&Grid>,
        needed_m: f64,
        hull_radius_m: f64,
    ) -> Explanation<'a> {
        let on_map = on_map.filter(|map| map.cells.len() == grid.cells().cells.len());
        let found = on_map.map_or_else(Vec::new, |map| {
            let is = |grid: &Grid, cell: usize| {
                grid.cells.get(cell).is_some_and(|odds| grid.class_of(*odds) == CellClass::Occupied)
            };
            groups(grid.size, &|cell| is(grid.cells(), cell) && !is(map, cell))
        });
        Explanation { grid, found, needed_m, hull_radius_m }
    }

    /// Anything was found on the way.
    pub fn knows_found(&self) -> bool {
        !self.found.is_empty()
    }

    /// This cell was found on the way.
    pub fn is_found(&self, cell: usize) -> bool {
        self.group_of(cell).is_some()
    }

    /// The sentence.
    pub fn of(&self, obstruction: &Obstruction) -> String {
        let (mut words, named) = match obstruction {
            Obstruction::Narrow { cell, distance } => self.of_narrow(*cell, *distance),
            Obstruction::Closed { cells } => self.of_closed(cells),
        };
        let others: Vec<&Group> = self.found.iter().filter(|group| !named.contains(group)).collect();
        if !others.is_empty() {
            let names: Vec<String> = others.iter().take(MOST_NAMED).map(|group| self.place(group)).collect();
            words += &format!("; also found on the way: {}", names.join(", "));
            if others.len() > MOST_NAMED {
                words += &format!(" and {} more", others.len() - MOST_NAMED);
            }
        }
        words
    }

    fn of_narrow(&self, cell: usize, distance: f64) -> (String, Vec<&Group>) {
        let (at, found_m, needed_m) =
            (self.grid.middle_of(cell), distance * self.grid.resolution_m(), self.needed_m);
        let passage =
            format!("the narrowest passage, at ({:.2}, {:.2}) m, leaves {found_m:.2} m to", at.x, at.y);
        let reach = distance.ceil() as usize + 1;
        let blocker = near(self.grid.size, cell, reach).find_map(|near| self.group_of(near));
        let setting = format!("set minimum_clearance_m to at most {found_m:.2}");
        let hull_m = self.hull_radius_m;
        let fits = found_m > hull_m;
        let words = match (blocker, fits) {
            (Some(group), _) => {
                let or_else = if fits { format!(", or {setting}") } else { String::new() };
                format!(
                    "{passage} what was found on the way {} and is not on the map, where {needed_m:.2} m are kept; take \
                     it away{or_else}",
                    self.place(group)
                )
            }
            (None, true) => {
                format!(
                    "{passage} the nearest obstacle where {needed_m:.2} m are kept; widen it, or {setting}"
                )
            }
            (None, false) => format!(
                "{passage} the nearest obstacle where {needed_m:.2} m are kept; too narrow for the robot, whose radius \
                 is {hull_m:.2} m: open it"
            ),
        };
        (words, blocker.into_iter().collect())
    }

    fn of_closed(&self, cells: &[usize]) -> (String, Vec<&Group>) {
        let mut named: Vec<&Group> = Vec::new();
        for group in cells.iter().filter_map(|cell| self.group_of(*cell)) {
            if !named.contains(&group) {
                named.push(group);
            }
        }
        let on_map: Vec<usize> =
            cells.iter().copied().filter(|cell| self.group_of(*cell).is_none()).collect();
        let mut changes: Vec<String> = named
            .iter()
            .map(|group| format!("take away what was found on the way {}, not on the map", self.place(group)))
            .collect();
        if let Some(&first) = on_map.first() {
            let at = self.grid.middle_of(first);
            let thickness_m = on_map.len() as f64 * self.grid.resolution_m();
            let stands = format!("{thickness_m:.2} m of it, stands at ({:.2}, {:.2}) m", at.x, at.y);
            if named.is_empty() {
                return (format!("every way is closed; the thinnest obstacle, {stands}, on the map"), named);
            }
            changes.push(format!("open what is on the map: {stands}"));
        }
        (format!("every way is closed; the least that opens one: {}", changes.join("; and ")), named)
    }

    fn group_of(&self, cell: usize) -> Option<&Group> {
        self.found.iter().find(|group| group.cells.binary_search(&cell).is_ok())
    }

    /// Where a found obstacle is, and how far it goes across.
    fn place(&self, group: &Group) -> String {
        let at = self.grid.in_map(group.middle());
        format!("at ({:.2}, {:.2}) m, {:.2} m across", at.x, at.y, group.extent() * self.grid.resolution_m())
    }
}
