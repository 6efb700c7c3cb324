//! Derivatives of the simulated output of `x⁺ = A x + B v`, `ŷ = C x + D v` along the local
//! coordinates, sample by sample, by 1 + ny² + ny(nu + 1) filters of order n:
//!
//! - `∂ŷ_i/∂W_kl` is state k of `w⁺ = Aᵀw + c_iᵀ v_l`;
//! - `∂ŷ_i/∂V_kj = g_ij(z) x_k`, `g_ij = Y_ij + c_i(zI − A)⁻¹X_j`, is state k of the model itself, driven by
//!   `s_l = g_ij(z) v_l = Y_ij v_l + X_jᵀ w_il` and started by the impulse response of g_ij times x(0);
//! - `∂ŷ_i/∂x(0)` is `f⁺ = Aᵀf` from `f = c_iᵀ`.

use crate::data::Segment;
use crate::linalg::columns::Columns;
use crate::linalg::dense::{rows, short_dot};
use crate::pem::coordinates::Coordinates;

/// What drives the model whose output is compared with y.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Drive {
    /// The inputs: the error of the simulation.
    Inputs,
    /// Inputs and measured outputs: the model is the predictor of the innovation form.
    InputsAndOutputs,
}

impl Drive {
    pub(super) fn width(self, inputs: usize, outputs: usize) -> usize {
        match self {
            Self::Inputs => inputs,
            Self::InputsAndOutputs => inputs + outputs,
        }
    }

    #[inline(always)]
    pub(super) fn fill(self, segment: &Segment, t: usize, v: &mut [f64]) {
        let m = segment.u.nrows();
        for (l, value) in v.iter_mut().enumerate() {
            *value = if l < m { segment.u[(l, t)] } else { segment.y[(l - m, t)] };
        }
    }
}

pub(super) struct Sensitivities<'a> {
    coordinates: &'a Coordinates,
    drive: Drive,
    segment: &'a Segment,
    a: Columns,
    at: Columns,
    b: Columns,
    /// C and D row by row, X column by column.
    c: Vec<f64>,
    d: Vec<f64>,
    x_perp: Vec<f64>,
    x0: &'a [f64],
    offsets: Option<&'a [f64]>,
    v: Vec<f64>,
    /// n: state; ny² by n: states behind V, ordered (i, j); ny·nv by n: adjoint states, ordered
    /// (i, l); ny by n: free responses.
    x: Vec<f64>,
    xv: Vec<f64>,
    w: Vec<f64>,
    f: Vec<f64>,
    /// Whether the initial state still shows in the output.
    pub(super) free: bool,
    next: Vec<f64>,
    s: Vec<f64>,
}

impl<'a> Sensitivities<'a> {
    pub(super) fn new(
        coordinates: &'a Coordinates,
        drive: Drive,
        segment: &'a Segment,
        x0: &'a [f64],
        offsets: Option<&'a [f64]>,
    ) -> Self {
        let model = &coordinates.model;
        let (n, m, p) = (model.order(), model.inputs(), model.outputs());
        let c = rows(model.c.as_ref());
        let mut xv = vec![0.0; p * p * n];
        for i in 0..p {
            for j in 0..p {
                for k in 0..n {
                    xv[(i * p + j) * n + k] = coordinates.y[(i, j)] * x0[k];
                }
            }
        }
        Self {
            a: Columns::new(model.a.as_ref()),
            at: Columns::new(model.a.transpose()),
            b: Columns::new(model.b.as_ref()),
            d: rows(model.d.as_ref()),
            x_perp: rows(coordinates.x.transpose()),
            v: vec![0.0; m],
            x: x0.to_vec(),
            xv,
            w: vec![0.0; p * m * n],
            f: c.clone(),
            c,
            free: true,
            next: vec![0.0; n],
            s: vec![0.0; m],
            coordinates,
            drive,
            segment,
            x0,
            offsets,
        }
    }

