//! What this process has spent, where the system tells.

#[cfg(unix)]
use nix::sys::resource::{Usage, UsageWho, getrusage};

/// Processor seconds of all threads, in the program and in the system.
pub(crate) fn cpu_seconds() -> Option<f64> {
    #[cfg(unix)]
    return usage().map(|usage| {
        let seconds = |t: nix::sys::time::TimeVal| t.tv_sec() as f64 + t.tv_usec() as f64 * 1e-6;
        seconds(usage.user_time()) + seconds(usage.system_time())
    });
    #[cfg(not(unix))]
    None
}

/// Most bytes of memory that it held at once.
pub(crate) fn peak_bytes() -> Option<u64> {
    #[cfg(unix)]
    return usage().and_then(|usage| {
        // Kilobytes, but for macOS.
        let unit = if cfg!(target_vendor = "apple") { 1 } else { 1024 };
        u64::try_from(usage.max_rss()).ok().map(|n| n * unit)
    });
    #[cfg(not(unix))]
    None
}

#[cfg(unix)]
fn usage() -> Option<Usage> {
    getrusage(UsageWho::RUSAGE_SELF).ok()
}
