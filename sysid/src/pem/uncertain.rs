//! An estimate with its covariance, and what that means for quantities without a basis.
//!
//! The delta method: a quantity moves by its derivative along each direction of the covariance's
//! root, so its covariance is the sum of the squares of these moves.

use crate::Error;
use crate::linalg::dense::{eigenvalues, rows, short_dot, spectral_radius};
use crate::model::{Innovation, StateSpace};
use faer::linalg::solvers::Solve;
use faer::{Mat, c64};
use steerwright_formats::{EstimationFocus as Focus, UncertainPole as PoleEstimate};

/// Standard deviations that poles must be apart for the derivative to be used.
const CLEAR: f64 = 3.0;
/// Draws in a row that may be unstable before the attempt is given up.
const MOST_REFUSED: usize = 1000;

/// A model in innovation form with the root of the covariance of its entries.
#[derive(Debug, Clone, PartialEq)]
pub struct Uncertain {
    /// The estimate.
    pub innovation: Innovation,
    /// Moves of the entries of A, B, C, D, K, each row by row, one column for each standard normal
    /// number: the covariance is `factor · factorᵀ`, without changes of basis.
    pub factor: Mat<f64>,
    /// Whose errors the estimate made small.
    pub focus: Focus,
}

/// The frequency response at one frequency with its standard errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResponseEstimate {
    /// Real part.
    pub re: f64,
    /// Imaginary part.
    pub im: f64,
    /// Standard error of the real part.
    pub re_error: f64,
    /// Standard error of the imaginary part.
    pub im_error: f64,
    /// Standard error of the magnitude.
    pub magnitude_error: f64,
    /// Standard error of the phase, rad.
    pub phase_error: f64,
}

