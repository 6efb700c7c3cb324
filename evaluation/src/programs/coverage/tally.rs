//! Statements of value and standard error, counted against the truth.

use steerwright_evaluation::measure::median;

/// One quantity over all drives.
#[derive(Debug, Clone, Default)]
pub(crate) struct Tally {
    /// (estimate − truth)/standard error.
    scores: Vec<f64>,
    /// Estimate over truth less 1, or for angles the difference, degrees.
    errors: Vec<f64>,
    /// Drives in which the band holds the truth.
    held: usize,
}

/// Half a 95 % band in standard errors: of one normal number.
const HALF_BAND: f64 = 1.96;

impl Tally {
    /// An estimate of a number that is not zero.
    pub(crate) fn ratio(&mut self, estimate: f64, error: f64, truth: f64) {
        self.add((estimate - truth) / error, 100.0 * (estimate / truth - 1.0));
    }

    /// An estimate of an angle, rad.
    pub(crate) fn angle(&mut self, estimate: f64, error: f64, truth: f64) {
        let apart = estimate - truth;
        let apart = apart.sin().atan2(apart.cos());
        self.add(apart / error, apart.to_degrees());
    }

    fn add(&mut self, score: f64, error: f64) {
        self.push(score, error, score.abs() <= HALF_BAND);
    }

    /// A statement of its own kind: `held` is whether it holds.
    pub(crate) fn push(&mut self, score: f64, error: f64, held: bool) {
        self.scores.push(score);
        self.errors.push(error);
        self.held += usize::from(held);
    }

    /// Coverage with its standard error and what the errors are like.
    pub(crate) fn row(&self, name: &str, unit: &str) -> String {
        let n = self.scores.len().max(1) as f64;
        let share = self.held as f64 / n;
        let spread = (share * (1.0 - share) / n).sqrt();
        let absolute = |x: &[f64]| median(&x.iter().map(|x| x.abs()).collect::<Vec<f64>>());
        format!(
            "{name:<34}{:>6}{:>8.1} % ± {:>3.1}{:>12.2}{:>12.2} {unit:<2}{:>10.2}{:>10.2}",
            self.scores.len(),
            100.0 * share,
            100.0 * spread,
            median(&self.errors),
            absolute(&self.errors),
            median(&self.scores),
            // That of a normal distribution is 1.
            absolute(&self.scores) / 0.6745,
        )
    }
}

/// The columns of [`Tally::row`].
pub(crate) fn header() -> String {
    format!(
        "{:<34}{:>6}{:>16}{:>12}{:>12}   {:>10}{:>10}",
        "95 % band of", "drives", "holds the truth", "bias", "error", "bias/s.e.", "error/s.e."
    )
}
