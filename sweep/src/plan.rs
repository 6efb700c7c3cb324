//! A study resolved into value references and places: all that a run needs, and no name more.
//!
//! Every number that passes between FMUs, or that a metric sees, has a place in one array of
//! floats: Booleans are 1 and 0, and every Integer of FMI 2.0 is a float exactly. An FMU's Real
//! outputs lie side by side, so that `fmi2GetReal` writes straight into the array.

use std::ops::Range;

use fmi2_host::{Kind, Master, Value};

use crate::distribution::Distribution;
use crate::disturbance::Disturbance;
use crate::draws::Key;
use crate::metric::Metric;
use crate::quantity::Linear;

/// What the runs of a study share.
#[derive(Debug)]
pub(crate) struct Plan {
    pub(crate) members: Vec<Member>,
    /// Places in the array of values.
    pub(crate) slots: usize,
    pub(crate) master: Master,
    pub(crate) start: f64,
    pub(crate) step: f64,
    pub(crate) steps: usize,
    pub(crate) varied: Vec<Varied>,
    pub(crate) disturbances: Vec<Disturbance>,
    pub(crate) metrics: Vec<Metric>,
    /// What trajectories show: names and places.
    pub(crate) recorded: Vec<(String, usize)>,
    /// Draws for each point of the grid.
    pub(crate) draws: usize,
    /// Points of the grid.
    pub(crate) points: usize,
    pub(crate) same_draws_on_grid: bool,
}

/// One FMU of the system.
#[derive(Debug, Default)]
pub(crate) struct Member {
    pub(crate) name: String,
    /// Whether one instance serves all runs of a thread.
    pub(crate) reused: bool,
    /// What is set before initialization.
    pub(crate) parameters: Vec<Assignment>,
    /// Free inputs, set in initialization mode.
    pub(crate) constants: Vec<Assignment>,
    /// What is set at every step.
    pub(crate) inputs: Inputs,
    /// Outputs, read after every step.
    pub(crate) outputs: Outputs,
    /// What else is looked at, read at communication points.
    pub(crate) others: Outputs,
}

/// A value that is set.
#[derive(Debug, Clone)]
pub(crate) struct Assignment {
    pub(crate) reference: u32,
    pub(crate) kind: Kind,
    pub(crate) value: Assigned,
}

#[derive(Debug, Clone)]
pub(crate) enum Assigned {
    Fixed(Value),
    /// A varied quantity, by its place, and from its unit to the variable's.
    Varied(usize, Linear),
}

/// Inputs of one FMU, by kind, and the places they are taken from.
#[derive(Debug, Default)]
pub(crate) struct Inputs {
    pub(crate) real: Vec<u32>,
    pub(crate) real_from: Vec<usize>,
    pub(crate) integer: Vec<u32>,
    pub(crate) integer_from: Vec<usize>,
    pub(crate) boolean: Vec<u32>,
    pub(crate) boolean_from: Vec<usize>,
    /// Inputs that are more than a copy; computed first.
    pub(crate) composed: Vec<Composed>,
}

/// An input that a connection scales or disturbances are added to.
#[derive(Debug)]
pub(crate) struct Composed {
    /// Where the input's value goes.
    pub(crate) slot: usize,
    /// Where its source is, or the constant it has without one.
    pub(crate) from: usize,
    pub(crate) scale: Linear,
    /// Disturbances, by their places.
    pub(crate) disturbances: Vec<usize>,
    /// The value of an input that nothing feeds.
    pub(crate) constant: Option<Assigned>,
}

/// Variables of one FMU that are read: their references by kind, and where their values go.
#[derive(Debug, Default, Clone)]
pub(crate) struct Outputs {
    pub(crate) real: Vec<u32>,
    pub(crate) integer: Vec<u32>,
    pub(crate) boolean: Vec<u32>,
    /// The first place: Reals, then Integers, then Booleans.
    pub(crate) first: usize,
    /// For messages, in the order of the places.
    pub(crate) names: Vec<String>,
}

impl Outputs {
    pub(crate) fn reals(&self) -> Range<usize> {
        self.first..self.first + self.real.len()
    }
}

/// A varied quantity.
#[derive(Debug)]
pub(crate) struct Varied {
    pub(crate) name: String,
    pub(crate) distribution: Distribution,
    /// Whether its values are whole numbers.
    pub(crate) whole: bool,
    pub(crate) key: Key,
    /// How many runs of the grid go by before its point changes, in points.
    pub(crate) stride: usize,
}

impl Plan {
    /// The number of runs.
    pub(crate) fn runs(&self) -> usize {
        self.draws * self.points
    }

    /// The stop time: the last communication point.
    pub(crate) fn stop(&self) -> f64 {
        self.time(self.steps)
    }

    /// A communication point.
    pub(crate) fn time(&self, k: usize) -> f64 {
        self.start + k as f64 * self.step
    }

    /// Under which index a run draws: runs of equal draw share it where the study says so.
    pub(crate) fn draw_of(&self, run: usize) -> usize {
        if self.same_draws_on_grid { run % self.draws } else { run }
    }

    /// The varied quantities of a run. The points of a grid follow each other, each with all its
    /// draws, the axis named last moving fastest.
    pub(crate) fn quantities(&self, run: usize) -> Vec<f64> {
        let point = run / self.draws;
        let draw = self.draw_of(run);
        let value = |varied: &Varied| {
            let on_axis = (point / varied.stride) % varied.distribution.points();
            varied.distribution.value(&mut varied.key.stream(draw), on_axis)
        };
        self.varied.iter().map(value).collect()
    }
}