impl Uncertain {
    fn moves(&self) -> impl Iterator<Item = Innovation> + '_ {
        (0..self.factor.ncols()).map(|k| self.unpacked(|entry| self.factor[(entry, k)]))
    }

    /// An innovation form's worth of numbers from their places in the factor's columns.
    fn unpacked(&self, value: impl Fn(usize) -> f64) -> Innovation {
        let model = &self.innovation.model;
        let (n, m, p) = (model.order(), model.inputs(), model.outputs());
        let mut at = 0;
        let mut take = |height: usize, width: usize| {
            let from = at;
            at += height * width;
            Mat::from_fn(height, width, |i, j| value(from + i * width + j))
        };
        let model = StateSpace { a: take(n, n), b: take(n, m), c: take(p, n), d: take(p, m) };
        Innovation { model, gain: take(n, p) }
    }

    /// The estimate from `input[j]·u_j` to `output[i]·y_i`, its state as it is.
    #[must_use]
    pub fn scaled(&self, input: &[f64], output: &[f64]) -> Self {
        let scaled = |of: &Innovation| Innovation {
            model: of.model.scaled(input, output),
            gain: Mat::from_fn(of.gain.nrows(), of.gain.ncols(), |i, j| {
                of.gain[(i, j)] / output[j]
            }),
        };
        let columns: Vec<Vec<f64>> = self.moves().map(|m| packed(&scaled(&m))).collect();
        Self {
            innovation: scaled(&self.innovation),
            factor: Mat::from_fn(self.factor.nrows(), self.factor.ncols(), |i, j| columns[j][i]),
            focus: self.focus,
        }
    }

    /// The eigenvalues of A; λ_i moves by (U⁻¹dA U)_ii for the eigenvectors U. The variances of
    /// multiple poles, and of those that may meet, are those of models that are drawn.
    ///
    /// # Errors
    /// [`Error::Numerical`] where the eigenvectors cannot be had.
    pub fn poles(&self) -> Result<Vec<PoleEstimate>, Error> {
        let a = &self.innovation.model.a;
        let n = a.nrows();
        // Also refuses what is not finite.
        eigenvalues(a.as_ref())?;
        let eigen = a.eigen().map_err(|_| Error::Numerical { what: "eigenvectors of A" })?;
        let u = eigen.U();
        let values = eigen.S().column_vector();
        let inverse = u.partial_piv_lu().solve(Mat::<c64>::identity(n, n));
        let mut poles: Vec<PoleEstimate> = (0..n)
            .map(|i| PoleEstimate {
                re: values[i].re,
                im: values[i].im,
                variance_re: 0.0,
                variance_im: 0.0,
                covariance: 0.0,
            })
            .collect();
        for delta in self.moves() {
            for (i, pole) in poles.iter_mut().enumerate() {
                let mut move_of = c64::new(0.0, 0.0);
                for r in 0..n {
                    for c in 0..n {
                        move_of += inverse[(i, r)] * delta.model.a[(r, c)] * u[(c, i)];
                    }
                }
                pole.variance_re += move_of.re * move_of.re;
                pole.variance_im += move_of.im * move_of.im;
                pole.covariance += move_of.re * move_of.im;
            }
        }
        if poles.iter().enumerate().any(|(i, pole)| {
            let apart = |p: &PoleEstimate| (p.re - pole.re).hypot(p.im - pole.im);
            let others = poles.iter().enumerate().filter(|(j, _)| *j != i);
            let nearest = others.map(|(_, p)| apart(p)).fold(f64::INFINITY, f64::min);
            let deviation = (pole.variance_re + pole.variance_im).sqrt();
            // Not a number where the data determine nothing.
            deviation.is_nan() || CLEAR * deviation > nearest
        }) {
            self.scatter(&mut poles)?;
        }
        Ok(poles)
    }

    /// Sets the variances to those about the poles of drawn models, as a real pair may as well be a
    /// complex one where two poles may meet.
    fn scatter(&self, poles: &mut [PoleEstimate]) -> Result<(), Error> {
        const DRAWN: usize = 500;
        let a = &self.innovation.model.a;
        let n = a.nrows();
        let mut random = Normal { state: 1 };
        let mut sums = vec![[0.0; 3]; poles.len()];
        for _ in 0..DRAWN {
            let xi: Vec<f64> = (0..self.factor.ncols()).map(|_| random.next()).collect();
            let drawn = Mat::from_fn(n, n, |i, j| {
                let row = self.factor.row(i * n + j);
                a[(i, j)] + row.iter().zip(&xi).map(|(f, xi)| f * xi).sum::<f64>()
            });
            let drawn = eigenvalues(drawn.as_ref())?;
            for (sum, pole) in sums.iter_mut().zip(poles.iter()) {
                let apart = |z: &(f64, f64)| (z.0 - pole.re).hypot(z.1 - pole.im);
                let Some(z) = drawn.iter().min_by(|x, y| apart(x).total_cmp(&apart(y))) else {
                    continue;
                };
                let (re, im) = (z.0 - pole.re, z.1 - pole.im);
                // Of a real pole either of a pair is as near.
                let both = if pole.im == 0.0 { 0.0 } else { re * im };
                for (sum, x) in sum.iter_mut().zip([re * re, im * im, both]) {
                    *sum += x / DRAWN as f64;
                }
            }
        }
        for (pole, [re, im, both]) in poles.iter_mut().zip(sums) {
            (pole.variance_re, pole.variance_im, pole.covariance) = (re, im, both);
        }
        Ok(())
    }

    /// `count` models from N(estimate, covariance), to first order, by a seed. A draw whose A (or A
    /// − KC, where K is not zero) is not stable is drawn again: a system that was driven for
    /// minutes is known to be stable.
    ///
    /// # Errors
    /// [`Error::NoModel`] where next to no draw is stable.
    pub fn ensemble(&self, count: usize, seed: u64) -> Result<Vec<Innovation>, Error> {
        let nominal = packed(&self.innovation);
        let mut random = Normal { state: seed };
        let mut members = Vec::with_capacity(count);
        let mut refused = 0;
        while members.len() < count {
            let xi: Vec<f64> = (0..self.factor.ncols()).map(|_| random.next()).collect();
            let member = self.unpacked(|entry| {
                let row = self.factor.row(entry);
                nominal[entry] + row.iter().zip(&xi).map(|(f, xi)| f * xi).sum::<f64>()
            });
            if is_stable(&member) {
                members.push(member);
                refused = 0;
            } else {
                refused += 1;
                if refused > MOST_REFUSED {
                    return Err(Error::no_model(format!(
                        "none of {MOST_REFUSED} models drawn from the estimate's distribution is stable"
                    )));
                }
            }
        }
        Ok(members)
    }

    /// The frequency response of one input–output pair at `omega` rad per sample.
    #[must_use]
    pub fn frequency_response(&self, output: usize, input: usize, omega: f64) -> ResponseEstimate {
        let at = Response::new(&self.innovation.model, output, input, omega);
        let response = at.value;
        let size = response.re.hypot(response.im).max(1e-300);
        let mut squares = [0.0; 4];
        for delta in self.moves() {
            let by = at.along(&delta.model);
            // Along the response and across it.
            let along = (by.re * response.re + by.im * response.im) / size;
            let across = (by.im * response.re - by.re * response.im) / size;
            for (sum, x) in squares.iter_mut().zip([by.re, by.im, along, across]) {
                *sum += x * x;
            }
        }
        let [re_error, im_error, magnitude_error, across] = squares.map(f64::sqrt);
        ResponseEstimate {
            re: response.re,
            im: response.im,
            re_error,
            im_error,
            magnitude_error,
            phase_error: across / size,
        }
    }

    /// The steady-state gain of one input–output pair with its standard error; `None` for an
    /// integrator.
    #[must_use]
    pub fn steady_state_gain(&self, output: usize, input: usize) -> Option<(f64, f64)> {
        let at_rest = self.frequency_response(output, input, 0.0);
        if at_rest.re.is_finite() && at_rest.re_error.is_finite() {
            Some((at_rest.re, at_rest.re_error))
        } else {
            None
        }
    }

    /// The output after a unit step of one input at sample 0, with its standard error, for the
    /// samples 0 … `count` − 1.
    #[must_use]
    pub fn step_response(&self, output: usize, input: usize, count: usize) -> Vec<(f64, f64)> {
        let model = &self.innovation.model;
        let n = model.order();
        let [a, c] = [&model.a, &model.c].map(|m| rows(m.as_ref()));
        let times = |a: &[f64], x: &[f64]| -> Vec<f64> {
            (0..n).map(|i| short_dot(&a[i * n..(i + 1) * n], x)).collect()
        };
        let states: Vec<Vec<f64>> = {
            let mut x = vec![0.0; n];
            let mut all = Vec::with_capacity(count);
            for _ in 0..count {
                let mut next = times(&a, &x);
                for (i, v) in next.iter_mut().enumerate() {
                    *v += model.b[(i, input)];
                }
                all.push(std::mem::replace(&mut x, next));
            }
            all
        };
        let c_row = &c[output * n..(output + 1) * n];
        let mut out: Vec<(f64, f64)> =
            states.iter().map(|x| (short_dot(c_row, x) + model.d[(output, input)], 0.0)).collect();
        for delta in self.moves() {
            let delta = &delta.model;
            let da = rows(delta.a.as_ref());
            let dc: Vec<f64> = (0..n).map(|j| delta.c[(output, j)]).collect();
            let mut dx = vec![0.0; n];
            for (x, (_, sum)) in states.iter().zip(&mut out) {
                let by = short_dot(&dc, x) + short_dot(c_row, &dx) + delta.d[(output, input)];
                *sum += by * by;
                let mut next = times(&a, &dx);
                for (i, (o, forced)) in next.iter_mut().zip(times(&da, x)).enumerate() {
                    *o += forced + delta.b[(i, input)];
                }
                dx = next;
            }
        }
        for (_, sum) in &mut out {
            *sum = sum.sqrt();
        }
        out
    }
}

