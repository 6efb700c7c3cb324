//! The plants that one set of gains must serve: drawn from the identified uncertainty, at latencies and, where
//! the model holds there, speeds around those designed for.

use crate::closed_loop::scenario::Scenario;
use crate::design::objective::Objective;
use crate::design::options::{DesignOptions, RobustOptions};
use crate::plants::design_plant::DesignPlant;
use steerwright_models::noise::gaussian;

/// Ratio of the plants drawn at the nominal latency to those above and below it.
const AT_NOMINAL: usize = 3;
/// Draws for one plant: a drawn plant may be unstable.
const TRIES: u64 = 20;

pub(crate) struct Ensemble<'a> {
    pub(crate) plant: &'a DesignPlant,
    pub(crate) options: &'a DesignOptions,
    pub(crate) robust: RobustOptions,
    /// About how long a response takes, s.
    pub(crate) scale: f64,
}

/// A plant of the ensemble, and whether it is a drawn one at the nominal latency and speed.
pub(crate) struct Member {
    pub(crate) scenario: Scenario,
    pub(crate) at_nominal: bool,
}

impl<'a> Ensemble<'a> {
    /// The ensemble of the options; `None` for a design on the nominal plant alone.
    pub(crate) fn new(
        plant: &'a DesignPlant,
        options: &'a DesignOptions,
        objective: &Objective,
    ) -> Option<Self> {
        options.robust.map(|robust| Ensemble { plant, options, robust, scale: objective.scale })
    }
}

impl Ensemble<'_> {
    /// Lowest and highest delay of the loop beyond the plant's own, s.
    pub(crate) fn delays(&self) -> [f64; 2] {
        let (delay, spread) = (self.options.loop_delay_s, self.robust.latency_s);
        // Without + 0.0 the lowest would be −0 for a plant without delay.
        [(delay - spread).max(-self.plant.input_delay) + 0.0, delay + spread]
    }

    /// Lowest and highest speed, m/s, where the model holds at others than its own.
    pub(crate) fn speeds(&self) -> Option<[f64; 2]> {
        let scheduled = self.plant.is_speed_scheduled() && self.robust.speed_share > 0.0;
        let share = self.robust.speed_share;
        if scheduled {
            Some([1.0 - share, 1.0 + share].map(|s| s * self.plant.speed))
        } else {
            None
        }
    }

    /// A plant with a delay of the loop, s; `None` where it cannot be sampled.
    pub(crate) fn scenario(&self, plant: &DesignPlant, delay: f64) -> Option<Scenario> {
        Scenario::new(plant, self.options.sample_time_s, delay, self.scale).ok()
    }

    /// `count` plants drawn, and the nominal one with other gains, at all latencies and speeds.
    pub(crate) fn draw(&self, stream: u64, count: usize) -> Vec<Member> {
        let nominal = self.options.loop_delay_s;
        let mut delays = self.delays().to_vec();
        delays.retain(|d| (d - nominal).abs() > 1e-9);
        let mut all = Vec::new();
        let mut push = |plant: &DesignPlant, delay: f64, at_nominal: bool| {
            all.extend(self.scenario(plant, delay).map(|s| Member { scenario: s, at_nominal }));
        };
        for delay in &delays {
            push(self.plant, *delay, false);
        }
        for (k, drawn) in self.plants(stream, count).iter().enumerate() {
            push(drawn, nominal, true);
            if k % AT_NOMINAL == 0 {
                delays.iter().for_each(|delay| push(drawn, *delay, false));
            }
        }
        for gain in self.robust.gain.into_iter().filter(|g| *g != 1.0) {
            push(&self.plant.with_gain(gain), nominal, false);
        }
        for speed in self.speeds().into_iter().flatten() {
            let Ok(plant) = self.plant.at_speed(speed) else { continue };
            push(&plant, nominal, false);
            delays.iter().for_each(|delay| push(&plant, *delay, false));
        }
        all
    }

    fn plants(&self, stream: u64, count: usize) -> Vec<DesignPlant> {
        let n = self.plant.ensemble_dimension() as u64;
        if n == 0 {
            return Vec::new();
        }
        // Streams of one seed are disjoint: a plant uses at most TRIES · n numbers of its own.
        let seed = (self.options.seed % (1 << 30)) as i32;
        let first = |k: u64| ((stream << 32) + k * TRIES) * n;
        (0..count as u64)
            .filter_map(|k| {
                (0..TRIES).find_map(|t| {
                    let from = first(k) + t * n;
                    let xi: Vec<f64> = (from..from + n).map(|i| gaussian(seed, i)).collect();
                    self.plant.member(&xi)
                })
            })
            .collect()
    }
}
