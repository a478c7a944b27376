//! The numbers of the literature, and points on the ellipsoid in space.

use nalgebra::Vector3;

use super::*;

fn vectors() -> toml::Table {
    let vectors: toml::Table =
        toml::from_str(include_str!("../../../tests/data/dc_serial_lines.toml")).unwrap();
    vectors["local_tangent_plane"].as_table().unwrap().clone()
}

fn number(table: &toml::Table, key: &str) -> f64 {
    table[key].as_float().unwrap()
}

#[test]
fn radii_and_meters_are_those_of_the_literature() {
    let plane = vectors();
    let latitude_deg = number(&plane, "latitude_deg");
    let frame = LocalFrame::new(latitude_deg, -47.895_735, 0.0);
    assert!((frame.meridian_radius_m() - number(&plane, "meridian_radius_m")).abs() < 1e-3);
    assert!((frame.prime_vertical_radius_m() - number(&plane, "prime_vertical_radius_m")).abs() < 1e-3);
    let step_deg = 0.0001 / 60.0;
    let one = frame.east_north_m(latitude_deg + step_deg, -47.895_735 + step_deg);
    assert!((one.y - number(&plane, "metr\u{65}s_per_0_0001_minute_north")).abs() < 1e-6);
    assert!((one.x - number(&plane, "metr\u{65}s_per_0_0001_minute_east")).abs() < 1e-6);
    let [north_deg, _] = frame.degrees(Vector2::new(0.0, 5.0));
    assert!((north_deg - number(&plane, "latitude_5_m_north_deg")).abs() < 1e-9);
    let fix = plane["example_fix"].as_table().unwrap();
    let found = frame.map_m(number(fix, "latitude_deg"), number(fix, "longitude_deg"));
    assert!((found.y - number(fix, "north_m")).abs() < 1e-4, "{found}");
    assert!((found.x - number(fix, "east_m")).abs() < 1e-4, "{found}");
}

/// A point of the ellipsoid from the earth's center, meters.
fn in_space(latitude_deg: f64, longitude_deg: f64) -> Vector3<f64> {
    let (latitude, longitude) = (latitude_deg.to_radians(), longitude_deg.to_radians());
    let radius_m = SEMI_MAJOR_M / (1.0 - ECCENTRICITY_SQUARED * latitude.sin().powi(2)).sqrt();
    let across = Vector3::new(longitude.cos(), longitude.sin(), 0.0) * radius_m * latitude.cos();
    across + Vector3::z() * radius_m * (1.0 - ECCENTRICITY_SQUARED) * latitude.sin()
}

#[test]
fn within_a_kilometer_the_plane_is_decimeters_from_the_ellipsoid() {
    for (latitude_deg, longitude_deg) in [(-22.0, -47.9), (48.1, 11.5), (65.0, 179.999), (0.0, -180.0)] {
        let frame = LocalFrame::new(latitude_deg, longitude_deg, 0.0);
        let origin = in_space(latitude_deg, longitude_deg);
        let (latitude, longitude) = (f64::to_radians(latitude_deg), f64::to_radians(longitude_deg));
        let east = Vector3::new(-longitude.sin(), longitude.cos(), 0.0);
        let north = Vector3::z() * latitude.cos()
            - Vector3::new(longitude.cos(), longitude.sin(), 0.0) * latitude.sin();
        for (east_m, north_m) in [(1000.0, 0.0), (0.0, 1000.0), (-700.0, 700.0), (3.0, -4.0)] {
            let [there_deg, beside_deg] = frame.degrees(Vector2::new(east_m, north_m));
            assert!(beside_deg.abs() <= 180.0);
            let way = in_space(there_deg, beside_deg) - origin;
            let off = Vector2::new(way.dot(&east) - east_m, way.dot(&north) - north_m).norm();
            // East and north by the tangent of the latitude over the earth's radius.
            let most_m = 1.1 * (east_m * east_m + north_m * north_m) / 6.36e6 * 65f64.to_radians().tan();
            assert!(off < most_m, "{latitude_deg} {east_m} {north_m}: {off}");
        }
    }
}

#[test]
fn the_map_is_turned_counterclockwise_from_east_and_degrees_come_back() {
    let frame = LocalFrame::new(10.0, 20.0, 90f64.to_radians());
    let [latitude_deg, longitude_deg] = LocalFrame::new(10.0, 20.0, 0.0).degrees(Vector2::new(7.0, 0.0));
    let east = frame.map_m(latitude_deg, longitude_deg);
    assert!(east.x.abs() < 1e-6 && (east.y - 7.0).abs() < 1e-6, "east is up: {east}");
    let [latitude_deg, longitude_deg] = frame.degrees(Vector2::new(-30.0, 12.0));
    assert!((frame.map_m(latitude_deg, longitude_deg) - Vector2::new(-30.0, 12.0)).norm() < 1e-6);
}
