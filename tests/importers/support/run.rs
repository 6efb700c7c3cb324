//! Co-simulation over any importer.
//!
//! Written against the FMI 2.0 text and the interfaces of the FMUs alone, like the one in
//! tests/python: neither knows anything of the Rust host in fmu/host.

use super::LoopCoupling;

/// One FMU in an importer, its variables by name; Booleans are 1 and 0.
pub(crate) trait Unit {
    /// Leaves the state of instantiation: experiment from time 0, initialization mode.
    fn enter_initialization(&mut self);
    fn exit_initialization(&mut self);
    fn set(&mut self, variable: &str, value: f64);
    fn get(&mut self, variable: &str) -> f64;
    fn step(&mut self, time: f64, step: f64);
    fn terminate(&mut self);
}

/// A variable of a unit: the unit's place in the order of steps, and the variable's name.
pub(crate) type Port<'a> = (usize, &'a str);
/// From an output to an input.
pub(crate) type Wire<'a> = (Port<'a>, Port<'a>);

/// Steps the units in their order; gives time and the recorded variables, a row each point.
pub(crate) fn run<U: Unit>(
    units: &mut [U],
    wires: &[Wire<'_>],
    coupling: LoopCoupling,
    steps: usize,
    step: f64,
    record: &[Port<'_>],
) -> Vec<Vec<f64>> {
    // What stands on the wires; a Jacobi coupling reads all before it sets any.
    let read = |units: &mut [U]| -> Vec<f64> {
        wires.iter().map(|((unit, output), _)| units[*unit].get(output)).collect()
    };
    let feed = |units: &mut [U], sink: usize, values: &[f64]| {
        for ((_, (unit, input)), value) in wires.iter().zip(values) {
            if *unit == sink {
                units[sink].set(input, *value);
            }
        }
    };
    let row = |units: &mut [U], time: f64| {
        let values = record.iter().map(|(unit, variable)| units[*unit].get(variable));
        std::iter::once(time).chain(values).collect()
    };
    units.iter_mut().for_each(Unit::enter_initialization);
    // No chain of wires is longer than the units are many.
    for _ in 0..=units.len() {
        for sink in 0..units.len() {
            let values = read(units);
            feed(units, sink, &values);
        }
    }
    units.iter_mut().for_each(Unit::exit_initialization);
    let mut rows = vec![row(units, 0.0)];
    for k in 0..steps {
        let mut values = read(units);
        for sink in 0..units.len() {
            feed(units, sink, &values);
            units[sink].step(k as f64 * step, step);
            if coupling == LoopCoupling::GaussSeidel {
                values = read(units);
            }
        }
        rows.push(row(units, (k + 1) as f64 * step));
    }
    units.iter_mut().for_each(Unit::terminate);
    rows
}
