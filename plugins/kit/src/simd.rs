//! Runs a piece of code compiled for the widest vectors this processor has.
//!
//! The code itself stays plain safe Rust that the compiler vectorizes; the same body, compiled without the wider
//! vectors, is its scalar twin ([`narrowest`]).

/// Runs `body` compiled for the widest vectors found at run time.
///
/// What `body` calls must be `#[inline(always)]`, else it is compiled for the baseline.
#[inline]
pub fn widest<R>(body: impl FnOnce() -> R) -> R {
    #[cfg(target_arch = "x86_64")]
    {
        let has_avx512 = is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512bw")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("avx512vl")
            && is_x86_feature_detected!("bmi2");
        if has_avx512 {
            // SAFETY: the processor has just been asked for exactly these features.
            #[allow(unsafe_code)]
            return unsafe { with_avx512(body) };
        }
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("bmi2") {
            // SAFETY: the processor has just been asked for exactly these features.
            #[allow(unsafe_code)]
            return unsafe { with_avx2(body) };
        }
    }
    narrowest(body)
}

/// Runs `body` compiled for the baseline of the target: the twin of [`widest`].
#[inline(never)]
pub fn narrowest<R>(body: impl FnOnce() -> R) -> R {
    body()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,bmi2")]
fn with_avx512<R>(body: impl FnOnce() -> R) -> R {
    body()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi2")]
fn with_avx2<R>(body: impl FnOnce() -> R) -> R {
    body()
}
