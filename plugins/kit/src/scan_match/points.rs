//! The points of one scan, in the base frame.

use super::observability::Observability;
use super::shape::{ScanShape, ShapePoint};

/// Points with weights, as columns that are kept between scans.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ScanPoints {
    x: Vec<f32>,
    y: Vec<f32>,
    weights: Vec<f32>,
    shape: Option<ScanShape>,
    blind: Option<Observability>,
}

impl ScanPoints {
    /// Takes all points out.
    pub fn clear(&mut self) {
        [&mut self.x, &mut self.y, &mut self.weights].into_iter().for_each(Vec::clear);
        (self.shape, self.blind) = (None, None);
    }

    /// Adds a point, meters; a weight of 1 is that of an ordinary reading. What is not finite is left out.
    #[inline]
    pub fn push(&mut self, x_m: f32, y_m: f32, weight: f32) {
        if x_m.is_finite() && y_m.is_finite() && weight.is_finite() && weight > 0.0 {
            self.x.push(x_m);
            self.y.push(y_m);
            self.weights.push(weight);
        }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// There are none.
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// Along x of the base frame, meters.
    pub fn x(&self) -> &[f32] {
        &self.x
    }

    /// Along y of the base frame, meters.
    pub fn y(&self) -> &[f32] {
        &self.y
    }

    /// One weight a point.
    pub fn weights(&self) -> &[f32] {
        &self.weights
    }

    /// Changes the weights; those of points not named stay as they are.
    pub fn weights_mut(&mut self) -> &mut [f32] {
        &mut self.weights
    }

    /// What the scan tells by its own shape; none where it tells all directions many times over, or where nobody looked.
    pub fn shape(&self) -> Option<&ScanShape> {
        self.shape.as_ref()
    }

    /// The same, without keeping it.
    pub fn take_shape(&mut self) -> Option<ScanShape> {
        self.shape.take()
    }

    pub(super) fn set_shape(&mut self, shape: Option<ScanShape>) {
        self.blind = shape.as_ref().and_then(ScanShape::blind);
        self.shape = shape;
    }

    /// Directions, in the base frame, of which the scan tells something and nothing; none where it tells all.
    pub fn blind(&self) -> Option<&Observability> {
        self.blind.as_ref()
    }

    /// From now on only those points tell directions that are known where the scan is laid.
    pub fn count_where(&mut self, is_known: impl Fn(&ShapePoint) -> bool) {
        self.blind = self.shape.as_ref().and_then(|shape| shape.blind_where(is_known));
    }

    pub(super) fn set_blind(&mut self, blind: Option<Observability>) {
        self.blind = blind;
    }

    /// x, y and weight of each.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = [f32; 3]> + '_ {
        let places = self.x.iter().zip(&self.y);
        places.zip(&self.weights).map(|((x, y), weight)| [*x, *y, *weight])
    }

    /// Root of the mean square distance from the base, meters (rho); 1 where there are no points.
    pub fn extent_m(&self) -> f64 {
        let (mut sum, mut weight) = (0.0, 0.0);
        for [x, y, w] in self.iter() {
            let [x, y, w] = [x, y, w].map(f64::from);
            sum += w * (x * x + y * y);
            weight += w;
        }
        if sum > 0.0 { (sum / weight).sqrt() } else { 1.0 }
    }
}
