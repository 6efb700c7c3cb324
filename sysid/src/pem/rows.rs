//! Derivatives of the simulated output of `x⁺ = A x + B v`, `ŷ = C x + D v` along the local
//! coordinates, sample by sample, by 1 + ny² + ny(nu + 1) filters of order n:
//!
//! - `∂ŷ_i/∂W_kl` is state k of `w⁺ = Aᵀw + c_iᵀ v_l`;
//! - `∂ŷ_i/∂V_kj = g_ij(z) x_k`, `g_ij = Y_ij + c_i(zI − A)⁻¹X_j`, is state k of the model itself, driven by
//!   `s_l = g_ij(z) v_l = Y_ij v_l + X_jᵀ w_il` and started by the impulse response of g_ij times x(0);
//! - `∂ŷ_i/∂x(0)` is `f⁺ = Aᵀf` from `f = c_iᵀ`.
//!
//! All states lie in one vector, those of each filter padded with zeros to whole vectors of the processor.

use crate::data::Segment;
use crate::linalg::blocks::{BlockColumns, LANES, block_dot, blocks_of, padded_rows};
use crate::linalg::dense::rows;
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
    offsets: Option<&'a [f64]>,
    a: BlockColumns,
    at: BlockColumns,
    b: BlockColumns,
    /// C row by row and X column by column, each padded; x(0) padded; D row by row.
    c: Vec<f64>,
    x_perp: Vec<f64>,
    x0: Vec<f64>,
    d: Vec<f64>,
    v: Vec<f64>,
    /// Free responses i; states behind V, ordered (i, j); adjoint states, ordered (i, l); the state.
    states: Vec<f64>,
    next: Vec<f64>,
    /// Where the entries of a row are in `states`, for each output but for offsets, D and the error.
    places: Vec<usize>,
    /// Whether the initial state still shows in the output.
    pub(super) free: bool,
    s: Vec<f64>,
}

/// Samples after which it is looked whether the initial state still shows.
const LOOK: usize = 16;

impl<'a> Sensitivities<'a> {
    pub(super) fn new(
        coordinates: &'a Coordinates,
        drive: Drive,
        segment: &'a Segment,
        x0: &[f64],
        offsets: Option<&'a [f64]>,
    ) -> Self {
        let model = &coordinates.model;
        let (n, m, p) = (model.order(), model.inputs(), model.outputs());
        let height = LANES * blocks_of(n);
        let mut x = vec![0.0; height];
        x[..n].copy_from_slice(x0);
        let c = padded_rows(model.c.as_ref());
        let mut states = c.clone();
        for i in 0..p {
            for j in 0..p {
                states.extend(x.iter().map(|x| coordinates.y[(i, j)] * x));
            }
        }
        states.resize((p + p * p + p * m) * height, 0.0);
        states.extend_from_slice(&x);
        let mut places = Vec::new();
        for i in 0..p {
            let behind = |filter: usize| move |k: usize| filter * height + k;
            places.extend((0..n).map(behind(i)));
            for k in 0..n {
                places.extend((0..p).map(|j| behind(p + i * p + j)(k)));
            }
            for k in 0..n {
                places.extend((0..m).map(|l| behind(p + p * p + i * m + l)(k)));
            }
        }
        Self {
            a: BlockColumns::new(model.a.as_ref()),
            at: BlockColumns::new(model.a.transpose()),
            b: BlockColumns::new(model.b.as_ref()),
            d: rows(model.d.as_ref()),
            x_perp: padded_rows(coordinates.x.transpose()),
            v: vec![0.0; m],
            next: vec![0.0; states.len()],
            states,
            places,
            x0: x,
            c,
            free: true,
            s: vec![0.0; m],
            coordinates,
            drive,
            segment,
            offsets,
        }
    }

    /// The rows of sample t, one for each output: derivatives by x(0), by the offsets where these are
    /// free, by the local coordinates, and the error y − ŷ, each row `n + ny + count + 1` long, without
    /// offsets `n + count + 1`. Then the filters move on, so t runs from 0.
    #[inline(always)]
    pub(super) fn sample(&mut self, t: usize, out: &mut [f64]) {
        // Of a known height the states stay in registers.
        match self.a.blocks() {
            1 => self.sample_of::<1>(t, out),
            2 => self.sample_of::<2>(t, out),
            3 => self.sample_of::<3>(t, out),
            _ => self.sample_of::<0>(t, out),
        }
    }

