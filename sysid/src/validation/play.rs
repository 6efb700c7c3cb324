//! Play (lash) of the steering, from the data, and the limit cycle that it causes
//! (docs/methods/validation.md).
//!
//! With play of width w the road wheels follow the recorded angle δ by `δ_w(t) = min(max(δ_w(t−1),
//! δ(t) − w/2), δ(t) + w/2)`; the width that leaves the least of the yaw rate is the estimate, with
//! a jackknife over blocks of time. A loop L, a PI controller on the yaw angle with its crossover
//! at [`CROSSOVER_RADPS`], oscillates where N(A) L(jω) = −1 with the describing function N of play
//! of half-width b (Slotine and Li, *Applied Nonlinear Control*, 1991, section 5.2.3), `N = ¹⁄_π
//! (π/2 − asin c − c √(1 − c²)) + j (4b/πA)(b/A − 1)`, `c = 2b/A − 1`.

use crate::validation::regression::{BLOCKS, Pair, Sums, jackknife};
use std::f64::consts::{FRAC_PI_2, PI};
use steerwright_formats::{LimitCycle, SteeringPlay};

/// Widths tried, in standard deviations of the steering: beyond two of them the vehicle hardly turns.
const WIDTHS: [f64; 15] =
    [0.0, 0.025, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.25, 1.5, 2.0];
/// Pole of the functions, rad/s: the yaw rate of road vehicles answers within 0.1 to 0.3 s.
const POLE_RADPS: f64 = 8.0;
/// Play is reported beyond that many standard errors …
const SIGNIFICANT: f64 = 3.5;
/// … and with that share of what a linear response leaves; a driver's answers have 0.01.
const EXPLAINED: f64 = 0.015;
/// Crossover of a typical yaw loop, rad/s: four time constants are a second.
const CROSSOVER_RADPS: f64 = 4.0;
/// Its integral action begins at that share of the crossover.
const INTEGRAL_SHARE: f64 = 0.2;

