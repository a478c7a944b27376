//! `--set-range KEY=A..B`: a value that each seed draws anew, the same for all alternatives. `0.0..1.0` draws fractions,
//! `0..5` whole numbers.

use rand_xoshiro::rand_core::Rng as _;
use rumbo_core::rng::stream;

/// A key and the values that it may take.
#[derive(Debug, Clone, PartialEq)]
pub struct SetRange {
    /// As in `--set`.
    pub key: String,
    /// The lowest value.
    pub low: f64,
    /// The highest value.
    pub high: f64,
    /// Both ends are written as whole numbers: so are the values, ends included.
    pub is_whole: bool,
}

impl SetRange {
    /// The value of one seed.
    pub fn draw(&self, seed: u64) -> f64 {
        let share = unit(&mut stream(seed, &format!("compare.set.{}", self.key)));
        match self.is_whole {
            true => (self.low + ((self.high - self.low + 1.0) * share).floor()).min(self.high),
            false => self.low + (self.high - self.low) * share,
        }
    }

    /// As an argument of `--set`.
    pub fn set(&self, seed: u64) -> String {
        match self.is_whole {
            true => format!("{}={:.0}", self.key, self.draw(seed)),
            false => format!("{}={:?}", self.key, self.draw(seed)),
        }
    }
}

/// Uniform in 0..1, from the upper 53 bits: every step is exact.
pub fn unit(rng: &mut rumbo_core::rng::Rng) -> f64 {
    (rng.next_u64() >> 11) as f64 * 2f64.powi(-53)
}

/// Reads `KEY=A..B`.
pub fn parse(text: &str) -> Result<SetRange, String> {
    let shape = "expected KEY=A..B, such as world.slip.speed=0.0..0.05";
    let (key, range) = text.split_once('=').ok_or_else(|| format!("`{text}` has no `=`, {shape}"))?;
    let (low, high) = range.split_once("..").ok_or_else(|| format!("`{text}` has no `..`, {shape}"))?;
    let number = |word: &str| {
        let number: Option<f64> = word.trim().parse().ok();
        number.filter(|n| n.is_finite()).ok_or_else(|| format!("`{word}` is no finite number, {shape}"))
    };
    let is_whole = [low, high].iter().all(|word| word.trim().parse::<i32>().is_ok());
    let (low, high, key) = (number(low)?, number(high)?, key.trim().to_owned());
    if key.is_empty() {
        return Err(format!("`{text}` has an empty key, {shape}"));
    }
    if low > high {
        return Err(format!("`{text}` is reversed, write {key}={high}..{low}"));
    }
    Ok(SetRange { key, low, high, is_whole })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_draws_the_same_value_each_time_and_stays_in_the_range() {
        let range = parse("world.slip.speed=0.01..0.05").unwrap();
        let drawn: Vec<f64> = (0..200).map(|seed| range.draw(seed)).collect();
        assert!(drawn.iter().all(|v| (0.01..0.05).contains(v)));
        assert_eq!(drawn[7], range.draw(7));
        let mean = drawn.iter().sum::<f64>() / 200.0;
        assert!((mean - 0.03).abs() < 0.003, "{mean}");
        assert_eq!(parse("a=2.0..2").unwrap().set(9), "a=2.0");
    }

    #[test]
    fn a_range_of_whole_numbers_draws_each_of_them_alike() {
        let range = parse("localizer.max_particles=-1..3").unwrap();
        let mut n_of = [0; 5];
        for seed in 0..1000 {
            n_of[(range.draw(seed) + 1.0) as usize] += 1;
        }
        assert!(n_of.iter().all(|n| (150..250).contains(n)), "{n_of:?}");
        assert_eq!(parse("a=2..2").unwrap().set(9), "a=2");
    }

    #[test]
    fn faults_of_a_range_are_named() {
        for (text, words) in [
            ("a.b", "no `=`"),
            ("a=1", "no `..`"),
            ("a=x..2", "`x` is no finite"),
            ("a=1..nan", "`nan`"),
            ("a=3..1", "is reversed, write a=1..3"),
            ("=1..2", "empty key"),
        ] {
            assert!(parse(text).unwrap_err().contains(words), "{text}");
        }
    }
}
