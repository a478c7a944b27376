//! A wall's line by a local Hough transform. Hernández Alamilla (2005), section 4.4.3.
//!
//! Differs from the source: the normal may point in any direction (the printed half turn cannot represent walls whose
//! normal's foot lies behind the robot), and of several cells with most votes the mean is taken.

use super::readings::{Reading, way};
use std::f64::consts::{PI, TAU};

/// The line with most votes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HoughLine {
    /// From the sensor, meters.
    pub distance_m: f64,
    /// Direction of the normal, radians.
    pub bearing_rad: f64,
    /// Readings that voted for it.
    pub n_votes: u32,
}

/// Steps of the direction in a full turn: 0.25 degrees each.
const N_DIRECTIONS: usize = 1440;
/// Steps of the distance in a meter.
const STEPS_PER_M: f64 = 100.0;
/// The normal of a straight piece lies within so many steps of that of its chord: 10 degrees.
const WINDOW: usize = 40;
/// A chord nearer than this may have its normal on the other side, meters.
const NEAR_M: f64 = 0.3;

/// Finds lines; keeps its memory.
#[derive(Debug, Clone)]
pub struct Hough {
    /// Cosine and sine of each direction.
    directions: Vec<[f64; 2]>,
    /// Votes for each distance along one direction.
    votes: Vec<u32>,
    cells: Vec<usize>,
}

/// What the cells with most votes add up to.
#[derive(Default)]
struct Ties {
    n_votes: u32,
    n: f64,
    distance: f64,
    cos: f64,
    sin: f64,
}

impl Default for Hough {
    fn default() -> Self {
        Hough::new()
    }
}

impl Hough {
    /// Prepares directions.
    pub fn new() -> Hough {
        let angle = |k: usize| TAU * k as f64 / N_DIRECTIONS as f64 - PI;
        let directions = (0..N_DIRECTIONS).map(|k| [angle(k).cos(), angle(k).sin()]).collect();
        Hough { directions, votes: Vec::new(), cells: Vec::new() }
    }

    /// The line with most votes among all directions within 10 degrees of the chord's normal; none without votes.
    /// Lines farther than `reach_m` are not looked for.
    pub fn strongest(&mut self, readings: &[Reading], reach_m: f64) -> Option<HoughLine> {
        let [first, .., last] = readings else { return None };
        let chord = way(first, last);
        let normal = (-chord[0]).atan2(chord[1]);
        let distance = first.place[0] * normal.cos() + first.place[1] * normal.sin();
        let outward = if distance < 0.0 { normal + PI } else { normal };
        let step = ((outward + PI).rem_euclid(TAU) / TAU * N_DIRECTIONS as f64).round() as usize;
        let mut ties = Ties::default();
        self.vote_around(step, readings, reach_m, &mut ties);
        if distance.abs() < NEAR_M {
            self.vote_around(step + N_DIRECTIONS / 2, readings, reach_m, &mut ties);
        }
        ties.line()
    }

    fn vote_around(&mut self, step: usize, readings: &[Reading], reach_m: f64, ties: &mut Ties) {
        for k in step + N_DIRECTIONS - WINDOW..=step + N_DIRECTIONS + WINDOW {
            self.vote(k % N_DIRECTIONS, readings, reach_m, ties);
        }
    }

    /// One row of the accumulator at a time: no other row is needed to find the maximum.
    fn vote(&mut self, direction: usize, readings: &[Reading], reach_m: f64, ties: &mut Ties) {
        let Some(&[cos, sin]) = self.directions.get(direction) else { return };
        self.cells.clear();
        for reading in readings {
            let distance = reading.place[0] * cos + reading.place[1] * sin;
            if !(0.0..=reach_m).contains(&distance) {
                continue;
            }
            let cell = (distance * STEPS_PER_M).round() as usize;
            if cell >= self.votes.len() {
                self.votes.resize(cell + 1, 0);
            }
            if let Some(votes) = self.votes.get_mut(cell) {
                if *votes == 0 {
                    self.cells.push(cell);
                }
                *votes += 1;
            }
        }
        for &cell in &self.cells {
            if let Some(votes) = self.votes.get_mut(cell) {
                ties.add(*votes, cell, [cos, sin]);
                *votes = 0;
            }
        }
    }
}

impl Ties {
    fn add(&mut self, n_votes: u32, cell: usize, [cos, sin]: [f64; 2]) {
        if n_votes > self.n_votes {
            *self = Ties { n_votes, ..Ties::default() };
        }
        if n_votes == self.n_votes {
            self.n += 1.0;
            self.distance += cell as f64 / STEPS_PER_M;
            self.cos += cos;
            self.sin += sin;
        }
    }

    fn line(&self) -> Option<HoughLine> {
        let (distance_m, bearing_rad) = (self.distance / self.n, self.sin.atan2(self.cos));
        (self.n_votes > 0).then_some(HoughLine { distance_m, bearing_rad, n_votes: self.n_votes })
    }
}
