//! The level that a signal moves about.
//!
//! Input and output are taken relative to their means, as if the mean output were the gain times the
//! mean input. It is not: what was driven before the record still rings in it, and what is driven at
//! its end does not show any more. The difference is a constant in the simulation errors, of the size
//! of (memory of the system)/(length of the record), which the estimate takes for a very slow mode.
//! Means weighted by a window that begins and ends at zero with zero slope (Hann's) lose nothing at
//! the ends, and the constant falls with the 1.5th power of the record's length (R. Pintelon,
//! J. Schoukens, *System Identification: A Frequency Domain Approach*, 2012, section 2.2.3, on leakage
//! at the frequency 0).

/// Mean of all stretches, each weighted by a Hann window of its length.
pub(crate) fn level<'a>(stretches: impl Iterator<Item = &'a [f64]>) -> f64 {
    let (mut sum, mut total) = (0.0, 0.0);
    for stretch in stretches {
        for (t, x) in stretch.iter().enumerate() {
            let phase = std::f64::consts::PI * (t as f64 + 0.5) / stretch.len() as f64;
            let weight = phase.sin().powi(2);
            sum += weight * x;
            total += weight;
        }
    }
    if total > 0.0 { sum / total } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_a_constant_and_of_a_slow_response() {
        assert!((level([[3.0; 10].as_slice(), &[3.0; 5]].into_iter()) - 3.0).abs() < 1e-14);
        // y⁺ = 0.95 y + 0.05 u from a state that the input before the record left.
        let u: Vec<f64> = (0..2000).map(|t| (f64::from(t) * 0.37).sin() + 0.5).collect();
        let mut y = vec![4.0];
        for (t, u) in u.iter().enumerate().skip(1) {
            y.push(0.95 * y[t - 1] + 0.05 * u);
        }
        let off = |mean: fn(&[f64]) -> f64| (mean(&y) - mean(&u)).abs();
        let (plain, tapered) = (off(drivelog::signal::mean), off(|x| level(std::iter::once(x))));
        assert!(plain > 0.02 && tapered < 0.05 * plain, "{plain} {tapered}");
    }
}
