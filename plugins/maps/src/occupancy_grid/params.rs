//! What `[map_builder] plugin = "occupancy_grid"` takes.

use rumbo_core::registry::{Params, Surroundings};
use rumbo_core::stages::BuildError;
use rumbo_kit::map_file::DEFAULT_MAX_CELLS;
use rumbo_kit::occupancy::{
    BeamLimits, Evidence, EvidenceFault, FreeSpace, MapperSettings, Pyramid, doubtful_turn,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A grid of log-odds made from laser scans and the localizer's poses. Each cell changes at most once a scan, and a hit
/// wins over any number of beams that pass. The map grows with what is seen.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct OccupancyGridParams {
    /// Edge of a cell, meters.
    pub resolution_m: f64,
    /// Cells along each axis at the start.
    pub size_cells: u32,
    /// Where the first pose lies on the grid, as a share of its width.
    pub start_x: f64,
    /// The same for its height.
    pub start_y: f64,
    /// Grids at 1, 2, 4, ... times the edge of a cell, each made from the scans themselves: for matching from coarse
    /// to fine. Plans and files use the finest.
    pub levels: u32,
    /// The grid grows when the robot or what it sees lies beside it; otherwise scans from beside it are not inserted.
    pub auto_grow: bool,
    /// The grid grows by multiples of this, cells.
    pub grow_block_cells: u32,
    /// The grid does not grow beyond this.
    pub max_cells: u64,
    /// Probability that a cell is occupied although a beam passed it; below 0.5.
    pub update_factor_free: f64,
    /// Probability that a cell is occupied in which a beam ended; above 0.5.
    pub update_factor_occupied: f64,
    /// No cell becomes surer to be free than this probability of being occupied.
    pub p_min: f64,
    /// No cell becomes surer to be occupied than this probability.
    pub p_max: f64,
    /// A scan is inserted after the robot has moved this far since the last one, meters, ...
    pub map_update_distance_m: f64,
    /// ... or has turned this much, degrees; never more than a quarter of the scanner's field of view.
    pub map_update_angle_deg: f64,
    /// Insert every scan, however little the robot moved: for poses that are known.
    pub map_with_known_poses: bool,
    /// A pose whose standard deviation along x or y is larger inserts nothing, meters.
    pub max_pose_std_m: f64,
    /// A scan farther than this from the estimate in time is not inserted, seconds: the odometer alone does not carry
    /// a pose that far. 0 takes only scans of the estimate's own time.
    pub max_pose_age_s: f64,
    /// Nearer readings are dropped, meters.
    pub min_range_m: f64,
    /// Farther readings count as nothing seen, meters.
    pub max_range_m: f64,
    /// A beam that sees nothing within reach frees the cells that it passes. Off by default: glass, black and mirrors
    /// look like nothing to a real scanner, and freeing behind them wipes out walls.
    pub clear_on_no_return: bool,
    /// How far such a beam frees, meters; without it: as far as the scanner reaches.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clear_range_m: Option<f64>,
    /// Which cells a scan frees.
    pub free_space: FreeSpaceRule,
    /// Beams farther apart than this bound no area, degrees; their own cells alone are freed.
    pub widest_wedge_deg: f64,
}

/// Which cells a scan frees.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FreeSpaceRule {
    /// All between neighboring beams: no gaps far from the robot, and the fastest.
    #[default]
    Area,
    /// Only those on the beams.
    Beams,
}

impl Default for OccupancyGridParams {
    fn default() -> Self {
        Self {
            resolution_m: 0.05,
            size_cells: 1024,
            start_x: 0.5,
            start_y: 0.5,
            levels: 5,
            auto_grow: true,
            grow_block_cells: 256,
            max_cells: DEFAULT_MAX_CELLS,
            update_factor_free: 0.4,
            update_factor_occupied: 0.9,
            p_min: 0.01,
            p_max: 0.99,
            map_update_distance_m: 0.4,
            map_update_angle_deg: 51.6,
            map_with_known_poses: false,
            max_pose_std_m: 0.5,
            max_pose_age_s: 0.5,
            min_range_m: 0.0,
            max_range_m: 30.0,
            clear_on_no_return: false,
            clear_range_m: None,
            free_space: FreeSpaceRule::Area,
            widest_wedge_deg: 1.1,
        }
    }
}

