//! The model structure of a unit with its states: Outputs, Derivatives and InitialUnknowns with
//! their dependencies (section 2.2.8).
//!
//! At a communication point the knowns are the inputs and the states, and [`CoSimulationUnit::dependency`]
//! returns the dependencies. In initialization mode the knowns are the inputs and the variables with
//! `initial="exact"`. There a row of the table lists the variables that it depends on, and
//! [`CoSimulationUnit::dependency`] adds the other dependencies, for example a feedthrough that is defined by the
//! resources.

use crate::unit::{CoSimulationUnit, Known, Unknown, VariableId, listed};
use model_description as xml;
use model_description::{Causality, DependencyKind, Initial, ModelDescription};

/// How an unknown depends on a known in initialization mode.
pub(crate) fn depends_initially<S: CoSimulationUnit>(
    unit: &S,
    unknown: Unknown<S::Variable>,
    known: Known<S::Variable>,
) -> Option<DependencyKind> {
    let of_table = match (unknown, known) {
        (Unknown::Variable(unknown), Known::Variable(known)) => {
            listed(unknown.spec().initial_depends_on, known)
        }
        _ => None,
    };
    match (unknown, known) {
        _ if of_table.is_some() => of_table,
        // A calculated parameter is fixed before the states are initialized.
        (Unknown::Variable(unknown), Known::State(_))
            if unknown.spec().causality == Causality::CalculatedParameter =>
        {
            None
        }
        // The standard defines no other kinds in initialization mode.
        _ => match unit.dependency(unknown, known)? {
            DependencyKind::Constant => Some(DependencyKind::Constant),
            _ => Some(DependencyKind::Dependent),
        },
    }
}

/// Fills in the model structure of a description that has these rows of the table and the states.
pub(crate) fn structure<S: CoSimulationUnit>(
    unit: &S,
    rows: &[&xml::VariableSpec],
    settable: &[bool],
    description: &mut ModelDescription,
) {
    // Indices start at 1: first the rows, then state and derivative alternately.
    let state_index = |state: usize| index(rows.len() + 2 * state);
    let derivative_index = |state: usize| index(rows.len() + 2 * state + 1);
    let variables = |wanted: &dyn Fn(&xml::VariableSpec) -> bool| -> Vec<_> {
        rows.iter()
            .enumerate()
            .filter(|(_, row)| wanted(row))
            .filter_map(|(i, row)| Some((index(i), S::Variable::from_reference(row.reference)?)))
            .collect()
    };
    let states = |wanted: &dyn Fn(bool) -> bool| {
        (0..settable.len())
            .filter(|state| settable.get(*state).is_some_and(|settable| wanted(*settable)))
            .map(|state| (state_index(state), Known::State(state)))
            .collect::<Vec<_>>()
    };
    let knowns = |variables: Vec<(u32, S::Variable)>, states: Vec<(u32, Known<S::Variable>)>| {
        let variables = variables.into_iter().map(|(i, variable)| (i, Known::Variable(variable)));
        variables.chain(states).collect::<Vec<_>>()
    };
    let is_input = |row: &xml::VariableSpec| row.causality == Causality::Input;
    let is_exact = |row: &xml::VariableSpec| row.effective_initial() == Some(Initial::Exact);

    let at_points = knowns(variables(&is_input), states(&|_| true));
    let later = |index: u32, unknown: Unknown<S::Variable>| {
        list(index, &at_points, |known| unit.dependency(unknown, known))
    };
    description.outputs = variables(&|row| row.causality == Causality::Output)
        .into_iter()
        .map(|(index, variable)| later(index, Unknown::Variable(variable)))
        .collect();
    description.derivatives = (0..settable.len())
        .map(|state| later(derivative_index(state), Unknown::Derivative(state)))
        .collect();

    let at_first = knowns(variables(&|row| is_input(row) || is_exact(row)), states(&|exact| exact));
    let first = |index: u32, unknown: Unknown<S::Variable>| {
        list(index, &at_first, |known| depends_initially(unit, unknown, known))
    };
    let of_table = description.initial_unknowns.iter().filter_map(|unknown| {
        let row = rows.get(usize::try_from(unknown.index).ok()?.checked_sub(1)?)?;
        Some(first(unknown.index, Unknown::Variable(S::Variable::from_reference(row.reference)?)))
    });
    let of_states = settable.iter().enumerate().flat_map(|(state, settable)| {
        let follows =
            if *settable { None } else { Some(first(state_index(state), Unknown::State(state))) };
        let derivative = first(derivative_index(state), Unknown::Derivative(state));
        follows.into_iter().chain([derivative])
    });
    description.initial_unknowns = of_table.chain(of_states).collect();
}

/// The index, from 1, of the variable at a position from 0.
fn index(place: usize) -> u32 {
    u32::try_from(place + 1).unwrap_or(u32::MAX)
}

/// An unknown with the knowns that it depends on.
fn list<V: Copy>(
    index: u32,
    knowns: &[(u32, Known<V>)],
    dependency: impl Fn(Known<V>) -> Option<DependencyKind>,
) -> xml::Unknown {
    let found: Vec<(u32, DependencyKind)> = knowns
        .iter()
        .filter_map(|&(index, known)| dependency(known).map(|kind| (index, kind)))
        .collect();
    let (dependencies, kinds): (Vec<u32>, Vec<DependencyKind>) = found.into_iter().unzip();
    // Without dependencies the kinds are left out: some importers reject an empty list.
    let kinds = if kinds.is_empty() { None } else { Some(kinds) };
    xml::Unknown { index, dependencies: Some(dependencies), kinds }
}
