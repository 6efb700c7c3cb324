//! The varied quantities that explain a kind of failure: a decision tree of depth two.
//!
//! A node is split where that gains most information about who fails: each quantity at each of its
//! values, and a choice also into one of its values and all others. A split counts where Fisher's
//! exact test (1922, one-sided) shows that it is no chance, corrected for every split that was looked at
//! in that node (Bonferroni): under chance each of them has a hypergeometric table.

use serde::Serialize;

/// A split that chance makes at least this often explains nothing.
const SIGNIFICANCE: f64 = 0.01;

/// The values of a varied quantity, run by run.
#[derive(Debug, Clone)]
pub(crate) struct Column {
    pub(crate) name: String,
    pub(crate) values: Vec<f64>,
    /// Whether the values have no order that means anything.
    pub(crate) is_choice: bool,
}

/// A condition on a varied quantity.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)]
pub struct Condition {
    pub quantity: String,
    pub is: Relation,
    /// The number it is compared with, in the study's unit.
    pub value: f64,
}

/// The comparison of a quantity with a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[allow(missing_docs)]
pub enum Relation {
    Below,
    AtLeast,
    Equal,
    NotEqual,
}

/// Runs that fail, of some.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[allow(missing_docs)]
pub struct Failing {
    pub failed: usize,
    pub of: usize,
}

/// A condition associated with a failure.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)]
pub struct Cause {
    /// The runs that it is about; all of them where absent.
    pub among: Option<Condition>,
    pub condition: Condition,
    pub with: Failing,
    pub without: Failing,
    /// Probability of such a split by chance, corrected for all that were tried.
    pub p_value: f64,
}

impl Condition {
    fn holds(&self, value: f64) -> bool {
        match self.is {
            Relation::Below => value < self.value,
            Relation::AtLeast => value >= self.value,
            Relation::Equal => value == self.value,
            Relation::NotEqual => value != self.value,
        }
    }

    fn reversed(&self) -> Self {
        let is = match self.is {
            Relation::Below => Relation::AtLeast,
            Relation::AtLeast => Relation::Below,
            Relation::Equal => Relation::NotEqual,
            Relation::NotEqual => Relation::Equal,
        };
        Self { is, ..self.clone() }
    }
}

impl std::fmt::Display for Condition {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let word = match self.is {
            Relation::Below => "below",
            Relation::AtLeast => "of at least",
            Relation::Equal => "of",
            Relation::NotEqual => "other than",
        };
        write!(f, "{} {word} {}", self.quantity, self.value)
    }
}

/// The causes of the failures, the one that explains most first; none where nothing explains them.
pub(crate) fn explain(columns: &[Column], failed: &[bool]) -> Vec<Cause> {
    let all: Vec<usize> = (0..failed.len()).collect();
    let logs = log_factorials(failed.len());
    let best = |rows: &[usize]| split(columns, failed, rows, &logs);
    let Some(first) = best(&all) else { return Vec::new() };
    let condition = first.condition.clone();
    let column = columns.iter().find(|c| c.name == condition.quantity);
    let (with, without): (Vec<usize>, Vec<usize>) = all
        .iter()
        .copied()
        .partition(|&row| column.is_some_and(|c| condition.holds(c.values[row])));
    let mut causes = vec![first];
    for (rows, among) in [(with, condition.clone()), (without, condition.reversed())] {
        if let Some(cause) = best(&rows) {
            causes.push(Cause { among: Some(among), ..cause });
        }
    }
    causes
}

