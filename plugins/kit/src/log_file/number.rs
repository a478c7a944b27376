//! Decimal numbers from bytes, fast and exact.

/// Powers of ten that a double holds exactly and that short decimals need.
const POWERS: [f64; 16] =
    [1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15];

/// The number that a word spells, `nan` and `inf` included; the nearest double.
pub(super) fn number(word: &[u8]) -> Option<f64> {
    short_decimal(word).or_else(|| std::str::from_utf8(word).ok()?.parse().ok())
}

/// Digits with an optional sign and point, at most 15 of them: mantissa and power are exact, so that one division
/// rounds once (Clinger, *How to read floating point numbers accurately*, 1990, the fast path).
fn short_decimal(word: &[u8]) -> Option<f64> {
    let (is_negative, digits) = match word.split_first()? {
        (b'-', rest) => (true, rest),
        _ => (false, word),
    };
    let (mut mantissa, mut n_digits, mut n_decimals, mut has_point) = (0_u64, 0_usize, 0_usize, false);
    for byte in digits {
        match byte {
            b'0'..=b'9' if n_digits < 15 => {
                mantissa = mantissa * 10 + u64::from(byte - b'0');
                n_digits += 1;
                n_decimals += usize::from(has_point);
            }
            b'.' if !has_point => has_point = true,
            _ => return None,
        }
    }
    if n_digits == 0 {
        return None;
    }
    let value = mantissa as f64 / POWERS.get(n_decimals)?;
    Some(if is_negative { -value } else { value })
}

#[cfg(test)]
mod tests {
    use super::number;
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    #[test]
    fn the_fast_path_agrees_with_the_standard_library_to_the_bit() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
        for _ in 0..100_000 {
            let (value, decimals): (f64, usize) = (rng.random_range(-2e9..2e9), rng.random_range(0..9));
            let scaled = value / 10_f64.powi(rng.random_range(0..12));
            let text = format!("{scaled:.decimals$}");
            let expected: f64 = text.parse().unwrap();
            assert_eq!(number(text.as_bytes()).map(f64::to_bits), Some(expected.to_bits()), "{text}");
        }
    }

    #[test]
    fn everything_else_is_a_number_as_the_standard_library_has_it_or_none() {
        for (text, expected) in
            [("1.01893e+09", 1.018_93e9), ("+5", 5.0), (".5", 0.5), ("5.", 5.0), ("inf", f64::INFINITY)]
        {
            assert_eq!(number(text.as_bytes()), Some(expected), "{text}");
        }
        assert!(number(b"nan").is_some_and(f64::is_nan));
        for text in ["", "-", ".", "-.", "1.2.3", "0x10", "1,5", "nohost", "1e", "--1"] {
            assert_eq!(number(text.as_bytes()), None, "{text}");
        }
        assert_eq!(number(&[0xff, 0xfe]), None);
    }
}
