//! Lines that may become walls: each must be seen again before it enters the map (section 2.5 of the source).

use super::growth::Growth;
use super::state::wrapped;
use super::wall::{Axes, Wall};

/// A line that was seen and is not in the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Candidate {
    /// As it was seen last: `[rho, phi]`.
    pub line: [f64; 2],
    /// From where to where it was seen so far.
    pub piece: Wall,
    /// Scans that showed it.
    pub hits: u32,
    /// The last of them.
    pub last_scan: u64,
}

/// All of them.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Tentative {
    pub candidates: Vec<Candidate>,
}

impl Tentative {
    /// Takes in a line that is no wall of the map. Returns its candidate once that was seen often enough, and forgets it.
    pub fn see(&mut self, line: [f64; 2], ends_m: [[f64; 2]; 2], scan: u64, rules: &Growth) -> Option<Wall> {
        let axes = Axes::new(line);
        let offer = |(idx, candidate): (usize, &Candidate)| {
            let away = dissimilarity(candidate, line, &axes, &ends_m, rules)?;
            Some((idx, away))
        };
        let nearest = self.candidates.iter().enumerate().filter_map(offer);
        let nearest = nearest.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(idx, _)| idx);
        let idx = match nearest {
            Some(idx) => {
                let candidate = self.candidates.get_mut(idx)?;
                if candidate.last_scan == scan {
                    // One scan counts once, however many pieces of the wall it shows.
                    return None;
                }
                candidate.line = line;
                candidate.piece.extend(&axes, &ends_m);
                candidate.hits += 1;
                candidate.last_scan = scan;
                idx
            }
            None => {
                self.candidates.push(Candidate { line, piece: Wall { ends_m }, hits: 1, last_scan: scan });
                self.candidates.len() - 1
            }
        };
        let is_confirmed = self.candidates.get(idx).is_some_and(|c| c.hits >= rules.confirm_hits);
        is_confirmed.then(|| self.candidates.remove(idx).piece)
    }

    /// Forgets what was not seen for too many scans.
    pub fn age(&mut self, scan: u64, rules: &Growth) {
        self.candidates.retain(|c| scan.saturating_sub(c.last_scan) < u64::from(rules.forget_after_scans));
    }
}

/// How unlike a line and a candidate are: each difference over its limit, summed up; none beyond a limit.
fn dissimilarity(
    candidate: &Candidate,
    line: [f64; 2],
    axes: &Axes,
    ends_m: &[[f64; 2]; 2],
    rules: &Growth,
) -> Option<f64> {
    let parts = [
        axes.across_m(candidate.piece.middle()).abs() / rules.offset_m,
        wrapped(candidate.line[1] - line[1]).abs() / rules.angle_rad,
        axes.gap_m(&candidate.piece.ends_m, ends_m).max(0.0) / rules.gap_m,
    ];
    parts.iter().all(|part| *part <= 1.0).then(|| parts.iter().sum())
}