/// Play in the units of the steering of `segments`; `None` where the data show none.
fn play(segments: &[Pair<'_>], sample_time_s: f64) -> Option<(f64, f64)> {
    let all: Vec<f64> = segments.iter().flat_map(|s| s.steering.iter().copied()).collect();
    let unit = steerwright_drivelog::signal::standard_deviation(&all);
    if unit.is_nan() || unit <= 0.0 {
        return None;
    }
    let sums: Vec<Sums> = WIDTHS
        .iter()
        .map(|w| {
            let change = |u: &[f64]| behind_play(u, w * unit);
            Sums::new(segments, sample_time_s, POLE_RADPS, 0, &change)
        })
        .collect();
    let least = |without: Option<usize>| -> Option<(f64, f64, f64)> {
        let left: Option<Vec<f64>> = sums.iter().map(|s| s.left(without)).collect();
        let left = left?;
        let best = (0..left.len()).min_by(|a, b| left[*a].total_cmp(&left[*b]))?;
        Some((vertex(&WIDTHS, &left, best), left[0], left[best]))
    };
    let (width, linear, left) = least(None)?;
    if left.is_nan() || left >= (1.0 - EXPLAINED) * linear {
        return None;
    }
    let without: Option<Vec<f64>> = (0..BLOCKS).map(|b| Some(least(Some(b))?.0)).collect();
    // No finer than the widths tried are apart.
    let error = jackknife(&without?).max(0.02 * width);
    (width > SIGNIFICANT * error).then_some((width * unit, error * unit))
}

fn behind_play(u: &[f64], width: f64) -> Vec<f64> {
    let half = 0.5 * width;
    let mut at = u.first().copied().unwrap_or(0.0);
    u.iter()
        .map(|u| {
            at = at.clamp(u - half, u + half);
            at
        })
        .collect()
}

/// Where the parabola through a least value and its neighbours is least.
fn vertex(x: &[f64], y: &[f64], i: usize) -> f64 {
    if i == 0 || i + 1 == x.len() {
        return x[i];
    }
    let (a, b, c) = (x[i - 1], x[i], x[i + 1]);
    let (below, above) = ((y[i] - y[i - 1]) / (b - a), (y[i + 1] - y[i]) / (c - b));
    let bend = (above - below) / (c - a);
    if bend > 0.0 { (0.5 * (a + b) - 0.5 * below / bend).clamp(a, c) } else { b }
}

/// Play at the road wheel, with its limit cycle about a plant with the response `plant(ω)`, ω in
/// rad/s.
pub(crate) fn steering_play(
    segments: &[Pair<'_>],
    sample_time_s: f64,
    steering_ratio: f64,
    plant: &dyn Fn(f64) -> (f64, f64),
) -> Option<SteeringPlay> {
    let (width, error) = play(segments, sample_time_s)?;
    let road_wheel_rad = width / steering_ratio;
    Some(SteeringPlay {
        road_wheel_rad,
        standard_error_rad: error / steering_ratio,
        limit_cycle: limit_cycle(0.5 * road_wheel_rad, plant),
    })
}

/// The describing function of play at amplitude `a` half-widths, a > 1.
fn describing_function(a: f64) -> (f64, f64) {
    let c = 2.0 / a - 1.0;
    let re = (FRAC_PI_2 - c.asin() - c * (1.0 - c * c).max(0.0).sqrt()) / PI;
    (re, 4.0 / (PI * a) * (1.0 / a - 1.0))
}

/// The largest limit cycle of the typical loop, for play of half-width `half` rad.
fn limit_cycle(half: f64, plant: &dyn Fn(f64) -> (f64, f64)) -> Option<LimitCycle> {
    let open = |omega: f64, gain: f64| -> (f64, f64) {
        // k (1 + ω_i/(jω)) G/(jω)
        let (re, im) = plant(omega);
        let i = INTEGRAL_SHARE * CROSSOVER_RADPS / omega;
        let (re, im) = (re + i * im, im - i * re);
        (gain * im / omega, -gain * re / omega)
    };
    let (re, im) = open(CROSSOVER_RADPS, 1.0);
    let gain = 1.0 / re.hypot(im);
    // −1/L = N at that frequency: the amplitude by the phase, and what is left by the magnitude.
    let amplitude = |omega: f64| -> Option<(f64, f64)> {
        let (re, im) = open(omega, gain);
        let square = re * re + im * im;
        let wanted = (-re / square, im / square);
        let phase = wanted.1.atan2(wanted.0);
        if !(phase > -FRAC_PI_2 && phase < 0.0) {
            return None;
        }
        // The phase rises with the amplitude from −90° to 0.
        let (mut low, mut high) = (1.0 + 1e-9, 1e6);
        for _ in 0..100 {
            let middle = f64::sqrt(low * high);
            let n = describing_function(middle);
            if n.1.atan2(n.0) < phase { low = middle } else { high = middle }
        }
        let n = describing_function(low);
        Some((low, n.0.hypot(n.1) / wanted.0.hypot(wanted.1) - 1.0))
    };
    const STEPS: usize = 400;
    let frequency = |k: usize| CROSSOVER_RADPS * 10_f64.powf(2.0 * k as f64 / STEPS as f64 - 1.5);
    let mut found: Option<(f64, f64)> = None;
    let mut before: Option<f64> = None;
    for k in 0..=STEPS {
        let here = amplitude(frequency(k));
        if let (Some((a, rest)), Some(last)) = (here, before)
            && rest * last <= 0.0
            && found.is_none_or(|(most, _)| a > most)
        {
            found = Some((a, frequency(k)));
        }
        before = here.map(|h| h.1);
    }
    let (a, omega) = found?;
    let n = describing_function(a);
    let (re, im) = plant(omega);
    Some(LimitCycle {
        road_wheel_rad: a * half,
        yaw_rad: n.0.hypot(n.1) * a * half * re.hypot(im) / omega,
        period_s: 2.0 * PI / omega,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::validation::correlation::tests::noise;

    /// A first-order vehicle, 5/(1 + 0.15 s).
    fn plant(omega: f64) -> (f64, f64) {
        let d = 1.0 + (0.15 * omega).powi(2);
        (5.0 / d, -5.0 * 0.15 * omega / d)
    }

    /// The describing function against the loop simulated in time.
    #[test]
    fn the_limit_cycle_is_that_of_a_simulation() {
        let half = 0.25_f64.to_radians();
        let expected = limit_cycle(half, &plant).unwrap();
        let (re, im) = plant(CROSSOVER_RADPS);
        let i = INTEGRAL_SHARE * CROSSOVER_RADPS;
        let gain =
            CROSSOVER_RADPS / (re.hypot(im) * (1.0 + INTEGRAL_SHARE * INTEGRAL_SHARE).sqrt());
        let h = 1e-4;
        let (mut rate, mut yaw, mut integral, mut wheel) = (0.0, 0.05, 0.0, 0.0_f64);
        let (mut largest, mut crossings, mut last) = ((0.0_f64, 0.0_f64), Vec::new(), 0.0);
        for k in 0..1_200_000 {
            let steering = -gain * (yaw + i * integral);
            wheel = wheel.clamp(steering - half, steering + half);
            rate += h * (5.0 * wheel - rate) / 0.15;
            yaw += h * rate;
            integral += h * yaw;
            if k > 600_000 {
                largest = (largest.0.max(steering.abs()), largest.1.max(yaw.abs()));
                if last < 0.0 && yaw >= 0.0 {
                    crossings.push(f64::from(k) * h);
                }
            }
            last = yaw;
        }
        let period = (crossings[crossings.len() - 1] - crossings[0]) / (crossings.len() - 1) as f64;
        println!("{expected:?} simulated {largest:?} {period}");
        assert!((expected.road_wheel_rad / largest.0 - 1.0).abs() < 0.2);
        assert!((expected.yaw_rad / largest.1 - 1.0).abs() < 0.2);
        assert!((expected.period_s / period - 1.0).abs() < 0.2);
    }

    #[test]
    fn play_is_estimated_and_none_is_made_up() {
        let (mut seed, n, step) = (7, 3000, 0.04);
        let mut smooth = [0.0; 2];
        let steering: Vec<f64> = (0..n)
            .map(|_| {
                smooth[0] += 0.2 * (noise(&mut seed) - smooth[0]);
                smooth[1] += 0.2 * (smooth[0] - smooth[1]);
                0.06 * smooth[1]
            })
            .collect();
        for degrees in [0.0_f64, 0.13, 0.5] {
            let wheel = behind_play(&steering, degrees.to_radians());
            let mut x = [0.0; 2];
            let yaw_rate: Vec<f64> = wheel
                .iter()
                .map(|u| {
                    // ω 8 rad/s, damping 0.7
                    let y = x[0];
                    for _ in 0..10 {
                        x[0] += 0.1 * step * x[1];
                        x[1] += 0.1 * step * (64.0 * (5.0 * u - x[0]) - 11.2 * x[1]);
                    }
                    y + 2e-3 * noise(&mut seed)
                })
                .collect();
            let segments = [Pair { steering: &steering, yaw_rate: &yaw_rate, speed: None }];
            let found = play(&segments, step);
            println!("{degrees}: {found:?}");
            match found {
                None => assert_eq!(degrees, 0.0),
                Some((width, error)) => {
                    assert!(degrees > 0.0);
                    let off = (width.to_degrees() - degrees).abs();
                    assert!(off < 0.1 * degrees + 3.0 * error.to_degrees(), "{off}");
                }
            }
        }
    }
}
