//! Distributions of varied quantities.
//!
//! Real numbers have 53 random bits. Normal numbers are those of `rand_distr` (ziggurat), truncated
//! ones drawn again until they lie within the bounds, which [`Distribution::from_study`] keeps from being
//! rare. For Integer and Boolean variables, `uniform` draws whole numbers, both ends included.

use crate::study::{DistributionKind, Vary};
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use rand_distr::StandardNormal;

/// The least share of a normal distribution that its bounds may leave.
const LEAST_SHARE: f64 = 1e-3;
/// Standard deviations that a normal distribution is taken to reach.
const REACH: f64 = 6.0;
/// More points than this are taken for a slip.
const MOST_POINTS: usize = 1_000_000;

/// The distribution of a quantity. A choice has values and the upper ends of their shares of [0, 1);
/// points follow one after the other.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Distribution {
    Uniform { minimum: f64, maximum: f64 },
    Whole { minimum: i64, maximum: i64 },
    LogUniform { minimum: f64, maximum: f64 },
    Normal { mean: f64, deviation: f64, minimum: f64, maximum: f64 },
    Choice { values: Vec<f64>, ends: Vec<f64> },
    Points(Vec<f64>),
}

impl Distribution {
    /// The distribution that a study describes; `whole` for variables that are no Reals.
    pub(crate) fn from_study(vary: &Vary, whole: bool) -> Result<Self, String> {
        unused(vary)?;
        let need = |key: &str, value: Option<f64>| match value {
            None => Err(format!("{} needs {key}", vary.distribution.name())),
            Some(value) if !value.is_finite() => Err(format!("{key} is {value}")),
            Some(value) => Ok(value),
        };
        let bounds = || {
            let minimum = need("minimum", vary.minimum)?;
            let maximum = need("maximum", vary.maximum)?;
            if minimum < maximum {
                return Ok((minimum, maximum));
            }
            Err(format!("minimum {minimum} is not below maximum {maximum}"))
        };
        let normal = |minimum: f64, maximum: f64| {
            let mean = need("mean", vary.mean)?;
            let deviation = need("standard_deviation", vary.standard_deviation)?;
            if deviation <= 0.0 {
                return Err(format!("standard_deviation {deviation} is not above 0"));
            }
            Ok(Self::Normal { mean, deviation, minimum, maximum })
        };
        let real_only = |d: Self| {
            if whole {
                let name = vary.distribution.name();
                return Err(format!("{name} draws real numbers, and the variable is none"));
            }
            Ok(d)
        };
        match vary.distribution {
            DistributionKind::Uniform if whole => {
                let (minimum, maximum) = bounds()?;
                if minimum.fract() != 0.0 || maximum.fract() != 0.0 {
                    return Err(format!("{minimum} and {maximum} must be whole numbers here"));
                }
                Ok(Self::Whole { minimum: minimum as i64, maximum: maximum as i64 })
            }
            DistributionKind::Uniform => {
                let (minimum, maximum) = bounds()?;
                if (maximum - minimum).is_infinite() {
                    return Err(format!("{minimum} to {maximum} is too wide"));
                }
                Ok(Self::Uniform { minimum, maximum })
            }
            DistributionKind::LogUniform => {
                let (minimum, maximum) = bounds()?;
                if minimum <= 0.0 {
                    return Err(format!("log-uniform needs a minimum above 0, not {minimum}"));
                }
                real_only(Self::LogUniform { minimum, maximum })
            }
            DistributionKind::Normal => real_only(normal(f64::NEG_INFINITY, f64::INFINITY)?),
            DistributionKind::TruncatedNormal => {
                let (minimum, maximum) = bounds()?;
                let distribution = normal(minimum, maximum)?;
                if let Self::Normal { mean, deviation, .. } = distribution {
                    let share = share(mean, deviation, minimum, maximum);
                    if share < LEAST_SHARE {
                        return Err(format!(
                            "only {share:.1e} of normal({mean}, {deviation}) lies from {minimum} \
                             to {maximum}"
                        ));
                    }
                }
                real_only(distribution)
            }
            DistributionKind::Choice => choice(vary),
            DistributionKind::Grid => Ok(Self::Points(values(vary)?)),
            DistributionKind::Linspace => {
                let (minimum, maximum) = bounds()?;
                let count = vary.count.ok_or("linspace needs count")?;
                if !(2..=MOST_POINTS).contains(&count) {
                    return Err(format!("count {count} is not from 2 to {MOST_POINTS}"));
                }
                let last = (count - 1) as f64;
                let at = |k: usize| {
                    let share = k as f64 / last;
                    // Both ends exactly.
                    minimum * (1.0 - share) + maximum * share
                };
                Ok(Self::Points((0..count).map(at).collect()))
            }
        }
    }

    /// The points of a grid; 1 for what is drawn.
    pub(crate) fn points(&self) -> usize {
        if let Self::Points(values) = self { values.len() } else { 1 }
    }

