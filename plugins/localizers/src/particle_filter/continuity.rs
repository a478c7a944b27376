//! Which guess is the robot's while it is followed: not every update's heaviest.
//!
//! Scattered particles that look for a carried-away robot sometimes find a place that fits one scan better than the true
//! one. A robot does not jump: the guess that goes on from the last one, or where there is none the odometer's word, is
//! kept until another has been heavier several times in a row.

use super::clusters::Cluster;
use nalgebra::Matrix3;
use rumbo_core::frames::Pose2;

/// Remembers how long another guess has been heavier.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Continuity {
    n_challenged: u32,
}

impl Continuity {
    /// A guess this near to the expected pose goes on from the last one, meters and radians.
    const REACH: [f64; 2] = [1.0, 0.6];
    /// With less of the weight than this it says nothing.
    const LEAST_WEIGHT: f64 = 0.03;
    /// So many updates another guess may be heavier.
    const PATIENCE: u32 = 5;

    /// Puts the guess that goes on from the `expected` pose (with the last covariance) first, or that pose itself with
    /// no weight. Leaves the heaviest first where nothing is expected, or where it has been elsewhere for long.
    pub fn choose(&mut self, clusters: &mut Vec<Cluster>, expected: Option<(Pose2, Matrix3<f64>)>) {
        let Some((map_from_base, covariance)) = expected else {
            self.n_challenged = 0;
            return;
        };
        let goes_on = |cluster: &Cluster| {
            let off = map_from_base.inverse() * cluster.map_from_base;
            let is_near = off.translation.vector.norm() <= Self::REACH[0]
                && off.rotation.angle().abs() <= Self::REACH[1];
            is_near && cluster.weight >= Self::LEAST_WEIGHT
        };
        let same = clusters.iter().position(goes_on);
        if same == Some(0) || self.n_challenged >= Self::PATIENCE {
            self.n_challenged = 0;
            return;
        }
        self.n_challenged += 1;
        match same.and_then(|idx| clusters.get_mut(..=idx)) {
            Some(front) => front.rotate_right(1),
            None => clusters.insert(0, Cluster { weight: 0.0, map_from_base, covariance }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Matrix3;
    use rumbo_core::frames::pose2;

    fn cluster(weight: f64, x_m: f64) -> Cluster {
        Cluster { weight, map_from_base: pose2(x_m, 0.0, 0.0), covariance: Matrix3::identity() * 0.01 }
    }

    /// Where the first guess is after a choice.
    fn chosen(continuity: &mut Continuity, mut clusters: Vec<Cluster>, expected: Option<f64>) -> f64 {
        let expected = expected.map(|x_m| (pose2(x_m, 0.0, 0.0), Matrix3::identity()));
        continuity.choose(&mut clusters, expected);
        clusters[0].map_from_base.translation.x
    }

    #[test]
    fn the_robot_does_not_jump_to_a_guess_that_is_heavier_for_a_moment() {
        let mut continuity = Continuity::default();
        let far = || vec![cluster(0.7, 30.0), cluster(0.3, 1.2)];
        for _ in 0..10 {
            assert_eq!(chosen(&mut continuity, far(), Some(1.0)), 1.2);
            assert_eq!(chosen(&mut continuity, vec![cluster(0.9, 1.1)], Some(1.0)), 1.1);
        }
        let choices: Vec<f64> = (0..6).map(|_| chosen(&mut continuity, far(), Some(1.0))).collect();
        assert_eq!(choices, [1.2, 1.2, 1.2, 1.2, 1.2, 30.0], "but it may have been carried there");
    }

    #[test]
    fn the_odometer_is_believed_for_a_while_where_no_guess_goes_on() {
        let mut continuity = Continuity::default();
        let far = || vec![cluster(0.95, 30.0), cluster(0.02, 1.0)];
        let choices: Vec<f64> = (0..6).map(|_| chosen(&mut continuity, far(), Some(1.5))).collect();
        assert_eq!(choices, [1.5, 1.5, 1.5, 1.5, 1.5, 30.0]);
        assert_eq!(chosen(&mut Continuity::default(), Vec::new(), Some(1.5)), 1.5);
    }

    #[test]
    fn the_heaviest_guess_is_taken_where_nothing_is_expected() {
        let mut continuity = Continuity::default();
        assert_eq!(chosen(&mut continuity, vec![cluster(0.6, 30.0), cluster(0.4, 1.0)], None), 30.0);
        assert_eq!(continuity, Continuity::default());
        continuity.choose(&mut Vec::new(), None);
    }
}
