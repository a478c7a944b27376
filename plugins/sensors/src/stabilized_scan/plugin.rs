//! Leveled scans, as a virtual sensor of the framework.

use nalgebra::Translation3;
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::Pose3;
use rumbo_core::messages::{Data, LaserScan, Observation, ObservationKind, Observations, Seen, SensorId};
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::stages::{BuildContext, BuildError, Cx, Sensor, SensorError, World};
use rumbo_core::time::{Span, Time};

use super::StabilizedScanParams;
use super::attitude_track::{AttitudeThen, AttitudeTrack};
use super::beams::{BeamRules, Tally, Tilt};
use super::thinning::thin;

rumbo_core::register_sensor!(
    StabilizedScanParams,
    "stabilized_scan",
    "scans of a laser on a robot that tilts, leveled by its attitude"
);

/// Levels scans.
#[derive(Debug)]
pub struct StabilizedScan {
    sensor: SensorId,
    rules: BeamRules,
    max_points: usize,
    deskews: bool,
    max_attitude_age: Span,
    attitudes: AttitudeTrack,
    last_scan: Option<Time>,
    counts: Counts,
}

/// Scans and beams since the start.
#[derive(Debug, Clone, Copy, Default)]
struct Counts {
    n_scans: u64,
    n_stale: u64,
    n_empty: u64,
    n_late: u64,
    n_without_attitude: u64,
    n_by_range: u64,
    n_by_height: u64,
}

impl Plugin<dyn Sensor> for StabilizedScanParams {
    fn manifest(&self) -> Manifest {
        Manifest {
            consumes: vec![vec![ObservationKind::LaserScan], vec![ObservationKind::Imu]],
            produces: vec![ObservationKind::LaserScan],
            is_virtual: true,
            ..Manifest::default()
        }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Sensor>, BuildError> {
        if let Some(fault) = self.check().into_iter().next() {
            return Err(fault);
        }
        let rules = BeamRules {
            min_range_m: self.min_range_m.map(|range_m| range_m as f32),
            max_range_m: self.max_range_m.map(|range_m| range_m as f32),
            self_filter_m: self.self_filter_m.map(|range_m| range_m as f32),
            heights_m: [self.lowest_m, self.highest_m],
            floor_m: self.floor_m,
            tilt_margin_sine: self.tilt_margin_deg.to_radians().sin(),
        };
        Ok(Box::new(StabilizedScan {
            sensor: context.sensor,
            rules,
            max_points: self.max_points as usize,
            deskews: self.deskew,
            max_attitude_age: Span::from_secs(self.max_attitude_age_s),
            attitudes: AttitudeTrack::default(),
            last_scan: None,
            counts: Counts::default(),
        }))
    }
}

impl Sensor for StabilizedScan {
    fn poll(&mut self, _: &mut Cx<'_>, _: &mut dyn World, _: &mut Observations) -> Result<(), SensorError> {
        Err(SensorError::Other("this sensor levels the scans of `inputs` and reads no world".to_owned()))
    }