/// The response of one input–output pair at one frequency, with its derivatives:
/// `dG = (dC + C R dA) R B + C R dB + dD` with `R = (e^{jω}I − A)⁻¹`.
pub(super) struct Response {
    /// G.
    pub(super) value: c64,
    /// R B and (C R)ᵀ.
    state: Mat<c64>,
    adjoint: Mat<c64>,
    output: usize,
    input: usize,
}

impl Response {
    pub(super) fn new(model: &StateSpace, output: usize, input: usize, omega: f64) -> Self {
        let n = model.order();
        let (sin, cos) = omega.sin_cos();
        let pencil = Mat::from_fn(n, n, |i, j| {
            let diagonal = if i == j { c64::new(cos, sin) } else { real(0.0) };
            diagonal - real(model.a[(i, j)])
        });
        let lu = pencil.partial_piv_lu();
        let state = lu.solve(Mat::from_fn(n, 1, |i, _| real(model.b[(i, input)])));
        let adjoint = pencil
            .transpose()
            .partial_piv_lu()
            .solve(Mat::from_fn(n, 1, |i, _| real(model.c[(output, i)])));
        let mut value = real(model.d[(output, input)]);
        for i in 0..n {
            value += real(model.c[(output, i)]) * state[(i, 0)];
        }
        Self { value, state, adjoint, output, input }
    }

    pub(super) fn along(&self, StateSpace { a, b, c, d }: &StateSpace) -> c64 {
        let mut by = real(d[(self.output, self.input)]);
        for i in 0..a.nrows() {
            let mut inner = real(b[(i, self.input)]);
            for j in 0..a.nrows() {
                inner += real(a[(i, j)]) * self.state[(j, 0)];
            }
            by += self.adjoint[(i, 0)] * inner + real(c[(self.output, i)]) * self.state[(i, 0)];
        }
        by
    }
}

fn is_stable(of: &Innovation) -> bool {
    let closed = &of.model.a - &of.gain * &of.model.c;
    of.model.spectral_radius() < 1.0
        && (of.gain.norm_max() == 0.0 || spectral_radius(closed.as_ref()) < 1.0)
}

fn real(x: f64) -> c64 {
    c64::new(x, 0.0)
}

/// Entries of A, B, C, D, K, each row by row.
fn packed(of: &Innovation) -> Vec<f64> {
    let m = &of.model;
    [&m.a, &m.b, &m.c, &m.d, &of.gain].into_iter().flat_map(|m| rows(m.as_ref())).collect()
}

/// Standard normal numbers, without a crate, so that a file is drawn alike everywhere: SplitMix64 (Steele,
/// Lea and Flood 2014) through the transform of Box and Muller (1958).
struct Normal {
    state: u64,
}

impl Normal {
    fn uniform(&mut self) -> f64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn next(&mut self) -> f64 {
        let (radius, angle) = (self.uniform().max(1e-300), self.uniform());
        (-2.0 * radius.ln()).sqrt() * (std::f64::consts::TAU * angle).cos()
    }
}
