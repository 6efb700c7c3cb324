//! Statistics over the rows of a sweep.

use crate::distribution::Distribution;
use crate::explain::{Cause, Column, explain};
use crate::metric::{Class, Metric, Outcome};
use crate::prepare::Sweep;
use serde::Serialize;

/// The 97.5 % quantile of the normal distribution.
const Z95: f64 = 1.959_963_984_540_054;

/// Counts, shares and quantiles over the rows of the results.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)]
pub struct Summary {
    /// The hash that the rows are marked with.
    pub study: String,
    pub runs: usize,
    pub rows: usize,
    /// Rows that are no results but errors.
    pub errors: usize,
    pub first_error: Option<String>,
    /// Runs that did everything required, where anything is.
    pub passed: Option<Requirement>,
    /// The outcomes of the runs, from the best to the worst.
    pub outcomes: Vec<ClassSummary>,
    /// Conditions associated with the failures: all of them first, then each kind where there are several.
    pub failures: Vec<FailureSummary>,
    pub metrics: Vec<MetricSummary>,
}

/// The number of runs of an outcome.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[allow(missing_docs)]
pub struct ClassSummary {
    pub outcome: Class,
    pub runs: usize,
}

/// A kind of failure, and the varied quantities that go with it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FailureSummary {
    /// Which; every one where absent.
    pub outcome: Option<Class>,
    /// Runs that fail like this.
    pub runs: usize,
    /// Their conditions, the most informative first; empty where no quantity explains them.
    pub causes: Vec<Cause>,
}

/// The number of runs that meet the requirements. A run that ended in an error does not.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)]
pub struct Requirement {
    pub passed: usize,
    pub of: usize,
    pub share: f64,
    /// Wilson's interval for the probability, at 95 %.
    pub share_interval_95: [f64; 2],
}

/// A metric over the rows that have a value of it: neither an error, nor NaN.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)]
pub struct MetricSummary {
    pub name: String,
    pub unit: Option<String>,
    /// Rows with a value.
    pub count: usize,
    /// Rows where it never came about (`inf`): what did not settle, a bound never passed.
    pub never: usize,
    /// Mean; `None`, as everything below, where it is no finite number.
    pub mean: Option<f64>,
    /// Standard deviation, of one less than the count.
    pub standard_deviation: Option<f64>,
    pub minimum: Option<f64>,
    /// 5 % quantile, linear between order statistics.
    pub q05: Option<f64>,
    pub q25: Option<f64>,
    pub median: Option<f64>,
    pub q75: Option<f64>,
    pub q95: Option<f64>,
    pub q99: Option<f64>,
    pub maximum: Option<f64>,
    /// Runs that did what is required of this metric, where anything is.
    pub requirement: Option<Requirement>,
}

impl Summary {
    /// Of consecutive runs, of which `first` is the first.
    pub(crate) fn new(sweep: &Sweep, first: usize, outcomes: &[Outcome]) -> Self {
        let plan = &sweep.plan;
        let errors: Vec<&String> = outcomes
            .iter()
            .filter_map(|o| if let Outcome::Failed(text) = o { Some(text) } else { None })
            .collect();
        let passed = outcomes.iter().filter(|outcome| plan.passes(outcome)).count();
        let classes: Vec<Class> = outcomes.iter().map(|outcome| plan.class(outcome)).collect();
        let metrics = plan.metrics.iter().enumerate();
        Self {
            study: sweep.id.clone(),
            runs: plan.runs(),
            rows: outcomes.len(),
            errors: errors.len(),
            first_error: errors.first().map(|text| (*text).clone()),
            outcomes: outcomes_of(&classes),
            failures: failures(sweep, first, &classes),
            passed: if plan.requires() {
                Some(Requirement::new(passed, outcomes.len()))
            } else {
                None
            },
            metrics: metrics.map(|(i, m)| MetricSummary::new(m, i, outcomes)).collect(),
        }
    }

    /// Whether every row is a result that is as required, on the path.
    #[must_use]
    pub fn all_passed(&self) -> bool {
        self.outcomes.iter().all(|o| o.outcome == Class::Met)
    }
}

fn outcomes_of(classes: &[Class]) -> Vec<ClassSummary> {
    let count = |class| classes.iter().filter(|c| **c == class).count();
    let all = Class::ALL.map(|outcome| ClassSummary { outcome, runs: count(outcome) });
    all.into_iter().filter(|o| o.runs > 0).collect()
}

