//! An interior-point method for the speed profile.
//!
//! The time plus −μ·Σ ln c of all conditions is decreased by Newton's method for a falling sequence of μ, with estimates of
//! the multipliers in its matrix (primal–dual, as in Wächter and Biegler, *On the implementation of an interior-point filter
//! line-search algorithm*, 2006, without slack variables). Every iterate keeps all conditions. The matrix is pentadiagonal,
//! so an iteration takes a time in proportion to the length of the path.

use crate::Error;
use crate::profile::banded::Pentadiagonal;
use crate::profile::problem::{Form, Problem};

/// The sum of all products of condition and multiplier, over the time, at which the search ends.
const ACCURACY: f64 = 1e-5;
/// Factor of μ from one sequence of steps to the next.
const REDUCTION: f64 = 0.1;
/// A sequence ends where Newton's method promises less than this share of the sum of products.
const CENTRED: f64 = 0.05;
/// Share of the way to the nearest bound that a step goes at most.
const TO_BOUND: f64 = 0.99;
/// Most factors between a multiplier and μ/c.
const SPREAD: f64 = 1e8;
/// Share of the promised decrease that a step must keep.
const SUFFICIENT: f64 = 1e-4;
/// Most steps of Newton's method.
const MOST_STEPS: usize = 600;
/// What a shortfall of a stated end speed by its whole square costs, s: more than it can save.
const SHORTFALL_COST: f64 = 30.0;
/// Slack of all conditions at the beginning.
const FIRST_SLACK: f64 = 0.2;

/// The unknowns of the time-optimal profile.
pub(super) fn solve(problem: &Problem<'_>) -> Result<Vec<f64>, Error> {
    let mut x = start(problem)?;
    let mut conditions = Vec::new();
    values(problem, &x, &mut conditions);
    let count = conditions.len() as f64;
    let mut barrier = 0.1 * objective(problem, &x) / count;
    let mut multipliers: Vec<f64> = conditions.iter().map(|c| barrier / c).collect();
    for _ in 0..MOST_STEPS {
        let system = System::new(problem, &x, barrier, &multipliers);
        let direction = system.direction()?;
        let promised = -dot(&system.gradient, &direction);
        if promised <= CENTRED * barrier * count {
            if barrier * count <= ACCURACY * objective(problem, &x) {
                return Ok(x);
            }
            barrier *= REDUCTION;
            continue;
        }
        x = step(problem, &x, &direction, promised, barrier, &mut multipliers)?;
    }
    Err(Error::ProfileNotConverged { steps: MOST_STEPS })
}

/// A low constant speed, so low that all conditions have slack.
fn start(problem: &Problem<'_>) -> Result<Vec<f64>, Error> {
    let mut all = Vec::new();
    let mut level = 1e4;
    for _ in 0..200 {
        let x = vec![level; problem.unknowns];
        values(problem, &x, &mut all);
        // The last conditions are x > 0, which the level itself meets.
        all.truncate(all.len() - problem.unknowns);
        if all.iter().all(|value| *value >= FIRST_SLACK) {
            return Ok(x);
        }
        level *= 0.5;
    }
    Err(Error::ProfileNotConverged { steps: 0 })
}

fn values(problem: &Problem<'_>, x: &[f64], all: &mut Vec<f64>) {
    all.clear();
    problem.visit(x, |condition| all.push(condition.value));
}

/// The time, s, and what the shortfall of stated end speeds costs.
fn objective(problem: &Problem<'_>, x: &[f64]) -> f64 {
    let roots: Vec<f64> =
        problem.nodes.iter().map(|node| node.z.value(x).max(0.0).sqrt()).collect();
    let mut time = 0.0;
    for (k, length) in problem.lengths().enumerate() {
        time += 2.0 * length / (roots[k] + roots[problem.next(k)]);
    }
    for (length, node) in problem.rest_intervals() {
        time += 3.0 * length / roots[node];
    }
    for (node, square) in problem.stated_ends() {
        time += SHORTFALL_COST * (1.0 - roots[node] * roots[node] / square);
    }
    time
}

/// Gradient and matrix of Newton's method at a point.
struct System {
    gradient: Vec<f64>,
    matrix: Pentadiagonal,
}

impl System {
    fn new(problem: &Problem<'_>, x: &[f64], barrier: f64, multipliers: &[f64]) -> Self {
        let mut system = Self {
            gradient: vec![0.0; x.len()],
            matrix: Pentadiagonal::zeros(x.len(), problem.is_ring()),
        };
        system.add_time(problem, x);
        let mut index = 0;
        problem.visit(x, |condition| {
            let multiplier = multipliers[index];
            index += 1;
            let c = condition.value;
            let [first, second] = condition.forms;
            let whole = combined(first, condition.gradient[0], second, condition.gradient[1]);
            system.add(&whole, -barrier / c, multiplier / c);
            for (form, curvature) in condition.forms.into_iter().zip(condition.curvature) {
                if curvature > 0.0 {
                    system.add(form, 0.0, multiplier * curvature);
                }
            }
        });
        system
    }

