//! The way around what closes the field's own: after a turn away the robot goes straight on for a bit, else it would turn
//! back at once to where it came from, and to and fro for ever beside a door jamb that only its memory sees.

use crate::nearest::Side;
use rumbo_core::frames::{Point2, Pose2};

/// A bit of way that the field does not say.
#[derive(Debug, Clone, Copy, Default)]
pub struct Detour {
    /// Where it began, and which way the robot turns.
    began: Option<(Point2, Side)>,
}

impl Detour {
    /// So far the robot goes straight on, meters.
    const LENGTH_M: f64 = 0.3;

    /// The field's way is closed: where to turn, the same way as long as the detour lasts.
    pub fn begin(&mut self, odom_from_base: &Pose2, away: Side) -> Side {
        self.began.get_or_insert((odom_from_base.translation.vector.into(), away)).1
    }

    /// The field's way is open.
    pub fn end(&mut self) {
        self.began = None;
    }

    /// The robot is still on its detour.
    pub fn is_on(&mut self, odom_from_base: &Pose2) -> bool {
        let at = Point2::from(odom_from_base.translation.vector);
        self.began = self.began.filter(|(from, _)| (at - from).norm() < Self::LENGTH_M);
        self.began.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_core::frames::pose2;

    #[test]
    fn a_detour_ends_after_its_length_or_when_the_way_is_open() {
        let mut detour = Detour::default();
        assert!(!detour.is_on(&pose2(0.0, 0.0, 0.0)));
        assert_eq!(detour.begin(&pose2(1.0, 0.0, 0.0), Side::Left), Side::Left);
        // It begins once.
        assert_eq!(detour.begin(&pose2(1.2, 0.0, 0.0), Side::Right), Side::Left);
        assert!(detour.is_on(&pose2(1.29, 0.0, 2.0)) && !detour.is_on(&pose2(1.31, 0.0, 0.0)));
        detour.begin(&pose2(0.0, 0.0, 0.0), Side::Right);
        detour.end();
        assert!(!detour.is_on(&pose2(0.0, 0.0, 0.0)));
    }
}
