//! Tables of known answers, for tests.

/// One row of a table.
#[derive(Debug)]
pub struct Row<'a> {
    names: Vec<&'a str>,
    fields: Vec<&'a str>,
}

impl Row<'_> {
    /// What stands in a column.
    pub fn number(&self, column: &str) -> f64 {
        let at = self.names.iter().position(|name| *name == column);
        self.fields[at.unwrap_or_else(|| panic!("no column {column}"))].parse().unwrap()
    }
}

/// Rows of a comma-separated table with a head.
pub fn rows(text: &str) -> Vec<Row<'_>> {
    let mut lines = text.lines().filter(|line| !line.trim().is_empty());
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let rows: Vec<Row<'_>> =
        lines.map(|line| Row { names: names.clone(), fields: line.split(',').collect() }).collect();
    assert!(rows.len() > 3);
    rows
}