    fn derive(
        &mut self,
        cx: &mut Cx<'_>,
        inputs: Seen<'_>,
        out: &mut Observations,
    ) -> Result<(), SensorError> {
        // Attitudes first: one that came with a scan and is a little younger makes the scan's better.
        for observation in inputs.iter().filter(|observation| observation.valid) {
            if let Data::Imu(imu) = &observation.data {
                self.attitudes.push(observation.stamp, &observation.base_from_sensor, imu);
            }
        }
        for (observation, scan) in inputs.laser_scans() {
            self.level(observation, scan, out);
        }
        self.counts.tell(cx);
        Ok(())
    }
}

impl StabilizedScan {
    fn level(&mut self, observation: &Observation, scan: &LaserScan, out: &mut Observations) {
        let stamp = observation.stamp;
        if self.last_scan.is_some_and(|last| last >= stamp) {
            self.counts.n_late += 1;
            return;
        }
        // Which way is up nobody knows yet: a scan that may be tilted is worse than none.
        let Some(attitude) = self.attitudes.at(stamp) else {
            self.counts.n_without_attitude += 1;
            return;
        };
        self.last_scan = Some(stamp);
        let is_stale = attitude.age > self.max_attitude_age;
        let tilt = Pose3::from_parts(Translation3::identity(), attitude.stabilized_from_base);
        let base_from_sensor = tilt * observation.base_from_sensor;
        let mut leveled = scan.clone();
        if self.deskews {
            deskew(&mut leveled, &attitude, &observation.base_from_sensor);
        }
        let tally = self.drop_beams(&mut leveled, &Tilt::of(&base_from_sensor), out);
        self.counts.add(&tally, is_stale);
        let valid = observation.valid && !is_stale;
        let (sensor, data) = (self.sensor, Data::LaserScan(leveled));
        out.push(Observation { sensor, stamp, base_from_sensor, valid, data });
    }

    /// Beams that say nothing read not-a-number; a scan in which all say something shares its ranges with the laser's.
    fn drop_beams(&self, scan: &mut LaserScan, tilt: &Tilt, out: &mut Observations) -> Tally {
        let mut ranges_m: Option<Buffer<f32>> = None;
        let tally = self.rules.apply(scan, tilt, |idx, range_m| {
            let ranges_m = ranges_m.get_or_insert_with(|| copy(&scan.ranges_m, out));
            if let Some(kept_m) = ranges_m.make_mut().get_mut(idx) {
                *kept_m = range_m;
            }
        });
        if let Some(ranges_m) = ranges_m {
            scan.ranges_m = ranges_m;
        }
        if self.max_points > 0 && tally.n_hits as usize > self.max_points {
            let mut ranges_m = copy(&scan.ranges_m, out);
            thin(scan, self.max_points, |idx| {
                if let Some(kept_m) = ranges_m.make_mut().get_mut(idx) {
                    *kept_m = f32::NAN;
                }
            });
            scan.ranges_m = ranges_m;
        }
        tally
    }
}

fn copy(ranges_m: &Buffer<f32>, out: &mut Observations) -> Buffer<f32> {
    let mut copied = out.buffer(ranges_m.len());
    copied.make_mut().copy_from_slice(ranges_m);
    copied
}

/// Beam `k` of `n` leaves the laser `k / (n - 1)` of the sweep after the stamp, turned by as much as the laser has turned
/// about its own axis until then: at an even rate, beams stay evenly apart.
fn deskew(scan: &mut LaserScan, attitude: &AttitudeThen, base_from_sensor: &Pose3) {
    let rate_rad_s = (base_from_sensor.rotation.inverse() * attitude.rates_rad_s).z;
    let n_steps = scan.ranges_m.len().saturating_sub(1).max(1);
    scan.bearing_step_rad += rate_rad_s * scan.sweep_s / n_steps as f64;
    scan.sweep_s = 0.0;
}

impl Counts {
    fn add(&mut self, tally: &Tally, is_stale: bool) {
        self.n_scans += 1;
        self.n_stale += u64::from(is_stale);
        self.n_empty += u64::from(tally.n_hits == 0);
        self.n_by_range += u64::from(tally.n_by_range);
        self.n_by_height += u64::from(tally.n_by_height);
    }

    fn tell(&self, cx: &mut Cx<'_>) {
        for (name, n) in [
            ("scans_leveled", self.n_scans),
            ("scans_attitude_stale", self.n_stale),
            ("scans_too_few_points", self.n_empty),
            ("scans_not_newer", self.n_late),
            ("scans_without_attitude", self.n_without_attitude),
            ("beams_out_of_range", self.n_by_range),
            ("beams_out_of_height", self.n_by_height),
        ] {
            cx.trace.count(name, n as f64);
        }
    }
}

#[cfg(test)]
mod tests;
