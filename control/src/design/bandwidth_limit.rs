//! The bandwidth limit of a plant: a settling time near the shortest one, by which a search is scaled.
//!
//! The phase of the sampled plant falls to −180° at some ω₁₈₀, and the lead of a controller moves the crossover
//! little beyond; a step settles in about 5 over the crossover. A step r takes `r/(G₀·u_max)` at least.

use crate::plants::sampled::Sampled;
use nalgebra::Complex;
use std::f64::consts::{FRAC_PI_2, PI};

/// Settling time times crossover of a usual loop, rad.
pub(crate) const CROSSOVER_TIMES_SETTLING: f64 = 5.0;
/// Height of the step, rad: only the scale of a search depends on it.
const STEP: f64 = 5.0 / 180.0 * PI;
/// Lowest angle of the grid, rad a sample, and its points.
const LOWEST: f64 = 1e-5;
const POINTS: i32 = 400;
/// Shortest scale, samples, and the longest, s: that of the longest settling time that may be required.
const LEAST_SAMPLES: f64 = 4.0;
const LONGEST: f64 = 60.0;

/// A settling time near the shortest that can be reached, s.
pub(crate) fn settling_scale(plant: &Sampled, gain: f64, max_angle: f64) -> f64 {
    let ts = plant.sample_time;
    let phase_limited = CROSSOVER_TIMES_SETTLING * ts / phase_crossover(plant);
    let angle_limited = STEP / (gain * max_angle);
    phase_limited.max(angle_limited).clamp(LEAST_SAMPLES * ts, LONGEST.max(LEAST_SAMPLES * ts))
}

/// The lowest angle, rad a sample, at which the phase has fallen to −180°; π where it never does.
fn phase_crossover(plant: &Sampled) -> f64 {
    let mut phase = -FRAC_PI_2;
    let mut before: Option<Complex<f64>> = None;
    for i in 0..POINTS {
        let angle = LOWEST * (PI / LOWEST).powf(f64::from(i) / f64::from(POINTS - 1));
        let response = plant.response(Complex::from_polar(1.0, angle));
        if let Some(before) = before {
            phase += (response * before.conj()).arg();
        }
        if phase <= -PI {
            return angle;
        }
        before = Some(response);
    }
    PI
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plants::design_plant::DesignPlant;

    fn lag(gain: f64, tau: f64, delay: f64) -> Sampled {
        let plant =
            DesignPlant::from_matrices(&[-1.0 / tau], &[gain / tau], &[1.0], 0.0, delay).unwrap();
        Sampled::new(&plant, 0.001, 0.0).unwrap()
    }

    /// 1/(s(τs + 1))·e^{−Ls}: −180° where ω·(L + T/2) + atan(ωτ) = 90°.
    #[test]
    fn the_phase_crossover_is_that_of_lag_and_delay() {
        for (tau, delay) in [(0.1, 0.05), (0.5, 0.01), (0.02, 0.2)] {
            let w = phase_crossover(&lag(4.0, tau, delay)) / 0.001;
            let fallen = w * (delay + 0.0005) + (w * tau).atan();
            assert!((fallen - FRAC_PI_2).abs() < 0.06, "{fallen}");
        }
    }

    #[test]
    fn a_small_steering_angle_limits_the_bandwidth() {
        let plant = lag(4.0, 0.1, 0.0);
        let free = settling_scale(&plant, 4.0, 1.0);
        assert!((settling_scale(&plant, 4.0, 0.005) - STEP / 0.02).abs() < 1e-9);
        assert!(free < 1.0, "{free}");
    }
}
