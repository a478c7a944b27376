//! A hall of 12 m by 9 m with a floor, seen by a laser on a base that drives and tilts, and felt by its inertial device.
//! Beams and forces are computed here, by nothing that the filter uses.

use super::*;
use rand_distr::{Distribution, StandardNormal};

/// Walls by their ends, meters.
const WALLS: [[f64; 4]; 8] = [
    [0.0, 0.0, 12.0, 0.0],
    [12.0, 0.0, 12.0, 9.0],
    [12.0, 9.0, 0.0, 9.0],
    [0.0, 9.0, 0.0, 0.0],
    [9.0, 3.0, 10.0, 3.0],
    [10.0, 3.0, 10.0, 4.0],
    [2.0, 7.0, 3.5, 8.0],
    [1.0, 1.0, 2.0, 0.5],
];
const WALL_HEIGHT_M: f64 = 2.5;

/// How the inertial device errs.
#[derive(Debug, Clone, Copy)]
pub struct Device {
    pub rate_noise_rad_s: f64,
    pub rate_bias_rad_s: f64,
    pub force_noise_m_s2: f64,
    /// Of the attitude that levels the scans.
    pub attitude_deg: f64,
    /// Where it sits on the base, meters.
    pub arm_m: [f64; 3],
}

impl Default for Device {
    fn default() -> Self {
        Device {
            rate_noise_rad_s: 0.005,
            rate_bias_rad_s: 0.005,
            force_noise_m_s2: 0.05,
            attitude_deg: 0.5,
            arm_m: [0.0; 3],
        }
    }
}

impl Device {
    fn mount(&self) -> Pose3 {
        Pose3::from_parts(Vector3::from(self.arm_m).into(), UnitQuaternion::identity())
    }
}

/// How the robot drives and tilts.
#[derive(Debug, Clone, Copy, Default)]
pub struct Drive {
    pub seconds: f64,
    pub speed_m_s: f64,
    pub turn_rad_s: f64,
    /// Roll and pitch sway by this at 0.5 Hz.
    pub sway_deg: f64,
    /// Pitched by this from second 1.5 to 6.5.
    pub steep_deg: f64,
    pub device: Device,
}

const LASER_HZ: f64 = 20.0;
const IMU_HZ: f64 = 200.0;

impl Drive {
    /// The base after so many seconds, in the hall.
    pub fn truth(&self, seconds: f64) -> Pose3 {
        // It stands for a second and gets to its speed within another.
        let since = (seconds - 1.0).max(0.0);
        let gathering = since.min(1.0);
        let driven_s = gathering.powi(3) - 0.5 * gathering.powi(4) + (since - 1.0).max(0.0);
        let way = Twist::new(self.speed_m_s, self.turn_rad_s).integrate(driven_s);
        // It begins and ends to tilt smoothly, as bodies do.
        let smooth = |share: f64| share * share * (3.0 - 2.0 * share);
        let omega = std::f64::consts::PI;
        let roll_deg = self.sway_deg * smooth((seconds - 1.0).clamp(0.0, 1.0)) * (omega * seconds).sin();
        let sway_deg =
            self.sway_deg * smooth((seconds - 1.0).clamp(0.0, 1.0)) * (omega * seconds + 1.0).sin();
        let share = ((seconds - 1.0) / 0.5).clamp(0.0, 1.0) - ((seconds - 6.5) / 0.5).clamp(0.0, 1.0);
        let pitch_deg = sway_deg + self.steep_deg * smooth(share);
        let tilt = UnitQuaternion::from_euler_angles(roll_deg.to_radians(), pitch_deg.to_radians(), 0.0);
        let place = lift(&(pose2(4.0, 3.5, 0.3) * way));
        place * Pose3::from_parts(Translation3::identity(), tilt)
    }

    /// Where the odometer's frame is: on the floor where the robot begins.
    pub fn start(&self) -> Pose3 {
        lift(&pose2(4.0, 3.5, 0.3))
    }

