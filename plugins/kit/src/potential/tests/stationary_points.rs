use super::warehouse::{field, groups, stationary_points};
use crate::potential::{Field, Form, Obstacles};
use nalgebra::{Matrix2, Point2, Vector2};

/// FC-A2: Newton from a grid of places finds the two minima and the twelve saddles that the source's map has, and no
/// others.
#[test]
fn stationary_points_are_the_published_ones() {
    let obstacles = Obstacles::new(&groups(), 2.0).unwrap();
    let field = field(&obstacles, Form::Conic);
    let mut found: Vec<(bool, Point2<f64>)> = Vec::new();
    for col in 0..160 {
        for row in 0..120 {
            let from = Point2::new(0.125 + 0.25 * f64::from(col), 0.125 + 0.25 * f64::from(row));
            let Some((at, is_minimum)) = newton(&field, from) else { continue };
            if found.iter().all(|(_, other)| (at - other).norm() > 1e-3) {
                found.push((is_minimum, at));
            }
        }
    }
    let published = stationary_points();
    assert_eq!(published.len(), 14);
    assert_eq!(found.len(), 14, "{found:?}");
    for (is_minimum, at) in published {
        // Saddles are printed with four digits.
        let allowed = if is_minimum { 1e-6 } else { 1e-3 };
        let same = found.iter().find(|(_, other)| (at - other).norm() < allowed);
        assert_eq!(same.map(|(found, _)| *found), Some(is_minimum), "{at}");
    }
}

/// Newton's method from one place. None where it does not come to a stationary point that is outside of all racks and
/// has force zero on all sides.
fn newton(field: &Field<'_>, from: Point2<f64>) -> Option<(Point2<f64>, bool)> {
    const STEP: f64 = 1e-6;
    let mut at = from;
    for _ in 0..60 {
        let force = field.sample(at).force;
        let column = |axis: Vector2<f64>| {
            (field.sample(at - axis * STEP).force - field.sample(at + axis * STEP).force) / (2.0 * STEP)
        };
        let hessian = Matrix2::from_columns(&[column(Vector2::x()), column(Vector2::y())]);
        if force.norm() < 1e-10 {
            let eigenvalues = hessian.symmetric_eigenvalues();
            let is_outside = !groups().iter().any(|group| group.len() == 4 && is_inside(group, at));
            return is_outside.then_some((at, eigenvalues.min() > 0.0));
        }
        let step = hessian.try_inverse()? * force;
        // Long steps leave the neighborhood that a grid place stands for.
        at += step * (0.25 / step.norm()).min(1.0);
    }
    None
}

fn is_inside(rack: &[crate::potential::Piece], at: Point2<f64>) -> bool {
    let side = |piece: &crate::potential::Piece| (piece.to - piece.from).perp(&(at - piece.from)) > 0.0;
    rack.iter().all(side)
}
