//! Bias of an estimator over many records, with its confidence interval.

use steerwright_sysid::StateSpace;

/// Angular frequencies at which responses are compared, rad a sample: 0 to half the Nyquist
/// frequency, closer together where a vehicle's dynamics are.
const GRID: [f64; 8] = [0.0, 0.03, 0.08, 0.16, 0.3, 0.5, 0.8, 1.5];

/// What a record's model errs by.
#[derive(Debug, Clone)]
pub struct Errors {
    /// Steady-state gain over the true one, minus 1.
    pub gain: f64,
    /// Real and imaginary parts of the response's errors over the grid, over the largest response.
    pub response: Vec<f64>,
    /// Real and imaginary parts of the distance of the pole nearest to the true slowest one.
    pub pole: Vec<f64>,
}

impl Errors {
    /// Compares a model with the truth (first input and output); `None` where it is not finite.
    #[must_use]
    pub fn new(model: &StateSpace, truth: &StateSpace) -> Option<Self> {
        let at = |m: &StateSpace| GRID.map(|w| m.frequency_response(0, 0, w));
        let (got, expected) = (at(model), at(truth));
        let size = expected.iter().map(|(re, im)| re.hypot(*im)).fold(0.0, f64::max);
        let response: Vec<f64> = got
            .iter()
            .zip(&expected)
            .flat_map(|(a, b)| [(a.0 - b.0) / size, (a.1 - b.1) / size])
            .collect();
        let found = model.poles().ok()?;
        let slowest = |poles: &[(f64, f64)]| {
            let above = poles.iter().filter(|p| p.1 >= 0.0);
            above.max_by(|a, b| a.0.hypot(a.1).total_cmp(&b.0.hypot(b.1))).copied()
        };
        let (re, im) = slowest(&truth.poles().ok()?)?;
        let near = |p: &&(f64, f64)| (p.0 - re).hypot(p.1.abs() - im);
        let found = found.iter().min_by(|a, b| near(a).total_cmp(&near(b)))?;
        let pole = vec![found.0 - re, found.1.abs() - im];
        let gain = got[0].0 / expected[0].0 - 1.0;
        let finite = response.iter().chain(&pole).all(|x| x.is_finite());
        (finite && gain.is_finite()).then_some(Self { gain, response, pole })
    }
}

/// A mean error and half its 95 % confidence interval; of several numbers, the root mean square of
/// each.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bias {
    /// Mean error.
    pub mean: f64,
    /// Half width of its confidence interval.
    pub half_width: f64,
}

impl Bias {
    /// Over records (rows) of one or several errors each.
    #[must_use]
    pub fn new(records: &[Vec<f64>]) -> Self {
        let (n, width) = (records.len() as f64, records.first().map_or(0, Vec::len));
        let (mut squares, mut variances) = (0.0, 0.0);
        let mut signed = 0.0;
        for k in 0..width {
            let mean = records.iter().map(|r| r[k]).sum::<f64>() / n;
            let variance = records.iter().map(|r| (r[k] - mean).powi(2)).sum::<f64>() / (n - 1.0);
            signed = mean;
            squares += mean * mean;
            variances += 1.96_f64.powi(2) * variance / n;
        }
        let mean = if width == 1 { signed } else { (squares / width as f64).sqrt() };
        Self { mean, half_width: (variances / width as f64).sqrt() }
    }

    /// Whether the bias is outside its confidence interval.
    #[must_use]
    pub fn is_significant(&self) -> bool {
        self.mean.abs() > self.half_width
    }
}

/// Bias in all that is compared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Biases {
    /// Of the steady-state gain, relative.
    pub gain: Bias,
    /// Of the frequency response, relative to its largest.
    pub response: Bias,
    /// Of the slowest pole.
    pub pole: Bias,
    /// Records with a model.
    pub records: usize,
}

impl Biases {
    /// Over records; at least two are needed.
    #[must_use]
    pub fn new(errors: &[Errors]) -> Self {
        let over =
            |f: fn(&Errors) -> Vec<f64>| Bias::new(&errors.iter().map(f).collect::<Vec<_>>());
        Self {
            gain: over(|e| vec![e.gain]),
            response: over(|e| e.response.clone()),
            pole: over(|e| e.pole.clone()),
            records: errors.len(),
        }
    }
}
