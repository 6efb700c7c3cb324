//! The descent of Nelder and Mead (1965), reproducible.
//!
//! A candidate replaces a point only where it is better, so the evaluation of a cost may end once it
//! exceeds that of the point. The descent of argmin evaluates every cost to its end, which doubles the time
//! of a design.

/// Sample standard deviation of a simplex's costs below which it has converged.
const CONVERGED: f64 = 1e-6;
/// Factors of reflection, expansion, contraction and shrinkage.
const REFLECT: f64 = 1.0;
const EXPAND: f64 = 2.0;
const CONTRACT: f64 = 0.5;
const SHRINK: f64 = 0.5;

/// The best point after at most some iterations, with its cost, from a simplex of this size at `start`
/// along the axes. `cost` takes a point and a cost from which on it need not be exact.
pub(crate) fn descend(
    cost: &impl Fn(&[f64], f64) -> f64,
    start: &[f64],
    size: f64,
    iterations: u64,
) -> (Vec<f64>, f64) {
    let exact = |x: Vec<f64>| {
        let c = cost(&x, f64::INFINITY);
        (x, c)
    };
    let mut all = vec![exact(start.to_vec())];
    for i in 0..start.len() {
        let mut vertex = start.to_vec();
        vertex[i] += size;
        all.push(exact(vertex));
    }
    // A stable sort: equal costs keep their order.
    all.sort_by(|a, b| a.1.total_cmp(&b.1));
    let worst = start.len();
    for _ in 0..iterations {
        if worst == 0 || spread(&all) < CONVERGED {
            break;
        }
        let centre = centroid(&all[..worst]);
        let below = all[worst].1;
        let reflected = towards(&centre, &all[worst].0, -REFLECT);
        let now = cost(&reflected, below);
        let next = if now < all[0].1 {
            let expanded = towards(&centre, &reflected, EXPAND);
            let further = cost(&expanded, now);
            Some(if further < now { (expanded, further) } else { (reflected, now) })
        } else if now < all[worst - 1].1 {
            Some((reflected, now))
        } else if now < below {
            let outside = towards(&centre, &reflected, CONTRACT);
            let nearer = cost(&outside, now);
            if nearer <= now { Some((outside, nearer)) } else { None }
        } else {
            let inside = towards(&centre, &all[worst].0, CONTRACT);
            let nearer = cost(&inside, below);
            if nearer < below { Some((inside, nearer)) } else { None }
        };
        match next {
            Some(next) => all[worst] = next,
            None => {
                for k in 1..=worst {
                    all[k] = exact(towards(&all[0].0, &all[k].0, SHRINK));
                }
            }
        }
        all.sort_by(|a, b| a.1.total_cmp(&b.1));
    }
    all.swap_remove(0)
}

/// `from + factor·(to − from)`.
fn towards(from: &[f64], to: &[f64], factor: f64) -> Vec<f64> {
    from.iter().zip(to).map(|(a, b)| a + (b - a) * factor).collect()
}

fn centroid(points: &[(Vec<f64>, f64)]) -> Vec<f64> {
    let mut sum = points[0].0.clone();
    for (point, _) in &points[1..] {
        sum.iter_mut().zip(point).for_each(|(s, x)| *s += x);
    }
    let share = 1.0 / points.len() as f64;
    sum.iter_mut().for_each(|s| *s *= share);
    sum
}

fn spread(points: &[(Vec<f64>, f64)]) -> f64 {
    let n = points.len() as f64;
    let mean = points.iter().map(|(_, c)| c).sum::<f64>() / n;
    let squares = points.iter().map(|(_, c)| (c - mean).powi(2)).sum::<f64>();
    (1.0 / (n - 1.0) * squares).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use argmin::core::{CostFunction, Executor, State};
    use argmin::solver::neldermead::NelderMead;
    use std::cell::Cell;

    /// Rosenbrock's function in three dimensions, with a discontinuity.
    fn valley(x: &[f64]) -> f64 {
        let step = |a: f64, b: f64| (1.0 - a).powi(2) + 100.0 * (b - a * a).powi(2);
        step(x[0], x[1]) + step(x[1], x[2]) + if x[0] > 0.5 { 0.0 } else { 0.3 }
    }

    struct Valley;

    impl CostFunction for Valley {
        type Param = Vec<f64>;
        type Output = f64;

        fn cost(&self, x: &Self::Param) -> Result<f64, argmin::core::Error> {
            Ok(valley(x))
        }
    }

    /// The result of an independent implementation, which must be the same to the bit.
    fn of_argmin(start: &[f64], size: f64, iterations: u64) -> (Vec<f64>, f64) {
        let mut simplex = vec![start.to_vec(); start.len() + 1];
        (0..start.len()).for_each(|i| simplex[i + 1][i] += size);
        let solver = NelderMead::new(simplex).with_sd_tolerance(CONVERGED).unwrap();
        let run = Executor::new(Valley, solver).configure(|s| s.max_iters(iterations));
        let result = run.timer(false).run().unwrap();
        (result.state().get_best_param().unwrap().clone(), result.state().get_best_cost())
    }

    #[test]
    fn equals_another_implementation_with_and_without_early_ends() {
        let spared = Cell::new(0);
        let early = |x: &[f64], most: f64| {
            let all = valley(x);
            if all > most {
                spared.set(spared.get() + 1);
                return f64::INFINITY;
            }
            all
        };
        for start in [[-1.2, 1.0, 0.3], [3.0, -2.0, 2.0], [0.0, 0.0, 0.0], [0.4, 0.2, -5.0]] {
            for (size, iterations) in [(0.4, 7), (0.4, 120), (0.12, 250), (2.0, 1000)] {
                let expected = of_argmin(&start, size, iterations);
                let plain = descend(&|x, _| valley(x), &start, size, iterations);
                assert_eq!(plain, expected);
                assert_eq!(descend(&early, &start, size, iterations), expected);
            }
        }
        assert!(spared.get() > 100, "{}", spared.get());
        let (x, least) = descend(&early, &[3.0, -2.0, 2.0], 0.4, 1000);
        assert!(least < 1e-5 && x.iter().all(|x| (x - 1.0).abs() < 0.01), "{x:?} {least}");
    }

    #[test]
    fn a_point_without_coordinates_is_the_best_there_is() {
        assert_eq!(descend(&|_, _| 3.0, &[], 0.4, 10), (vec![], 3.0));
    }
}
