//! A picture of two trajectories, one over the other.

use crate::exit::Failure;
use crate::picture::{Anchor, Raster, Role, Sketch, scale_bar};
use rumbo_core::frames::Pose3;
use rumbo_kit::trajectory::{PosePair, Similarity};

const EDGE: f64 = 24.0;
/// Room for the title.
const HEAD: f64 = 56.0;
/// Room for scale and legend.
const FOOT: f64 = 60.0;
const WIDTH: f64 = 1000.0;
const MOST_HEIGHT: f64 = 760.0;
const LETTERS: f64 = 15.0;
const AXES: [&str; 3] = ["x", "y", "z"];

/// The two axes along which the truth extends most, drawn to scale: a robot seen from above, whatever its camera calls
/// the axes.
pub fn overlay(pairs: &[PosePair], alignment: &Similarity, headline: &str) -> Sketch {
    let truth: Vec<Pose3> = pairs.iter().map(|pair| pair.truth).collect();
    let aligned: Vec<Pose3> = pairs.iter().map(|pair| alignment.apply(&pair.estimate)).collect();
    let axes = widest(&truth);
    let seen = |poses: &[Pose3]| -> Vec<[f64; 2]> {
        poses.iter().map(|pose| axes.map(|axis| pose.translation.vector[axis])).collect()
    };
    let (truth, aligned) = (seen(&truth), seen(&aligned));
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for point in truth.iter().chain(&aligned) {
        for ((low, high), value) in low.iter_mut().zip(&mut high).zip(point) {
            (*low, *high) = (low.min(*value), high.max(*value));
        }
    }
    // A trajectory that stands still is a point in a square meter.
    let [width_m, height_m] = [high[0] - low[0], high[1] - low[1]].map(|size| size.max(1e-3));
    let pixels_per_m = ((WIDTH - 2.0 * EDGE) / width_m).min(MOST_HEIGHT / height_m);
    let height = height_m * pixels_per_m;
    let place =
        |[x, y]: [f64; 2]| [EDGE + (x - low[0]) * pixels_per_m, HEAD + height - (y - low[1]) * pixels_per_m];
    let drawn = |points: Vec<[f64; 2]>| points.into_iter().map(place).collect::<Vec<_>>();
    let mut sheet = Sketch::sheet(WIDTH, HEAD + height + FOOT + EDGE);
    sheet.heading([EDGE, 34.0], 18.0, headline);
    sheet.chain(Role::Truth, drawn(truth));
    sheet.chain(Role::Estimate, drawn(aligned));
    let foot = HEAD + height + FOOT;
    scale_bar(&mut sheet, [EDGE, foot], pixels_per_m);
    let names = axes.map(|axis| AXES.get(axis).copied().unwrap_or_default());
    let plane = format!("{} to the right, {} up", names[0], names[1]);
    for (left, role, words) in
        [(300.0, Some(Role::Truth), "truth"), (460.0, Some(Role::Estimate), "estimate, aligned")]
            .into_iter()
            .chain([(700.0, None, plane.as_str())])
    {
        if let Some(role) = role {
            sheet.chain(role, vec![[left, foot - 5.0], [left + 28.0, foot - 5.0]]);
        }
        sheet.text(Role::Text, [left + 36.0, foot], LETTERS, Anchor::Start, words);
    }
    sheet
}

/// The two axes of greatest extent, in their order.
fn widest(poses: &[Pose3]) -> [usize; 2] {
    let extent = |axis: usize| {
        let values = poses.iter().map(|pose| pose.translation.vector[axis]);
        values.clone().fold(f64::NEG_INFINITY, f64::max) - values.fold(f64::INFINITY, f64::min)
    };
    let extents = [0, 1, 2].map(extent);
    // Of equal ones the vertical axis is left out.
    match extents {
        [x, y, z] if z > y && y <= x => [0, 2],
        [x, y, z] if z > x && x < y => [1, 2],
        _ => [0, 1],
    }
}

/// The sketch as a PNG file.
pub fn png(sketch: &Sketch) -> Result<Vec<u8>, Failure> {
    /// Sharp on screens with small pixels.
    const SCALE: f64 = 1.5;
    let png = Raster::draw(sketch, SCALE).and_then(|raster| raster.png());
    png.map_err(|error| Failure::Internal(format!("cannot draw the picture: {error}")))
}
