//! One closed loop of instances, run after run: what a thread of a sweep has.
//!
//! The loop is [`steerwright_host::Cosimulation`], so a run has the numbers of [`steerwright_host::System::run`],
//! to the bit. Here are the instances that serve several runs, the disturbances, and the metrics.

use crate::disturbance::Signal;
use crate::memory::Memory;
use crate::metric::Metric;
use crate::plan::Plan;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;
use steerwright_host::{Archive, Cosimulation, Error as HostError, Instance};

/// Receives time and values at a communication point.
pub(crate) type See<'a> = &'a mut dyn FnMut(f64, &[f64]);

/// Steps between checks whether to stop.
const STEPS_BETWEEN_CHECKS: usize = 256;

/// Why a run has no results.
#[derive(Debug)]
pub(crate) enum Ended {
    Failed(HostError),
    Stopped,
    TooLong,
}

impl From<HostError> for Ended {
    fn from(error: HostError) -> Self {
        Self::Failed(error)
    }
}

/// A thread's instances and buffers.
pub(crate) struct Rig<'a> {
    plan: &'a Plan,
    archives: Vec<&'a Archive>,
    /// Those that a run left for the next.
    instances: Vec<Option<Instance>>,
    run: Cosimulation<'a>,
    signals: Vec<Signal>,
    memories: Vec<Memory>,
    /// When an unfinished run is ended; checked between steps.
    pub(crate) deadline: Option<Instant>,
}

impl<'a> Rig<'a> {
    /// Buffers; instances are made when first needed.
    pub(crate) fn new(plan: &'a Plan, archives: Vec<&'a Archive>) -> Self {
        Self {
            plan,
            instances: archives.iter().map(|_| None).collect(),
            archives,
            run: Cosimulation::new(&plan.system),
            signals: Vec::new(),
            memories: Vec::new(),
            deadline: None,
        }
    }

    /// Runs to the end, or for so many steps, and returns the metrics. `see` receives the values at every
    /// communication point.
    pub(crate) fn run(
        &mut self,
        steps: usize,
        run: usize,
        quantities: &[f64],
        stop: &AtomicBool,
        mut see: Option<See<'_>>,
    ) -> Result<Vec<f64>, Ended> {
        let mut instances = Vec::new();
        for ((left, name), archive) in
            self.instances.iter_mut().zip(&self.plan.instances).zip(&self.archives)
        {
            instances.push(match left.take() {
                Some(instance) => instance,
                None => Instance::new(archive, &name.name)?,
            });
        }
        // After an error no instance is kept: its state is unknown.
        self.steps(&mut instances, steps, run, quantities, stop, &mut see)?;
        for ((left, instance), of) in
            self.instances.iter_mut().zip(instances).zip(&self.plan.instances)
        {
            *left = if of.reused { Some(instance) } else { None };
        }
        let of = |(memory, metric): (&Memory, &Metric)| memory.result(metric.kind);
        Ok(self.memories.iter().zip(&self.plan.metrics).map(of).collect())
    }

    fn steps(
        &mut self,
        instances: &mut [Instance],
        steps: usize,
        run: usize,
        quantities: &[f64],
        stop: &AtomicBool,
        see: &mut Option<See<'_>>,
    ) -> Result<(), Ended> {
        let plan = self.plan;
        let (grid, draw) = (plan.system.grid, plan.draw_of(run));
        self.signals.clear();
        self.signals
            .extend(plan.disturbances.iter().map(|d| d.signal(quantities, draw, grid.step)));
        self.memories.clear();
        self.memories.extend(plan.metrics.iter().map(|m| Memory::new(m, quantities)));
        let signals = &mut self.signals;
        let mut disturb = |time: f64, values: &mut [f64]| {
            for (value, signal) in values.iter_mut().zip(&mut *signals) {
                *value = signal.next(time, grid.step);
            }
        };
        let memories = &mut self.memories;
        let mut observe = |time: f64, values: &[f64]| {
            for (memory, metric) in memories.iter_mut().zip(&plan.metrics) {
                memory.see(metric, values, time, grid.step);
            }
            if let Some(see) = see {
                see(time, values);
            }
        };
        self.run.initialize(instances, quantities, &mut disturb)?;
        observe(grid.start, self.run.values());
        for k in 0..steps.min(grid.steps) {
            self.run.step(instances, k, &mut disturb)?;
            observe(grid.time(k + 1), self.run.values());
            if k % STEPS_BETWEEN_CHECKS == 0 {
                if stop.load(Ordering::Relaxed) {
                    return Err(Ended::Stopped);
                }
                if self.deadline.is_some_and(|deadline| Instant::now() > deadline) {
                    return Err(Ended::TooLong);
                }
            }
        }
        for instance in instances {
            instance.terminate()?;
        }
        Ok(())
    }
}
