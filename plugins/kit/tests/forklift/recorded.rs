//! The recorded log: encoders, extracted lines and truth, so that no random generator takes part.

use super::{N_STEPS, SCAN_EVERY, Step};
use rumbo_kit::lines::SensedLine;

fn table(name: &str) -> Vec<Vec<f64>> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/line_slam/");
    let text = std::fs::read_to_string(format!("{folder}{name}")).unwrap();
    text.lines().skip(1).map(|row| row.split(',').map(|word| word.parse().unwrap()).collect()).collect()
}

/// Seed 1 of the reference generator.
pub fn recorded() -> Vec<Step> {
    let mut steps = vec![Step::default(); N_STEPS];
    for row in table("ekf_log_encoders.csv") {
        let step = &mut steps[row[0] as usize];
        (step.wheels, step.steering) = (Some([row[2], row[3]]), Some(row[4]));
    }
    steps.iter_mut().step_by(SCAN_EVERY).for_each(|step| step.lines = Some(Vec::new()));
    for row in table("ekf_log_lines.csv") {
        let line = SensedLine {
            distance_m: row[1],
            normal_rad: row[2],
            covariance: [row[3], row[4], row[5]],
            ends_m: [[row[6], row[7]], [row[8], row[9]]],
            n_points: row[10] as usize,
            rms_m: 0.03,
        };
        steps[row[0] as usize].lines.as_mut().unwrap().push(line);
    }
    for row in table("ekf_log_truth.csv") {
        steps[row[0] as usize].truth = Some([row[2], row[3], row[4]]);
    }
    steps
}