    /// The least and the greatest value, to six standard deviations for a normal distribution.
    pub(crate) fn reach(&self) -> (f64, f64) {
        let ends = |values: &[f64]| {
            let least = values.iter().copied().fold(f64::INFINITY, f64::min);
            (least, values.iter().copied().fold(f64::NEG_INFINITY, f64::max))
        };
        match self {
            Self::Uniform { minimum, maximum } | Self::LogUniform { minimum, maximum } => {
                (*minimum, *maximum)
            }
            Self::Whole { minimum, maximum } => (*minimum as f64, *maximum as f64),
            Self::Normal { mean, deviation, minimum, maximum } => {
                ((mean - REACH * deviation).max(*minimum), (mean + REACH * deviation).min(*maximum))
            }
            Self::Choice { values, .. } | Self::Points(values) => ends(values),
        }
    }

    /// The value of a run; `point` is its place on the grid's axis.
    pub(crate) fn value(&self, stream: &mut ChaCha8Rng, point: usize) -> f64 {
        match self {
            Self::Uniform { minimum, maximum } => {
                let share: f64 = stream.random();
                (minimum + (maximum - minimum) * share).clamp(*minimum, *maximum)
            }
            Self::Whole { minimum, maximum } => stream.random_range(*minimum..=*maximum) as f64,
            Self::LogUniform { minimum, maximum } => {
                let share: f64 = stream.random();
                (minimum.ln() + (maximum.ln() - minimum.ln()) * share)
                    .exp()
                    .clamp(*minimum, *maximum)
            }
            Self::Normal { mean, deviation, minimum, maximum } => loop {
                let unit: f64 = stream.sample(StandardNormal);
                let value = mean + deviation * unit;
                if (*minimum..=*maximum).contains(&value) {
                    return value;
                }
            },
            Self::Choice { values, ends } => {
                let share: f64 = stream.random();
                let index = ends.partition_point(|end| *end <= share);
                values[index.min(values.len() - 1)]
            }
            Self::Points(values) => values[point],
        }
    }
}

impl DistributionKind {
    /// As it is written.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Uniform => "uniform",
            Self::LogUniform => "log-uniform",
            Self::Normal => "normal",
            Self::TruncatedNormal => "truncated-normal",
            Self::Choice => "choice",
            Self::Grid => "grid",
            Self::Linspace => "linspace",
        }
    }
}

/// Refuses keys that the distribution makes no use of: they are a slip.
fn unused(vary: &Vary) -> Result<(), String> {
    let given = [
        ("minimum", vary.minimum.is_some()),
        ("maximum", vary.maximum.is_some()),
        ("mean", vary.mean.is_some()),
        ("standard_deviation", vary.standard_deviation.is_some()),
        ("count", vary.count.is_some()),
        ("values", vary.values.is_some()),
        ("weights", vary.weights.is_some()),
    ];
    let used: &[&str] = match vary.distribution {
        DistributionKind::Uniform | DistributionKind::LogUniform => &["minimum", "maximum"],
        DistributionKind::Normal => &["mean", "standard_deviation"],
        DistributionKind::TruncatedNormal => &["minimum", "maximum", "mean", "standard_deviation"],
        DistributionKind::Choice => &["values", "weights"],
        DistributionKind::Grid => &["values"],
        DistributionKind::Linspace => &["minimum", "maximum", "count"],
    };
    match given.iter().find(|(key, given)| *given && !used.contains(key)) {
        None => Ok(()),
        Some((key, _)) => Err(format!("{} has no {key}", vary.distribution.name())),
    }
}

fn values(vary: &Vary) -> Result<Vec<f64>, String> {
    let name = vary.distribution.name();
    let values = vary.values.as_deref().ok_or_else(|| format!("{name} needs values"))?;
    if values.is_empty() || values.len() > MOST_POINTS {
        return Err(format!("{name} has {} values", values.len()));
    }
    let number = |value: &toml::Value| match value {
        toml::Value::Integer(value) => Some(*value as f64),
        toml::Value::Float(value) => Some(*value).filter(|v| v.is_finite()),
        toml::Value::Boolean(value) => Some(f64::from(u8::from(*value))),
        _ => None,
    };
    values
        .iter()
        .map(|v| number(v).ok_or_else(|| format!("{v} is no finite number, true or false")))
        .collect()
}

fn choice(vary: &Vary) -> Result<Distribution, String> {
    let values = values(vary)?;
    let weights = vary.weights.clone().unwrap_or_else(|| vec![1.0; values.len()]);
    if weights.len() != values.len() {
        return Err(format!("{} weights for {} values", weights.len(), values.len()));
    }
    if let Some(bad) = weights.iter().find(|w| !(w.is_finite() && **w >= 0.0)) {
        return Err(format!("weight {bad} is not 0 or more"));
    }
    let sum: f64 = weights.iter().sum();
    if !(sum > 0.0 && sum.is_finite()) {
        return Err(format!("the weights' sum is {sum}"));
    }
    let mut end = 0.0;
    let mut ends: Vec<f64> = weights
        .iter()
        .map(|weight| {
            end += weight / sum;
            end
        })
        .collect();
    // The sum may end an ulp short of 1; the last value with a weight gets the rest.
    let last = weights.iter().rposition(|w| *w > 0.0).unwrap_or(0);
    ends[last..].fill(1.0);
    Ok(Distribution::Choice { values, ends })
}

