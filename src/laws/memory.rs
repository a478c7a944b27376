//! Memory that a plugin holds, as the operating system sees it.

use super::law::{Trouble, Verdict, expect};

/// Calls that are watched.
pub const N_CALLS: usize = 10_000;
/// Calls before, in which buffers may find their size.
const N_WARM_UP: usize = 500;
/// Looks at the memory this often, so that what leaks is stopped early.
const EVERY: usize = 250;
/// Room for what allocators and caches keep.
const MOST_GROWTH_BYTES: u64 = 64 << 20;

/// Bytes of this process that are in memory, where the operating system tells.
pub fn resident_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes << 10)
}

/// Calls 10,500 times, and looks at what the last 10,000 calls keep.
pub fn stays_finite(mut call: impl FnMut(usize) -> Result<(), Trouble>) -> Verdict {
    let untold = || Trouble::not_applicable("this operating system does not tell how much memory is used");
    resident_bytes().ok_or_else(untold)?;
    for k in 0..N_WARM_UP {
        call(k)?;
    }
    let before = resident_bytes().ok_or_else(untold)?;
    let mut grown = 0;
    for k in 0..N_CALLS {
        call(N_WARM_UP + k)?;
        if (k + 1) % EVERY == 0 {
            grown = resident_bytes().ok_or_else(untold)?.saturating_sub(before);
            let found = || format!("after {} calls {} MiB more", k + 1, grown >> 20);
            expect(
                grown <= MOST_GROWTH_BYTES,
                found,
                format!("at most {} MiB more after {N_CALLS} calls", MOST_GROWTH_BYTES >> 20),
            )?;
        }
    }
    Ok(format!("{:.1} MiB more after {N_CALLS} calls", grown as f64 / f64::from(1 << 20)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(target_os = "linux")]
    fn the_resident_set_is_read() {
        assert!(resident_bytes().is_some_and(|bytes| bytes > 1 << 20));
    }
}
