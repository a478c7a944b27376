//! When a camera sees too little: sunlight, a lens cap, a cable that came off.

/// Counts pictures that show too little.
#[derive(Debug, Clone)]
pub(crate) struct Blindness {
    min_share: f64,
    n_frames: u32,
    n_blind: u32,
}

impl Blindness {
    /// Blind after `n_frames` pictures in a row that show less than `min_share`.
    pub fn after(n_frames: u32, min_share: f64) -> Self {
        Self { min_share, n_frames, n_blind: 0 }
    }

    /// Takes in what share of a picture (or scan) has readings, and tells whether the camera is blind now.
    pub fn is_blind(&mut self, share: f64) -> bool {
        // A share of nothing at all is not a number, and little enough.
        let is_enough = share >= self.min_share;
        self.n_blind = if is_enough { 0 } else { self.n_blind.saturating_add(1) };
        self.n_blind >= self.n_frames
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_camera_is_blind_after_some_pictures_in_a_row_and_sees_again_at_once() {
        let mut blindness = Blindness::after(3, 0.05);
        let told: Vec<bool> = [0.0, 0.04, 0.05, 0.0, 0.0, f64::NAN, 0.0, 0.5, 0.0]
            .into_iter()
            .map(|share| blindness.is_blind(share))
            .collect();
        assert_eq!(told, [false, false, false, false, false, true, true, false, false]);
        assert!(!Blindness::after(1, 0.0).is_blind(0.0), "0 turns it off");
    }
}