/// The most informative split of some rows, if it is significant.
fn split(columns: &[Column], failed: &[bool], rows: &[usize], logs: &[f64]) -> Option<Cause> {
    let total = Failing { failed: rows.iter().filter(|r| failed[**r]).count(), of: rows.len() };
    if total.failed == 0 || total.failed == total.of {
        return None;
    }
    let mut tried = 0_usize;
    let mut best: Option<(f64, Condition, Failing)> = None;
    for column in columns {
        let mut sorted: Vec<(f64, bool)> =
            rows.iter().map(|r| (column.values[*r], failed[*r])).collect();
        sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut consider = |part: Failing, is: Relation, value: f64| {
            tried += 1;
            let gain = gain(part, total);
            if best.as_ref().is_none_or(|(most, ..)| gain > *most) {
                let quantity = column.name.clone();
                best = Some((gain, Condition { quantity, is, value }, part));
            }
        };
        let mut below = Failing { failed: 0, of: 0 };
        let mut groups = sorted.chunk_by(|a, b| a.0 == b.0).peekable();
        while let Some(group) = groups.next() {
            let own = Failing { failed: group.iter().filter(|(_, f)| *f).count(), of: group.len() };
            below = Failing { failed: below.failed + own.failed, of: below.of + own.of };
            // One of two values is not other than the one that is not the other.
            if column.is_choice && own.of < total.of {
                consider(own, Relation::Equal, group[0].0);
            }
            if let Some(next) = groups.peek() {
                consider(below, Relation::Below, between(group[0].0, next[0].0));
            }
        }
    }
    let (_, condition, part) = best?;
    let rest = Failing { failed: total.failed - part.failed, of: total.of - part.of };
    // The condition is that of the side where more fail.
    let (condition, with, without) = if share(part) >= share(rest) {
        (condition, part, rest)
    } else {
        (condition.reversed(), rest, part)
    };
    // Either side of each split could have been the one where more fail.
    let p_value = (fisher(with, total, logs) * 2.0 * tried as f64).min(1.0);
    let cause = Cause { among: None, condition, with, without, p_value };
    if p_value < SIGNIFICANCE { Some(cause) } else { None }
}

fn share(part: Failing) -> f64 {
    part.failed as f64 / part.of.max(1) as f64
}

/// Information gain of a split about failures, nats over all rows.
fn gain(part: Failing, total: Failing) -> f64 {
    let rest = Failing { failed: total.failed - part.failed, of: total.of - part.of };
    let entropy = |x: Failing| {
        let term = |count: usize| {
            let (count, of) = (count as f64, x.of as f64);
            if count == 0.0 { 0.0 } else { -count * (count / of).ln() }
        };
        term(x.failed) + term(x.of - x.failed)
    };
    entropy(total) - entropy(part) - entropy(rest)
}

/// Probability that a part of that size holds as many failures or more by chance.
fn fisher(part: Failing, total: Failing, logs: &[f64]) -> f64 {
    let choose = |n: usize, k: usize| logs[n] - logs[k] - logs[n - k];
    let all = choose(total.of, part.of);
    let most = part.of.min(total.failed);
    (part.failed..=most)
        .filter(|k| part.of - k <= total.of - total.failed)
        .map(|k| {
            let ways = choose(total.failed, k) + choose(total.of - total.failed, part.of - k);
            (ways - all).exp()
        })
        .sum::<f64>()
        .min(1.0)
}

/// ln k! for k = 0 … n.
fn log_factorials(n: usize) -> Vec<f64> {
    let mut sum = 0.0;
    (0..=n)
        .map(|k| {
            sum += (k.max(1) as f64).ln();
            sum
        })
        .collect()
}

