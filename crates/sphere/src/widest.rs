//! Loops in the widest vector instructions that the machine has and this module knows.
#![allow(unsafe_code)] // Thrice below: measured to take a look-up in a block from 73 to 43 ns, and further.

/// A loop over directions side by side. `run` must be `#[inline(always)]`: only so is it
/// compiled anew for each set of instructions.
pub trait Loop {
    /// Runs it.
    fn run(self);
}

/// Runs a loop, compiled for AVX-512 or AVX2 where the processor has it.
///
/// Results do not depend on it: the same sums and products, eight or four at a time instead of two; Rust
/// never fuses them.
#[inline]
pub fn widest(work: impl Loop) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::is_x86_feature_detected as has;
        if has!("avx2") && has!("bmi2") {
            if has!("avx512f") && has!("avx512bw") && has!("avx512dq") && has!("avx512vl") {
                // SAFETY: the features that the function asks for have just been found.
                return unsafe { with_avx512(work) };
            }
            // SAFETY: as above.
            return unsafe { with_avx2(work) };
        }
    }
    work.run();
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2")]
fn with_avx2(work: impl Loop) {
    work.run();
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,bmi1,bmi2")]
fn with_avx512(work: impl Loop) {
    work.run();
}

/// Asks the machine to bring a slice near, which is read soon.
#[inline]
pub fn fetch_ahead<T>(slice: &[T]) {
    #[cfg(not(target_arch = "x86_64"))]
    let _ = slice;
    #[cfg(target_arch = "x86_64")]
    for bytes in 0..std::mem::size_of_val(slice).div_ceil(64) {
        use std::arch::x86_64::{_MM_HINT_T1, _mm_prefetch};
        // SAFETY: a hint, which reads nothing, whatever the address.
        unsafe {
            _mm_prefetch::<_MM_HINT_T1>(slice.as_ptr().cast::<i8>().wrapping_add(64 * bytes));
        }
    }
}
