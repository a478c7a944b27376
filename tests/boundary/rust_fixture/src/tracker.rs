//! A SLAM for tests that believes the odometer, keeps where it was at each scan, and maps nothing.

use rumbo_core::frames::{Pose2, lift};
use rumbo_core::map::{Grid, Layer, Map};
use rumbo_core::messages::{Estimate, ObservationKind, Prior, Seen, StampedPose};
use rumbo_core::nalgebra::Matrix3;
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::stages::{BuildContext, BuildError, Cx, Slam, SlamError};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Believes the odometer.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
struct TrackerParams {
    /// It panics when it is asked for its trajectory.
    panics: bool,
}

impl Params for TrackerParams {}

impl Plugin<dyn Slam> for TrackerParams {
    fn manifest(&self) -> Manifest {
        Manifest {
            gives_layers: vec![Layer::Grid],
            consumes: vec![vec![ObservationKind::LaserScan]],
            uses: vec![ObservationKind::Odometry, ObservationKind::Imu],
            ..Manifest::default()
        }
    }

    fn build(&self, _: &BuildContext) -> Result<Box<dyn Slam>, BuildError> {
        let (map_from_odom, odom_from_base, poses) = (Pose2::identity(), Pose2::identity(), Vec::new());
        Ok(Box::new(Tracker { params: self.clone(), map_from_odom, odom_from_base, poses }))
    }
}

struct Tracker {
    params: TrackerParams,
    map_from_odom: Pose2,
    odom_from_base: Pose2,
    poses: Vec<StampedPose>,
}

impl Slam for Tracker {
    fn start(&mut self, prior: &Prior, map: &mut Map) -> Result<(), SlamError> {
        map.grid = Grid::unknown(400, 400, 0.1).ok();
        map.touch();
        self.poses.clear();
        if *prior == Prior::Unknown { Ok(()) } else { self.relocate(prior, map) }
    }

    fn update(&mut self, cx: &mut Cx<'_>, seen: Seen<'_>, map: &mut Map) -> Result<Estimate, SlamError> {
        if let Some((_, odometry)) = seen.odometry().last() {
            self.odom_from_base = odometry.odom_from_base;
        }
        let map_from_base = self.map_from_odom * self.odom_from_base;
        for (scan, _) in seen.laser_scans() {
            self.poses.push(StampedPose { stamp: scan.stamp, map_from_base: lift(&map_from_base) });
            map.touch();
        }
        Ok(Estimate::planar(cx.now, map_from_base, self.odom_from_base, Matrix3::identity() * 1e-4))
    }

    fn relocate(&mut self, prior: &Prior, _: &mut Map) -> Result<(), SlamError> {
        let Prior::Pose { map_from_base, odom_from_base, .. } = prior else {
            return Err(SlamError::Prior { prior: "no pose", needs: "a pose" });
        };
        self.map_from_odom = map_from_base * odom_from_base.inverse();
        Ok(())
    }

    fn trajectory(&self) -> Result<Vec<StampedPose>, SlamError> {
        assert!(!self.params.panics, "made to panic in trajectory");
        Ok(self.poses.clone())
    }
}

rumbo_core::register_slam!(TrackerParams, "fixture_tracker", "believes the odometer, for tests");
