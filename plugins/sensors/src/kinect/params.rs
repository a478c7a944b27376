//! What `[[sensor]] plugin = "kinect"` takes.

use rumbo_core::messages::{Intrinsics, ObservationKind};
use rumbo_core::registry::Params;
use rumbo_core::stages::BuildError;
use rumbo_kit::depth::{DepthDevice, DepthScale, DepthStep, RAW_MAX, Rays, pinhole_of_view};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{CameraModel, Projection};

/// A depth camera like the Kinect: it gives its pictures, points between two heights, and a virtual scan of them, so that it
/// takes the place of a laser scanner by changing its own section only.
///
/// A camera that sees too little for some pictures gives observations that are not valid, and the guard stops the robot.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct KinectParams {
    /// `"v1"`: 57 x 43 degrees up to 3.5 m; `"v2"`: 70 x 60 degrees up to 4.5 m.
    pub model: CameraModel,
    /// Columns of the picture; absent: a quarter of the device's, 160 (v1) or 128 (v2).
    pub columns: Option<u32>,
    /// Rows of the picture; absent: a quarter of the device's, 120 (v1) or 106 (v2).
    pub rows: Option<u32>,
    /// A calibrated camera in place of the model's field of view: `{ focal_px = [580.0, 580.0], center_px = [319.5,
    /// 239.5] }` for the picture's `columns` and `rows`.
    pub intrinsics: Option<CameraIntrinsics>,
    /// What is made of the pictures: `"laser_scan"`, `"point_cloud"` (points outside of the heights are not-a-number),
    /// `"depth_image"` (as the device gives it).
    pub gives: Vec<Given>,
    /// What columns and rows are taken for: `"pinhole"`, or `"linear_angle"` and `"linear_angle_one_off"` as in Valverde
    /// Moreno (2015).
    pub projection: Projection,
    /// Steps of simulated depths: `"millimeter"` (v1: in steps that grow with the square of the depth), or
    /// `"unit_range"`: 13 bits from the near plane over `depth_amplitude_m`, without a least distance, as the source
    /// simulates it. Recorded pictures say their own unit.
    pub depth_scale: DepthScale,
    /// What is read nearer than this counts as being here, meters (z_near).
    pub near_plane_m: f64,
    /// Depths that 13 bits stand for, meters (A); for `unit_range`.
    pub depth_amplitude_m: f64,
    /// The simulated device reads nothing nearer, meters; absent: 0.5, or 0 for `unit_range`.
    pub min_range_m: Option<f64>,
    /// Nothing farther is read, meters; absent: 3.5 (v1) or 4.5 (v2).
    pub max_range_m: Option<f64>,
    /// What lies lower does not count, meters over the floor.
    pub min_height_m: f64,
    /// What lies higher does not count, meters over the floor; absent: the robot's height and 0.10 m.
    pub max_height_m: Option<f64>,
    /// Beams of the scan; absent: as many as leave none empty.
    pub beams: Option<u32>,
    /// The scan looks at this many rows around the picture's middle only; absent: at all, and the heights select.
    pub slice_rows: Option<u32>,
    /// A 3 x 3 median takes single wrong pixels away.
    pub median: bool,
    /// Pictures with less than this share of readings show too little.
    pub min_valid_fraction: f64,
    /// After so many of them in a row the camera is blind: observations are not valid.
    pub blind_frames: u32,
    /// Regions of the picture that lose their readings after they were nearer than `near_margin_m` beyond the least
    /// distance count as occupied, where they were last. A reading of their own or below them frees them.
    pub near_is_occupied: bool,
    /// See `near_is_occupied`, meters.
    pub near_margin_m: f64,
    /// How fast such a region is taken to come nearer, down to the near plane, m/s. 0 leaves it where it was, and the
    /// robot must stop there; with the robot's speed it is as near as the robot can have come, and whoever stands before
    /// it does not pass.
    pub near_closing_m_s: f64,
    /// Simulated depths in their steps without any error.
    pub exact: bool,
    /// Standard deviation of a simulated depth, meters: its constant part.
    pub deviation_m: f64,
    /// The part that grows with the square of the depth, 1/m.
    pub deviation_per_m: f64,
    /// Share of the simulated pixels beside a nearer thing that are not read.
    pub edge_holes: f64,
    /// Share of the simulated pixels that are not read, by chance.
    pub dropout: f64,
    /// Sunlight: the share of the simulated pixels at the largest range that are not read; nearer ones by the square of
    /// their depth. Above 1 nothing is read from some depth on.
    pub sunlight: f64,
}