/// The share of a normal distribution between two bounds, to about 1e-7.
fn share(mean: f64, deviation: f64, minimum: f64, maximum: f64) -> f64 {
    (upper_tail((minimum - mean) / deviation) - upper_tail((maximum - mean) / deviation)).max(0.0)
}

/// 1 − Φ(z) by formula 26.2.17 of Abramowitz and Stegun, absolute error below 7.5e-8.
fn upper_tail(z: f64) -> f64 {
    if z < 0.0 {
        return 1.0 - upper_tail(-z);
    }
    let t = 1.0 / (1.0 + 0.231_641_9 * z);
    let polynomial = [1.330_274_429, -1.821_255_978, 1.781_477_937, -0.356_563_782, 0.319_381_530]
        .iter()
        .fold(0.0, |sum, c| (sum + c) * t);
    polynomial * (-0.5 * z * z).exp() / (2.0 * std::f64::consts::PI).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draws::Key;

    const DRAWS: usize = 4_000;

    fn parsed(text: &str, whole: bool) -> Result<Distribution, String> {
        Distribution::from_study(&toml::from_str(text).unwrap(), whole)
    }

    /// Draws of as many runs, sorted.
    fn drawn(text: &str, whole: bool) -> Vec<f64> {
        let distribution = parsed(text, whole).unwrap();
        let key = Key::new(1, "x");
        let value = |run| distribution.value(&mut key.stream(run), 0);
        let mut values: Vec<f64> = (0..DRAWS).map(value).collect();
        values.sort_by(f64::total_cmp);
        values
    }

    /// Kolmogorov and Smirnov's distance to a distribution function; 1.63/√n is passed by chance
    /// once in a hundred.
    fn assert_distributed(values: &[f64], function: impl Fn(f64) -> f64) {
        let n = values.len() as f64;
        let distance = values
            .iter()
            .enumerate()
            .map(|(i, x)| (function(*x) - (i as f64 + 0.5) / n).abs())
            .fold(0.0, f64::max);
        assert!(distance < 1.63 / n.sqrt(), "{distance}");
    }

    #[test]
    fn draws_have_the_distribution_that_is_named() {
        let uniform = drawn("distribution = \"uniform\"\nminimum = -2.0\nmaximum = 3.0", false);
        assert_distributed(&uniform, |x| (x + 2.0) / 5.0);
        let log = drawn("distribution = \"log-uniform\"\nminimum = 0.1\nmaximum = 10.0", false);
        assert_distributed(&log, |x| (x / 0.1).ln() / 100f64.ln());
        let normal = "mean = 5.0\nstandard_deviation = 2.0";
        let whole = drawn(&format!("distribution = \"normal\"\n{normal}"), false);
        assert_distributed(&whole, |x| 1.0 - upper_tail((x - 5.0) / 2.0));
        let text =
            format!("distribution = \"truncated-normal\"\nminimum = 6\nmaximum = 9\n{normal}");
        let cut = drawn(&text, false);
        assert!(cut[0] >= 6.0 && cut[DRAWS - 1] <= 9.0);
        let all = share(5.0, 2.0, 6.0, 9.0);
        assert_distributed(&cut, |x| share(5.0, 2.0, 6.0, x) / all);
    }

    #[test]
    fn whole_numbers_and_choices_have_their_shares() {
        let count = |values: &[f64], x: f64| values.iter().filter(|v| **v == x).count() as f64;
        let dice = drawn("distribution = \"uniform\"\nminimum = 1\nmaximum = 6", true);
        let text = "distribution = \"choice\"\nvalues = [1, 2, 3]\nweights = [3, 0, 1]";
        let choice = drawn(text, false);
        for (values, x, share) in [
            (&dice, 1.0, 1.0 / 6.0),
            (&dice, 6.0, 1.0 / 6.0),
            (&choice, 1.0, 0.75),
            (&choice, 2.0, 0.0),
            (&choice, 3.0, 0.25),
        ] {
            let n = DRAWS as f64;
            let off = (count(values, x) - share * n).abs();
            assert!(off <= 3.3 * (n * share * (1.0 - share)).sqrt(), "{x}: {off}");
        }
    }

    #[test]
    fn a_linspace_has_both_its_ends() {
        let text = "distribution = \"linspace\"\nminimum = 0.1\nmaximum = 0.7\ncount = 4";
        let Ok(Distribution::Points(values)) = parsed(text, false) else { panic!("no points") };
        assert_eq!((values.len(), values[0], values[3]), (4, 0.1, 0.7));
        assert!((values[1] - 0.3).abs() < 1e-15);
    }
}
