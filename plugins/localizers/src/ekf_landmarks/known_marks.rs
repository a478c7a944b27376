//! The marks of the map, by their identity.

use std::collections::BTreeMap;

use nalgebra::{Matrix2, Point2};
use rumbo_core::map::{Landmark, Landmarks};

/// A mark of the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KnownMark {
    /// Where it is in the map.
    pub at: Point2<f64>,
    /// How surely, m².
    pub covariance: Matrix2<f64>,
}

/// All marks of a map.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct KnownMarks {
    by_identity: BTreeMap<u32, KnownMark>,
}

impl KnownMarks {
    /// The marks of a layer.
    ///
    /// # Errors
    /// A sentence about the first mark that is no mark, or is there twice.
    pub fn of(layer: &Landmarks) -> Result<KnownMarks, String> {
        let mut by_identity = BTreeMap::new();
        for landmark in layer.landmarks.iter() {
            let Landmark { identity, position: [x, y], covariance: [xx, xy, yy], .. } = *landmark;
            let is_finite = [x, y, xx, xy, yy].iter().all(|v| v.is_finite());
            let is_covariance = xx >= 0.0 && yy >= 0.0 && xy * xy <= xx * yy * (1.0 + 1e-9);
            if !is_finite || !is_covariance {
                return Err(format!(
                    "landmark {identity} of the map has position {:?} and covariance {:?}, expected finite numbers \
                     and a covariance",
                    landmark.position, landmark.covariance
                ));
            }
            let mark = KnownMark { at: Point2::new(x, y), covariance: Matrix2::new(xx, xy, xy, yy) };
            if by_identity.insert(identity, mark).is_some() {
                return Err(format!("the map has two landmarks of identity {identity}, expected one"));
            }
        }
        Ok(KnownMarks { by_identity })
    }

    /// The mark of an identity.
    pub fn get(&self, identity: u32) -> Option<&KnownMark> {
        self.by_identity.get(&identity)
    }

    /// All of them with their identities.
    pub fn iter(&self) -> impl Iterator<Item = (u32, &KnownMark)> {
        self.by_identity.iter().map(|(identity, mark)| (*identity, mark))
    }
}
