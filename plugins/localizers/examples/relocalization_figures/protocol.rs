//! The protocol of S. Hernández Alamilla (2005), section 8.3, on the three office maps: success, errors and cells after the
//! filter.

use super::relocalization_work::{Clutter, Laser, Office, Outcome, trial};
use rumbo_localizers::landmark_noise::LandmarkNoiseParams;
use rumbo_localizers::landmark_relaxation::LandmarkRelaxationParams;

/// So many trials on each of these maps, or on all.
pub fn run(n_trials: u64, maps: &[String]) {
    for thesis_mode in [false, true] {
        let landmark_noise = Some(LandmarkNoiseParams::default());
        let params =
            LandmarkRelaxationParams { thesis_mode, landmark_noise, ..LandmarkRelaxationParams::default() };
        let mode = if thesis_mode { "thesis " } else { "default" };
        for name in ["5x5", "10x10", "20x20"] {
            if !maps.is_empty() && !maps.iter().any(|map| map == name) {
                continue;
            }
            let office = Office::named(name);
            let known = office.knowledge(&params);
            let is_other = if name == "10x10" { "5x5" } else { "10x10" };
            let other = Office::named(is_other);
            let cases = [
                ("as it is", &office, Clutter::None),
                ("boxes", &office, Clutter::Boxes),
                ("half hidden", &office, Clutter::HalfHidden),
                ("in another building", &other, Clutter::None),
            ];
            for (case, place, clutter) in cases {
                let run = |seed| trial(place, &known, &params, &Laser::lms200(), clutter, seed);
                let outcomes: Vec<Outcome> = (0..n_trials).map(run).collect();
                tell(&format!("{name:6} {mode} {case}"), known.model.n_bytes(), &outcomes);
            }
        }
    }
}

fn tell(case: &str, n_bytes: usize, outcomes: &[Outcome]) {
    let count = |of: fn(&Outcome) -> bool| outcomes.iter().filter(|outcome| of(outcome)).count();
    let found: Vec<&Outcome> = outcomes.iter().filter(|outcome| outcome.is_success()).collect();
    let quantile = |share: f64, of: fn(&Outcome) -> f64| {
        let mut values: Vec<f64> = found.iter().map(|outcome| of(outcome)).collect();
        values.sort_by(f64::total_cmp);
        values.get((share * (values.len().max(1) - 1) as f64) as usize).copied().unwrap_or(f64::NAN)
    };
    let n = outcomes.len();
    let mean_cells = outcomes.iter().map(|outcome| outcome.n_cells).sum::<usize>() as f64 / n as f64;
    let mean_nees = found.iter().map(|outcome| outcome.nees).sum::<f64>() / found.len().max(1) as f64;
    println!(
        "{case}: {} of {n} found, {} wrong, {} ambiguous, {} nothing; position {:.4} m (95 % {:.4}), heading {:.2} deg \
         (95 % {:.2}), error in terms of the covariance {mean_nees:.2}, {mean_cells:.1} cells, {:.2} MB",
        found.len(),
        count(Outcome::is_wrong),
        count(|outcome| outcome.is_ambiguous),
        count(|outcome| !outcome.is_found && !outcome.is_ambiguous),
        quantile(0.5, |outcome| outcome.off_m),
        quantile(0.95, |outcome| outcome.off_m),
        quantile(0.5, |outcome| outcome.off_deg),
        quantile(0.95, |outcome| outcome.off_deg),
        n_bytes as f64 / 1e6,
    );
    for (seed, outcome) in outcomes.iter().enumerate().filter(|(_, outcome)| !outcome.is_success()).take(5) {
        println!("       trial {seed}: {outcome:?}");
    }
}
