//! Scans into occupancy grids: what each beam says about the cells it passes and ends in.
//!
//! Cells are independent binary variables, kept as log-odds with prior zero (Thrun, Burgard, Fox, *Probabilistic
//! Robotics*, 2005, chapter 9). Within one scan each cell changes at most once, and a hit wins over any number of beams
//! that pass.

mod area;
mod beam_ends;
mod evidence;
mod gate;
mod line;
mod painter;
mod pyramid;
mod scan_mapper;

pub use area::AreaFill;
pub use beam_ends::{BeamEnd, BeamEnds, BeamLimits, Mount2};
pub use evidence::{Evidence, EvidenceFault};
pub use gate::{UpdateGate, doubtful_turn};
pub use line::line_cells;
pub use painter::{FreeSpace, ScanPainter};
pub use pyramid::{Grown, Pyramid};
pub use scan_mapper::{Inserted, MapperSettings, ScanMapper};

/// The largest whole number that is not above `value`, without a call into the mathematics library.
#[inline(always)]
fn floor(value: f32) -> i32 {
    let truncated = value as i32;
    truncated - i32::from(truncated as f32 > value)
}

/// The smallest whole number that is not below `value`.
#[inline(always)]
fn ceil(value: f32) -> i32 {
    let truncated = value as i32;
    truncated + i32::from((truncated as f32) < value)
}

#[cfg(test)]
mod tests;
