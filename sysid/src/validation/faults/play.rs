//! Play (lash) of the steering, from the data, and the limit cycle that it causes
//! (docs/methods/validation.md).
//!
//! With play of width w the road wheels follow the recorded angle δ by `δ_w(t) = min(max(δ_w(t−1),
//! δ(t) − w/2), δ(t) + w/2)`; the width with which a reference bicycle leaves the least of the yaw rate is the
//! estimate, with a jackknife over blocks of time. A loop L, a PI controller on the yaw angle with its crossover
//! at [`CROSSOVER_RADPS`], oscillates where N(A) L(jω) = −1 with the describing function N of play
//! of half-width b (Slotine and Li, *Applied Nonlinear Control*, 1991, section 5.2.3), `N = ¹⁄_π
//! (π/2 − asin c − c √(1 − c²)) + j (4b/πA)(b/A − 1)`, `c = 2b/A − 1`.

use crate::structures::bicycle::reference::{BLOCKS, Delay, Fitted, Reference};
use crate::validation::residuals::pairs::jackknife;
use std::f64::consts::{FRAC_PI_2, PI};
use steerwright_formats::{LimitCycle, SteeringPlay};

/// Widths tried, in standard deviations of the steering: beyond two of them the vehicle hardly turns.
const WIDTHS: [f64; 15] =
    [0.0, 0.025, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.25, 1.5, 2.0];
/// Those that are tried first.
const COARSE_WIDTHS: [f64; 5] = [0.05, 0.15, 0.4, 0.8, 1.5];
/// Play is reported beyond that many standard errors …
const SIGNIFICANT: f64 = 3.5;
/// … and with that share of what a bicycle leaves; a driver's answers have 0.01 …
const EXPLAINED: f64 = 0.015;
/// … and of the yaw rate: play of a tenth of the steering's deviation explains a hundred times as much.
const EXPLAINED_OF_ALL: f64 = 1e-5;
/// Crossover of a typical yaw loop, rad/s: four time constants are a second.
const CROSSOVER_RADPS: f64 = 4.0;
/// Its integral action begins at that share of the crossover.
const INTEGRAL_SHARE: f64 = 0.2;

/// Width of the play with its standard error, in standard deviations of the steering; `None` where the data show none.
pub(crate) fn play(reference: &Reference<'_>, recorded: &Fitted) -> Option<(f64, f64)> {
    let of_all = EXPLAINED_OF_ALL * reference.variation();
    let linear = recorded.left();
    let explains = |left: f64| linear - left > (EXPLAINED * linear).max(of_all);
    let behind = |width: f64, from: &Fitted| {
        reference.changed(&|u| behind_play(u, width), Delay::Free, from)
    };
    // A few widths show whether there is any play.
    let mut shows = false;
    for width in COARSE_WIDTHS {
        shows = explains(reference.left_by(&|u| behind_play(u, width), recorded)?);
        if shows {
            break;
        }
    }
    if !shows {
        return None;
    }
    let mut tried: Vec<(f64, Fitted)> = Vec::new();
    for width in &WIDTHS[1..] {
        let from = tried.last().map_or(recorded, |(_, fit)| fit);
        let next = behind(*width, from)?;
        tried.push((*width, next));
    }
    // Between the best and its neighbours once more.
    let widths: Vec<f64> = std::iter::once(0.0).chain(tried.iter().map(|(w, _)| *w)).collect();
    let left = |of: &dyn Fn(&Fitted) -> f64, tried: &[(f64, Fitted)]| -> Vec<f64> {
        std::iter::once(of(recorded)).chain(tried.iter().map(|(_, fit)| of(fit))).collect()
    };
    let best = least(&left(&Fitted::left, &tried));
    if !explains(left(&Fitted::left, &tried)[best]) {
        return None;
    }
    for neighbour in [best.saturating_sub(1), (best + 1).min(widths.len() - 1)] {
        if neighbour != best {
            let width = 0.5 * (widths[best] + widths[neighbour]);
            let next = behind(width, &tried[best - 1].1)?;
            tried.push((width, next));
        }
    }
    tried.sort_by(|a, b| a.0.total_cmp(&b.0));
    let widths: Vec<f64> = std::iter::once(0.0).chain(tried.iter().map(|(w, _)| *w)).collect();
    let width = |of: &dyn Fn(&Fitted) -> f64| {
        let left = left(of, &tried);
        vertex(&widths, &left, least(&left))
    };
    let found = width(&Fitted::left);
    let without: Vec<f64> = (0..BLOCKS).map(|b| width(&|f| f.left_without(b))).collect();
    // No finer than the widths tried are apart.
    let error = jackknife(&without).max(0.02 * found);
    if found <= SIGNIFICANT * error {
        return None;
    }
    // What happens between the samples makes the play no less certain, but its width.
    Some((found, error.hypot(reference.width_between_samples())))
}

/// Where the least of some values is.
fn least(of: &[f64]) -> usize {
    (0..of.len()).min_by(|a, b| of[*a].total_cmp(&of[*b])).unwrap_or_default()
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

/// Play at the road wheel, with its limit cycle about a plant with the response `plant(ω)`, ω in rad/s.
pub(crate) fn steering_play(
    (road_wheel_rad, standard_error_rad): (f64, f64),
    plant: &dyn Fn(f64) -> (f64, f64),
) -> SteeringPlay {
    let limit_cycle = limit_cycle(0.5 * road_wheel_rad, plant);
    SteeringPlay { road_wheel_rad, standard_error_rad, limit_cycle }
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
    use crate::validation::residuals::correlation::tests::noise;
    use crate::validation::residuals::pairs::Pair;

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
            let reference = Reference::new(&segments, step).unwrap();
            let recorded = reference.recorded().unwrap();
            let found = play(&reference, &recorded)
                .map(|(width, error)| (width * reference.unit, error * reference.unit));
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
