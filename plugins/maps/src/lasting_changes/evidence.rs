//! What one visit says of one cell.

/// When a visit is sure of a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VisitRules {
    /// From at least so many scans, each from another pose.
    pub min_scans: u16,
    /// And over at least this time, seconds.
    pub min_duration_s: f32,
}

/// What a visit is sure of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Something stands there at the end of the visit.
    Occupied,
    /// Nothing stands there at the end of the visit.
    Free,
}

/// Scans that say the same.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Run {
    n: u16,
    /// Of these, those after the last scan that said the opposite.
    in_a_row: u16,
    first_s: f32,
    last_s: f32,
}

impl Run {
    fn add(&mut self, now_s: f32) {
        if self.n == 0 {
            self.first_s = now_s;
        }
        self.n = self.n.saturating_add(1);
        self.in_a_row = self.in_a_row.saturating_add(1);
        self.last_s = now_s;
    }

    fn is_sure(&self, rules: &VisitRules) -> bool {
        self.n >= rules.min_scans && self.last_s - self.first_s >= rules.min_duration_s
    }
}

/// Scans that ended in a cell, and scans that saw through it. Who was there for a while and left is forgotten once enough
/// scans in a row see through the place; what was put there, and the look through it before, likewise.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CellEvidence {
    hits: Run,
    passes: Run,
}

impl CellEvidence {
    /// A scan ends in the cell.
    pub fn hit(&mut self, now_s: f32, rules: &VisitRules) {
        self.hits.add(now_s);
        self.passes.in_a_row = 0;
        if self.hits.in_a_row >= rules.min_scans {
            self.passes = Run::default();
        }
    }

    /// A scan sees through the cell.
    pub fn pass(&mut self, now_s: f32, rules: &VisitRules) {
        self.passes.add(now_s);
        self.hits.in_a_row = 0;
        if self.passes.in_a_row >= rules.min_scans {
            self.hits = Run::default();
        }
    }

    /// Scans that ended in it.
    pub fn n_hits(&self) -> u16 {
        self.hits.n
    }

    /// Scans that saw through it.
    pub fn n_passes(&self) -> u16 {
        self.passes.n
    }

    /// What these scans alone say.
    pub fn verdict(&self, rules: &VisitRules) -> Option<Verdict> {
        if self.hits.n >= self.passes.n && self.hits.is_sure(rules) {
            Some(Verdict::Occupied)
        } else if self.passes.is_sure(rules) && is_rare(self.hits.n, self.passes.n) {
            Some(Verdict::Free)
        } else {
            None
        }
    }
}

/// So few scans ended there that they say nothing against those that saw through.
fn is_rare(n_hits: u16, n_passes: u16) -> bool {
    const PASSES_A_HIT: u32 = 10;
    u32::from(n_hits) * PASSES_A_HIT <= u32::from(n_passes)
}

#[cfg(test)]
mod tests {
    use super::*;

    const RULES: VisitRules = VisitRules { min_scans: 4, min_duration_s: 2.0 };

    /// One letter a second: `h` a hit, `p` a pass, anything else nothing.
    fn seen(scans: &str) -> Option<Verdict> {
        let mut cell = CellEvidence::default();
        for (second, scan) in (0u16..).zip(scans.chars()) {
            match scan {
                'h' => cell.hit(f32::from(second), &RULES),
                'p' => cell.pass(f32::from(second), &RULES),
                _ => {}
            }
        }
        cell.verdict(&RULES)
    }

    #[test]
    fn the_end_of_a_visit_decides() {
        assert_eq!(seen("hhhh"), Some(Verdict::Occupied));
        assert_eq!(seen("h.h.hh"), Some(Verdict::Occupied));
        assert_eq!(seen("pppp"), Some(Verdict::Free));
        assert_eq!(seen("hhhhhhhhhhhhhhhhpppp"), Some(Verdict::Free), "somebody stood there and left");
        assert_eq!(seen("pppppppppppppppphhhh"), Some(Verdict::Occupied), "it was put there");
        assert_eq!(seen("pphhpppp"), Some(Verdict::Free), "somebody walked by");
    }

    #[test]
    fn few_scans_and_short_looks_say_nothing() {
        assert_eq!(seen(""), None);
        assert_eq!(seen("hhh"), None);
        assert_eq!(seen("ppp"), None);
        let mut cell = CellEvidence::default();
        (0..40).for_each(|k| cell.hit(k as f32 * 0.04, &RULES));
        assert_eq!(cell.verdict(&RULES), None, "40 scans within 1.6 s");
        assert_eq!(seen("phphphp"), None, "an edge that some beams pass");
    }
}
