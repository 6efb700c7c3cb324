//! How a model is identified.

use crate::Error;
use crate::data::scaled::{Detrend, Preparation};
use crate::data::split::ValidationData;
use crate::model::stability::TIME_CONSTANTS;
use crate::subspace::closed_loop::ClosedLoopMethod;
use crate::subspace::{Realization, Weighting};
use std::collections::BTreeMap;
use steerwright_formats::InputKind;

/// Options of [`identify`](crate::identify); `None` leaves the choice to the estimation data. The
/// validation data choose nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct IdentifyOptions {
    /// Method. `None`: the open-loop ones, or the closed-loop ones where the data show feedback
    /// ([`feedback`](crate::subspace::closed_loop::feedback)).
    pub method: Option<Method>,
    /// How A and C are realized. `None`: for each order the one whose simulation fits the estimation
    /// data better, since both have equally many parameters.
    pub realization: Option<Realization>,
    /// Order of the model.
    pub order: Option<usize>,
    /// Largest order tried where the order is chosen.
    pub max_order: usize,
    /// Block rows s of the Hankel matrices.
    pub horizon: Option<usize>,
    /// Whether the output may depend on the input of its own sample; without, D is zero by
    /// construction. `None`: where the data require it and the order is chosen too, since at a stated
    /// order it could represent states that are not allowed.
    pub feedthrough: Option<bool>,
    /// What drives the model.
    pub input_kind: InputKind,
    /// Most samples that estimate, in blocks spread over the log; `None`: all of them.
    pub max_samples: Option<usize>,
    /// Which part of the log validates.
    pub validation: ValidationData,
    /// What is taken out of input and output before a model is fitted.
    pub detrend: Detrend,
    /// Pure delay of the input, s. `None`: the one that the data determine (see
    /// [`estimate_delay`](crate::selection::delay::estimate_delay)).
    pub delay_s: Option<f64>,
    /// Whether the subspace model is refined by its simulation error.
    pub refine: bool,
    /// Length of the estimation data over the time constant of the slowest mode, at least.
    pub time_constants: f64,
}

/// By default; 20 minutes at 20 ms.
pub(crate) const MOST_SAMPLES: usize = 60_000;
const LEAST_SAMPLES: usize = 1_000;

impl Default for IdentifyOptions {
    fn default() -> Self {
        Self {
            method: None,
            realization: None,
            order: None,
            max_order: 8,
            horizon: None,
            feedthrough: None,
            input_kind: InputKind::Steering,
            max_samples: Some(MOST_SAMPLES),
            validation: ValidationData::default(),
            detrend: Detrend::Mean,
            delay_s: None,
            refine: true,
            time_constants: TIME_CONSTANTS,
        }
    }
}

impl IdentifyOptions {
    pub(crate) fn check(&self) -> Result<(), Error> {
        self.check_for(1)
    }

    /// The same for so many outputs, of which each block row of the horizon has as many states.
    pub(crate) fn check_for(&self, outputs: usize) -> Result<(), Error> {
        let out_of_range =
            |option, value: String, expected: &str| Err(Error::option(option, value, expected));
        self.validation.check()?;
        if !(1..=32).contains(&self.max_order) {
            return out_of_range("max order", self.max_order.to_string(), "1 to 32");
        }
        if let Some(order) = self.order
            && !(1..=32).contains(&order)
        {
            return out_of_range("order", order.to_string(), "1 to 32, or auto");
        }
        if let Some(delay) = self.delay_s
            && !(0.0..=2.0).contains(&delay)
        {
            return out_of_range("delay", format!("{delay} s"), "0 s to 2 s, or auto");
        }
        if let Some(most) = self.max_samples
            && most < LEAST_SAMPLES
        {
            let expected = format!("{LEAST_SAMPLES} or more, or all");
            return out_of_range("max samples", most.to_string(), &expected);
        }
        if let Some(horizon) = self.horizon {
            if !(2..=200).contains(&horizon) {
                return out_of_range("horizon", horizon.to_string(), "2 to 200, or auto");
            }
            let order = self.order.unwrap_or(1);
            if (horizon - 1) * outputs < order {
                return Err(Error::OrderAboveHorizon { order, horizon });
            }
        }
        Ok(())
    }

    pub(crate) fn preparation(&self) -> Preparation {
        Preparation {
            input_kind: self.input_kind,
            detrend: self.detrend,
            validation: self.validation,
            max_samples: self.max_samples,
        }
    }

    /// Whether a constant on the outputs is found along with the model.
    pub(crate) fn has_output_offset(&self) -> bool {
        self.detrend == Detrend::Mean && self.refine
    }

    pub(crate) fn to_map(&self) -> BTreeMap<String, String> {
        fn or(x: Option<impl ToString>, none: &str) -> String {
            match x {
                Some(x) => x.to_string(),
                None => none.into(),
            }
        }
        let mut map = BTreeMap::from([
            ("method".into(), self.method.map_or("auto", Method::name).into()),
            ("order".into(), or(self.order, "auto")),
            ("max_order".into(), self.max_order.to_string()),
            ("max_samples".into(), or(self.max_samples, "all")),
            ("horizon".into(), or(self.horizon, "auto")),
            ("feedthrough".into(), or(self.feedthrough, "auto")),
            ("detrend".into(), self.detrend.name().into()),
            ("delay_s".into(), or(self.delay_s, "auto")),
            ("refine".into(), self.refine.to_string()),
        ]);
        self.validation.describe(&mut map);
        map
    }
}

/// A method of identification.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// For data whose input does not depend on past outputs: a weighting of the open-loop subspace
    /// methods, refined by the simulation error.
    OpenLoop(Weighting),
    /// For data with feedback from output to input: a predictor-based method, refined by the
    /// one-step prediction error.
    ClosedLoop(ClosedLoopMethod),
}

steerwright_formats::words!(Method {
    OpenLoop(Weighting::N4sid) = "n4sid",
    OpenLoop(Weighting::Moesp) = "moesp",
    OpenLoop(Weighting::Cva) = "cva",
    ClosedLoop(ClosedLoopMethod::Ssarx) = "ssarx",
    ClosedLoop(ClosedLoopMethod::Pbsid) = "pbsid",
});

impl From<Weighting> for Method {
    fn from(method: Weighting) -> Self {
        Self::OpenLoop(method)
    }
}

impl From<ClosedLoopMethod> for Method {
    fn from(method: ClosedLoopMethod) -> Self {
        Self::ClosedLoop(method)
    }
}
