//! Which gray says which occupancy: the reading of map files, turned around.

use super::{ShadeReading, UNKNOWN};

/// A pixel that is written: its gray, and whether it is opaque.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Ink {
    pub gray: u8,
    pub is_opaque: bool,
}

/// The grays of ROS `map_saver` for occupied, free and unknown, and the same where white means occupied.
const USUAL: [u8; 6] = [0, 254, 205, 255, 1, 50];
/// Under transparency.
const MIDDLE: u8 = 128;

/// The pixel for each occupancy from 0 to 100, and for unknown at the end; none where no gray is read as that.
pub(super) fn palette(reading: &ShadeReading, can_be_transparent: bool) -> [Option<Ink>; 102] {
    let mut palette = [None; 102];
    for (place, ink) in palette.iter_mut().enumerate() {
        let wanted = if place > 100 { UNKNOWN } else { place as i8 };
        let says = |gray: &u8| reading.occupancy(f32::from(*gray) / 255.0) == wanted;
        let all: Vec<u8> = (0..=u8::MAX).filter(says).collect();
        // Other readers may round otherwise: the middle of several grays is the safest.
        let gray = USUAL.into_iter().find(says).or_else(|| all.get(all.len() / 2).copied());
        let through = (wanted == UNKNOWN && can_be_transparent).then_some(MIDDLE);
        let opaque = gray.map(|gray| Ink { gray, is_opaque: true });
        *ink = opaque.or(through.map(|gray| Ink { gray, is_opaque: false }));
    }
    palette
}

/// The place of an occupancy in the palette; everything outside 0 to 100 is unknown.
pub(super) fn place(occupancy: i8) -> usize {
    if (0..=100).contains(&occupancy) { usize::from(occupancy.unsigned_abs()) } else { 101 }
}
