//! The fit of simulations, and tests of the prediction errors.

use crate::structures::longitudinal::model::{Lags, Point, Schedule, Simulation};
use crate::structures::longitudinal::signals::{Piece, Signals, samples};

/// Length of the windows that are simulated, s. An error of the acceleration, as of an unknown grade, is an error of the
/// speed that grows as long as the simulation lasts.
pub(super) const WINDOW_S: f64 = 10.0;
/// Fewest windows of which a standard error is estimated.
const LEAST_WINDOWS: usize = 8;

/// The windows of the pieces of a log.
#[derive(Debug, Clone, Default)]
pub(super) struct Windows(Vec<Window>);

/// A window that is simulated from an estimated initial speed.
#[derive(Debug, Clone)]
struct Window {
    /// Place of its first sample.
    start: usize,
    /// Simulated speeds, m/s.
    speeds: Vec<f64>,
    /// Sums of the squared errors, and of the squared changes of the measured speed.
    sums: [f64; 2],
    /// Sums of the products of the changes of the measured and the simulated speed, and of the squares of the latter.
    products: [f64; 2],
}

impl Windows {
    /// Simulates windows of the pieces, each from an estimated initial speed, with inputs and gears of the log alone.
    pub(super) fn simulate(
        signals: &Signals<'_>,
        schedule: &Schedule,
        point: &Point,
        pieces: &[Piece],
    ) -> Self {
        let simulation = Simulation::new(signals, schedule, *point);
        let log = signals.log;
        let window = samples(WINDOW_S, log);
        let mut all = Vec::new();
        for (place, segment) in log.segments.iter().enumerate() {
            let mut starts: Vec<(usize, usize)> = Vec::new();
            for piece in pieces.iter().filter(|piece| piece.segment == place) {
                let count = (piece.range.len() / window).max(1);
                let length = piece.range.len() / count;
                for i in 0..count {
                    let start = piece.range.start + i * length;
                    starts.push((start, start + length));
                }
            }
            let mut starts = starts.into_iter().peekable();
            let from = segment.range.start;
            let mut lags = simulation.steady(from);
            for k in segment.range.clone() {
                if let Some((start, end)) = starts.next_if(|(start, _)| *start == k) {
                    all.push(one_window(signals, &simulation, lags, from, (start, end)));
                }
                if starts.peek().is_none() {
                    break;
                }
                simulation.increment(&mut lags, from, k, signals.mean_speed[k]);
            }
        }
        Self(all)
    }

    pub(super) fn count(&self) -> usize {
        self.0.len()
    }

    /// Fit in percent.
    pub(super) fn fit(&self) -> f64 {
        let [error, change] = self.sums();
        if change <= 0.0 {
            return 0.0;
        }
        100.0 * (1.0 - (error / change).sqrt())
    }

    /// Root mean square of the changes of the measured speed within a window, m/s, for `samples` in all.
    pub(super) fn change_rms(&self, samples: usize) -> f64 {
        (self.sums()[1] / samples.max(1) as f64).sqrt()
    }

    /// Standard error of the fit, percent.
    pub(super) fn standard_error(&self) -> Option<f64> {
        let (ratio, deviation) = ratio(self.0.iter().map(|window| window.sums))?;
        Some(100.0 * 0.5 * deviation / ratio.sqrt().max(1e-9))
    }

    /// Writes the simulated speeds to their places.
    pub(super) fn write_to(&self, signal: &mut [f64]) {
        for Window { start, speeds, .. } in &self.0 {
            signal[*start..start + speeds.len()].copy_from_slice(speeds);
        }
    }

    fn sums(&self) -> [f64; 2] {
        self.0
            .iter()
            .fold([0.0; 2], |[a, b], Window { sums: [error, change], .. }| [a + error, b + change])
    }
}

/// By how much the measured speed changes where the simulated one changes by 1, with its standard error.
pub(super) fn slope(windows: [&Windows; 2]) -> Option<(f64, f64)> {
    ratio(windows.into_iter().flat_map(|windows| &windows.0).map(|window| window.products))
}