/// A calibrated camera.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CameraIntrinsics {
    /// Focal lengths, pixels: horizontal and vertical.
    pub focal_px: [f64; 2],
    /// Where the optical axis meets the picture, pixels.
    pub center_px: [f64; 2],
}

/// What the sensor makes of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Given {
    /// A planar scan.
    LaserScan,
    /// Points between the heights.
    PointCloud,
    /// The picture itself.
    DepthImage,
}

impl Given {
    pub(super) fn kind(self) -> ObservationKind {
        match self {
            Given::LaserScan => ObservationKind::LaserScan,
            Given::PointCloud => ObservationKind::PointCloud,
            Given::DepthImage => ObservationKind::DepthImage,
        }
    }
}

impl Default for KinectParams {
    fn default() -> Self {
        Self {
            model: CameraModel::V1,
            columns: None,
            rows: None,
            intrinsics: None,
            gives: vec![Given::LaserScan],
            projection: Projection::Pinhole,
            depth_scale: DepthScale::Millimeter,
            near_plane_m: 0.2,
            depth_amplitude_m: 3.3,
            min_range_m: None,
            max_range_m: None,
            min_height_m: 0.05,
            max_height_m: None,
            beams: None,
            slice_rows: None,
            median: true,
            min_valid_fraction: 0.05,
            blind_frames: 5,
            near_is_occupied: true,
            near_margin_m: 0.25,
            near_closing_m_s: 0.0,
            exact: false,
            deviation_m: 0.001,
            deviation_per_m: 0.0015,
            edge_holes: 0.3,
            dropout: 0.005,
            sunlight: 0.0,
        }
    }
}

/// Most pixels of a simulated picture.
const MOST_PIXELS: u64 = 4_000_000;

impl Params for KinectParams {
    fn check(&self) -> Vec<BuildError> {
        let mut faults = Vec::new();
        let mut expect = |fine: bool, key: &str, value: String, expected: &str| {
            if !fine {
                faults.push(BuildError::at(key, format!("is {value}, expected {expected}")));
            }
        };
        let [columns, rows] = self.size();
        let fits = columns > 0 && rows > 0 && u64::from(columns) * u64::from(rows) <= MOST_PIXELS;
        expect(fits, "columns", format!("{columns} with {rows} rows"), "1 to 4 million pixels");
        if fits && let Err(error) = Rays::pinhole(&self.camera()) {
            expect(false, "intrinsics", error.to_string(), "a camera");
        }
        let twice = (1..self.gives.len()).any(|idx| self.gives[..idx].contains(&self.gives[idx]));
        let gives_fits = !self.gives.is_empty() && !twice;
        expect(gives_fits, "gives", format!("{:?}", self.gives), "one or several kinds, each once");
        let reach_m = self.reach_m();
        let mut number = |fine: bool, key: &str, value: f64, expected: &str| {
            expect(value.is_finite() && fine, key, value.to_string(), expected);
        };
        number(reach_m > 0.0 && reach_m <= 60.0, "max_range_m", reach_m, "more than 0 and at most 60");
        let near_fits = self.near_plane_m > 0.0 && self.near_plane_m < reach_m;
        number(near_fits, "near_plane_m", self.near_plane_m, "more than 0 and less than max_range_m");
        number(self.depth_amplitude_m > 0.0, "depth_amplitude_m", self.depth_amplitude_m, "more than 0");
        let least_m = self.least_m();
        number((0.0..reach_m).contains(&least_m), "min_range_m", least_m, "from 0 to max_range_m");
        let highest_m = self.max_height_m.unwrap_or(f64::MAX);
        number(highest_m > self.min_height_m, "max_height_m", highest_m, "more than min_height_m");
        number(true, "min_height_m", self.min_height_m, "a height");
        for (key, share) in [
            ("min_valid_fraction", self.min_valid_fraction),
            ("edge_holes", self.edge_holes),
            ("dropout", self.dropout),
        ] {
            number((0.0..=1.0).contains(&share), key, share, "a share from 0 to 1");
        }
        for (key, value) in [
            ("sunlight", self.sunlight),
            ("deviation_m", self.deviation_m),
            ("deviation_per_m", self.deviation_per_m),
            ("near_margin_m", self.near_margin_m),
            ("near_closing_m_s", self.near_closing_m_s),
        ] {
            number(value >= 0.0, key, value, "0 or more");
        }
        let beams = self.beams.unwrap_or(1);
        expect((1..=4096).contains(&beams), "beams", beams.to_string(), "1 to 4096");
        let slice = self.slice_rows.unwrap_or(1);
        expect((1..=rows).contains(&slice), "slice_rows", slice.to_string(), "1 to the number of rows");
        expect(self.blind_frames > 0, "blind_frames", "0".to_owned(), "1 or more");
        faults
    }
}

