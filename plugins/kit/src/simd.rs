//! Runs a piece of code compiled for the widest vectors this processor has, found at run time.
//!
//! Most of it stays plain safe Rust that the compiler vectorizes. Two inner loops of the cost field do not come out
//! well that way and are written with intrinsics for AVX-512; [`Portable`] is their scalar twin. This is the only file
//! of the crate with unsafe code.

mod lanes;

pub use lanes::{UNWRITTEN, sums_of, whole};

/// A piece of code with its arguments.
pub trait Kernel {
    /// What it answers.
    type Output;

    /// Does the work. Must be `#[inline(always)]`, like all that it calls: what is not inlined into [`widest`] is
    /// compiled for the baseline. (Closures and function pointers do not serve: their calls are not inlined.)
    fn run<V: Vectors>(self) -> Self::Output;
}

/// Cells in a line that is relaxed at once.
pub const LINE_CELLS: usize = 32;
/// Cells before and after those of a line; only the innermost one on each side is looked at.
pub const LINE_PAD: usize = 8;

/// A line of costs with its padding.
pub type Line = [f64; LINE_CELLS + 2 * LINE_PAD];

/// Inner loops that exist once for all processors and once for wide vectors, with the same answers to the bit.
pub trait Vectors {
    /// Lowers each cell of `to` to the cheapest step into it from the three cells beside it in `from`, where a straight
    /// step costs `entries` and a diagonal one `extra` more, and tells whether any cell was lowered. Infinite cells are
    /// blocked. Without `CUTTING`, a diagonal step needs both cells that it squeezes between to be open.
    fn relax_line<const CUTTING: bool>(
        from: &Line,
        to: &mut Line,
        entries: &[f64; LINE_CELLS],
        extra: f64,
    ) -> bool;

    /// Copies a square of `LINE_CELLS` lines transposed; the lines of each side begin `stride` apart. Bit `i` of the
    /// answer says that line `i` of `to` was lowered somewhere.
    fn transpose(from: &[f64], from_stride: usize, to: &mut [f64], to_stride: usize) -> u64;

    /// Sum of the bytes of a table at these places; a place beyond its end counts 255.
    #[inline(always)]
    fn sum_of<const N: usize>(table: &[u8], places: &[u32; N]) -> u32 {
        places.iter().map(|place| u32::from(table.get(*place as usize).copied().unwrap_or(u8::MAX))).sum()
    }
}

/// The twin for every processor.
pub struct Portable;

impl Vectors for Portable {
    #[inline(always)]
    fn relax_line<const CUTTING: bool>(
        from: &Line,
        to: &mut Line,
        entries: &[f64; LINE_CELLS],
        extra: f64,
    ) -> bool {
        // A diagonal step into a cell squeezes between the cell before it in its own line and its straight source.
        let mut diagonal = [0.0; LINE_CELLS + 2];
        for i in 0..LINE_CELLS + 2 {
            let (source, beside) = (from[LINE_PAD - 1 + i], to[LINE_PAD - 1 + i]);
            diagonal[i] = if !CUTTING && beside == f64::INFINITY { f64::INFINITY } else { source };
        }
        let mut any = 0_u64;
        for i in 0..LINE_CELLS {
            let straight = from[LINE_PAD + i];
            let slanted = lesser(diagonal[i], diagonal[i + 2]) + extra;
            let slanted = if !CUTTING && straight == f64::INFINITY { f64::INFINITY } else { slanted };
            let lower = lesser(straight, slanted) + entries[i];
            let present = to[LINE_PAD + i];
            any |= u64::from(lower < present);
            to[LINE_PAD + i] = lesser(lower, present);
        }
        any != 0
    }

    #[inline(always)]
    fn transpose(from: &[f64], from_stride: usize, to: &mut [f64], to_stride: usize) -> u64 {
        let mut lowered = 0;
        for i in 0..LINE_CELLS {
            for j in 0..LINE_CELLS {
                let cell = &mut to[i * to_stride + j];
                let source = from[j * from_stride + i];
                lowered |= u64::from(source < *cell) << i;
                *cell = source;
            }
        }
        lowered
    }
}