/// More levels than this make cells of half a kilometer.
const MOST_LEVELS: u32 = 12;

impl Params for OccupancyGridParams {
    fn check(&self) -> Vec<BuildError> {
        let mut faults = Vec::new();
        let mut expect = |fine: bool, key: &str, found: &dyn std::fmt::Display, expected: &str| {
            if !fine {
                faults.push(BuildError::at(key, format!("is {found}, expected {expected}")));
            }
        };
        let positive = |value: f64| value.is_finite() && value > 0.0;
        let lengths = [
            ("resolution_m", self.resolution_m),
            ("max_pose_std_m", self.max_pose_std_m),
            ("max_range_m", self.max_range_m),
            ("clear_range_m", self.clear_range_m.unwrap_or(1.0)),
            ("widest_wedge_deg", self.widest_wedge_deg),
        ];
        for (key, value) in lengths {
            expect(positive(value), key, &value, "a finite number above 0");
        }
        let at_least_0 = [
            ("max_pose_age_s", self.max_pose_age_s),
            ("map_update_distance_m", self.map_update_distance_m),
            ("map_update_angle_deg", self.map_update_angle_deg),
            ("min_range_m", self.min_range_m),
        ];
        for (key, value) in at_least_0 {
            expect(value.is_finite() && value >= 0.0, key, &value, "a finite number, 0 or more");
        }
        expect(
            self.min_range_m < self.max_range_m,
            "min_range_m",
            &self.min_range_m,
            "less than max_range_m",
        );
        for (key, value) in [("start_x", self.start_x), ("start_y", self.start_y)] {
            expect((0.0..=1.0).contains(&value), key, &value, "a share from 0 to 1");
        }
        let levels_fit = (1..=MOST_LEVELS).contains(&self.levels);
        expect(levels_fit, "levels", &self.levels, "from 1 to 12");
        let coarsest = 1u32 << (self.levels.clamp(1, MOST_LEVELS) - 1);
        for (key, value) in [("size_cells", self.size_cells), ("grow_block_cells", self.grow_block_cells)] {
            let expected =
                format!("a multiple of {coarsest}, so that all {} levels have whole cells", self.levels);
            expect(value > 0 && value % coarsest == 0, key, &value, &expected);
        }
        let fits = u64::from(self.size_cells).pow(2) <= self.max_cells;
        expect(fits, "size_cells", &self.size_cells, "at most max_cells cells in all");
        faults.extend(self.evidence().err().into_iter().flatten().map(|fault| {
            BuildError::at(fault.name, format!("is {}, expected {}", fault.found, fault.expected))
        }));
        faults
    }

    fn doubts(&self, surroundings: &Surroundings) -> Vec<BuildError> {
        doubtful_turn("map_update_angle_deg", self.map_update_angle_deg, surroundings.narrowest_view_rad)
            .into_iter()
            .collect()
    }
}

impl OccupancyGridParams {
    /// What beams say.
    pub(super) fn evidence(&self) -> Result<Evidence, Vec<EvidenceFault>> {
        Evidence::new(self.update_factor_free, self.update_factor_occupied, self.p_min, self.p_max)
    }

    pub(super) fn mapper(&self, evidence: Evidence) -> MapperSettings {
        MapperSettings {
            evidence,
            pyramid: Pyramid {
                resolution_m: self.resolution_m,
                levels: self.levels,
                block_cells: self.grow_block_cells,
                max_cells: self.max_cells,
            },
            limits: self.limits(),
            free_space: self.free_space(),
            auto_grow: self.auto_grow,
        }
    }

    fn limits(&self) -> BeamLimits {
        let clear_range_m =
            if self.clear_on_no_return { self.clear_range_m.unwrap_or(self.max_range_m) } else { 0.0 };
        BeamLimits { min_range_m: self.min_range_m, max_range_m: self.max_range_m, clear_range_m }
    }

    fn free_space(&self) -> FreeSpace {
        match self.free_space {
            FreeSpaceRule::Beams => FreeSpace::Beams,
            FreeSpaceRule::Area => FreeSpace::Area { widest_wedge_rad: self.widest_wedge_deg.to_radians() },
        }
    }
}
