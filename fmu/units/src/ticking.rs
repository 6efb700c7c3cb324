//! Communication steps of the units that tick: how many ticks one has, alike in each of them.

use fmi2_export::Log;

/// Most ticks in one step: ten hours at 100 Hz. A longer step is a slip of the importer, which gets an error instead of
/// a long wait.
const MOST_TICKS: f64 = 3_600_000.0;

/// A step in periods of the ticks, both in s.
///
/// # Errors
/// Where it has more ticks than are taken.
#[inline(always)]
pub(crate) fn ticks_in(step: f64, sample_time: f64) -> Result<f64, String> {
    let ticks = step / sample_time;
    if ticks > MOST_TICKS { Err(too_many(step, ticks, sample_time)) } else { Ok(ticks) }
}

#[cold]
fn too_many(step: f64, ticks: f64, sample_time: f64) -> String {
    format!(
        "the step of {step} s spans {ticks:.3e} ticks of {sample_time} s, at most {MOST_TICKS:e} are taken; hint: step by \
         sample_time"
    )
}

/// Warns once of a step with several ticks; `consequence` is what that means for the unit, and what to do.
#[cold]
pub(crate) fn warn_of_long_step(
    warned: &mut bool,
    log: &mut Log,
    [step, sample_time]: [f64; 2],
    count: u64,
    consequence: &str,
) {
    if !*warned {
        *warned = true;
        log.warning(format!(
            "the step of {step} s spans {count} ticks of {sample_time} s: {consequence}"
        ));
    }
}
