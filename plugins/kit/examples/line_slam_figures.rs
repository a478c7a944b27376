//! Figures of localization and mapping with lines in the forklift experiment.
//!
//! `cargo run --release -p rumbo-kit --example line_slam_figures [SEEDS]` drives through the hall with each of so many seeds
//! (100 if nothing is said) and prints mean, least and most; then the grid of tunings with three of them.
#![allow(clippy::print_stdout)]

#[path = "../tests/forklift/mod.rs"]
mod forklift;

use forklift::{Mode, Outcome, Setup, Step, recorded, run, simulated};
use rumbo_kit::line_filter::{FilterSettings, Growth, Integration, MotionModel};

const MODES: [(&str, Mode); 3] =
    [("known map", Mode::KnownMap), ("multi-rate", Mode::MultiRate), ("single rate", Mode::SingleRate)];

fn settings(integration: Integration, bootstrap: bool) -> FilterSettings {
    FilterSettings {
        motion: MotionModel { integration, ..MotionModel::default() },
        growth: Growth { bootstrap, ..Growth::default() },
        ..FilterSettings::default()
    }
}

fn spread(outcomes: &[Outcome], number: impl Fn(&Outcome) -> f64) -> String {
    let numbers: Vec<f64> = outcomes.iter().map(number).collect();
    let mean = numbers.iter().sum::<f64>() / numbers.len() as f64;
    let least = numbers.iter().copied().fold(f64::INFINITY, f64::min);
    let most = numbers.iter().copied().fold(0.0, f64::max);
    format!("{mean:8.2} ({least:.2} to {most:.2})")
}

fn table(title: &str, settings: &FilterSettings, drives: &[Vec<Step>]) {
    println!("\n{title}, {} seeds: mean (least to most)", drives.len());
    for (name, mode) in MODES {
        let one = |steps: &Vec<Step>| run(&Setup { mode, settings: settings.clone() }, steps);
        let outcomes: Vec<Outcome> = drives.iter().map(one).collect();
        println!("  {name}");
        println!("    position RMSE, mm   {}", spread(&outcomes, |o| 1e3 * o.position_rmse_m));
        println!("    largest error, mm   {}", spread(&outcomes, |o| 1e3 * o.max_error_m));
        println!("    heading RMSE, mrad  {}", spread(&outcomes, |o| 1e3 * o.heading_rmse_rad));
        println!("    NEES (3 expected)   {}", spread(&outcomes, |o| o.nees));
        println!("    NIS of a line (2)   {}", spread(&outcomes, |o| o.line_nis));
        println!("    map offset, mm      {}", spread(&outcomes, |o| 1e3 * o.map_offset_m));
        println!("    walls (28 true)     {}", spread(&outcomes, |o| o.n_walls as f64));
        println!("    unstable            {}", outcomes.iter().filter(|o| o.is_unstable).count());
        println!(
            "    largest rise of a wall's deviation {:.1e}",
            outcomes.iter().map(|o| o.largest_rise).fold(0.0, f64::max)
        );
    }
}

/// Unstable runs of 60, and the median and largest RMSE of the others, mm.
fn tunings(integration: Integration, mode: Mode, has_gate: bool, drives: &[Vec<Step>]) -> String {
    let (mut n_unstable, mut errors_mm) = (0, Vec::new());
    for acceleration_m_s2 in [0.05, 0.2, 0.5, 1.0, 2.0] {
        for turn_acceleration_rad_s2 in [0.02, 0.1, 0.3, 1.0] {
            let mut settings = settings(integration, true);
            settings.motion.acceleration_m_s2 = acceleration_m_s2;
            settings.motion.turn_acceleration_rad_s2 = turn_acceleration_rad_s2;
            if !has_gate {
                settings.wheels.slip_gate = f64::INFINITY;
            }
            for steps in drives.iter().take(3) {
                let outcome = run(&Setup { mode, settings: settings.clone() }, steps);
                if outcome.is_unstable {
                    n_unstable += 1;
                } else {
                    errors_mm.push(1e3 * outcome.position_rmse_m);
                }
            }
        }
    }
    errors_mm.sort_by(f64::total_cmp);
    let stable = match (errors_mm.get(errors_mm.len() / 2), errors_mm.last()) {
        (Some(median), Some(most)) => format!("{median:.1} (at most {most:.1})"),
        _ => "none stable".to_owned(),
    };
    format!("{n_unstable:2} of 60 unstable, RMSE of the others, mm: {stable}")
}

fn main() {
    let n_seeds = std::env::args().nth(1).and_then(|word| word.parse().ok()).unwrap_or(100);
    let log = vec![recorded()];
    let drives: Vec<Vec<Step>> = (1..=n_seeds).map(simulated).collect();
    for (title, integration, bootstrap) in [
        ("Midpoint", Integration::Midpoint, true),
        ("Midpoint, without the first scan", Integration::Midpoint, false),
        ("Euler, as printed", Integration::Euler, true),
    ] {
        let settings = settings(integration, bootstrap);
        table(&format!("Recorded log. {title}"), &settings, &log);
        table(title, &settings, &drives);
    }
    println!("\nTunings: sigma_a 0.05 to 2, sigma_alpha 0.02 to 1");
    for integration in [Integration::Euler, Integration::Midpoint] {
        for (name, mode) in &MODES[1..] {
            for (gate, has_gate) in [("slip gate", true), ("no slip gate", false)] {
                println!(
                    "  {integration:?}, {name}, {gate}: {}",
                    tunings(integration, *mode, has_gate, &drives)
                );
            }
        }
    }
}
