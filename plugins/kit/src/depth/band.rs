//! Which points are obstacles: those between two heights over the floor.

use rumbo_core::frames::Pose3;

/// A band of heights over the floor, as a camera sees it: points on the floor must not count, else a robot is repelled by
/// the ground for ever.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeightBand {
    /// What a meter ahead, left and up in the camera's frame rises over the floor, meters.
    pub rise: [f64; 3],
    /// Height of the camera over the floor, meters.
    pub camera_m: f64,
    /// Lowest and highest height that counts, meters.
    pub heights_m: [f64; 2],
}

impl HeightBand {
    /// Of a camera at this mount; heights are over the plane z = 0 of the base.
    pub fn of_mount(base_from_camera: &Pose3, heights_m: [f64; 2]) -> HeightBand {
        let rotation = base_from_camera.rotation.to_rotation_matrix();
        let rise = [0, 1, 2].map(|axis| rotation[(2, axis)]);
        HeightBand { rise, camera_m: base_from_camera.translation.z, heights_m }
    }

    /// Of a camera at this height that looks up by this angle: `h + Y cos p + Z sin p`.
    pub fn of_pitch(camera_m: f64, up_rad: f64, heights_m: [f64; 2]) -> HeightBand {
        HeightBand { rise: [up_rad.sin(), 0.0, up_rad.cos()], camera_m, heights_m }
    }

    /// Height of a point of the camera's frame over the floor, meters.
    pub fn height_m(&self, point_m: [f64; 3]) -> f64 {
        let [x, y, z] = point_m;
        self.camera_m + self.rise[0] * x + self.rise[1] * y + self.rise[2] * z
    }

    /// The point counts.
    pub fn has(&self, point_m: [f64; 3]) -> bool {
        let [lowest_m, highest_m] = self.heights_m;
        (lowest_m..=highest_m).contains(&self.height_m(point_m))
    }
}
