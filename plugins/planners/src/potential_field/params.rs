//! Parameters of `potential_field`.

use crate::field_descent::FieldSettings;
use crate::field_descent::field_params;
use rumbo_core::stages::BuildError;

field_params! {
    /// Walks down an artificial potential: the goal attracts, obstacles repel (Khatib, 1986). It ends in the first local
    /// minimum, with an error that names the place.
    pub struct PotentialFieldParams {}
}

impl PotentialFieldParams {
    /// Every impossible value.
    pub fn faults(&self) -> Vec<BuildError> {
        self.shared_faults()
    }

    /// The rules of the walk.
    pub fn rules(&self) -> FieldSettings {
        self.settings()
    }
}
