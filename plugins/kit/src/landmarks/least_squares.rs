//! A wall's line by total least squares, and how surely it is known.

use super::readings::Reading;

/// A line in normal form: `x cos(bearing) + y sin(bearing) = distance`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Line {
    /// From the sensor, meters, at least zero.
    pub distance_m: f64,
    /// Direction of the normal, radians.
    pub bearing_rad: f64,
}

/// Sums over readings that were taken into account.
#[derive(Default)]
struct Moments {
    n: f64,
    mean: [f64; 2],
    xx: f64,
    xy: f64,
    yy: f64,
}

impl Moments {
    fn of(readings: impl Iterator<Item = [f64; 2]> + Clone) -> Moments {
        let mut m = Moments::default();
        for [x, y] in readings.clone() {
            m.n += 1.0;
            m.mean[0] += x;
            m.mean[1] += y;
        }
        m.mean = m.mean.map(|sum| sum / m.n);
        for [x, y] in readings {
            let (dx, dy) = (x - m.mean[0], y - m.mean[1]);
            m.xx += dx * dx;
            m.xy += dx * dy;
            m.yy += dy * dy;
        }
        m
    }

    /// Through the mean, along the larger eigenvector of the scatter.
    fn line(&self) -> Line {
        let along_rad = 0.5 * (2.0 * self.xy).atan2(self.xx - self.yy);
        Line::through(self.mean, along_rad + std::f64::consts::FRAC_PI_2)
    }
}

impl Line {
    /// The line through a point with this normal, or the opposite one if that points away from the sensor.
    fn through([x, y]: [f64; 2], normal_rad: f64) -> Line {
        let (sin, cos) = normal_rad.sin_cos();
        let distance = x * cos + y * sin;
        let turned = if distance < 0.0 { std::f64::consts::PI } else { 0.0 };
        Line { distance_m: distance.abs(), bearing_rad: normal_rad + turned }
    }
}

/// The line with the least sum of squared distances from the readings; those farther than `uneven_m` from a first fit are
/// left out of the second: door frames and switches are no part of the wall. There must be two readings.
pub(super) fn fitted(readings: &[Reading], uneven_m: f64) -> Line {
    let places = readings.iter().map(|reading| reading.place);
    let first = Moments::of(places.clone()).line();
    let (sin, cos) = first.bearing_rad.sin_cos();
    let near = places.filter(|[x, y]| (x * cos + y * sin - first.distance_m).abs() <= uneven_m);
    let moments = Moments::of(near);
    // A crooked piece that no straight line fits: the first fit is as good as any.
    if moments.n * 2.0 < readings.len() as f64 { first } else { moments.line() }
}

/// Covariance of distance and bearing of a fitted line when each range has an error of variance one: a reading leaves the
/// line by its error times the cosine of the incidence, which is `distance / range`. First order.
pub(super) fn unit_covariance(readings: &[Reading], line: &Line) -> [f64; 3] {
    let (sin, cos) = line.bearing_rad.sin_cos();
    let along = |reading: &Reading| reading.place[1] * cos - reading.place[0] * sin;
    let n = readings.len() as f64;
    let middle = readings.iter().map(along).sum::<f64>() / n;
    let (mut offset, mut both, mut slope, mut inertia) = (0.0, 0.0, 0.0, 0.0);
    for reading in readings {
        let t = along(reading) - middle;
        let cosine2 = (line.distance_m / reading.range_m).powi(2).min(1.0);
        offset += cosine2;
        both += t * cosine2;
        slope += t * t * cosine2;
        inertia += t * t;
    }
    if !(n > 0.0 && inertia > 0.0) {
        return [1.0, 0.0, 1.0];
    }
    let (offset, both, slope) = (offset / (n * n), both / (n * inertia), slope / (inertia * inertia));
    // The wall turns about its middle, which lies `middle` beside the foot of the normal.
    [offset - 2.0 * middle * both + middle * middle * slope, middle * slope - both, slope]
}

/// Root of the mean square of distances from a line, meters.
pub(super) fn unevenness_m(readings: &[Reading], line: &Line) -> f64 {
    let (sin, cos) = line.bearing_rad.sin_cos();
    let off = |reading: &Reading| reading.place[0] * cos + reading.place[1] * sin - line.distance_m;
    let sum: f64 = readings.iter().map(|reading| off(reading).powi(2)).sum();
    (sum / readings.len().max(1) as f64).sqrt()
}