/// The smaller of two numbers that are never NaN: one instruction, where `f64::min` needs three.
#[inline(always)]
pub fn lesser(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// Intrinsics for AVX-512; only [`widest`] names it, after asking the processor.
#[cfg(target_arch = "x86_64")]
struct Avx512;

#[cfg(target_arch = "x86_64")]
impl Vectors for Avx512 {
    #[inline(always)]
    fn relax_line<const CUTTING: bool>(
        from: &Line,
        to: &mut Line,
        entries: &[f64; LINE_CELLS],
        extra: f64,
    ) -> bool {
        // SAFETY: `Avx512` is only used where the processor has been asked.
        #[allow(unsafe_code)]
        unsafe {
            avx512::relax_line::<CUTTING>(from, to, entries, extra)
        }
    }

    #[inline(always)]
    fn transpose(from: &[f64], from_stride: usize, to: &mut [f64], to_stride: usize) -> u64 {
        let last = LINE_CELLS - 1;
        assert!(from.len() >= last * from_stride + LINE_CELLS, "the source holds all lines");
        assert!(to.len() >= last * to_stride + LINE_CELLS, "the target holds all lines");
        // SAFETY: `Avx512` is only used where the processor has been asked; the lengths are checked above.
        #[allow(unsafe_code)]
        unsafe {
            avx512::transpose(from.as_ptr(), from_stride, to.as_mut_ptr(), to_stride)
        }
    }
}

#[cfg(target_arch = "x86_64")]
mod avx512 {
    use super::{LINE_CELLS, LINE_PAD, Line};
    use std::arch::x86_64::*;

    const LANES: usize = 8;
    const N: usize = LINE_CELLS / LANES;

    /// All vectors of a line, padding included.
    #[inline]
    #[target_feature(enable = "avx512f")]
    fn load(line: &Line) -> [__m512d; N + 2] {
        const { assert!(LINE_PAD == LANES) };
        let (chunks, _) = line.as_chunks::<LANES>();
        // SAFETY: each chunk is eight numbers; the load needs no alignment.
        #[allow(unsafe_code)]
        std::array::from_fn(|k| unsafe { _mm512_loadu_pd(chunks[k].as_ptr()) })
    }

    #[inline]
    #[target_feature(enable = "avx512f")]
    pub(super) fn relax_line<const CUTTING: bool>(
        from: &Line,
        to: &mut Line,
        entries: &[f64; LINE_CELLS],
        extra: f64,
    ) -> bool {
        let (source, present) = (load(from), load(to));
        let blocked = _mm512_set1_pd(f64::INFINITY);
        let extra = _mm512_set1_pd(extra);
        let mut diagonal = source;
        if !CUTTING {
            for k in 0..N + 2 {
                let closed = _mm512_cmp_pd_mask::<_CMP_EQ_OQ>(present[k], blocked);
                diagonal[k] = _mm512_mask_mov_pd(source[k], closed, blocked);
            }
        }
        let bits = diagonal.map(|v| _mm512_castpd_si512(v));
        let mut any = 0;
        let (chunks, _) = to.as_chunks_mut::<LANES>();
        let (entry_chunks, _) = entries.as_chunks::<LANES>();
        for k in 1..=N {
            let left = _mm512_castsi512_pd(_mm512_alignr_epi64::<7>(bits[k], bits[k - 1]));
            let right = _mm512_castsi512_pd(_mm512_alignr_epi64::<1>(bits[k + 1], bits[k]));
            let mut slanted = _mm512_add_pd(_mm512_min_pd(left, right), extra);
            if !CUTTING {
                let closed = _mm512_cmp_pd_mask::<_CMP_EQ_OQ>(source[k], blocked);
                slanted = _mm512_mask_mov_pd(slanted, closed, blocked);
            }
            // SAFETY: each chunk is eight numbers; loads and stores need no alignment.
            #[allow(unsafe_code)]
            let entry = unsafe { _mm512_loadu_pd(entry_chunks[k - 1].as_ptr()) };
            let lower = _mm512_add_pd(_mm512_min_pd(source[k], slanted), entry);
            any |= _mm512_cmp_pd_mask::<_CMP_LT_OQ>(lower, present[k]);
            // SAFETY: as above.
            #[allow(unsafe_code)]
            unsafe {
                _mm512_storeu_pd(chunks[k].as_mut_ptr(), _mm512_min_pd(lower, present[k]));
            }
        }
        any != 0
    }

    /// # Safety
    /// Both pointers hold `LINE_CELLS` lines of `LINE_CELLS` numbers that begin the stride apart.
    #[inline]
    #[target_feature(enable = "avx512f")]
    #[allow(unsafe_code)]
    pub(super) unsafe fn transpose(
        from: *const f64,
        from_stride: usize,
        to: *mut f64,
        to_stride: usize,
    ) -> u64 {
        let mut lowered = 0;
        for i in (0..LINE_CELLS).step_by(LANES) {
            for j in (0..LINE_CELLS).step_by(LANES) {
                // SAFETY: block (j, i) of the source and (i, j) of the target lie inside the squares.
                let block =
                    std::array::from_fn(|k| unsafe { _mm512_loadu_pd(from.add((j + k) * from_stride + i)) });
                for (k, line) in transpose_block(block).into_iter().enumerate() {
                    // SAFETY: as above.
                    let cell = unsafe { to.add((i + k) * to_stride + j) };
                    let present = unsafe { _mm512_loadu_pd(cell) };
                    let is_lower = _mm512_cmp_pd_mask::<_CMP_LT_OQ>(line, present) != 0;
                    lowered |= u64::from(is_lower) << (i + k);
                    unsafe { _mm512_storeu_pd(cell, line) };
                }
            }
        }
        lowered
    }

    /// Pairs, then quarters, then halves change places.
    #[inline]
    #[target_feature(enable = "avx512f")]
    fn transpose_block(r: [__m512d; LANES]) -> [__m512d; LANES] {
        let pairs: [__m512d; LANES] = std::array::from_fn(|k| {
            let (a, b) = (r[k & !1], r[k | 1]);
            if k % 2 == 0 { _mm512_unpacklo_pd(a, b) } else { _mm512_unpackhi_pd(a, b) }
        });
        // Lane pairs of rows (0, 1) meet those of rows (2, 3), and of (4, 5) those of (6, 7).
        let quarters: [__m512d; LANES] = std::array::from_fn(|k| {
            let (half, odd, high) = (k & 4, k & 1, k & 2);
            let (a, b) = (pairs[half | odd], pairs[half | 2 | odd]);
            if high == 0 { _mm512_shuffle_f64x2::<0x88>(a, b) } else { _mm512_shuffle_f64x2::<0xdd>(a, b) }
        });
        // quarters[0..2] hold columns 0, 4 (even lanes of four) and 1, 5; quarters[2..4] columns 2, 6 and 3, 7.
        std::array::from_fn(|column| {
            let (odd, high, upper) = (column & 1, column & 2, column & 4);
            let (a, b) = (quarters[high | odd], quarters[4 | high | odd]);
            if upper == 0 { _mm512_shuffle_f64x2::<0x88>(a, b) } else { _mm512_shuffle_f64x2::<0xdd>(a, b) }
        })
    }
}

/// Runs a kernel compiled for the widest vectors found at run time.
#[inline]
pub fn widest<K: Kernel>(kernel: K) -> K::Output {
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
            return unsafe { with_avx512(kernel) };
        }
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("bmi2") {
            // SAFETY: the processor has just been asked for exactly these features.
            #[allow(unsafe_code)]
            return unsafe { with_avx2(kernel) };
        }
    }
    narrowest(kernel)
}

/// Runs a kernel compiled for the baseline of the target: the twin of [`widest`].
#[inline(never)]
pub fn narrowest<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<Portable>()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,bmi2")]
fn with_avx512<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<Avx512>()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi2")]
fn with_avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<Portable>()
}
