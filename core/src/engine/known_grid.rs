//! The grid as it was when somebody last asked for a way: what an avoider compares with what it sees.

use crate::map::Grid;
use crate::messages::Obstacle;

/// A map's grid with the obstacles that are on no map. Shares the map's cells for as long as both are the same; afterwards it
/// keeps its own memory and writes into that, so that a map which grows scan by scan is not copied into fresh memory each time.
#[derive(Debug, Default)]
pub(super) struct KnownGrid(Option<Grid>);

impl KnownGrid {
    /// As the map is now.
    pub fn renew(&mut self, map: Option<&Grid>, obstacles: &[Obstacle]) {
        match (&mut self.0, map) {
            (Some(known), Some(map)) if is_copy(known, map) => {
                known.cells.make_mut().copy_from_slice(&map.cells);
            }
            (known, map) => *known = map.cloned(),
        }
        let Some(known) = &mut self.0 else { return };
        for obstacle in obstacles {
            known.occupy_disc(obstacle.position, obstacle.radius_m);
        }
    }

    /// None before anybody asked.
    pub fn get(&self) -> Option<&Grid> {
        self.0.as_ref()
    }
}

/// Cells of its own that nobody else holds, with room for the map's.
fn is_copy(known: &Grid, map: &Grid) -> bool {
    known.cells.is_unique() && known.header() == map.header()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::Point2;
    use crate::time::Time;

    fn start(grid: &Grid) -> *const f32 {
        grid.cells.as_slice().as_ptr()
    }

    #[test]
    fn a_map_that_changes_is_copied_into_the_same_memory_again_and_again() {
        let (mut map, mut known) = (Grid::unknown(10, 10, 1.0).unwrap(), KnownGrid::default());
        known.renew(Some(&map), &[]);
        assert_eq!(start(known.get().unwrap()), start(&map), "shared");
        map.cells.make_mut()[5] = 1.0;
        let (own, of_map) = (start(known.get().unwrap()), start(&map));
        for k in 6..9 {
            map.cells.make_mut()[k] = 1.0;
            known.renew(Some(&map), &[]);
            assert_eq!(known.get(), Some(&map));
            assert_eq!((start(known.get().unwrap()), start(&map)), (own, of_map));
        }
        let larger = Grid::unknown(20, 10, 1.0).unwrap();
        known.renew(Some(&larger), &[]);
        assert_eq!(known.get(), Some(&larger));
        known.renew(None, &[]);
        assert_eq!(known.get(), None);
    }

    #[test]
    fn who_holds_what_was_known_keeps_it_and_obstacles_go_with_the_next_time() {
        let (map, mut known) = (Grid::unknown(10, 10, 1.0).unwrap(), KnownGrid::default());
        let obstacle = Obstacle { position: Point2::new(5.5, 5.5), radius_m: 0.1, stamp: Time::ZERO };
        known.renew(Some(&map), &[obstacle]);
        let held = known.get().unwrap().clone();
        assert_ne!(held, map);
        known.renew(Some(&map), &[]);
        assert_eq!(known.get(), Some(&map));
        assert_ne!(held, map, "somebody plans with it");
    }
}
