//! Time derivatives of inputs and outputs, and directional derivatives.
//!
//! A directional derivative is `Δunknown = Σ ∂unknown/∂known · Δknown` (section 2.1.9). A partial
//! derivative is zero without a dependency; otherwise it is the unit's value, or a central difference
//! on clones. With x the known and n its nominal value (default 1), the step is `∛ε · max(|x|, n)`,
//! which balances truncation and rounding errors, limited to the known's range.

use crate::access::Target;
use crate::calls::State;
use crate::contain::Contained;
use crate::exposed::Exposed;
use crate::instance::{Instance, Outcome};
use crate::structure::depends_initially;
use crate::types::Status;
use crate::unit::{CoSimulationUnit, Known, Unknown, VariableId};
use model_description::{Causality, Kind, Value, Variability, VariableSpec};
use std::mem::MaybeUninit;

/// The only order of time derivatives that is supported.
const ORDER: i32 = 1;

impl<S: CoSimulationUnit> Instance<S> {
    /// A continuous variable with a causality, if it has a derivative of the order.
    fn find_continuous(
        &self,
        reference: u32,
        order: i32,
        causality: Causality,
    ) -> Result<(S::Variable, &'static VariableSpec), String> {
        let target = self.find(reference, Kind::Real)?;
        match target {
            _ if order != ORDER => Err(format!(
                "`{}` has no derivative of order {order}, only of {ORDER}",
                target.name()
            )),
            Target::Variable(variable, row)
                if row.causality == causality && row.variability == Variability::Continuous =>
            {
                Ok((variable, row))
            }
            _ => Err(format!("`{}` is not a continuous {causality}", target.name())),
        }
    }

    pub(crate) fn set_input_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        values: &[f64],
    ) -> Outcome {
        for ((&reference, &order), &value) in references.iter().zip(orders).zip(values) {
            let (_, row) = self.find_continuous(reference, order, Causality::Input)?;
            if !value.is_finite() {
                return Err(format!("the derivative of `{}` cannot be {value}", row.name));
            }
        }
        for ((&reference, &order), &value) in references.iter().zip(orders).zip(values) {
            let (variable, _) = self.find_continuous(reference, order, Causality::Input)?;
            let pending = &mut self.core.input_derivatives;
            match pending.iter_mut().find(|(known, _)| *known == reference) {
                Some((_, derivative)) => *derivative = value,
                None => pending.push((reference, value)),
            }
            self.core.unit.set_input_derivative(variable, value);
        }
        Ok(Status::Ok)
    }

    pub(crate) fn get_output_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        values: &mut [MaybeUninit<f64>],
    ) -> Outcome {
        for (&reference, &order) in references.iter().zip(orders) {
            self.find_continuous(reference, order, Causality::Output)?;
        }
        for ((&reference, &order), slot) in references.iter().zip(orders).zip(values) {
            let (variable, row) = self.find_continuous(reference, order, Causality::Output)?;
            let derivative = self.core.unit.output_derivative(variable);
            if !derivative.is_finite() {
                return Err(format!("the derivative of `{}` is {derivative}", row.name));
            }
            slot.write(derivative);
        }
        Ok(Status::Ok)
    }

    /// An unknown of a directional derivative.
    fn find_unknown(&self, reference: u32) -> Result<Target<S::Variable>, String> {
        let target = self.find(reference, Kind::Real)?;
        if target.class().is_unknown_in(self.core.state) {
            return Ok(target);
        }
        let need = match self.core.state {
            State::Initialization => "an initial unknown",
            _ => "an output or the derivative of a state",
        };
        Err(format!("`{}` is not an unknown in this state: it is not {need}", target.name()))
    }

    /// A known of a directional derivative. `None` if it is not a Real: the XML may list such a
    /// dependency, and its partial derivative is zero.
    fn find_known(&self, reference: u32) -> Result<Option<Target<S::Variable>>, String> {
        let variable = S::Variable::from_reference(reference);
        let target = match variable.filter(|variable| self.core.unit.has(*variable)) {
            Some(variable) => Target::Variable(variable, variable.spec()),
            None => self.find(reference, Kind::Real)?,
        };
        if target.class().is_known_in(self.core.state) {
            let is_real = !matches!(target, Target::Variable(_, row) if row.kind != Kind::Real);
            return Ok(if is_real { Some(target) } else { None });
        }
        let need = match self.core.state {
            State::Initialization => {
                "an input or a variable with initial=\"exact\" that is not constant"
            }
            _ => "an input or a state",
        };
        Err(format!("`{}` is not a known in this state: it is not {need}", target.name()))
    }

    /// The sensitivities of the unknowns in the direction `seed` of the knowns.
    pub(crate) fn directional_derivative(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
    ) -> Result<Vec<f64>, String> {
        let unknowns = unknowns
            .iter()
            .map(|&reference| self.find_unknown(reference))
            .collect::<Result<Vec<_>, _>>()?;
        let mut sums = vec![0.0; unknowns.len()];
        for &reference in knowns {
            self.find_known(reference)?;
        }
        if let Some(direction) = seed.iter().find(|direction| !direction.is_finite()) {
            return Err(format!("dvKnown cannot be {direction}"));
        }
        for (&reference, &direction) in knowns.iter().zip(seed).filter(|(_, d)| **d != 0.0) {
            let Some(known) = self.find_known(reference)? else { continue };
            let mut difference = None;
            for (&unknown, sum) in unknowns.iter().zip(&mut sums) {
                *sum += self.partial(unknown, known, &mut difference)? * direction;
            }
            if let Some(difference) = difference {
                difference.release();
            }
        }
        match sums.iter().zip(&unknowns).find(|(sum, _)| !sum.is_finite()) {
            None => Ok(sums),
            Some((sum, unknown)) => {
                Err(format!("the directional derivative of `{}` is {sum}", unknown.name()))
            }
        }
    }

    /// `∂unknown/∂known`; `difference` keeps the clones for the other unknowns.
    fn partial(
        &mut self,
        unknown: Target<S::Variable>,
        known: Target<S::Variable>,
        difference: &mut Option<CentralDifference<S>>,
    ) -> Result<f64, String> {
        let unit = &mut self.core.unit;
        let to = match unknown {
            Target::Variable(variable, _) => Unknown::Variable(variable),
            Target::Exposed(Exposed::State { index, .. }) => Unknown::State(index),
            Target::Exposed(Exposed::Derivative { index }) => Unknown::Derivative(index),
        };
        let by = match known {
            Target::Variable(variable, _) => Known::Variable(variable),
            Target::Exposed(Exposed::State { index, .. } | Exposed::Derivative { index }) => {
                Known::State(index)
            }
        };
        let depends = match self.core.state {
            State::Initialization => depends_initially(&**unit, to, by).is_some(),
            _ => unit.dependency(to, by).is_some(),
        };
        if !depends {
            return Ok(0.0);
        }
        if let Some(partial) = unit.partial_derivative(to, by) {
            return Ok(partial);
        }
        if difference.is_none() {
            *difference = Some(CentralDifference::new(unit, known)?);
        }
        difference.as_mut().map_or(Ok(0.0), |difference| difference.difference(unknown))
    }
}

