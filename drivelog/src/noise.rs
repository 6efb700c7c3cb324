//! Whether the noise of a log is negligible.

use crate::resample::{Grid, MARGIN};
use crate::series::Series;
use crate::signal::{mean, standard_deviation};
use faer::Mat;

/// Rows that are looked at, at most; those that a log read in chunks begins with.
const ROWS: usize = 6000;
/// Past samples of each signal in the prediction: more than lateral dynamics with an actuator have states.
const LAGS: usize = 6;
/// Prediction errors of a smaller share of the yaw rate are of no sensor.
const NEGLIGIBLE: f64 = 3e-3;

/// Whether an ARX model of order 6 predicts the yaw rate but for what no sensor reaches.
pub(crate) fn is_negligible(steering: &Series, yaw_rate: &Series) -> bool {
    let period = steering.period;
    let rows = steering.time.len().min(yaw_rate.time.len()).min(ROWS);
    let from = steering.start().max(yaw_rate.start());
    let to = from + rows.saturating_sub(1) as f64 * period;
    let to = to.min(steering.end()).min(yaw_rate.end());
    let grid = Grid::within(from, to, period, 1, MARGIN);
    if grid.count < 20 * LAGS {
        return false;
    }
    let centred = |series: &Series| -> Vec<f64> {
        let x = series.interpolate(&grid);
        let (middle, size) = (mean(&x), standard_deviation(&x).max(f64::MIN_POSITIVE));
        x.iter().map(|x| (x - middle) / size).collect()
    };
    let (u, y) = (centred(steering), centred(yaw_rate));
    let count = grid.count - LAGS;
    // Regressors first: the last entry of R is the norm of what they leave of the last column.
    let joined = Mat::from_fn(count, 2 * LAGS + 2, |t, j| {
        let now = t + LAGS;
        match j {
            _ if j < LAGS => y[now - 1 - j],
            _ if j <= 2 * LAGS => u[now + LAGS - j],
            _ => y[now],
        }
    });
    let qr = joined.qr();
    let r = qr.thin_R();
    let left = r[(2 * LAGS + 1, 2 * LAGS + 1)].abs();
    left < NEGLIGIBLE * (count as f64).sqrt()
}
