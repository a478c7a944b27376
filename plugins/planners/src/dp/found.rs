//! Obstacles that were found on the way: cells that are occupied for this plan and not on the map.

use rumbo_kit::GridSize;

/// Cells that were found together.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// Its cells, in the order of the grid.
    pub cells: Vec<usize>,
    /// First and last column, first and last row.
    bounds: [usize; 4],
}

/// Cells with less than this between them are one obstacle: laser hits and arcs of sonars leave gaps, in cells.
const GAP: usize = 4;

impl Group {
    /// Middle of the box around it, in cells.
    pub fn middle(&self) -> [f64; 2] {
        let [left, right, bottom, top] = self.bounds;
        [(left + right + 1) as f64 / 2.0, (bottom + top + 1) as f64 / 2.0]
    }

    /// Its greatest extent, in cells: the diagonal of the box around it.
    pub fn extent(&self) -> f64 {
        let [left, right, bottom, top] = self.bounds;
        let (columns, rows) = (right - left, top - bottom);
        // One cell wide is one cell wide, not the diagonal of it.
        if columns == 0 || rows == 0 {
            (columns.max(rows) + 1) as f64
        } else {
            ((columns + 1) as f64).hypot((rows + 1) as f64)
        }
    }
}

/// The found cells, grouped.
pub fn groups(size: GridSize, is_found: &dyn Fn(usize) -> bool) -> Vec<Group> {
    let mut left: Vec<bool> = (0..size.width * size.height).map(is_found).collect();
    let mut groups = Vec::new();
    for first in 0..left.len() {
        if !std::mem::replace(&mut left[first], false) {
            continue;
        }
        let mut cells = vec![first];
        let mut n_spread = 0;
        while let Some(&cell) = cells.get(n_spread) {
            n_spread += 1;
            for near in near(size, cell, GAP) {
                if std::mem::replace(&mut left[near], false) {
                    cells.push(near);
                }
            }
        }
        cells.sort_unstable();
        let (columns, rows) = (|cell| size.col_row(cell).0, |cell| size.col_row(cell).1);
        let span = |of: &dyn Fn(usize) -> usize| {
            cells
                .iter()
                .map(|cell| of(*cell))
                .fold([usize::MAX, 0], |[least, most], at| [least.min(at), most.max(at)])
        };
        let ([left_most, right_most], [bottom, top]) = (span(&columns), span(&rows));
        groups.push(Group { bounds: [left_most, right_most, bottom, top], cells });
    }
    groups
}

/// The cells of the square around a cell.
pub fn near(size: GridSize, cell: usize, reach: usize) -> impl Iterator<Item = usize> {
    let (col, row) = size.col_row(cell);
    let rows = row.saturating_sub(reach)..(row + reach + 1).min(size.height);
    rows.flat_map(move |row| {
        let columns = col.saturating_sub(reach)..(col + reach + 1).min(size.width);
        columns.map(move |col| size.index(col, row))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_with_small_gaps_are_one_obstacle_and_others_are_not() {
        let picture = "\
            x..x......\n\
            ..........\n\
            .........x\n\
            .........x\n\
            .........x\n";
        let found: Vec<bool> = picture.split_whitespace().flat_map(str::chars).map(|c| c == 'x').collect();
        let size = GridSize::new(10, 5);
        let groups = groups(size, &|cell| found[cell]);
        assert_eq!(groups.len(), 2);
        assert_eq!((groups[0].cells.as_slice(), groups[0].extent()), ([0, 3].as_slice(), 4.0));
        assert_eq!((groups[1].cells.as_slice(), groups[1].extent()), ([29, 39, 49].as_slice(), 3.0));
        assert_eq!((groups[0].middle(), groups[1].middle()), ([2.0, 0.5], [9.5, 3.5]));
        assert!(super::groups(size, &|_| false).is_empty());
    }

    #[test]
    fn a_slanting_obstacle_is_as_wide_as_its_diagonal() {
        let size = GridSize::new(8, 8);
        let groups = groups(size, &|cell| size.col_row(cell).0 == size.col_row(cell).1);
        assert_eq!(groups.len(), 1);
        assert!((groups[0].extent() - 8.0 * 2f64.sqrt()).abs() < 1e-12);
    }
}
