//! The key frames, and what is known between them.

use super::contradiction::View;
use super::nearest::NearestTable;
use super::registration::RegistrationSettings;
use super::surface::{Surface, SurfacePoint, Turn};
use nalgebra::{Matrix2, Matrix3, Vector3};
use rumbo_core::frames::{Pose2, Pose3, pose2};
use rumbo_core::messages::LaserScan;
use rumbo_kit::pose_graph::{Constraint, GraphOptimizer, OptimizeSettings, PoseGraph, RobustKernel};
use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};

/// A scan that is kept.
#[derive(Debug, Clone)]
pub(super) struct KeyFrame {
    /// What was seen.
    pub scan: LaserScan,
    /// From where.
    pub base_from_sensor: Pose3,
    /// Its surfaces, seen from the base.
    pub surface: Surface,
    /// Its place was found by dead reckoning.
    pub is_guessed: bool,
}

impl KeyFrame {
    pub fn view(&self) -> View<'_> {
        View { scan: &self.scan, base_from_sensor: &self.base_from_sensor, surface: &self.surface }
    }
}

/// How key frames are tied together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TieSettings {
    pub registration: RegistrationSettings,
    /// Share of the information of all pairs that is believed: neighboring points err alike.
    pub believed_share: f64,
    /// Key frames before a new one that it is tied to.
    pub n_before: usize,
    /// Key frames of earlier visits that it is tied to.
    pub n_neighbors: usize,
    /// How far away these may be, meters.
    pub neighbor_reach_m: f64,
    /// Registrations with less overlap are not believed.
    pub least_overlap: f64,
    /// Nor those whose pairs agree less.
    pub least_agreement: f64,
    /// Nor those that are this far from where they were expected, meters and radians.
    pub most_surprise: [f64; 2],
    /// Ways longer than this through the graph need a search before they are tied, meters.
    pub trusted_way_m: f64,
    /// Error of the odometer: at least, and a share of the way (meters), and the same of the turn (radians).
    pub odometer: [f64; 4],
    /// Error of a gyroscope's turn: at least, radians; a drift, rad/s; and a share of the turn.
    pub gyroscope: [f64; 3],
    /// Deviations at which a tie begins to count less.
    pub kernel_c: f64,
}

impl TieSettings {
    /// How far a turn by the gyroscope may be off, radians.
    pub fn off_by_gyroscope_rad(&self, turn_rad: f64, seconds: f64) -> f64 {
        let [least_rad, drift_rad_s, share] = self.gyroscope;
        least_rad + drift_rad_s * seconds + share * turn_rad.abs()
    }
}

/// Wheels spin, castors swing around, readings come late: what the odometer says is doubted where it is far off.
const ODOMETER: RobustKernel = RobustKernel::Cauchy { c: 1.0 };
/// A base that is pushed over an edge or leans turns otherwise than its gyroscope says.
const GYROSCOPE: RobustKernel = RobustKernel::Cauchy { c: 2.0 };
/// Error of the odometer between two key frames beside that of the way, meters.
const BETWEEN_FRAMES_M: f64 = 0.02;
/// A turn of one radian is as long a way as this, meters.
pub(super) const TURN_AS_WAY_M: f64 = 0.5;

/// Key frames with their graph.
#[derive(Debug)]
pub(super) struct Atlas {
    pub settings: TieSettings,
    pub frames: Vec<KeyFrame>,
    pub graph: PoseGraph,
    optimizer: GraphOptimizer,
    /// Pairs that were registered, whether it worked or not.
    pub tried: BTreeSet<(usize, usize)>,
    /// Ties of each frame: the other one, and how long the way is, meters.
    ways: Vec<Vec<(usize, f64)>>,
    pub table: NearestTable,
    pub table_of: Option<usize>,
}

impl Clone for Atlas {
    fn clone(&self) -> Atlas {
        Atlas {
            settings: self.settings,
            frames: self.frames.clone(),
            graph: self.graph.clone(),
            optimizer: GraphOptimizer::default(),
            tried: self.tried.clone(),
            ways: self.ways.clone(),
            table: NearestTable::default(),
            table_of: None,
        }
    }
}

impl Atlas {
    pub fn new(settings: TieSettings) -> Atlas {
        Atlas {
            settings,
            frames: Vec::new(),
            graph: PoseGraph::default(),
            optimizer: GraphOptimizer::default(),
            tried: BTreeSet::new(),
            ways: Vec::new(),
            table: NearestTable::default(),
            table_of: None,
        }
    }

    /// Pose of a key frame in the map.
    pub fn pose(&self, frame: usize) -> Pose2 {
        self.graph.pose(frame).unwrap_or_else(Pose2::identity)
    }

    /// Adds a key frame at a pose, bound to the one before it by the odometer alone.
    pub fn add(
        &mut self,
        frame: KeyFrame,
        map_from_base: &Pose2,
        before: Option<(usize, Pose2)>,
    ) -> Option<usize> {
        let node = self.graph.add_pose(map_from_base).ok()?;
        self.frames.push(frame);
        self.ways.push(Vec::new());
        if let Some((before, before_from_base)) = before {
            let [_, share_m, least_rad, share_rad] = self.settings.odometer;
            let way_m = before_from_base.translation.vector.norm();
            let turn_rad = before_from_base.rotation.angle().abs();
            let off_m = BETWEEN_FRAMES_M + share_m * way_m;
            let off_rad = least_rad + share_rad * turn_rad;
            let diagonal = Vector3::new(off_m.powi(-2), off_m.powi(-2), off_rad.powi(-2));
            self.bind(before, node, before_from_base, Matrix3::from_diagonal(&diagonal), ODOMETER);
        }
        Some(node)
    }

