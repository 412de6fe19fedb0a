//! Loops in the widest vector instructions that the machine has and this crate knows.
#![allow(unsafe_code)] // Once below: measured to take a look-up in a block from 73 to 43 ns.

/// A loop over directions side by side. `run` must be `#[inline(always)]`: only so is it
/// compiled anew for each set of instructions.
pub(crate) trait Loop {
    fn run(self);
}

/// Runs a loop, compiled for AVX2 where the processor has it.
///
/// Results do not depend on it: the same sums and products, four at a time instead of two; Rust never
/// fuses them.
#[inline]
pub(crate) fn widest(work: impl Loop) {
    #[cfg(target_arch = "x86_64")]
    if std::is_x86_feature_detected!("avx2") && std::is_x86_feature_detected!("bmi2") {
        // SAFETY: the features that the function asks for have just been found.
        return unsafe { with_avx2(work) };
    }
    work.run();
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2")]
fn with_avx2(work: impl Loop) {
    work.run();
}
