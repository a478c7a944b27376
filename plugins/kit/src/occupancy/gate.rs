//! When a scan is worth inserting: a robot that stands would only make the map surer of the same errors.

use rumbo_core::frames::Pose2;
use rumbo_core::stages::BuildError;

/// Remembers the pose of the last insertion.
#[derive(Debug, Clone)]
pub struct UpdateGate {
    distance_m: f64,
    angle_rad: f64,
    last: Option<Pose2>,
}

impl UpdateGate {
    /// Opens after more than this way or turn.
    pub fn new(distance_m: f64, angle_rad: f64) -> UpdateGate {
        UpdateGate { distance_m, angle_rad, last: None }
    }

    /// Whether the robot has moved enough; the first pose always has. A scanner with a narrow view must not turn past
    /// what it saw last: a quarter of its field is the most.
    pub fn is_open(&self, map_from_base: &Pose2, field_of_view_rad: f64) -> bool {
        let Some(last) = &self.last else { return true };
        let step = last.inverse() * map_from_base;
        let most_turn_rad = self.angle_rad.min(field_of_view_rad / 4.0);
        step.translation.vector.norm() > self.distance_m || step.rotation.angle().abs() > most_turn_rad
    }

    /// Where the last scan was inserted from.
    pub fn last(&self) -> Option<Pose2> {
        self.last
    }

    /// A scan was inserted from here.
    pub fn close(&mut self, map_from_base: &Pose2) {
        self.last = Some(*map_from_base);
    }
}

/// The doubt about turns of `turn_deg` degrees between two scans of a map (parameter `key`), where a sensor sees only
/// `narrowest_view_rad` radians: with 57 degrees and 52 of turn two scans share 9.5 % (Arroyo Sánchez 2013's default).
pub fn doubtful_turn(key: &str, turn_deg: f64, narrowest_view_rad: Option<f64>) -> Option<BuildError> {
    let view_deg = narrowest_view_rad?.to_degrees();
    let most_deg = view_deg / 4.0;
    if turn_deg <= most_deg {
        return None;
    }
    let message = format!(
        "is {turn_deg}, more than a quarter of the {view_deg:.0} degrees that a sensor sees: scans of the map that follow \
         each other would have too little in common"
    );
    // Rounded down, so that what is advised is not doubtful itself.
    let advised_deg = (10.0 * most_deg).floor() / 10.0;
    Some(BuildError::at(key, message).help(format!("write {advised_deg} or less")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_core::frames::pose2;

    #[test]
    fn way_or_turn_opens_it_and_the_turn_is_compared_across_the_wrap() {
        let mut gate = UpdateGate::new(0.4, 0.9);
        assert!(gate.is_open(&pose2(0.0, 0.0, 3.0), 9.0));
        gate.close(&pose2(0.0, 0.0, 3.0));
        for (pose, open) in [
            (pose2(0.39, 0.0, 3.0), false),
            (pose2(-0.3, 0.28, 3.0), true),
            (pose2(0.0, 0.0, -2.5), false),
            (pose2(0.0, 0.0, -2.3), true),
            (pose2(0.0, 0.0, 2.0), true),
        ] {
            assert_eq!(gate.is_open(&pose, 9.0), open, "{pose}");
        }
        assert!(gate.is_open(&pose2(0.0, 0.0, 3.26), 1.0), "a quarter of one radian is less than 0.26");
    }

    #[test]
    fn a_turn_is_doubtful_above_a_quarter_of_the_view_and_only_where_a_view_is_known() {
        let view_rad = Some(57_f64.to_radians());
        let doubt = doubtful_turn("angle_deg", 51.6, view_rad).unwrap();
        assert_eq!((doubt.path.as_str(), doubt.help.as_deref()), ("angle_deg", Some("write 14.2 or less")));
        assert!(
            doubt.message.starts_with("is 51.6, more than a quarter of the 57 degrees"),
            "{}",
            doubt.message
        );
        assert_eq!(doubtful_turn("angle_deg", 14.2, view_rad), None);
        assert_eq!(doubtful_turn("angle_deg", 51.6, None), None);
    }
}
