//! A study resolved: the compiled system, and what is varied, added, measured and recorded.

use crate::distribution::Distribution;
use crate::disturbance::Disturbance;
use crate::draws::Key;
use crate::metric::{Class, Metric, Outcome};

/// What the runs of a study share.
#[derive(Debug)]
pub(crate) struct Plan {
    pub(crate) system: steerwright_host::Plan,
    pub(crate) instances: Vec<Reuse>,
    pub(crate) varied: Vec<Varied>,
    pub(crate) disturbances: Vec<Disturbance>,
    pub(crate) metrics: Vec<Metric>,
    /// The columns of trajectories: names and places.
    pub(crate) recorded: Vec<(String, usize)>,
    /// Draws for each point of the grid.
    pub(crate) draws: usize,
    pub(crate) points: usize,
    pub(crate) same_draws_on_grid: bool,
}

#[derive(Debug)]
pub(crate) struct Reuse {
    pub(crate) name: String,
    /// Whether one instance serves all runs of a thread.
    pub(crate) reused: bool,
}

/// A varied quantity.
#[derive(Debug)]
pub(crate) struct Varied {
    pub(crate) name: String,
    pub(crate) distribution: Distribution,
    pub(crate) whole: bool,
    pub(crate) key: Key,
    /// After how many points of the grid its value changes.
    pub(crate) stride: usize,
}

impl Plan {
    pub(crate) fn runs(&self) -> usize {
        self.draws * self.points
    }

    /// The index under which a run draws: runs of equal draw share it where the study states so.
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

    pub(crate) fn requires(&self) -> bool {
        self.metrics.iter().any(crate::metric::Metric::is_required)
    }

    /// Whether a run did all that is required; one that failed did not.
    pub(crate) fn passes(&self, outcome: &Outcome) -> bool {
        let Outcome::Done(values) = outcome else { return false };
        self.metrics.iter().zip(values).all(|(metric, value)| metric.is_met(*value))
    }

    /// The worst that a run's metrics show.
    pub(crate) fn class(&self, outcome: &Outcome) -> Class {
        let Outcome::Done(values) = outcome else { return Class::FailedToRun };
        let required = if self.passes(outcome) { Class::Met } else { Class::SpecificationMissed };
        let shown = self.metrics.iter().zip(values).filter_map(|(m, v)| m.class_of(*v));
        shown.fold(required, Class::max)
    }
}
