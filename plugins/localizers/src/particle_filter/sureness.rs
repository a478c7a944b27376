//! How sure the filter is: turns clusters and their fit into a status, and does not change its mind at every beam.

use super::clusters::Cluster;
use rumbo_core::messages::{Candidate, Status};

/// When a robot is found and when it is lost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurenessRules {
    /// A place that explains less than this share of the beams does not fit.
    pub least_explained: f64,
    /// So many updates in a row with one tight cluster, and a robot that could be anywhere is found.
    pub found_after_updates: u32,
    /// So many updates in a row with a place that does not fit, and the robot is lost.
    pub lost_after_updates: u32,
}

/// The status and what it remembers.
#[derive(Debug, Clone, PartialEq)]
pub struct Sureness {
    rules: SurenessRules,
    status: Status,
    has_tracked: bool,
    n_tight: u32,
    n_unfit: u32,
}

/// One answer: heaviest cluster with this share of the weight, and standard deviations of at most these.
struct Limits {
    weight: f64,
    deviation_m: f64,
    deviation_rad: f64,
}

/// To begin tracking.
const FOUND: Limits = Limits { weight: 0.9, deviation_m: 0.3, deviation_rad: 0.2 };
/// To go on tracking.
const KEPT: Limits = Limits { weight: 0.6, deviation_m: 0.6, deviation_rad: 0.4 };
/// Places that are named as candidates hold at least this share each, and together at least the other.
const CANDIDATE_WEIGHT: f64 = 0.05;
const CANDIDATES_TOGETHER: f64 = 0.8;

/// The cluster is one place, whatever its weight.
pub fn is_tight(cluster: &Cluster) -> bool {
    Limits { weight: 0.0, ..KEPT }.hold(cluster)
}

impl Limits {
    fn hold(&self, cluster: &Cluster) -> bool {
        cluster.weight >= self.weight
            && cluster.deviation_m() <= self.deviation_m
            && cluster.deviation_rad() <= self.deviation_rad
    }
}

impl Sureness {
    /// Nothing seen yet; `is_known` when somebody said where the robot is, and one tight cluster is enough.
    pub fn new(rules: SurenessRules, is_known: bool) -> Sureness {
        let n_tight = if is_known { rules.found_after_updates } else { 0 };
        Sureness { rules, status: Status::Converging, has_tracked: false, n_tight, n_unfit: 0 }
    }

    /// The robot was followed at some time, and is not lost.
    pub fn has_tracked(&self) -> bool {
        self.has_tracked && self.status != Status::Lost
    }

    /// The present status.
    pub fn status(&self) -> Status {
        self.status
    }

    /// Judges the clusters, heaviest first, and the share of beams that the heaviest explains, if any were weighed.
    pub fn judge(&mut self, clusters: &[Cluster], explained: Option<f64>) -> Status {
        let fits = explained.is_none_or(|share| share >= self.rules.least_explained);
        let Some(best) = clusters.first() else {
            self.status = Status::Lost;
            return self.status;
        };
        if self.has_tracked {
            self.n_unfit = if fits { 0 } else { self.n_unfit.saturating_add(1) };
        }
        let was_tracking = self.status == Status::Tracking;
        self.n_tight = if FOUND.hold(best) { self.n_tight.saturating_add(1) } else { 0 };
        let is_one = self.n_tight >= self.rules.found_after_updates || was_tracking && KEPT.hold(best);
        self.status = if self.n_unfit >= self.rules.lost_after_updates {
            Status::Lost
        } else if is_one && (fits || was_tracking) {
            // A tracked place that does not fit may be a crowd; the count above ends this.
            Status::Tracking
        } else if self.status == Status::Lost {
            Status::Lost
        } else if candidates(clusters).len() > 1 {
            Status::Ambiguous
        } else {
            Status::Converging
        };
        self.has_tracked |= self.status == Status::Tracking;
        self.status
    }
}

