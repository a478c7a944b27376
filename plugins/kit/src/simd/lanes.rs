//! What plain loops over lanes need to become vector code.

/// What lanes hold before a loop writes all of them. Not zero: that a zero need not be stored over a zero makes a masked store of
/// it, which takes tens of cycles.
pub const UNWRITTEN: f32 = f32::NAN;

/// A number of 0 or more, below 2^23, without its fraction if that is zero: in the last bits of itself and 2^23. A cast would be
/// a scalar one for each lane, since it saturates.
#[inline(always)]
pub fn whole(value: f32) -> u32 {
    const SHIFT: u32 = 1 << 23;
    (value + SHIFT as f32).to_bits() & (SHIFT - 1)
}

/// Sums over lanes; `map` would not be inlined.
#[inline(always)]
pub fn sums_of<const N: usize, const LANES: usize>(lanes: &[[f32; LANES]; N]) -> [f64; N] {
    let mut sums = [0.0; N];
    for (sum, lane) in sums.iter_mut().zip(lanes) {
        for value in lane {
            *sum += f64::from(*value);
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_whole_number_is_what_a_cast_makes_of_it() {
        for value in (0..1u32 << 23).step_by(97).chain([0, 1, (1 << 23) - 1]) {
            assert_eq!(whole(value as f32), value);
        }
    }

    #[test]
    fn sums_of_lanes_are_those_of_their_values() {
        let lanes = [[1.0f32, 2.0, 4.0], [0.5, -0.25, f32::EPSILON]];
        assert_eq!(sums_of(&lanes), [7.0, 0.25 + f64::from(f32::EPSILON)]);
    }
}
