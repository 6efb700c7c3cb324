//! Where a disturbance dies away as one slow mode, its end is known long before.

/// Where the decay is read, as shares of the time, and by how much its rate may differ between them for
/// one mode to be left.
const READ_AT: [f64; 3] = [0.4, 0.5, 0.6];
const ONE_MODE: f64 = 0.002;

/// Where the decay of a disturbed step is read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Decay {
    height: f64,
    ticks: [usize; 3],
}

impl Decay {
    /// Of a step of this height, looked at up to a time.
    pub(crate) fn of(height: f64, until: f64, sample_time: f64) -> Self {
        let [.., read] = READ_AT;
        let last = (until * read / sample_time).round();
        Self { height, ticks: READ_AT.map(|share| (share / read * last).round() as usize) }
    }

    /// The tick from which on the decay can be told.
    pub(crate) fn tick(&self) -> usize {
        self.ticks[2]
    }

    /// The error at the end, as a share of the step, where it decays as a single mode up to the tick at
    /// which that is told; none where it does not, or the response is shorter.
    pub(crate) fn error(&self, yaw: &[f64]) -> Option<f64> {
        let off = |k: usize| yaw.get(k).map(|y| 1.0 - y / self.height);
        let [first, second, third] = [off(self.ticks[0])?, off(self.ticks[1])?, off(self.tick())?];
        let (earlier, later) = (second / first, third / second);
        let decays = (0.0..1.0).contains(&earlier) && (0.0..1.0).contains(&later);
        let intervals = (1.0 - READ_AT[2]) / (READ_AT[2] - READ_AT[1]);
        (decays && (later - earlier).abs() < ONE_MODE).then(|| third.abs() * later.powf(intervals))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `1 − e^{−t/τ}` is told from its first 3 s to the end at 5 s, a second mode beside it is not.
    #[test]
    fn the_end_of_one_mode_is_told_early() {
        let decay = Decay::of(0.1, 5.0, 0.01);
        assert_eq!(decay.tick(), 300);
        let yaw = |second: f64| -> Vec<f64> {
            let t = (0..=300).map(|k| 0.01 * f64::from(k));
            t.map(|t| 0.1 * (1.0 - (-t / 2.0).exp() - second * (-t / 1.0).exp())).collect()
        };
        let error = decay.error(&yaw(0.0)).unwrap();
        assert!((error - (-2.5_f64).exp()).abs() < 1e-12, "{error}");
        assert_eq!(decay.error(&yaw(0.5)), None);
        assert_eq!(decay.error(&yaw(0.0)[..300]), None);
    }
}
