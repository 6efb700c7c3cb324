//! The values that pass between instances, and the ports through which they do.
//!
//! All outputs that are connected or recorded and all columns of an input table have a place in
//! [`Signals`]. What an instance gives and takes is resolved once into [`Ports`], so that a step
//! looks up no name and allocates nothing.

use model_description::Kind;

use crate::{Error, Instance};

/// The present values, by kind.
#[derive(Debug, Default)]
pub(super) struct Signals {
    real: Vec<f64>,
    integer: Vec<i32>,
    boolean: Vec<bool>,
    string: Vec<String>,
}

/// The place of a value in [`Signals`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Slot {
    pub(super) kind: Kind,
    index: usize,
}

impl Signals {
    /// A new place for a value of a kind.
    pub(super) fn slot(&mut self, kind: Kind) -> Slot {
        fn grow<T: Default>(store: &mut Vec<T>) -> usize {
            store.push(T::default());
            store.len() - 1
        }
        let index = match kind {
            Kind::Real => grow(&mut self.real),
            Kind::Integer => grow(&mut self.integer),
            Kind::Boolean => grow(&mut self.boolean),
            Kind::String => grow(&mut self.string),
        };
        Slot { kind, index }
    }

    /// A value as a number, Booleans as 1 and 0; texts are never asked for.
    pub(super) fn number(&self, slot: Slot) -> f64 {
        match slot.kind {
            Kind::Real => self.real[slot.index],
            Kind::Integer => f64::from(self.integer[slot.index]),
            Kind::Boolean => f64::from(u8::from(self.boolean[slot.index])),
            Kind::String => f64::NAN,
        }
    }

    /// Puts a number into a place; whether it fits the kind was asked before.
    pub(super) fn put(&mut self, slot: Slot, number: f64) {
        match slot.kind {
            Kind::Real => self.real[slot.index] = number,
            Kind::Integer => self.integer[slot.index] = number as i32,
            Kind::Boolean => self.boolean[slot.index] = number != 0.0,
            Kind::String => {}
        }
    }

    /// Whether a value is anything but NaN or infinite.
    fn is_finite(&self, slot: Slot) -> bool {
        slot.kind != Kind::Real || self.real[slot.index].is_finite()
    }
}

/// Variables of one kind of one instance, and their places.
#[derive(Debug, Default)]
struct Lane<T> {
    references: Vec<u32>,
    places: Vec<usize>,
    buffer: Vec<T>,
}

impl<T: Clone + Default + PartialEq> Lane<T> {
    fn add(&mut self, reference: u32, place: usize) {
        self.references.push(reference);
        self.places.push(place);
        self.buffer.push(T::default());
    }

    fn gather(&mut self, store: &[T]) {
        for (value, place) in self.buffer.iter_mut().zip(&self.places) {
            value.clone_from(&store[*place]);
        }
    }

    /// Whether anything changed.
    fn scatter(&self, store: &mut [T]) -> bool {
        let mut changed = false;
        for (value, place) in self.buffer.iter().zip(&self.places) {
            if store[*place] != *value {
                store[*place].clone_from(value);
                changed = true;
            }
        }
        changed
    }
}

/// Variables of one instance that are read into [`Signals`], or set from there.
#[derive(Debug, Default)]
pub(super) struct Ports {
    real: Lane<f64>,
    integer: Lane<i32>,
    boolean: Lane<bool>,
    string: Lane<String>,
    /// For messages.
    names: Vec<(Slot, String)>,
}

impl Ports {
    pub(super) fn add(&mut self, name: &str, reference: u32, slot: Slot) {
        match slot.kind {
            Kind::Real => self.real.add(reference, slot.index),
            Kind::Integer => self.integer.add(reference, slot.index),
            Kind::Boolean => self.boolean.add(reference, slot.index),
            Kind::String => self.string.add(reference, slot.index),
        }
        self.names.push((slot, name.to_owned()));
    }

    /// Reads the variables; whether any value changed.
    pub(super) fn read(
        &mut self,
        instance: &mut Instance,
        signals: &mut Signals,
    ) -> Result<bool, Error> {
        instance.get_real(&self.real.references, &mut self.real.buffer)?;
        let mut changed = self.real.scatter(&mut signals.real);
        instance.get_integer(&self.integer.references, &mut self.integer.buffer)?;
        changed |= self.integer.scatter(&mut signals.integer);
        instance.get_boolean(&self.boolean.references, &mut self.boolean.buffer)?;
        changed |= self.boolean.scatter(&mut signals.boolean);
        self.string.buffer = instance.get_string(&self.string.references)?;
        changed |= self.string.scatter(&mut signals.string);
        Ok(changed)
    }

    /// Sets the variables.
    pub(super) fn write(
        &mut self,
        instance: &mut Instance,
        signals: &Signals,
    ) -> Result<(), Error> {
        self.real.gather(&signals.real);
        instance.set_real(&self.real.references, &self.real.buffer)?;
        self.integer.gather(&signals.integer);
        instance.set_integer(&self.integer.references, &self.integer.buffer)?;
        self.boolean.gather(&signals.boolean);
        instance.set_boolean(&self.boolean.references, &self.boolean.buffer)?;
        self.string.gather(&signals.string);
        instance.set_string(&self.string.references, &self.string.buffer)
    }

    /// Refuses values that have left the numbers, with the variable's name.
    pub(super) fn check_finite(
        &self,
        instance: &Instance,
        signals: &Signals,
        time: f64,
    ) -> Result<(), Error> {
        if self.real.buffer.iter().all(|value| value.is_finite()) {
            return Ok(());
        }
        match self.names.iter().find(|(slot, _)| !signals.is_finite(*slot)) {
            None => Ok(()),
            Some((slot, name)) => Err(Error::NonFiniteOutput {
                variable: format!("{}.{name}", instance.name()),
                value: signals.number(*slot),
                time,
            }),
        }
    }
}
