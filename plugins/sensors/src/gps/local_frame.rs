//! The map as a plane that touches the earth: degrees into meters.
//!
//! Radii of curvature of the WGS-84 ellipsoid at the origin give meters a radian. Within a kilometer of the origin the
//! plane is off by decimeters at most, far below what a receiver errs.

use nalgebra::{Rotation2, Vector2};
use rumbo_core::frames::wrap_angle;

/// Half the equator's axis of WGS-84, meters.
const SEMI_MAJOR_M: f64 = 6_378_137.0;
/// Square of the first eccentricity of WGS-84.
const ECCENTRICITY_SQUARED: f64 = 0.006_694_379_990_14;

/// A plane that touches the ellipsoid at its origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalFrame {
    latitude_rad: f64,
    longitude_rad: f64,
    map_from_east_north: Rotation2<f64>,
}

impl LocalFrame {
    /// The plane at these degrees. `rotation_rad` is the direction of east in the map, counter-clockwise from its x axis.
    pub fn new(latitude_deg: f64, longitude_deg: f64, rotation_rad: f64) -> Self {
        Self {
            latitude_rad: latitude_deg.to_radians(),
            longitude_rad: longitude_deg.to_radians(),
            map_from_east_north: Rotation2::new(rotation_rad),
        }
    }

    /// Radius of curvature along the meridian, meters.
    pub fn meridian_radius_m(&self) -> f64 {
        SEMI_MAJOR_M * (1.0 - ECCENTRICITY_SQUARED) / self.flattening().powf(1.5)
    }

    /// Radius of curvature across the meridian, meters.
    pub fn prime_vertical_radius_m(&self) -> f64 {
        SEMI_MAJOR_M / self.flattening().sqrt()
    }

    fn flattening(&self) -> f64 {
        1.0 - ECCENTRICITY_SQUARED * self.latitude_rad.sin().powi(2)
    }

    /// Meters east and north of the origin.
    pub fn east_north_m(&self, latitude_deg: f64, longitude_deg: f64) -> Vector2<f64> {
        let north = self.meridian_radius_m() * (latitude_deg.to_radians() - self.latitude_rad);
        // Across the date line the shorter way.
        let to_east_rad = wrap_angle(longitude_deg.to_radians() - self.longitude_rad);
        let east = self.prime_vertical_radius_m() * self.latitude_rad.cos() * to_east_rad;
        Vector2::new(east, north)
    }

    /// A place in the map, meters.
    pub fn map_m(&self, latitude_deg: f64, longitude_deg: f64) -> Vector2<f64> {
        self.map_from_east_north * self.east_north_m(latitude_deg, longitude_deg)
    }

    /// Latitude and longitude of a place in the map, degrees.
    pub fn degrees(&self, map_m: Vector2<f64>) -> [f64; 2] {
        let east_north_m = self.map_from_east_north.inverse() * map_m;
        let latitude_rad = self.latitude_rad + east_north_m.y / self.meridian_radius_m();
        let radius_m = self.prime_vertical_radius_m() * self.latitude_rad.cos();
        let longitude_rad = wrap_angle(self.longitude_rad + east_north_m.x / radius_m);
        [latitude_rad.to_degrees(), longitude_rad.to_degrees()]
    }
}

#[cfg(test)]
mod tests;
