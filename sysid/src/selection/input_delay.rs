//! The recording with its steering delayed, so that what is left to identify has no delay.

use crate::Error;
use crate::data::scaled::{Data, Detrend};
use crate::selection::delay::{Delay, estimate_delay};
use crate::selection::options::IdentifyOptions;
use std::borrow::Cow;
use steerwright_drivelog::DriveLog;
use steerwright_formats::DelayEstimate;

pub(crate) struct InputDelay {
    pub(crate) seconds: f64,
    pub(crate) warning: Option<String>,
    /// The estimate, where the data determine the delay.
    pub(crate) estimate: Option<DelayEstimate>,
}

/// Delays the steering by the delay of the options, or the one that the estimation data determine.
pub(crate) fn delayed<'a>(
    log: &'a DriveLog,
    options: &IdentifyOptions,
) -> Result<(Cow<'a, DriveLog>, InputDelay), Error> {
    let delay = match options.delay_s {
        Some(seconds) => InputDelay { seconds, warning: None, estimate: None },
        None => found(log, options)?,
    };
    if delay.seconds == 0.0 {
        return Ok((Cow::Borrowed(log), delay));
    }
    Ok((Cow::Owned(log.with_input_delayed(delay.seconds)), delay))
}

fn found(log: &DriveLog, options: &IdentifyOptions) -> Result<InputDelay, Error> {
    let options = IdentifyOptions { detrend: Detrend::Mean, ..options.clone() };
    let data = Data::new(log, &options.preparation())?;
    // A log too short to determine a delay has none.
    let Ok(delay) = estimate_delay(&data.estimation.data) else {
        return Ok(InputDelay { seconds: 0.0, warning: None, estimate: None });
    };
    let warning = (delay.seconds > 0.0).then(|| words(&delay));
    let estimate = DelayEstimate {
        estimate_s: delay.estimate_s,
        standard_error_s: Some(delay.standard_error_s).filter(|e| e.is_finite()),
        lag_without_s: delay.lag_without_s,
        evidence: delay.evidence,
        taken: delay.seconds > 0.0,
    };
    let finite = [estimate.estimate_s, estimate.lag_without_s, estimate.evidence];
    let estimate = Some(estimate).filter(|_| finite.iter().all(|x| x.is_finite()));
    Ok(InputDelay { seconds: delay.seconds, warning, estimate })
}

fn words(delay: &Delay) -> String {
    format!(
        "the yaw rate follows the steering after {:.3} ± {:.3} s of pure delay, which is taken for the input's (a model of order {} without it needs a lag of {:.3} s and does worse; the ± includes what a servo's lag can replace, their sum is more certain); a stated delay of 0 s leaves it out",
        delay.seconds,
        2.0 * delay.standard_error_s,
        delay.order_without,
        delay.lag_without_s
    )
}
