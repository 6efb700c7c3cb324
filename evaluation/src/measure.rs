//! Time and memory of one process, and figures of many records.

use crate::bias::Bias;

/// Processor time of this process so far, s: what others do on the machine is not in it. Where there
/// is no such clock, time since the first call.
#[must_use]
#[cfg(unix)]
pub fn processor_time_s() -> f64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    now.tv_sec as f64 + 1e-9 * now.tv_nsec as f64
}

/// Time since the first call, s.
#[must_use]
#[cfg(not(unix))]
pub fn processor_time_s() -> f64 {
    static START: std::sync::OnceLock<std::time::Instant> = std::sync::OnceLock::new();
    START.get_or_init(std::time::Instant::now).elapsed().as_secs_f64()
}

/// Peak resident set of this process, bytes, where the system reports it.
#[must_use]
pub fn peak_memory() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<f64>().ok().map(|k| 1024.0 * k)
}

/// The middle of some numbers; NaN of none.
#[must_use]
pub fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}

/// A mean error ± half its 95 % interval, in a unit; a star marks an interval without zero.
#[must_use]
pub fn cell(b: Bias, unit: f64, digits: usize) -> String {
    let mark = if b.is_significant() { "*" } else { " " };
    format!("{:.digits$} ± {:.digits$}{mark}", b.mean * unit, b.half_width * unit)
}
