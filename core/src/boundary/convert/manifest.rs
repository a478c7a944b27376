//! What a plugin needs and gives, as bits.

use super::BadView;
use crate::boundary::abi::*;
use crate::map::Layer;
use crate::messages::ObservationKind;
use crate::registry::Manifest;
use crate::robot::DriveKind;

const LAYERS: [(u32, Layer); 4] = [
    (RUMBO_LAYER_GRID, Layer::Grid),
    (RUMBO_LAYER_LINES, Layer::Lines),
    (RUMBO_LAYER_LANDMARKS, Layer::Landmarks),
    (RUMBO_LAYER_VOXELS, Layer::Voxels),
];
const DRIVES: [(u32, DriveKind); 3] = [
    (1 << RUMBO_DIFFERENTIAL, DriveKind::Differential),
    (1 << RUMBO_TRICYCLE, DriveKind::Tricycle),
    (1 << RUMBO_OMNIDIRECTIONAL, DriveKind::Omnidirectional),
];
const KINDS: [(u32, ObservationKind); 12] = [
    (1 << RUMBO_ODOMETRY, ObservationKind::Odometry),
    (1 << RUMBO_WHEEL_SPEEDS, ObservationKind::WheelSpeeds),
    (1 << RUMBO_STEERING_ANGLE, ObservationKind::SteeringAngle),
    (1 << RUMBO_LASER_SCAN, ObservationKind::LaserScan),
    (1 << RUMBO_RANGE_RING, ObservationKind::RangeRing),
    (1 << RUMBO_BUMPERS, ObservationKind::Bumpers),
    (1 << RUMBO_DEPTH_IMAGE, ObservationKind::DepthImage),
    (1 << RUMBO_POINT_CLOUD, ObservationKind::PointCloud),
    (1 << RUMBO_IMU, ObservationKind::Imu),
    (1 << RUMBO_POSITION_FIX, ObservationKind::PositionFix),
    (1 << RUMBO_MARKS, ObservationKind::Marks),
    (1 << RUMBO_CUSTOM, ObservationKind::Custom),
];

fn bits<T: PartialEq>(values: &[T], known: &[(u32, T)]) -> u32 {
    known.iter().filter(|(_, value)| values.contains(value)).fold(0, |bits, (bit, _)| bits | bit)
}

fn values<T: Copy>(bits: u32, known: &[(u32, T)], what: &str) -> Result<Vec<T>, BadView> {
    let all = known.iter().fold(0, |all, (bit, _)| all | bit);
    if bits & !all != 0 {
        return Err(BadView::new(format!(
            "its manifest names {what} with the bits {:#x}, which this host does not know",
            bits & !all
        )));
    }
    Ok(known.iter().filter(|(bit, _)| bits & bit != 0).map(|(_, value)| *value).collect())
}

/// Layers as bits.
pub(crate) fn layer_bits(layers: &[Layer]) -> u32 {
    bits(layers, &LAYERS)
}

/// The layers behind bits; those that this side does not know are left out.
pub(crate) fn layers_from(bits: u32) -> Vec<Layer> {
    LAYERS.iter().filter(|(bit, _)| bits & bit != 0).map(|(_, layer)| *layer).collect()
}

/// A manifest as a struct of bits. Groups of needed observations beyond the struct's room are left out: no stage needs
/// so many.
pub(crate) fn manifest_of(manifest: &Manifest) -> rumbo_manifest {
    let mut consumes = [0; RUMBO_MOST_CONSUMED];
    for (to, group) in consumes.iter_mut().zip(&manifest.consumes) {
        *to = bits(group, &KINDS);
    }
    rumbo_manifest {
        size: size_of::<rumbo_manifest>(),
        needs_layers: layer_bits(&manifest.needs_layers),
        gives_layers: layer_bits(&manifest.gives_layers),
        produces: bits(&manifest.produces, &KINDS),
        drives: bits(&manifest.drives, &DRIVES),
        n_consumes: manifest.consumes.len().min(RUMBO_MOST_CONSUMED) as u32,
        consumes,
        overlays: manifest.overlays.into(),
        is_virtual: manifest.is_virtual.into(),
        needs_start_pose: manifest.needs_start_pose.into(),
        wishes_motion: manifest.wishes_motion.into(),
        default_rate_hz: manifest.default_rate_hz.unwrap_or(f64::NAN),
        max_rate_hz: manifest.max_rate_hz.unwrap_or(f64::NAN),
        uses: bits(&manifest.uses, &KINDS),
        reserved: 0,
        field_of_view_rad: manifest.field_of_view_rad.unwrap_or(f64::NAN),
    }
}

/// The manifest behind a struct of bits.
pub(crate) fn manifest_from(view: &rumbo_manifest) -> Result<Manifest, BadView> {
    let groups = view.consumes.iter().take(view.n_consumes as usize);
    let known = |value: f64| (!value.is_nan()).then_some(value);
    Ok(Manifest {
        needs_layers: values(view.needs_layers, &LAYERS, "layers")?,
        gives_layers: values(view.gives_layers, &LAYERS, "layers")?,
        overlays: view.overlays != 0,
        consumes: groups.map(|group| values(*group, &KINDS, "observations")).collect::<Result<_, _>>()?,
        uses: values(view.uses, &KINDS, "observations")?,
        produces: values(view.produces, &KINDS, "observations")?,
        is_virtual: view.is_virtual != 0,
        drives: values(view.drives, &DRIVES, "drives")?,
        default_rate_hz: known(view.default_rate_hz),
        max_rate_hz: known(view.max_rate_hz),
        field_of_view_rad: known(view.field_of_view_rad),
        needs_start_pose: view.needs_start_pose != 0,
        wishes_motion: view.wishes_motion != 0,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_manifest_crosses_both_ways() {
        let manifest = Manifest {
            needs_layers: vec![Layer::Grid, Layer::Voxels],
            consumes: vec![
                vec![ObservationKind::LaserScan, ObservationKind::RangeRing],
                vec![ObservationKind::Odometry],
            ],
            uses: vec![ObservationKind::Odometry, ObservationKind::Imu],
            produces: vec![ObservationKind::Custom],
            drives: vec![DriveKind::Tricycle],
            default_rate_hz: Some(5.0),
            wishes_motion: true,
            ..Manifest::default()
        };
        assert_eq!(manifest_from(&manifest_of(&manifest)), Ok(manifest));
        let newer = rumbo_manifest { drives: 1 << 9, ..manifest_of(&Manifest::default()) };
        assert!(manifest_from(&newer).is_err_and(|bad| bad.0.contains("0x200")));
    }
}
