//! Where a person is, from outside the robot: a phone, a tag, a tracker.

use super::check::{Check, Checker, MessageFault};
use super::vision::Custom;
use crate::boundary::Buffer;
use crate::frames::Point2;

/// Where a person is in the map's frame.
///
/// Not a [`PositionFix`](super::PositionFix), which is the robot's own: a localizer must not take one for the other. It
/// travels as a [`Custom`] observation of the schema [`SCHEMA`](Self::SCHEMA), so that plugins in any language can make it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PersonPosition {
    /// In the map's frame, meters.
    pub position: Point2,
    /// Standard deviation along each axis, meters.
    pub deviation_m: f64,
}

impl PersonPosition {
    /// Name of the schema: x, y and the deviation, meters, as three numbers of 64 bits, least significant byte first.
    pub const SCHEMA: &'static str = "rumbo/PersonPosition";

    /// As an observation's data.
    pub fn to_custom(&self) -> Custom {
        let numbers = [self.position.x, self.position.y, self.deviation_m];
        let bytes: Vec<u8> = numbers.into_iter().flat_map(f64::to_le_bytes).collect();
        Custom { schema: Self::SCHEMA.to_owned(), bytes: Buffer::from(bytes) }
    }

    /// What an observation says; nothing where it speaks of something else, an error where it is damaged.
    pub fn read(custom: &Custom) -> Option<Result<PersonPosition, MessageFault>> {
        if custom.schema != Self::SCHEMA {
            return None;
        }
        let (numbers, rest) = custom.bytes.as_chunks::<8>();
        Some(match (numbers, rest) {
            ([x, y, deviation], []) => {
                let [x, y, deviation_m] = [x, y, deviation].map(|bytes| f64::from_le_bytes(*bytes));
                let person = PersonPosition { position: Point2::new(x, y), deviation_m };
                person.check().map(|()| person)
            }
            _ => Checker("person_position")
                .equal("bytes", custom.bytes.len(), 24)
                .map(|()| PersonPosition::default()),
        })
    }
}

impl Check for PersonPosition {
    fn check(&self) -> Result<(), MessageFault> {
        let c = Checker("person_position");
        c.finite("position", &[self.position.x, self.position.y])?;
        c.finite("deviation_m", &[self.deviation_m])?;
        c.not_negative("deviation_m", self.deviation_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn custom(bytes: &[u8]) -> Custom {
        Custom { schema: "rumbo/PersonPosition".into(), bytes: Buffer::from(bytes.to_vec()) }
    }

    #[test]
    fn the_bytes_are_those_of_the_published_layout() {
        let person = PersonPosition { position: Point2::new(1.0, -2.0), deviation_m: 0.5 };
        // IEEE 754: 1.0 is 0x3ff0..., -2.0 is 0xc000..., 0.5 is 0x3fe0...
        let bytes =
            [[0, 0, 0, 0, 0, 0, 0xf0, 0x3f], [0, 0, 0, 0, 0, 0, 0, 0xc0], [0, 0, 0, 0, 0, 0, 0xe0, 0x3f]];
        assert_eq!(person.to_custom(), custom(&bytes.concat()));
        assert_eq!(PersonPosition::read(&custom(&bytes.concat())), Some(Ok(person)));
    }

    #[test]
    fn other_schemas_are_no_persons_and_damaged_ones_are_faults() {
        let smell = Custom { schema: "acme/Smell".into(), ..Custom::default() };
        assert_eq!(PersonPosition::read(&smell), None);
        for n_bytes in [0, 16, 23, 25, 32] {
            let read = PersonPosition::read(&custom(&vec![0; n_bytes]));
            assert!(read.unwrap().unwrap_err().to_string().contains("24"), "{n_bytes} bytes");
        }
        let odd = |x: f64, deviation_m: f64| PersonPosition { position: Point2::new(x, 0.0), deviation_m };
        for person in [odd(f64::NAN, 0.1), odd(f64::INFINITY, 0.1), odd(0.0, -0.1), odd(0.0, f64::NAN)] {
            assert!(PersonPosition::read(&person.to_custom()).unwrap().is_err(), "{person:?}");
        }
    }
}
