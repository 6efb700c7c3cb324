//! Where a simulated response is not followed to its end.

/// Bounds on a response, as shares of its step; a simulation ends where one is exceeded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StoppingBounds {
    /// Largest value at any time.
    pub(crate) highest: f64,
    /// Largest error after a time, s.
    pub(crate) settled: (f64, f64),
    /// Error that the response must come within, and the time by which, s.
    pub(crate) entered: (f64, f64),
    /// Where the response ends once it is known to decay as one mode.
    pub(crate) decay: Option<Decay>,
}

impl StoppingBounds {
    pub(crate) const NONE: Self = Self {
        highest: f64::INFINITY,
        settled: (f64::INFINITY, f64::INFINITY),
        entered: (f64::INFINITY, f64::INFINITY),
        decay: None,
    };
}

/// Shares of the time at which the decay is read, and the difference of its rate in one mode.
const READ_AT: [f64; 3] = [0.4, 0.5, 0.6];
const ONE_MODE: f64 = 0.002;

/// Where the decay of a disturbed step is read: a disturbance that decays as one slow mode has a known end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Decay {
    height: f64,
    ticks: [usize; 3],
}

impl Decay {
    /// For a step of a height, rad, evaluated at the time `until`, s.
    pub(crate) fn new(height: f64, until: f64, sample_time: f64) -> Self {
        let [.., read] = READ_AT;
        let last = (until * read / sample_time).round();
        Self { height, ticks: READ_AT.map(|share| (share / read * last).round() as usize) }
    }

    pub(crate) fn tick(&self) -> usize {
        self.ticks[2]
    }

    /// The error at the end as a share of the step; `None` unless the response decays as one mode.
    pub(crate) fn error(&self, yaw: &[f64]) -> Option<f64> {
        let off = |k: usize| yaw.get(k).map(|y| 1.0 - y / self.height);
        let [first, second, third] = [off(self.ticks[0])?, off(self.ticks[1])?, off(self.tick())?];
        let (earlier, later) = (second / first, third / second);
        let decays = (0.0..1.0).contains(&earlier) && (0.0..1.0).contains(&later);
        let intervals = (1.0 - READ_AT[2]) / (READ_AT[2] - READ_AT[1]);
        if decays && (later - earlier).abs() < ONE_MODE {
            Some(third.abs() * later.powf(intervals))
        } else {
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first 3 s of `1 − e^{−t/τ}` determine its value at 5 s; those of two modes do not.
    #[test]
    fn the_end_of_one_mode_is_known_early() {
        let decay = Decay::new(0.1, 5.0, 0.01);
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
