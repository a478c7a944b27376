//! All that is wrong with the numbers of a section.

use rumbo_core::stages::BuildError;

/// What is wrong, key by key.
#[derive(Debug, Default)]
pub struct Faults {
    list: Vec<BuildError>,
}

impl Faults {
    fn expect(&mut self, fine: bool, key: &str, value: f64, expected: &str) {
        if !fine {
            self.list.push(BuildError::at(key, format!("is {value}, expected a number {expected}")));
        }
    }

    /// Above zero.
    pub fn above(&mut self, key: &str, value: f64) {
        self.expect(value.is_finite() && value > 0.0, key, value, "above 0");
    }

    /// Zero or more.
    pub fn least(&mut self, key: &str, value: f64) {
        self.expect(value.is_finite() && value >= 0.0, key, value, "of 0 or more");
    }

    /// Any number.
    pub fn finite(&mut self, key: &str, value: f64) {
        self.expect(value.is_finite(), key, value, "that is finite");
    }

    /// Between two numbers.
    pub fn range(&mut self, key: &str, value: f64, from: f64, to: f64) {
        self.expect((from..=to).contains(&value), key, value, &format!("from {from} to {to}"));
    }

    /// Something else is wrong.
    pub fn add(&mut self, key: &str, message: String) {
        self.list.push(BuildError::at(key, message));
    }

    /// All of them.
    pub fn into_list(self) -> Vec<BuildError> {
        self.list
    }
}
