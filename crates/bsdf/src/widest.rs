//! Loops in the widest vector instructions that the machine has and this crate knows.
#![allow(unsafe_code)] // Once below: measured to halve the time of a look-up in a block.

/// Calls `f`, compiled for AVX2 where the processor has it.
///
/// Results do not depend on it: the same additions and products, four at a time instead of two;
/// Rust never fuses them.
#[inline(always)]
pub(crate) fn widest<R>(f: impl FnOnce() -> R) -> R {
    #[cfg(target_arch = "x86_64")]
    if std::is_x86_feature_detected!("avx2") && std::is_x86_feature_detected!("bmi2") {
        // SAFETY: the features that the function asks for have just been found.
        return unsafe { with_avx2(f) };
    }
    f()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2")]
fn with_avx2<R>(f: impl FnOnce() -> R) -> R {
    f()
}
