//! The report: what is known, as one page.

use crate::figures::ChannelSignals;
use crate::read::{StepResponse, Traces, Track};
use steerwright_formats::{Bicycle, Model, Path, Pid, SourceFile, StepMetrics};

/// Everything a report can show; what is absent is left out.
#[derive(Debug, Clone, Default)]
#[allow(missing_docs)]
pub struct Report<'a> {
    pub title: String,
    pub model: Option<&'a Model>,
    /// The drive and the model's simulation of it.
    pub traces: Option<&'a Traces>,
    /// The log of a model whose inputs and outputs have names, and the model's simulation of it.
    pub channels: Option<&'a ChannelSignals>,
    pub bicycle: Option<&'a Bicycle>,
    /// Fit of the bicycle model on the drive, percent.
    pub bicycle_fit: Option<f64>,
    /// The controllers, in the order to show.
    pub controllers: Vec<Controller<'a>>,
    pub path: Option<&'a Path>,
    /// Runs along the road, with the names to show.
    pub tracks: Vec<(&'a str, &'a Track)>,
    /// What was found on the way and is no result of one model: a road that needs more than the controller has, a
    /// controller that could not be designed.
    pub remarks: Vec<String>,
    /// The files that were written, by name and content.
    pub files: Vec<SourceFile>,
}

/// A controller, and its proof away from the model it was designed on.
#[derive(Debug, Clone)]
#[allow(missing_docs)]
pub struct Controller<'a> {
    pub name: &'a str,
    pub pid: &'a Pid,
    /// The step of its specification in closed loop.
    pub in_loop: Option<LoopStep<'a>>,
}

/// The specification's step in a closed loop.
#[derive(Debug, Clone, Copy)]
#[allow(missing_docs)]
pub struct LoopStep<'a> {
    /// The plant in the loop, for people, such as `the identified plant`.
    pub plant: &'a str,
    pub response: &'a StepResponse,
    pub metrics: &'a StepMetrics,
}

impl Controller<'_> {
    /// Whether every requirement is met, on the model designed on and in the loop.
    #[must_use]
    pub fn is_proved(&self) -> bool {
        let in_loop = self.in_loop.is_none_or(|l| self.pid.specification.is_met_by(l.metrics));
        self.pid.evidence.met && in_loop
    }
}