impl KinectParams {
    fn size(&self) -> [u32; 2] {
        let [columns, rows] = self.model.quarter_size();
        [self.columns.unwrap_or(columns), self.rows.unwrap_or(rows)]
    }

    fn reach_m(&self) -> f64 {
        self.max_range_m.unwrap_or(self.model.max_range_m())
    }

    /// The least distance of the simulated device.
    pub(super) fn least_m(&self) -> f64 {
        let own_m = match self.depth_scale {
            DepthScale::UnitRange => 0.0,
            DepthScale::Millimeter => self.model.min_range_m(),
        };
        self.min_range_m.unwrap_or(own_m)
    }

    /// The camera that the world is asked for.
    pub(super) fn camera(&self) -> Intrinsics {
        let [width, height] = self.size();
        match self.intrinsics {
            Some(CameraIntrinsics { focal_px, center_px }) => {
                Intrinsics { width, height, focal_px, center_px }
            }
            None => pinhole_of_view(width, height, self.model.half_angles_deg().map(f64::to_radians)),
        }
    }

    /// How wide it sees to its sides in all, radians.
    pub(super) fn field_of_view_rad(&self) -> f64 {
        let Intrinsics { width, focal_px: [focal_px, _], center_px: [center_px, _], .. } = self.camera();
        let [left_px, right_px] = [center_px + 0.5, f64::from(width) - 0.5 - center_px];
        (left_px / focal_px).atan() + (right_px / focal_px).atan()
    }

    /// The simulated device.
    pub(super) fn device(&self) -> DepthDevice {
        let share = |share: f64| if self.exact { 0.0 } else { share };
        let step_m = self.depth_amplitude_m / f64::from(RAW_MAX);
        let (step, unit_m, max_m) = match self.depth_scale {
            // A tenth of a millimeter tells the 13 bits apart.
            DepthScale::UnitRange => (
                DepthStep::From { near_m: self.near_plane_m, step_m },
                0.0001,
                self.reach_m().min(self.near_plane_m + self.depth_amplitude_m),
            ),
            DepthScale::Millimeter => (self.model.step(), 0.001, self.reach_m()),
        };
        DepthDevice {
            deviation: [share(self.deviation_m), share(self.deviation_per_m)],
            step,
            unit_m,
            min_m: self.least_m(),
            near_m: self.near_plane_m,
            // Counts are 16 bits.
            max_m: max_m.min(f64::from(u16::MAX) * unit_m),
            edge_m: EDGE_M,
            edge_holes: share(self.edge_holes),
            dropout: share(self.dropout),
            sunlight: share(self.sunlight),
        }
    }
}

/// Neighbors that differ by more are the edge of something.
const EDGE_M: f64 = 0.1;