    /// Adds what the gyroscope says of the turn between two frames.
    pub fn bind_turn(&mut self, from: usize, to: usize, turn_rad: f64, off_rad: f64) {
        let information = Matrix3::from_diagonal(&Vector3::new(0.0, 0.0, off_rad.powi(-2)));
        self.bind(from, to, pose2(0.0, 0.0, turn_rad), information, GYROSCOPE);
    }

    /// Pairs that were registered.
    pub fn tried(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.tried.iter().copied()
    }

    /// A pair that was registered before this atlas was saved.
    pub fn mark_tried(&mut self, pair: (usize, usize)) {
        self.tried.insert(pair);
    }

    /// A constraint as it was saved.
    pub fn put_back(&mut self, constraint: Constraint) -> Option<()> {
        self.graph.add(constraint).ok()?;
        self.add_way(&constraint);
        Some(())
    }

    /// Adds what is known between two frames; the information is in the axes of the first one.
    pub fn bind(
        &mut self,
        from: usize,
        to: usize,
        from_to: Pose2,
        information: Matrix3<f64>,
        kernel: RobustKernel,
    ) {
        // In the axes of the measured frame.
        let turn = nalgebra::Rotation3::from_axis_angle(&Vector3::z_axis(), from_to.rotation.angle());
        let information = turn.matrix().transpose() * information * turn.matrix();
        let information = (information + information.transpose()) * 0.5;
        let constraint = Constraint { from: Some(from), to, from_to, information, kernel };
        if self.graph.add(constraint).is_ok() {
            self.add_way(&constraint);
        }
    }

    fn add_way(&mut self, constraint: &Constraint) {
        let Constraint { from: Some(from), to, from_to, information, .. } = *constraint else { return };
        if information.fixed_view::<2, 2>(0, 0) == Matrix2::zeros() {
            return;
        }
        let way_m = from_to.translation.vector.norm() + TURN_AS_WAY_M * from_to.rotation.angle().abs();
        for (a, b) in [(from, to), (to, from)] {
            self.ways.iter_mut().skip(a).take(1).for_each(|ways| ways.push((b, way_m)));
        }
    }

    /// Shortest ways through the graph from a frame, meters; infinite beyond `most_m`.
    pub fn ways_from(&self, frame: usize, most_m: f64) -> Vec<f64> {
        let mut ways = vec![f64::INFINITY; self.frames.len()];
        let mut open = BinaryHeap::from([(Reverse(0u64), frame)]);
        while let Some((Reverse(way), at)) = open.pop() {
            let way_m = way as f64 * 1e-6;
            match ways.get_mut(at) {
                Some(known) if way_m < *known => *known = way_m,
                _ => continue,
            }
            for (other, more_m) in self.ways.get(at).into_iter().flatten() {
                let total_m = way_m + more_m;
                if total_m <= most_m && ways.get(*other).is_some_and(|known| total_m < *known) {
                    open.push((Reverse((total_m * 1e6) as u64), *other));
                }
            }
        }
        ways
    }

    /// Moves all key frames to where they agree best.
    pub fn optimize(&mut self, most_iterations: usize) {
        let settings =
            OptimizeSettings { most_iterations, least_decrease: 1e-4, ..OptimizeSettings::default() };
        self.optimizer.optimize(&mut self.graph, &settings);
    }

    /// How far off the ties are that came after the first `n_known`: squared deviations of the worst one.
    pub fn strain_since(&self, n_known: usize) -> f64 {
        let ties = self.graph.constraints().iter().skip(n_known);
        ties.map(|tie| self.graph.chi2(tie)).fold(0.0, f64::max)
    }

    /// Frames in a row have moved against each other by more than this since the graph was so, meters.
    pub fn is_torn_since(&self, earlier: &PoseGraph, most_m: f64) -> bool {
        let seen =
            |graph: &PoseGraph, frame: usize| Some(graph.pose(frame)?.inverse() * graph.pose(frame + 1)?);
        let torn_m = |frame| {
            Some(
                (seen(&self.graph, frame)?.translation.vector - seen(earlier, frame)?.translation.vector)
                    .norm(),
            )
        };
        (0..self.frames.len()).filter_map(torn_m).any(|torn_m| torn_m > most_m)
    }

    /// Forgets what was tied and moved since the graph was so.
    pub fn take_back(&mut self, earlier: PoseGraph) {
        self.graph = earlier;
        self.ways.iter_mut().for_each(Vec::clear);
        for constraint in self.graph.constraints().to_vec() {
            self.add_way(&constraint);
        }
    }

    /// The surfaces of some frames, seen from one of them.
    pub fn surfaces<'a>(
        &'a self,
        frames: impl Iterator<Item = usize> + 'a,
        seen_from: usize,
    ) -> impl Iterator<Item = SurfacePoint> + 'a {
        let here_from_map = self.pose(seen_from).inverse();
        frames.filter_map(|frame| Some((frame, self.frames.get(frame)?))).flat_map(move |(idx, frame)| {
            let turn = Turn::new(&(here_from_map * self.pose(idx)));
            frame.surface.iter().map(move |point| point.seen_from(&turn))
        })
    }
}