    /// Time and end speeds.
    fn add_time(&mut self, problem: &Problem<'_>, x: &[f64]) {
        for (k, length) in problem.lengths().enumerate() {
            let forms = [&problem.nodes[k].z, &problem.nodes[problem.next(k)].z];
            let roots = forms.map(|form| form.value(x).max(f64::MIN_POSITIVE).sqrt());
            let sum = roots[0] + roots[1];
            // Of each root by its z.
            let slopes = roots.map(|root| 0.5 / root);
            let steepness = 2.0 * length / (sum * sum);
            let whole = combined(forms[0], slopes[0], forms[1], slopes[1]);
            self.add(&whole, -steepness, 2.0 * steepness / sum);
            for (form, root) in forms.into_iter().zip(roots) {
                if form.weights != [0.0; 3] {
                    self.add(form, 0.0, steepness * 0.25 / root.powi(3));
                }
            }
        }
        for (length, node) in problem.rest_intervals() {
            let form = &problem.nodes[node].z;
            let root = form.value(x).sqrt();
            let time = 3.0 * length / root;
            self.add(form, -0.5 * time / (root * root), 0.75 * time / root.powi(4));
        }
        for (node, square) in problem.stated_ends() {
            self.add(&problem.nodes[node].z, -SHORTFALL_COST / square, 0.0);
        }
    }

    /// Adds the first and the second derivative by a combination of unknowns.
    fn add(&mut self, form: &Form, first: f64, second: f64) {
        for (j, (at, weight)) in form.at.into_iter().zip(form.weights).enumerate() {
            if weight == 0.0 {
                continue;
            }
            self.gradient[at] += first * weight;
            for (other, by) in form.at.into_iter().zip(form.weights).skip(j) {
                if by != 0.0 {
                    self.matrix.add(at, other, second * weight * by);
                }
            }
        }
    }

    /// Newton's step; a matrix that rounding made indefinite gets a larger diagonal.
    fn direction(&self) -> Result<Vec<f64>, Error> {
        let right: Vec<f64> = self.gradient.iter().map(|g| -g).collect();
        let mut matrix = self.matrix.clone();
        let mut share = 1e-12;
        while share < 1.0 {
            if let Some(direction) = matrix.solve(&right)
                && direction.iter().all(|d| d.is_finite())
            {
                return Ok(direction);
            }
            for row in &mut matrix.entries {
                row[0] *= 1.0 + share;
            }
            share *= 100.0;
        }
        Err(Error::ProfileNotConverged { steps: 0 })
    }
}

/// A step along a direction: to the bounds at most, and so far that time and barrier decrease. The multipliers follow.
fn step(
    problem: &Problem<'_>,
    x: &[f64],
    direction: &[f64],
    promised: f64,
    barrier: f64,
    multipliers: &mut [f64],
) -> Result<Vec<f64>, Error> {
    let (mut old, mut rates) = (Vec::new(), Vec::new());
    let mut size: f64 = 1.0;
    problem.visit(x, |condition| {
        let [first, second] = condition.forms;
        let rate = condition.gradient[0] * first.value(direction)
            + condition.gradient[1] * second.value(direction);
        if rate < 0.0 {
            size = size.min(-TO_BOUND * condition.value / rate);
        }
        old.push(condition.value);
        rates.push(rate);
    });
    let before = merit(objective(problem, x), barrier, &old);
    let mut conditions = Vec::new();
    let (mut next, mut is_found) = (Vec::new(), false);
    for _ in 0..60 {
        next = x.iter().zip(direction).map(|(x, d)| x + size * d).collect();
        values(problem, &next, &mut conditions);
        let is_inside =
            conditions.iter().zip(&old).all(|(c, old)| *c > (1.0 - TO_BOUND) * 0.5 * old);
        if is_inside {
            let after = merit(objective(problem, &next), barrier, &conditions);
            // Near the optimum the decrease is lost in rounding.
            let rounding = 1e-12 * before.abs();
            if after <= before - SUFFICIENT * size * promised + rounding {
                is_found = true;
                break;
            }
        }
        size *= 0.6;
    }
    if !is_found {
        return Err(Error::ProfileNotConverged { steps: 0 });
    }
    // The multipliers go to μ/c − λ·ċ/c, but not to 0.
    let mut dual_size: f64 = 1.0;
    let changes: Vec<f64> = multipliers
        .iter()
        .zip(old.iter().zip(&rates))
        .map(|(multiplier, (c, rate))| barrier / c - multiplier - multiplier * rate / c)
        .collect();
    for (multiplier, change) in multipliers.iter().zip(&changes) {
        if *change < 0.0 {
            dual_size = dual_size.min(-TO_BOUND * multiplier / change);
        }
    }
    for ((multiplier, change), c) in multipliers.iter_mut().zip(&changes).zip(&conditions) {
        let central = barrier / c;
        *multiplier = (*multiplier + dual_size * change).clamp(central / SPREAD, central * SPREAD);
    }
    Ok(next)
}

fn merit(objective: f64, barrier: f64, conditions: &[f64]) -> f64 {
    objective - barrier * conditions.iter().map(|c| c.ln()).sum::<f64>()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// A sum of two combinations, which together have at most three unknowns.
fn combined(first: &Form, by: f64, second: &Form, and: f64) -> Form {
    Form::default().plus(first, by).plus(second, and)
}