    /// The rows of sample t, one for each output: derivatives by x(0), by the offsets where these are
    /// free, by the local coordinates, and the error y − ŷ, each row `n + ny + count + 1` long, without
    /// offsets `n + count + 1`. Then the filters move on, so t runs from 0.
    #[inline(always)]
    pub(super) fn sample(&mut self, t: usize, out: &mut [f64]) {
        let model = &self.coordinates.model;
        let (n, m, p) = (model.order(), model.inputs(), model.outputs());
        let width = out.len() / p;
        self.drive.fill(self.segment, t, &mut self.v);
        for i in 0..p {
            let row = &mut out[i * width..(i + 1) * width];
            row[..n].copy_from_slice(&self.f[i * n..(i + 1) * n]);
            let offsets = self.offsets.map_or(0, <[f64]>::len);
            for (j, value) in row[n..n + offsets].iter_mut().enumerate() {
                *value = f64::from(u8::from(i == j));
            }
            let first = n + offsets;
            for j in 0..p {
                let states = &self.xv[(i * p + j) * n..(i * p + j + 1) * n];
                for (k, value) in states.iter().enumerate() {
                    row[first + k * p + j] = *value;
                }
            }
            let at = first + n * p;
            for l in 0..m {
                let states = &self.w[(i * m + l) * n..(i * m + l + 1) * n];
                for (k, value) in states.iter().enumerate() {
                    row[at + k * m + l] = *value;
                }
            }
            let at = at + n * m;
            row[at..].fill(0.0);
            let moving = self.coordinates.feedthrough.iter().filter(|moves| **moves).count();
            let fed = (0..m).filter(|l| self.coordinates.feedthrough[*l]);
            for (place, l) in fed.enumerate() {
                row[at + i * moving + place] = self.v[l];
            }
            let output = short_dot(&self.c[i * n..(i + 1) * n], &self.x)
                + short_dot(&self.d[i * m..(i + 1) * m], &self.v);
            let offset = self.offsets.map_or(0.0, |offsets| offsets[i]);
            row[width - 1] = self.segment.y[(i, t)] - output - offset;
        }
        self.advance();
    }

    #[inline(always)]
    fn advance(&mut self) {
        let (n, m) = (self.a.height(), self.v.len());
        let p = self.c.len() / n;
        for i in 0..p {
            let f = &self.f[i * n..(i + 1) * n];
            for j in 0..p {
                let x_j = &self.x_perp[j * n..(j + 1) * n];
                let y_ij = self.coordinates.y[(i, j)];
                for l in 0..m {
                    let w = &self.w[(i * m + l) * n..(i * m + l + 1) * n];
                    self.s[l] = y_ij * self.v[l] + short_dot(x_j, w);
                }
                if self.free {
                    let impulse = short_dot(f, x_j);
                    for (o, x) in self.next.iter_mut().zip(self.x0) {
                        *o = impulse * x;
                    }
                } else {
                    self.next.fill(0.0);
                }
                let states = &mut self.xv[(i * p + j) * n..(i * p + j + 1) * n];
                self.b.add_product(&self.s, &mut self.next);
                self.a.add_product(states, &mut self.next);
                states.copy_from_slice(&self.next);
            }
            for l in 0..m {
                let states = &mut self.w[(i * m + l) * n..(i * m + l + 1) * n];
                for (o, c) in self.next.iter_mut().zip(&self.c[i * n..(i + 1) * n]) {
                    *o = c * self.v[l];
                }
                self.at.add_product(states, &mut self.next);
                states.copy_from_slice(&self.next);
            }
        }
        self.b.product(&self.v, &mut self.next);
        self.a.add_product(&self.x, &mut self.next);
        self.x.copy_from_slice(&self.next);
        if self.free {
            for states in self.f.chunks_exact_mut(n) {
                self.at.product(states, &mut self.next);
                states.copy_from_slice(&self.next);
            }
            let size = |v: &[f64]| v.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
            if size(&self.f) <= 1e-18 * size(&self.c) {
                self.free = false;
                self.f.fill(0.0);
            }
        }
    }
}