/// A ratio of sums over windows with its standard error by the delta method.
fn ratio(sums: impl Iterator<Item = [f64; 2]>) -> Option<(f64, f64)> {
    let all: Vec<[f64; 2]> = sums.collect();
    let n = all.len();
    let [above, below] = all.iter().fold([0.0; 2], |[a, b], [x, y]| [a + x, b + y]);
    if n < LEAST_WINDOWS || below <= 0.0 {
        return None;
    }
    let ratio = above / below;
    let squares: f64 = all.iter().map(|[a, b]| (a - ratio * b).powi(2)).sum();
    Some((ratio, (squares * n as f64 / (n - 1) as f64).sqrt() / below))
}

fn one_window(
    signals: &Signals<'_>,
    simulation: &Simulation<'_, f64>,
    lags: Lags<f64>,
    from: usize,
    (start, end): (usize, usize),
) -> Window {
    let measured = &signals.log.output[start..end];
    let count = measured.len() as f64;
    let mean = measured.iter().sum::<f64>() / count;
    let mut initial = signals.mean_speed[start];
    let (mut squares, mut speeds) = (0.0, Vec::with_capacity(measured.len()));
    // The simulated speed is almost the initial one and a term that does not depend on it.
    for _ in 0..3 {
        let (mut lags, mut speed) = (lags, initial);
        let (mut sum, mut own) = (0.0, 0.0);
        speeds.clear();
        for (k, y) in (start..end).zip(measured) {
            speeds.push(speed);
            let error = y - speed;
            sum += error;
            own += error * error;
            speed = (speed + simulation.increment(&mut lags, from, k, speed)).max(0.0);
        }
        initial = (initial + sum / count).max(0.0);
        squares = own;
    }
    let sums = [squares, measured.iter().map(|y| (y - mean).powi(2)).sum()];
    let own_mean = speeds.iter().sum::<f64>() / count;
    let changes = || measured.iter().zip(&speeds).map(|(y, own)| [y - mean, own - own_mean]);
    let products =
        [changes().map(|[y, own]| y * own).sum(), changes().map(|[_, own]| own * own).sum()];
    Window { start, speeds, sums, products }
}

/// Tests of prediction errors: their standard deviation, the largest autocorrelation at lags up to 1 s, the largest
/// correlation with an earlier command within 2 s, and the standard error of a correlation of white errors.
pub(super) fn residual_tests(
    errors: &[Vec<f64>],
    pieces: &[Piece],
    signals: &Signals<'_>,
) -> (f64, [f64; 2], f64) {
    let count: usize = errors.iter().map(Vec::len).sum();
    if count == 0 {
        return (0.0, [0.0; 2], 0.0);
    }
    let square: f64 = errors.iter().flatten().map(|e| e * e).sum();
    let input = &signals.log.input;
    let commands = || pieces.iter().flat_map(|piece| &input[piece.range.clone()]);
    let samples_of_command = commands().count().max(1) as f64;
    let mean = commands().sum::<f64>() / samples_of_command;
    let power: f64 = commands().map(|u| (u - mean).powi(2)).sum::<f64>() / samples_of_command;
    let (mut auto, mut cross) = (0.0_f64, 0.0_f64);
    for lag in 1..=samples(1.0, signals.log) {
        let product: f64 = errors
            .iter()
            .flat_map(|own| own.iter().zip(own.iter().skip(lag)))
            .map(|(a, b)| a * b)
            .sum();
        auto = auto.max((product / square.max(f64::MIN_POSITIVE)).abs());
    }
    for lag in 0..=samples(2.0, signals.log) {
        let mut product = 0.0;
        for (piece, own) in pieces.iter().zip(errors) {
            for (i, e) in own.iter().enumerate().skip(lag) {
                product += e * (input[piece.range.start + 1 + i - lag] - mean);
            }
        }
        let size = (square * power * count as f64).sqrt().max(f64::MIN_POSITIVE);
        cross = cross.max((product / size).abs());
    }
    ((square / count as f64).sqrt(), [auto, cross], 1.0 / (count as f64).sqrt())
}
