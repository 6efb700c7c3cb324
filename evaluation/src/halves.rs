//! A drive with its second half first.

use steerwright_drivelog::DriveLog;

/// The same drive with its halves exchanged: the second half comes first, in segments of its own.
#[must_use]
pub fn swapped_halves(log: &DriveLog) -> DriveLog {
    let (n, half) = (log.len(), log.len() / 2);
    let swap = |x: &[f64]| [&x[half..], &x[..half]].concat();
    let moved = |from: usize, to: usize, shift: isize| {
        log.segments.iter().filter_map(move |s| {
            let (a, b) = (s.range.start.max(from), s.range.end.min(to));
            if a < b {
                Some(steerwright_drivelog::Segment {
                    time0_s: s.time0_s + (a - s.range.start) as f64 * log.sample_time_s,
                    range: a.wrapping_add_signed(shift)..b.wrapping_add_signed(shift),
                })
            } else {
                None
            }
        })
    };
    let segments =
        moved(half, n, -(half as isize)).chain(moved(0, half, (n - half) as isize)).collect();
    DriveLog {
        segments,
        input: swap(&log.input),
        output: swap(&log.output),
        speed: log.speed.as_deref().map(swap),
        others: log.others.iter().map(|(role, x)| (*role, swap(x))).collect(),
        ..log.clone()
    }
}