/// The shortest decimal above `low` and at most `high`.
fn between(low: f64, high: f64) -> f64 {
    let middle = low + 0.5 * (high - low);
    (0..17)
        .filter_map(|digits| format!("{middle:.digits$e}").parse().ok())
        .find(|candidate: &f64| *candidate > low && *candidate <= high)
        .unwrap_or(high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draws::Key;
    use rand::RngExt;

    /// Uniform in [0, 1), a quantity without any effect among them.
    fn columns(runs: usize) -> Vec<Column> {
        let column = |name: &str| {
            let key = Key::new(7, name);
            Column {
                name: name.to_owned(),
                values: (0..runs).map(|run| key.stream(run).random::<f64>()).collect(),
                is_choice: false,
            }
        };
        ["friction", "speed", "mass"].map(column).into()
    }

    #[test]
    fn one_threshold_is_found() {
        let columns = columns(500);
        let failed: Vec<bool> = columns[0].values.iter().map(|mu| *mu < 0.2).collect();
        let count = failed.iter().filter(|f| **f).count();
        let causes = explain(&columns, &failed);
        assert_eq!(causes.len(), 1, "{causes:?}");
        let cause = &causes[0];
        assert_eq!(
            cause.condition.to_string(),
            format!("friction below {}", cause.condition.value)
        );
        assert!((cause.condition.value - 0.2).abs() < 0.005, "{}", cause.condition.value);
        assert_eq!(cause.with, Failing { failed: count, of: count });
        assert_eq!(cause.without, Failing { failed: 0, of: 500 - count });
        assert!(cause.p_value < 1e-80);
    }

    #[test]
    fn two_thresholds_are_found() {
        let columns = columns(600);
        let failed: Vec<bool> =
            (0..600).map(|k| columns[0].values[k] < 0.4 && columns[1].values[k] > 0.7).collect();
        let causes = explain(&columns, &failed);
        assert_eq!(causes.len(), 2, "{causes:?}");
        let of: Vec<&str> = causes.iter().map(|c| c.condition.quantity.as_str()).collect();
        assert!(of.contains(&"friction") && of.contains(&"speed"), "{causes:?}");
        let within = &causes[1];
        assert_eq!(within.with.failed, within.with.of);
        assert_eq!(within.without.failed, 0);
    }

    #[test]
    fn failures_at_both_ends_are_found() {
        let columns = columns(400);
        let failed: Vec<bool> =
            columns[2].values.iter().map(|m| !(0.1..=0.85).contains(m)).collect();
        let causes = explain(&columns, &failed);
        assert_eq!(causes.len(), 2, "{causes:?}");
        let mut is: Vec<Relation> = causes.iter().map(|c| c.condition.is).collect();
        is.sort_by_key(|r| *r as u8);
        assert_eq!(is, [Relation::Below, Relation::AtLeast]);
    }

    #[test]
    fn one_of_a_choice_is_found() {
        let values: Vec<f64> = (0..90).map(|k| [16.0, 18.0, 20.0][k % 3]).collect();
        let failed: Vec<bool> = values.iter().map(|v| *v == 18.0).collect();
        let column = Column { name: "tyre".into(), values, is_choice: true };
        let causes = explain(&[column], &failed);
        assert_eq!(causes[0].condition.to_string(), "tyre of 18");
        assert_eq!(causes[0].with, Failing { failed: 30, of: 30 });
    }

    /// Of 200 studies in which failures are chance, at most one in a hundred is explained.
    #[test]
    fn chance_explains_nothing() {
        let explained = (0..200).filter(|seed| {
            let key = Key::new(*seed, "failures");
            let failed: Vec<bool> =
                (0..150).map(|run| key.stream(run).random::<f64>() < 0.2).collect();
            !explain(&columns(150), &failed).is_empty()
        });
        assert!(explained.count() <= 2);
    }

    /// SciPy: `fisher_exact([[9, 1], [3, 12]], alternative="greater")`.
    #[test]
    fn the_test_is_fisher_s() {
        let logs = log_factorials(25);
        let p = fisher(Failing { failed: 9, of: 10 }, Failing { failed: 12, of: 25 }, &logs);
        assert!((p - 8.951_406_649_616_369e-4).abs() < 1e-15, "{p}");
    }

    #[test]
    fn thresholds_are_short() {
        assert_eq!(between(0.4587, 0.4612), 0.46);
        assert_eq!(between(3.0, 4.0), 4.0);
        assert_eq!(between(-1.0, 1.0), 0.0);
        assert_eq!(between(1.0, 1.0 + f64::EPSILON), 1.0 + f64::EPSILON);
    }
}