/// The places that fit when several do: tight clusters that together hold most of the weight. Scores sum to 1.
pub fn candidates(clusters: &[Cluster]) -> Vec<Candidate> {
    let is_place = |cluster: &&Cluster| {
        let limits = Limits { weight: CANDIDATE_WEIGHT, ..KEPT };
        limits.hold(cluster)
    };
    let places = || clusters.iter().filter(is_place);
    let together: f64 = places().map(|cluster| cluster.weight).sum();
    if together < CANDIDATES_TOGETHER {
        return Vec::new();
    }
    let candidate = |cluster: &Cluster| Candidate {
        map_from_base: cluster.map_from_base,
        score: cluster.weight / together,
    };
    places().map(candidate).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, Vector3};
    use rumbo_core::frames::Pose2;

    fn cluster(weight: f64, deviation_m: f64) -> Cluster {
        let variances = Vector3::new(deviation_m.powi(2), 0.0, 0.01);
        Cluster { weight, map_from_base: Pose2::identity(), covariance: Matrix3::from_diagonal(&variances) }
    }

    fn fresh() -> Sureness {
        let rules = SurenessRules { least_explained: 0.3, found_after_updates: 1, lost_after_updates: 4 };
        Sureness::new(rules, false)
    }

    #[test]
    fn one_tight_cluster_is_tracking_and_stays_so_until_it_is_twice_as_wide() {
        let mut sureness = fresh();
        assert_eq!(sureness.judge(&[cluster(0.95, 0.4)], None), Status::Converging);
        assert_eq!(sureness.judge(&[cluster(0.95, 0.2)], None), Status::Tracking);
        assert_eq!(sureness.judge(&[cluster(0.7, 0.5)], None), Status::Tracking);
        assert_eq!(sureness.judge(&[cluster(0.7, 0.7)], None), Status::Converging);
        assert_eq!(sureness.judge(&[cluster(0.7, 0.2)], None), Status::Converging);
    }

    #[test]
    fn several_tight_clusters_are_candidates_whose_scores_sum_to_one() {
        let clusters = [cluster(0.5, 0.2), cluster(0.4, 0.2), cluster(0.04, 0.1), cluster(0.06, 3.0)];
        assert_eq!(fresh().judge(&clusters, None), Status::Ambiguous);
        let found = candidates(&clusters);
        assert_eq!(found.len(), 2);
        assert!((found.iter().map(|c| c.score).sum::<f64>() - 1.0).abs() < 1e-12);
        assert!(found[0].score > found[1].score);
        assert_eq!(fresh().judge(&[cluster(0.4, 0.2), cluster(0.3, 0.2)], None), Status::Converging);
    }

    #[test]
    fn a_robot_is_lost_only_after_several_updates_in_a_row_that_do_not_fit() {
        let (mut sureness, tight) = (fresh(), [cluster(1.0, 0.1)]);
        assert_eq!(
            sureness.judge(&tight, Some(0.1)),
            Status::Converging,
            "a tight cluster alone is no place"
        );
        sureness.judge(&tight, Some(0.9));
        for _ in 0..5 {
            (0..3).for_each(|_| assert_eq!(sureness.judge(&tight, Some(0.1)), Status::Tracking));
            assert_eq!(sureness.judge(&tight, Some(0.5)), Status::Tracking);
        }
        (0..3).for_each(|_| assert_ne!(sureness.judge(&tight, Some(0.1)), Status::Lost));
        assert_eq!(sureness.judge(&tight, Some(0.1)), Status::Lost);
        assert_eq!(sureness.judge(&[cluster(0.5, 2.0)], Some(0.8)), Status::Lost, "not found yet");
        assert_eq!(sureness.judge(&tight, Some(0.8)), Status::Tracking);
        assert_eq!(fresh().judge(&[], None), Status::Lost);
    }

    #[test]
    fn a_robot_that_could_be_anywhere_is_found_after_several_tight_updates_in_a_row() {
        let rules = SurenessRules { least_explained: 0.3, found_after_updates: 3, lost_after_updates: 4 };
        let (tight, wide) = ([cluster(1.0, 0.1)], [cluster(1.0, 1.0)]);
        let mut sureness = Sureness::new(rules, false);
        for clusters in [&tight, &tight, &wide, &tight, &tight] {
            assert_eq!(sureness.judge(clusters, None), Status::Converging);
        }
        assert_eq!(sureness.judge(&tight, None), Status::Tracking);
        assert_eq!(Sureness::new(rules, true).judge(&tight, None), Status::Tracking, "it was told");
        assert_eq!(Sureness::new(rules, true).judge(&wide, None), Status::Converging);
    }

    #[test]
    fn a_robot_that_was_never_found_is_not_lost() {
        let mut sureness = fresh();
        (0..50).for_each(|_| assert_eq!(sureness.judge(&[cluster(0.5, 2.0)], Some(0.1)), Status::Converging));
    }
}
