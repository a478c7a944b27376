//! What a run costs, as the operating system counts it: memory, and time on the processor. Linux tells; elsewhere nobody does.

use std::fs::{read_to_string, write};

/// The most memory of this process so far, megabytes (10⁶ bytes).
pub fn peak_memory_mb() -> Option<f64> {
    let status = read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1.024e-3)
}

/// From now on the most memory is counted anew. Returns whether it is.
pub fn forget_peak_memory() -> bool {
    // proc(5): 5 resets the peak resident set size.
    write("/proc/self/clear_refs", "5").is_ok()
}

/// Time that this thread has been on a processor, seconds. Threads that a plugin starts are not counted.
pub fn thread_cpu_s() -> Option<f64> {
    let counted = read_to_string("/proc/thread-self/schedstat").ok()?;
    let nanoseconds: f64 = counted.split_whitespace().next()?.parse().ok()?;
    Some(nanoseconds * 1e-9)
}

#[cfg(test)]
#[cfg(target_os = "linux")]
mod tests {
    use super::*;

    #[test]
    fn memory_and_time_that_are_used_are_counted() {
        let before_s = thread_cpu_s().unwrap();
        let (mut sum, mut large) = (0u64, vec![1u8; 64 << 20]);
        for (k, byte) in large.iter_mut().enumerate() {
            *byte = byte.wrapping_add(k as u8);
            sum = sum.wrapping_add(u64::from(*byte));
        }
        assert!(sum > 0 && peak_memory_mb().unwrap() > 67.0);
        assert!(thread_cpu_s().unwrap() > before_s);
    }
}
