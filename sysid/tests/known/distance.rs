//! Distances between models that do not depend on the basis of the state.

use steerwright_sysid::StateSpace;

/// Largest distance between two sets of poles, each matched to its nearest; infinite where a model
/// is not finite or their orders differ.
#[must_use]
pub fn pole_distance(a: &StateSpace, b: &StateSpace) -> f64 {
    let (Ok(poles), Ok(mut left)) = (a.poles(), b.poles()) else {
        return f64::INFINITY;
    };
    if poles.len() != left.len() {
        return f64::INFINITY;
    }
    let mut worst: f64 = 0.0;
    for (re, im) in poles {
        let nearest = left
            .iter()
            .map(|(r, i)| (r - re).hypot(i - im))
            .enumerate()
            .min_by(|x, y| x.1.total_cmp(&y.1));
        let Some((k, distance)) = nearest else { break };
        left.swap_remove(k);
        worst = worst.max(distance);
    }
    worst
}

/// Largest difference of Markov parameters over the largest of `a`'s.
#[must_use]
pub fn markov_distance(a: &StateSpace, b: &StateSpace, count: usize) -> f64 {
    let (a, b) = (a.markov_parameters(count), b.markov_parameters(count));
    let size = a.iter().map(|m| m.norm_max()).fold(0.0, f64::max);
    a.iter().zip(&b).map(|(x, y)| (x - y).norm_max()).fold(0.0, f64::max) / size
}

/// Largest relative difference of the frequency responses (first input and output).
#[must_use]
pub fn response_distance(a: &StateSpace, b: &StateSpace) -> f64 {
    let (mut worst, mut size): (f64, f64) = (0.0, 0.0);
    for k in 0..200 {
        let omega = std::f64::consts::PI * f64::from(k) / 200.0;
        let (x, y) = (a.frequency_response(0, 0, omega), b.frequency_response(0, 0, omega));
        worst = worst.max((x.0 - y.0).hypot(x.1 - y.1));
        size = size.max(x.0.hypot(x.1));
    }
    worst / size
}
