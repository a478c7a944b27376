//! The tables that all robots share: where the landmarks are, and whose bar code is which.

use std::collections::BTreeMap;
use std::path::Path;

use super::error::MrclamError;
use super::table::{self, Row, Table};

const LANDMARKS: &str = "Landmark_Groundtruth.dat";
const BARCODES: &str = "Barcodes.dat";

/// A landmark as it was surveyed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LandmarkPlace {
    /// Its number in the data set, by which everybody calls it.
    pub subject: u32,
    /// x and y, meters.
    pub position_m: [f64; 2],
    /// Standard deviations of x and y, meters.
    pub deviation_m: [f64; 2],
}

/// Where the landmarks of a data set are.
///
/// # Errors
/// [`MrclamError`] for a table that is missing or not whole, or a landmark that is there twice.
pub fn read_landmarks(folder: &Path) -> Result<Vec<LandmarkPlace>, MrclamError> {
    let table = table::read(table::find(folder, LANDMARKS)?, "landmark", |words| {
        let subject = table::whole(words, "subject")?;
        let position_m = [words.number("x")?, words.number("y")?];
        let deviation_m =
            [table::not_negative(words, "x_deviation")?, table::not_negative(words, "y_deviation")?];
        Ok(LandmarkPlace { subject, position_m, deviation_m })
    })?;
    let table = table.whole("subject x y x_deviation y_deviation")?;
    once(&table, "landmark", |place| place.subject)?;
    Ok(table.rows.into_iter().map(|row| row.told).collect())
}

/// Which subject has which bar code.
pub(super) fn read_barcodes(folder: &Path) -> Result<BTreeMap<u32, u32>, MrclamError> {
    let table = table::read(table::find(folder, BARCODES)?, "barcode", |words| {
        Ok((table::whole(words, "subject")?, table::whole(words, "barcode")?))
    })?;
    let table = table.whole("subject barcode")?;
    once(&table, "subject", |(subject, _)| *subject)?;
    once(&table, "bar code", |(_, barcode)| *barcode)?;
    Ok(table.rows.into_iter().map(|Row { told: (subject, barcode), .. }| (barcode, subject)).collect())
}

fn once<T>(table: &Table<T>, what: &str, number: impl Fn(&T) -> u32) -> Result<(), MrclamError> {
    let mut lines = BTreeMap::new();
    for row in &table.rows {
        let number = number(&row.told);
        if let Some(first) = lines.insert(number, row.line) {
            let (path, what) = (table.path.clone(), format!("{what} {number}"));
            return Err(MrclamError::Twice { path, line: row.line, first, what });
        }
    }
    Ok(())
}