/// A central difference: two clones with a known below and above its value.
struct CentralDifference<S> {
    below: Contained<S>,
    above: Contained<S>,
    /// The difference of the known between the clones.
    width: f64,
}

impl<S: CoSimulationUnit> CentralDifference<S> {
    fn new(unit: &mut Contained<S>, known: Target<S::Variable>) -> Result<Self, String> {
        let (at, nominal, min, max) = match known {
            Target::Variable(variable, row) => {
                let at = unit.get(variable).as_number();
                let limit = |limit: Option<f64>, other| limit.unwrap_or(other);
                let (min, max) = (limit(row.min, f64::MIN), limit(row.max, f64::MAX));
                (at, row.nominal.unwrap_or(1.0), min, max)
            }
            Target::Exposed(Exposed::State { index, settable: true }) => {
                (Some(unit.state(index)), 1.0, f64::MIN, f64::MAX)
            }
            Target::Exposed(_) => (None, 1.0, 0.0, 0.0),
        };
        let Some(at) = at.filter(|at| at.is_finite()) else {
            return Err(format!("the model has no derivatives with respect to `{}`", known.name()));
        };
        let step = f64::EPSILON.cbrt() * at.abs().max(nominal);
        let (low, high) = ((at - step).max(min), (at + step).min(max));
        let width = high - low;
        // Written so that NaN fails.
        if !(width > 0.0 && width.is_finite()) {
            return Err(format!(
                "the limits of `{}` leave no step for a derivative at {at}",
                known.name()
            ));
        }
        let shifted = |value: f64| {
            let mut clone = unit.clone();
            match known {
                Target::Variable(variable, _) => clone.set(variable, &Value::Real(value)),
                Target::Exposed(exposed) => exposed.set(&mut *clone, value),
            }
            clone
        };
        Ok(Self { below: shifted(low), above: shifted(high), width })
    }

    fn difference(&mut self, unknown: Target<S::Variable>) -> Result<f64, String> {
        let value = |unit: &mut S| match unknown {
            Target::Variable(variable, _) => unit.get(variable).as_number(),
            Target::Exposed(exposed) => Some(exposed.value(unit)),
        };
        match (value(&mut self.below), value(&mut self.above)) {
            (Some(below), Some(above)) => Ok((above - below) / self.width),
            _ => {
                Err(format!("the model returned a value of another type for `{}`", unknown.name()))
            }
        }
    }

    /// Drops the clones; a panic of a destructor propagates.
    fn release(self) {
        self.below.release();
        self.above.release();
    }
}