    /// All that its sensors give, by stamp: samples before a scan of the same moment.
    pub fn observations(&self) -> Vec<Observation> {
        let mut rng = rumbo_core::rng::stream(11, "hall");
        let mut normal = |std: f64| -> f64 { std * Distribution::<f64>::sample(&StandardNormal, &mut rng) };
        let every = (IMU_HZ / LASER_HZ) as usize;
        let mut all = Vec::new();
        for k in 0..(self.seconds * IMU_HZ) as usize {
            let t = k as f64 / IMU_HZ;
            all.push(head(0, t, self.device.mount(), Data::Imu(self.sample(t, &mut normal))));
            if k % every == 0 {
                let truth = self.truth(t);
                let mount = Pose3::from_parts(Translation3::new(0.1, 0.0, 0.4), UnitQuaternion::identity());
                let std_rad = self.device.attitude_deg.to_radians();
                let tilts = self.sway_deg != 0.0 || self.steep_deg != 0.0;
                let wrong = if tilts {
                    UnitQuaternion::from_euler_angles(normal(std_rad), normal(std_rad), 0.0)
                } else {
                    UnitQuaternion::identity()
                };
                let leveled = wrong * FrameChain::of(&truth).stabilized_from_base;
                let scan = scan(&(truth * mount), &leveled, &mount, &mut normal);
                let base_from_sensor = leveled * mount;
                all.push(head(1, t, base_from_sensor, Data::LaserScan(scan)));
            }
        }
        all
    }

    /// Rates and forces by differences of the true poses.
    fn sample(&self, t: f64, normal: &mut impl FnMut(f64) -> f64) -> Imu {
        let h = 1e-3;
        let (before, now, after) = (self.truth(t - h), self.truth(t), self.truth(t + h));
        let rates = (before.rotation.inverse() * after.rotation).scaled_axis() / (2.0 * h);
        let arm = self.device.mount();
        let place = |pose: &Pose3| (pose * arm).translation.vector;
        let acceleration = (place(&before) + place(&after) - place(&now) * 2.0) / (h * h);
        let forces = now.rotation.inverse() * (acceleration + Vector3::z() * 9.80665);
        let device = self.device;
        let noise = |v: f64, std: f64, normal: &mut dyn FnMut(f64) -> f64| v + normal(std);
        Imu {
            attitude_rad: None,
            rates_rad_s: rates
                .map(|rate| noise(rate + device.rate_bias_rad_s, device.rate_noise_rad_s, normal))
                .into(),
            accelerations_m_s2: forces.map(|force| noise(force, device.force_noise_m_s2, normal)).into(),
        }
    }
}

fn head(sensor: u16, t: f64, base_from_sensor: Pose3, data: Data) -> Observation {
    Observation { sensor: SensorId(sensor), stamp: Time::from_secs(t), base_from_sensor, valid: true, data }
}

/// 361 beams over 270 degrees. What its own attitude takes for the floor, or for something over the walls, is left out.
fn scan(
    hall_from_sensor: &Pose3,
    leveled: &UnitQuaternion<f64>,
    mount: &Pose3,
    normal: &mut impl FnMut(f64) -> f64,
) -> LaserScan {
    let step = 0.75f64.to_radians();
    let first = -135f64.to_radians();
    let height_m = (leveled * mount).translation.z;
    let range = |k: usize, noise_m: f64| {
        let bearing = first + step * k as f64;
        let along = Vector3::new(bearing.cos(), bearing.sin(), 0.0);
        let range_m = cast(hall_from_sensor, &(hall_from_sensor.rotation * along)) + noise_m;
        let rises = (leveled * mount.rotation * along).z;
        let end_m = height_m + rises * range_m;
        let is_floor = rises < -0.0175 && end_m < 0.05 + 0.0175 * range_m;
        if is_floor || end_m - height_m > 1.0 { f32::NAN } else { range_m as f32 }
    };
    LaserScan {
        first_bearing_rad: first,
        bearing_step_rad: step,
        max_range_m: 30.0,
        ranges_m: (0..361).map(|k| range(k, normal(0.01))).collect::<Vec<f32>>().into(),
        ..LaserScan::default()
    }
}

/// Distance to the nearest wall or the floor, meters; infinite over the walls.
fn cast(from: &Pose3, along: &Vector3<f64>) -> f64 {
    let at = from.translation.vector;
    let floor_m = if along.z < -1e-9 { -at.z / along.z } else { f64::INFINITY };
    let walls = WALLS.iter().filter_map(|[x0, y0, x1, y1]| {
        let (dx, dy) = (x1 - x0, y1 - y0);
        let determinant = along.x * dy - along.y * dx;
        if determinant.abs() < 1e-12 {
            return None;
        }
        let (rx, ry) = (x0 - at.x, y0 - at.y);
        let range_m = (rx * dy - ry * dx) / determinant;
        let share = (rx * along.y - ry * along.x) / determinant;
        let is_met = range_m > 0.0 && (0.0..=1.0).contains(&share);
        (is_met && at.z + along.z * range_m < WALL_HEIGHT_M).then_some(range_m)
    });
    walls.fold(floor_m, f64::min)
}