    #[inline(always)]
    fn sample_of<const B: usize>(&mut self, t: usize, out: &mut [f64]) {
        let model = &self.coordinates.model;
        let (n, m, p) = (model.order(), model.inputs(), model.outputs());
        let width = out.len() / p;
        let offsets = self.offsets.map_or(0, <[f64]>::len);
        self.drive.fill(self.segment, t, &mut self.v);
        let height = self.x0.len();
        let x = &self.states[self.states.len() - height..];
        let places = self.places.chunks_exact(n * (1 + p + m));
        for (i, (row, places)) in out.chunks_exact_mut(width).zip(places).enumerate() {
            let (by_start, others) = places.split_at(n);
            for (value, &place) in row[..n].iter_mut().zip(by_start) {
                *value = self.states[place];
            }
            for (j, value) in row[n..n + offsets].iter_mut().enumerate() {
                *value = f64::from(u8::from(i == j));
            }
            let rest = &mut row[n + offsets..];
            for (value, &place) in rest.iter_mut().zip(others) {
                *value = self.states[place];
            }
            let direct = &mut rest[others.len()..];
            if direct.len() > 1 {
                direct.fill(0.0);
                let moving = (direct.len() - 1) / p;
                let fed = (0..m).filter(|l| self.coordinates.feedthrough[*l]);
                for (place, l) in fed.enumerate() {
                    direct[i * moving + place] = self.v[l];
                }
            }
            let mut output = block_dot::<B>(&self.c[i * height..(i + 1) * height], x);
            for (d, v) in self.d[i * m..(i + 1) * m].iter().zip(&self.v) {
                output += d * v;
            }
            let offset = self.offsets.map_or(0.0, |offsets| offsets[i]);
            row[width - 1] = self.segment.y[(i, t)] - output - offset;
        }
        self.advance::<B>(n, t);
    }

    #[inline(always)]
    fn advance<const B: usize>(&mut self, n: usize, t: usize) {
        let (m, height) = (self.v.len(), self.x0.len());
        let p = self.c.len() / height;
        let filter = |k: usize| k * height..(k + 1) * height;
        let (states, next) = (self.states.as_slice(), self.next.as_mut_slice());
        for i in 0..p {
            let f = &states[filter(i)];
            for j in 0..p {
                let x_j = &self.x_perp[filter(j)];
                let y_ij = self.coordinates.y[(i, j)];
                for (l, (s, v)) in self.s.iter_mut().zip(&self.v).enumerate() {
                    let w = &states[filter(p + p * p + i * m + l)];
                    *s = y_ij * v + block_dot::<B>(x_j, w);
                }
                let impulse = if self.free { block_dot::<B>(f, x_j) } else { 0.0 };
                let at = filter(p + i * p + j);
                let to = &mut next[at.clone()];
                to.iter_mut().zip(&self.x0).for_each(|(to, x)| *to = impulse * x);
                self.b.add_product::<B>(&self.s, to);
                self.a.add_product::<B>(&states[at][..n], to);
            }
            let c_i = &self.c[filter(i)];
            for (l, v) in self.v.iter().enumerate() {
                let at = filter(p + p * p + i * m + l);
                let to = &mut next[at.clone()];
                to.iter_mut().zip(c_i).for_each(|(to, c)| *to = c * v);
                self.at.add_product::<B>(&states[at][..n], to);
            }
            if self.free {
                let to = &mut next[filter(i)];
                to.fill(0.0);
                self.at.add_product::<B>(&f[..n], to);
            }
        }
        let at = filter(p + p * p + p * m);
        let to = &mut next[at.clone()];
        to.fill(0.0);
        self.b.add_product::<B>(&self.v, to);
        self.a.add_product::<B>(&states[at][..n], to);
        std::mem::swap(&mut self.states, &mut self.next);
        if self.free && t % LOOK == LOOK - 1 {
            let size = |v: &[f64]| v.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
            let f = &mut self.states[..p * height];
            if size(f) <= 1e-18 * size(&self.c) {
                self.free = false;
                f.fill(0.0);
                self.next[..p * height].fill(0.0);
            }
        }
    }
}
