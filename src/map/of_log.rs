//! The pipeline that stands behind a log: its laser, its odometer, poses, and a grid.

use std::path::Path;

/// The pipeline as text; every value can be changed with `--set`. Paths are meant from the working folder.
pub fn pipeline_text(log: &Path, poses: Option<&Path>, resolution_m: f64) -> String {
    let name = log.file_name().unwrap_or_default().to_string_lossy();
    let quoted = |path: &Path| {
        // A path from the working folder stays one, whatever folder the pipeline is said to be in.
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
        toml::Value::from(path.display().to_string()).to_string()
    };
    let poses = poses.map(|path| format!("file = {}\n", quoted(path))).unwrap_or_default();
    format!(
        "name = {}\n\n\
         [world]\nplugin = \"log\"\nfile = {}\n\n\
         [[sensor]]\nname = \"front_laser\"\nplugin = \"laser_2d\"\nmount = {{ z_m = 0.3 }}\n\n\
         [[sensor]]\nname = \"odometry\"\nplugin = \"wheel_encoders\"\n\n\
         [localizer]\nplugin = \"recorded_pose\"\n{poses}only_exact = true\n\n\
         [mission]\ninitial_pose = \"unknown\"\n\n\
         [map_builder]\nplugin = \"occupancy_grid\"\nresolution_m = {resolution_m:?}\nlevels = 1\n\
         max_pose_age_s = 0.0\n",
        toml::Value::from(format!("map of {name}")),
        quoted(log),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_path_becomes_a_readable_pipeline() {
        let text = pipeline_text(Path::new("a \"b\"\\c.clf"), Some(Path::new("p.txt")), 0.1);
        let table: toml::Table = text.parse().unwrap();
        assert!(table["world"]["file"].as_str().unwrap().ends_with("a \"b\"\\c.clf"));
        assert!(table["localizer"]["file"].as_str().unwrap().ends_with("/p.txt"));
        assert_eq!(table["map_builder"]["resolution_m"].as_float(), Some(0.1));
    }
}
