//! Grids as the source prints them: cells are (line, column) with line 0 at the top.

use rumbo_kit::GridSize;
use rumbo_kit::proximity::CellKind;
use std::path::PathBuf;

pub fn data(name: &str) -> String {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/natural_landmark").join(name);
    std::fs::read_to_string(path).unwrap()
}

pub fn toml(name: &str) -> toml::Table {
    data(name).parse().unwrap()
}

/// A table of numbers, line 0 first.
pub fn table(name: &str) -> Vec<Vec<f64>> {
    data(name).lines().map(|line| line.split(',').map(|v| v.trim().parse().unwrap()).collect()).collect()
}

#[derive(Clone)]
pub struct SourceGrid {
    pub size: GridSize,
    pub kinds: Vec<CellKind>,
}

impl SourceGrid {
    pub fn free(lines: usize, columns: usize) -> Self {
        let size = GridSize::new(columns, lines);
        Self { size, kinds: vec![CellKind::Free; size.n_cells()] }
    }

    pub fn from_table(table: &[Vec<f64>]) -> Self {
        let mut grid = Self::free(table.len(), table[0].len());
        for (line, cells) in table.iter().enumerate() {
            for (column, value) in cells.iter().enumerate() {
                grid.set(line, column, *value != 0.0);
            }
        }
        grid
    }

    pub fn index(&self, line: usize, column: usize) -> usize {
        self.size.index(column, self.size.height - 1 - line)
    }

    pub fn set(&mut self, line: usize, column: usize, occupied: bool) {
        let cell = self.index(line, column);
        self.kinds[cell] = if occupied { CellKind::Obstacle } else { CellKind::Free };
    }

    /// (line, column) of a cell.
    pub fn line_column(&self, cell: usize) -> (i64, i64) {
        let (col, row) = self.size.col_row(cell);
        ((self.size.height - 1 - row) as i64, col as i64)
    }

    /// (line, column) of a point that is the center of a cell.
    pub fn line_column_of(&self, point: [f64; 2]) -> (i64, i64) {
        self.line_column(self.size.index(point[0] as usize, point[1] as usize))
    }
}

/// A list of `[line, column]`.
pub fn cells(value: &toml::Value) -> Vec<(i64, i64)> {
    let pair = |v: &toml::Value| (v[0].as_integer().unwrap(), v[1].as_integer().unwrap());
    value.as_array().unwrap().iter().map(pair).collect()
}
