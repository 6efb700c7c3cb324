//! Models drawn from the distribution of an estimate.

use crate::Error;
use crate::linalg::dense::spectral_radius;
use crate::model::Innovation;
use crate::pem::uncertain::{Normal, Uncertain, packed};

/// Draws in a row that may be unstable before the attempt is given up.
const MOST_REFUSED: usize = 1000;

impl Uncertain {
    /// `count` models from N(estimate, covariance), to first order: nominal + factor·ξ with ξ standard
    /// normal. The same seed returns the same models.
    ///
    /// A draw whose A (or A − KC, where K is not zero) is not stable is drawn again, so the
    /// distribution is that of the stable models: a system that was driven for minutes is known to be
    /// one.
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
}

fn is_stable(of: &Innovation) -> bool {
    let closed = &of.model.a - &of.gain * &of.model.c;
    of.model.spectral_radius() < 1.0
        && (of.gain.norm_max() == 0.0 || spectral_radius(closed.as_ref()) < 1.0)
}
