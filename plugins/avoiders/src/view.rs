//! What one reading shows: points, and how far it sees in a direction.

use nalgebra::{Rotation3, Vector2, Vector3};
use rumbo_core::frames::{Point2, Pose3};
use rumbo_core::messages::{Data, LaserScan, Observation, PointCloud, RangeRing};

/// Turns readings into views; keeps the room that clouds need.
#[derive(Debug)]
pub struct View {
    band_m: [f64; 2],
    bins: Vec<Option<Point2>>,
}

/// A reading, seen from the base.
#[derive(Debug)]
pub struct Viewed<'a> {
    center: Point2,
    /// The sensor's x and y axes on the floor; y points right for a sensor that is mounted upside down.
    axes: [Vector2<f64>; 2],
    reading: Reading<'a>,
}

#[derive(Debug)]
enum Reading<'a> {
    Scan(&'a LaserScan),
    Ring(&'a RangeRing),
    /// The nearest point of every direction.
    Cloud(&'a [Option<Point2>]),
}

/// What a reading says of a point that was seen before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Word {
    /// It is seen again, or seen through.
    Told,
    /// The sensor looks elsewhere, or something stands before it.
    Hidden,
    /// The sensor looks there and has no reading: a depth camera reads nothing that is very near.
    Unread,
}

/// What a sensor says of a direction.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Glance {
    /// It does not look there.
    Outside,
    /// It looks there and cannot tell.
    NoReading,
    /// The first thing is so far from the sensor, meters; infinite where nothing is in reach.
    At(f64),
}

impl View {
    /// Directions of a cloud: a quarter of a turn is a quarter of them. At most 0.5 degrees wide.
    const N_BINS: usize = 1024;

    /// Points of clouds count between these heights over the floor, meters.
    pub fn new(band_m: [f64; 2]) -> View {
        View { band_m, bins: vec![None; Self::N_BINS] }
    }

    /// A reading that shows points; none for other kinds.
    pub fn look<'a>(&'a mut self, observation: &'a Observation) -> Option<Viewed<'a>> {
        let base_from_sensor = &observation.base_from_sensor;
        let on_floor = |axis: Vector3<f64>| (base_from_sensor.rotation * axis).xy();
        let center: Point2 = base_from_sensor.translation.vector.xy().into();
        let axes = [on_floor(Vector3::x()), on_floor(Vector3::y())];
        let reading = match &observation.data {
            Data::LaserScan(scan) => Reading::Scan(scan),
            Data::RangeRing(ring) => Reading::Ring(ring),
            Data::PointCloud(cloud) => {
                self.sort(cloud, base_from_sensor, center);
                Reading::Cloud(&self.bins)
            }
            _ => return None,
        };
        Some(Viewed { center, axes, reading })
    }

    /// The nearest point of every direction, as seen from the sensor, among those of the height band.
    fn sort(&mut self, cloud: &PointCloud, base_from_sensor: &Pose3, center: Point2) {
        self.bins.fill(None);
        let rotation: Rotation3<f64> = base_from_sensor.rotation.to_rotation_matrix();
        let shift = base_from_sensor.translation.vector;
        for [x, y, z] in cloud.points_m.iter().copied() {
            let point = rotation * Vector3::new(x.into(), y.into(), z.into()) + shift;
            // A point without reading is in no band.
            if !(point.z >= self.band_m[0] && point.z <= self.band_m[1]) {
                continue;
            }
            let (point, from_center_sq) =
                (Point2::new(point.x, point.y), (point.xy() - center.coords).norm_squared());
            if let Some(bin) = self.bins.get_mut(bin_of(point - center)) {
                let is_nearer = bin.is_none_or(|other| from_center_sq < (other - center).norm_squared());
                *bin = if is_nearer { Some(point) } else { *bin };
            }
        }
    }
}

/// The direction's number: an angle in which each quarter of a turn is one, without its sines.
fn bin_of(direction: Vector2<f64>) -> usize {
    let (x, y) = (direction.x, direction.y);
    let part = y / (x.abs() + y.abs()).max(f64::MIN_POSITIVE);
    let quarters = if x < 0.0 { 2.0 - part } else { part };
    (quarters.rem_euclid(4.0) / 4.0 * View::N_BINS as f64) as usize % View::N_BINS
}

impl Viewed<'_> {
    /// What the sensor sees this much nearer or farther is the same thing, meters.
    const SAME_M: f64 = 0.10;

    /// Every hit, in the base frame.
    pub fn each_point(&self, mut visit: impl FnMut(Point2)) {
        let mut polar = |bearing_rad: f64, distance_m: f64| {
            let (sin, cos) = bearing_rad.sin_cos();
            visit(self.center + self.axes[0] * (distance_m * cos) + self.axes[1] * (distance_m * sin));
        };
        match self.reading {
            Reading::Scan(scan) => scan.hits().for_each(|(bearing_rad, range_m)| polar(bearing_rad, range_m)),
            Reading::Ring(ring) => {
                ring.echoes()
                    .for_each(|(bearing_rad, range_m)| polar(bearing_rad, ring.ring_radius_m + range_m));
            }
            Reading::Cloud(bins) => bins.iter().flatten().for_each(|point| visit(*point)),
        }
    }

    /// What the reading says of a point of the base frame that was seen before.
    pub fn says_of(&self, in_base: Point2) -> Word {
        match self.glance(in_base) {
            Glance::Outside => Word::Hidden,
            Glance::NoReading => Word::Unread,
            Glance::At(first_m) if first_m < (in_base - self.center).norm() - Self::SAME_M => Word::Hidden,
            Glance::At(_) => Word::Told,
        }
    }

    fn glance(&self, in_base: Point2) -> Glance {
        let toward = in_base - self.center;
        let bearing_rad = toward.dot(&self.axes[1]).atan2(toward.dot(&self.axes[0]));
        match self.reading {
            Reading::Scan(scan) => {
                let beam = beam_at(scan.first_bearing_rad, scan.bearing_step_rad, bearing_rad);
                of_range(beam.and_then(|idx| scan.ranges_m.get(idx)), 0.0, scan.min_range_m, scan.max_range_m)
            }
            Reading::Ring(ring) => {
                let beam = beam_at(ring.first_bearing_rad, ring.bearing_step_rad, bearing_rad);
                of_range(
                    beam.and_then(|idx| ring.ranges_m.get(idx)),
                    ring.ring_radius_m,
                    ring.min_range_m,
                    ring.max_range_m,
                )
            }
            // A cloud does not say where its camera looks: without a point it may be elsewhere.
            Reading::Cloud(bins) => match bins.get(bin_of(toward)).copied().flatten() {
                None => Glance::Outside,
                Some(point) => Glance::At((point - self.center).norm()),
            },
        }
    }
}

/// The beam nearest to a bearing, which may be counted another turn around.
fn beam_at(first_rad: f64, step_rad: f64, bearing_rad: f64) -> Option<usize> {
    let turns = (bearing_rad - first_rad) * step_rad.signum() + step_rad.abs() / 2.0;
    let beam = turns.rem_euclid(std::f64::consts::TAU) / step_rad.abs();
    beam.is_finite().then_some(beam as usize)
}

fn of_range(range: Option<&f32>, from_m: f64, min_range_m: f32, max_range_m: f32) -> Glance {
    match range {
        None => Glance::Outside,
        Some(range) if *range > max_range_m => Glance::At(f64::INFINITY),
        Some(range) if *range >= min_range_m => Glance::At(from_m + f64::from(*range)),
        Some(_) => Glance::NoReading,
    }
}
