//! Where a robot is that sees three marks or more, and knows nothing else.
//!
//! The points that were seen, in the base's frame, are laid over the marks of the map: in closed form first (Arun, Huang
//! and Blostein 1987, in the plane), then by weighted least squares of ranges and bearings.

use nalgebra::{Matrix3, Point2, Vector2, Vector3};
use rumbo_core::frames::{Pose2, pose2, wrap_angle};

use super::known_marks::KnownMark;
use super::sighting::{Sighting, expect};

/// Fewer marks than this could be laid over the map by mistake.
pub const LEAST_MARKS: usize = 3;

/// A pose that fits all sightings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fix {
    /// The robot.
    pub map_from_base: Pose2,
    /// Covariance of x, y, yaw.
    pub covariance: Matrix3<f64>,
}

/// Steps of Gauss and Newton at most; a few do.
const MOST_STEPS: usize = 20;
/// Steps end below this, meters or radians.
const CONVERGED: f64 = 1e-10;

/// The pose from which these sightings of these marks were made. None with fewer than three, where all marks are in one
/// place, or where they contradict each other (99.9 % of the chi-square distribution).
pub fn locate(sightings: &[(Sighting, KnownMark)]) -> Option<Fix> {
    if sightings.len() < LEAST_MARKS {
        return None;
    }
    let mut pose = laid_over(sightings)?;
    for _ in 0..MOST_STEPS {
        let (information, pull, _) = normal_equations(&pose, sightings)?;
        let step: Vector3<f64> = information.cholesky()?.solve(&pull);
        pose = moved_by(&pose, &step);
        if step.amax() < CONVERGED {
            break;
        }
    }
    let (information, _, misfit) = normal_equations(&pose, sightings)?;
    let covariance = information.cholesky()?.inverse();
    let fits = misfit <= chi_square_999(2 * sightings.len() - 3);
    fits.then_some(Fix { map_from_base: pose, covariance: (covariance + covariance.transpose()) / 2.0 })
}

fn moved_by(pose: &Pose2, step: &Vector3<f64>) -> Pose2 {
    let at = pose.translation.vector + step.xy();
    pose2(at.x, at.y, wrap_angle(pose.rotation.angle() + step.z))
}

/// The rigid motion that brings the points that were seen nearest to the marks.
fn laid_over(sightings: &[(Sighting, KnownMark)]) -> Option<Pose2> {
    let pairs: Vec<[Point2<f64>; 2]> =
        sightings.iter().map(|(sighting, mark)| [sighting.in_base(), mark.at]).collect();
    let n = pairs.len() as f64;
    let mean = |which: fn(&[Point2<f64>; 2]) -> Point2<f64>| {
        pairs.iter().map(|pair| which(pair).coords).sum::<Vector2<f64>>() / n
    };
    let (seen_mean, map_mean) = (mean(|[seen, _]| *seen), mean(|[_, mark]| *mark));
    let (mut dot, mut cross) = (0.0, 0.0);
    for [seen, mark] in &pairs {
        let (a, b) = (seen.coords - seen_mean, mark.coords - map_mean);
        dot += a.dot(&b);
        cross += a.perp(&b);
    }
    // All in one place: any heading fits.
    let is_sound = dot.hypot(cross) > 1e-9;
    let rotation = nalgebra::UnitComplex::new(cross.atan2(dot));
    let at = map_mean - rotation * seen_mean;
    is_sound.then(|| pose2(at.x, at.y, rotation.angle()))
}

/// Information, its vector and the sum of squared deviations at a pose.
fn normal_equations(
    pose: &Pose2,
    sightings: &[(Sighting, KnownMark)],
) -> Option<(Matrix3<f64>, Vector3<f64>, f64)> {
    let (mut information, mut pull, mut misfit) = (Matrix3::zeros(), Vector3::zeros(), 0.0);
    for (sighting, mark) in sightings {
        let expected = expect(pose, &sighting.base_from_sensor, &mark.at)?;
        let noise = sighting.noise + expected.by_mark * mark.covariance * expected.by_mark.transpose();
        let weight = noise.cholesky()?.inverse();
        let residual = sighting.minus(&expected.expected);
        information += expected.by_pose.transpose() * weight * expected.by_pose;
        pull += expected.by_pose.transpose() * weight * residual;
        misfit += residual.dot(&(weight * residual));
    }
    Some((information, pull, misfit))
}

/// The value that a chi-square variable of so many degrees of freedom exceeds once in a thousand times: the cube of a
/// normal variable (Wilson and Hilferty 1931), within 2 % from three degrees on.
fn chi_square_999(degrees: usize) -> f64 {
    const NORMAL_999: f64 = 3.090_232_306_167_813;
    let k = degrees as f64;
    let spread = 2.0 / (9.0 * k);
    k * (1.0 - spread + NORMAL_999 * spread.sqrt()).powi(3)
}

#[cfg(test)]
mod tests {
    use super::chi_square_999;

    /// Printed tables of the chi-square distribution.
    #[test]
    fn the_quantile_agrees_with_printed_tables() {
        for (degrees, printed) in [(3, 16.266), (5, 20.515), (10, 29.588), (30, 59.703)] {
            assert!((chi_square_999(degrees) / printed - 1.0).abs() < 0.02, "{degrees}");
        }
    }
}