fn failures(sweep: &Sweep, first: usize, classes: &[Class]) -> Vec<FailureSummary> {
    let varied = &sweep.plan.varied;
    let draws: Vec<Vec<f64>> =
        (first..first + classes.len()).map(|run| sweep.plan.quantities(run)).collect();
    let column = |(k, v): (usize, &crate::plan::Varied)| Column {
        name: v.name.clone(),
        values: draws.iter().map(|values| values[k]).collect(),
        is_choice: matches!(v.distribution, Distribution::Choice { .. }),
    };
    let columns: Vec<Column> = varied.iter().enumerate().map(column).collect();
    let of = |outcome: Option<Class>| {
        let fails = |c: &Class| outcome.map_or(*c != Class::Met, |outcome| *c == outcome);
        let failed: Vec<bool> = classes.iter().map(fails).collect();
        let runs = failed.iter().filter(|f| **f).count();
        FailureSummary { outcome, runs, causes: explain(&columns, &failed) }
    };
    let kinds: Vec<Class> =
        outcomes_of(classes).iter().map(|o| o.outcome).filter(|c| *c != Class::Met).collect();
    match kinds[..] {
        [] => Vec::new(),
        [only] => vec![of(Some(only))],
        _ => std::iter::once(None).chain(kinds.iter().copied().map(Some)).map(of).collect(),
    }
}

impl Requirement {
    fn new(passed: usize, of: usize) -> Self {
        let share = if of == 0 { 0.0 } else { passed as f64 / of as f64 };
        Self { passed, of, share, share_interval_95: wilson(passed, of) }
    }
}

/// Wilson's score interval (1927) for a probability, at 95 %.
fn wilson(passed: usize, of: usize) -> [f64; 2] {
    if of == 0 {
        return [0.0, 1.0];
    }
    let (n, z2) = (of as f64, Z95 * Z95);
    let share = passed as f64 / n;
    let centre = (share + z2 / (2.0 * n)) / (1.0 + z2 / n);
    let half = Z95 / (1.0 + z2 / n) * (share * (1.0 - share) / n + z2 / (4.0 * n * n)).sqrt();
    // At the ends the formula yields 0 and 1 but for rounding.
    let low = if passed == 0 { 0.0 } else { centre - half };
    let high = if passed == of { 1.0 } else { centre + half };
    [low, high]
}

impl MetricSummary {
    fn new(metric: &Metric, index: usize, outcomes: &[Outcome]) -> Self {
        let all = outcomes.iter().filter_map(|outcome| match outcome {
            Outcome::Done(values) => Some(values[index]),
            Outcome::Failed(_) => None,
        });
        let mut values: Vec<f64> = all.filter(|value| !value.is_nan()).collect();
        let met = values.iter().filter(|value| metric.is_met(**value)).count();
        values.sort_by(f64::total_cmp);
        let count = values.len();
        let mean = values.iter().sum::<f64>() / count as f64;
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        let finite = |value: f64| Some(value).filter(|value| value.is_finite());
        let quantile = |share| finite(quantile(&values, share));
        Self {
            name: metric.name.clone(),
            unit: metric.unit.clone(),
            count,
            never: values.iter().filter(|value| value.is_infinite()).count(),
            mean: finite(mean),
            standard_deviation: finite((squares / (count as f64 - 1.0)).sqrt()),
            minimum: quantile(0.0),
            q05: quantile(0.05),
            q25: quantile(0.25),
            median: quantile(0.5),
            q75: quantile(0.75),
            q95: quantile(0.95),
            q99: quantile(0.99),
            maximum: quantile(1.0),
            requirement: if metric.is_required() {
                Some(Requirement::new(met, outcomes.len()))
            } else {
                None
            },
        }
    }
}

/// Linear between order statistics, as numpy's default; NaN of nothing.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let at = share * last as f64;
    let (low, rest) = (at.floor() as usize, at.fract());
    if rest == 0.0 || sorted[low] == sorted[low + 1] {
        return sorted[low];
    }
    sorted[low] + rest * (sorted[low + 1] - sorted[low])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_is_that_of_the_literature() {
        // Newcombe (1998), table I: 81 of 263, 15 of 148, 0 of 20, 1 of 29.
        for (passed, of, low, high) in [
            (81, 263, 0.2553, 0.3662),
            (15, 148, 0.0624, 0.1605),
            (0, 20, 0.0, 0.1611),
            (1, 29, 0.0061, 0.1718),
        ] {
            let [l, h] = wilson(passed, of);
            assert!((l - low).abs() < 5e-5 && (h - high).abs() < 5e-5, "{passed}/{of}: {l} {h}");
        }
        assert_eq!(wilson(20, 20)[1], 1.0);
        assert_eq!(wilson(0, 0), [0.0, 1.0]);
    }

    #[test]
    fn quantiles_are_numpys() {
        let sorted = [1.0, 2.0, 4.0, 8.0];
        assert_eq!(quantile(&sorted, 0.5), 3.0);
        assert!((quantile(&sorted, 0.95) - 7.4).abs() < 1e-12);
        assert_eq!(quantile(&sorted, 1.0), 8.0);
        assert_eq!(quantile(&[1.0, f64::INFINITY, f64::INFINITY], 0.75), f64::INFINITY);
        assert!(quantile(&[], 0.5).is_nan());
    }
}
