//! The experiment that several FMUs recommend together.

use model_description::DefaultExperiment;

use crate::archive::Archive;

/// The earliest start, the latest stop and the smallest step that any of the archives recommends, and a
/// remark where their starts differ. What none of them states is missing.
pub fn recommended_experiment<'a>(
    archives: impl Iterator<Item = &'a Archive>,
) -> (DefaultExperiment, Option<String>) {
    let (mut all, mut latest_start) = (DefaultExperiment::default(), None);
    let finite = |value: Option<f64>| value.filter(|value| value.is_finite());
    let reduced = |one: Option<f64>, other: Option<f64>, reduce: fn(f64, f64) -> f64| {
        one.into_iter().chain(finite(other)).reduce(reduce)
    };
    for archive in archives {
        let one = archive.model().description().default_experiment.unwrap_or_default();
        latest_start = reduced(latest_start, one.start_time, f64::max);
        all.start_time = reduced(all.start_time, one.start_time, f64::min);
        all.stop_time = reduced(all.stop_time, one.stop_time, f64::max);
        all.step_size = reduced(all.step_size, one.step_size, f64::min);
    }
    let remark = match (all.start_time, latest_start) {
        (Some(first), Some(last)) if first < last => {
            Some(format!("the FMUs recommend start times from {first} s to {last} s"))
        }
        _ => None,
    };
    (all, remark)
}
