//! How the forklift drives: circles of about 4.5 m.

use std::f64::consts::{FRAC_PI_2, TAU};

/// x, y, theta, v, omega at each step of 50 ms, integrated by trapezoids of 1 ms.
pub fn truth(n_steps: usize) -> Vec<[f64; 5]> {
    const FINE_S: f64 = 1e-3;
    let speed = |t: f64| (t / 4.0).min(1.0) * (1.2 + 0.30 * (TAU * t / 12.7).sin());
    let turn = |t: f64| speed(t) * (0.22 + 0.03 * (TAU * t / 17.0).sin());
    let [mut x, mut y, mut theta] = [19.5, 10.0, FRAC_PI_2];
    let mut steps = vec![[x, y, theta, speed(0.0), turn(0.0)]];
    for k in 1..n_steps {
        for fine in 0..50 {
            let (t, next) = (0.05 * (k - 1) as f64 + FINE_S * f64::from(fine), FINE_S);
            let (v, next_v) = (speed(t), speed(t + next));
            let next_theta = theta + FINE_S / 2.0 * (turn(t) + turn(t + next));
            x += FINE_S / 2.0 * (v * theta.cos() + next_v * next_theta.cos());
            y += FINE_S / 2.0 * (v * theta.sin() + next_v * next_theta.sin());
            theta = next_theta;
        }
        let t = 0.05 * k as f64;
        steps.push([x, y, theta, speed(t), turn(t)]);
    }
    steps
}
