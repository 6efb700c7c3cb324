//! Standard errors that hold for errors of any autocorrelation, by the [sandwich](crate::linalg::sandwich) of the scores
//! `J_t·e_t` of each second.
//!
//! A few seconds near the limit of grip may determine most of a parameter; the fit then follows the errors
//! of these seconds, which become smaller than they were. The sandwich enlarges the scores of each second for that.

use crate::Error;
use crate::linalg::sandwich::{ScoreBin, andrews_lags, sandwich};
use crate::structures::single_track::parameters::COUNT;
use crate::structures::single_track::problem::{Densities, OUTPUTS, Point, Problem};
use crate::structures::single_track::simulate::SimulationRun;
use faer::Mat;

/// Covariance of the coordinates; zero for those that are fixed.
pub(super) type Covariance = [[f64; COUNT]; COUNT];

/// Time over which scores are summed, s.
const BIN_S: f64 = 1.0;

/// What a second of the drive adds.
#[derive(Clone)]
struct Bin {
    score: Point,
    information: Covariance,
    /// Sums of the outputs' errors.
    errors: [f64; OUTPUTS],
}

/// The covariance of an estimate.
pub(super) fn covariance(
    problem: &Problem<'_>,
    p: &Point,
    densities: &Densities,
    run: &SimulationRun,
) -> Result<Covariance, Error> {
    let failed = || Error::Numerical { what: "the covariance of the single-track model" };
    let segments = bins(problem, p, densities, run).ok_or_else(failed)?;
    let free = &problem.free;
    let n = free.len();
    // In priors' deviations, so that nothing depends on units.
    let scale = |j: usize| problem.priors[free[j]].deviation;
    let scaled =
        |m: &Covariance| Mat::from_fn(n, n, |i, j| m[free[i]][free[j]] * scale(i) * scale(j));
    let scored = |bin: &Bin| ScoreBin {
        score: Mat::from_fn(n, 1, |j, _| bin.score[free[j]] * scale(j)),
        information: scaled(&bin.information),
    };
    let lags = lags(&segments);
    let scores: Vec<Vec<ScoreBin>> =
        segments.iter().map(|bins| bins.iter().map(scored).collect()).collect();
    let sandwich = sandwich(&scores, n, lags, failed)?;
    let mut all = [[0.0; COUNT]; COUNT];
    for (i, &row) in free.iter().enumerate() {
        for (j, &column) in free.iter().enumerate() {
            all[row][column] = sandwich[(i, j)] * scale(i) * scale(j);
        }
    }
    Ok(all)
}

/// The bins of each segment; `None` where the simulation leaves all bounds.
fn bins(
    problem: &Problem<'_>,
    p: &Point,
    densities: &Densities,
    run: &SimulationRun,
) -> Option<Vec<Vec<Bin>>> {
    let period = problem.period(run);
    let per_bin = (BIN_S / period).round().max(1.0) as usize;
    let empty =
        Bin { score: [0.0; COUNT], information: [[0.0; COUNT]; COUNT], errors: [0.0; OUTPUTS] };
    let mut all: Vec<Vec<Bin>> = vec![Vec::new(); problem.segments.len()];
    let mut filled = vec![0_usize; problem.segments.len()];
    let finite = problem.sensitivities(p, run, |segment, outputs| {
        if filled[segment].is_multiple_of(per_bin) {
            all[segment].push(empty.clone());
        }
        filled[segment] += 1;
        let Some(bin) = all[segment].last_mut() else { return };
        for (i, output) in outputs.iter().enumerate() {
            let Some((error, by)) = output else { continue };
            bin.errors[i] += error;
            let weight = period / densities[i];
            for (j, b) in by.iter().enumerate() {
                let weighted = weight * b;
                bin.score[j] += weighted * error;
                for (h, c) in bin.information[j].iter_mut().zip(by) {
                    *h += weighted * c;
                }
            }
        }
    });
    if finite { Some(all) } else { None }
}

/// Lags of Bartlett's weights by Andrews's rule for the most lasting output.
fn lags(segments: &[Vec<Bin>]) -> usize {
    let count: usize = segments.iter().map(Vec::len).sum();
    let correlation = |i: usize| {
        let product = |lag: usize| -> f64 {
            let of = |bins: &Vec<Bin>| -> f64 {
                bins.iter().zip(bins.iter().skip(lag)).map(|(a, b)| a.errors[i] * b.errors[i]).sum()
            };
            segments.iter().map(of).sum()
        };
        let variance = product(0);
        if variance > 0.0 { (product(1) / variance).clamp(0.0, 0.95) } else { 0.0 }
    };
    let rho = (0..OUTPUTS).map(correlation).fold(0.0, f64::max);
    andrews_lags(rho, count)
}
