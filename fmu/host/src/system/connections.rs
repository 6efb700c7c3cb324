//! Connections: their rules, and wiring by equal names.

use model_description::{Causality, Kind};

use super::by_name::{Connection, Measurement, Unit, wires_by_name};
use super::{Linear, OutsideInput, System};
use crate::Error;

impl System {
    /// The connections made so far.
    #[must_use]
    pub fn connections(&self) -> &[Connection] {
        &self.connections
    }

    /// Connects an output to an input of the same kind, or an Integer to a Real, and, where both state one, of the same
    /// unit.
    pub fn connect(&mut self, connection: Connection) -> Result<&mut Self, Error> {
        self.connect_in(connection, true)
    }

    /// [`System::connect`] with a change of the values, which is that of their units too.
    pub fn connect_scaled(&mut self, connection: Connection, scale: Linear) -> Result<(), Error> {
        let target = (connection.to.clone(), connection.input.clone());
        let ends = (connection.source(), connection.target());
        self.connect_in(connection, false)?;
        if scale == Linear::IDENTITY {
            return Ok(());
        }
        let kind = self.instances[self.index(&target.0)?].variable(&target.1)?.kind;
        if kind != Kind::Real {
            self.connections.pop();
            return Err(Error::ScaledKind { from: ends.0, to: ends.1, kind });
        }
        self.scales.insert(target, scale);
        Ok(())
    }

    fn connect_in(
        &mut self,
        connection: Connection,
        compare_units: bool,
    ) -> Result<&mut Self, Error> {
        let from = self.instances[self.index(&connection.from)?].variable(&connection.output)?;
        let to = self.instances[self.index(&connection.to)?].variable(&connection.input)?;
        let (start, end) = (connection.source(), connection.target());
        if from.causality != Causality::Output {
            let got = from.causality;
            return Err(Error::WrongCausality { end: start, need: "output", got });
        }
        if to.causality != Causality::Input {
            return Err(Error::WrongCausality { end, need: "input", got: to.causality });
        }
        let is_widened = from.kind == Kind::Integer && to.kind == Kind::Real;
        if from.kind != to.kind && !is_widened {
            let (from_kind, to_kind) = (from.kind, to.kind);
            return Err(Error::KindMismatch { from: start, from_kind, to: end, to_kind });
        }
        if compare_units
            && let (Some(from_unit), Some(to_unit)) = (&from.unit, &to.unit)
            && from_unit != to_unit
        {
            let (from_unit, to_unit) = (from_unit.clone(), to_unit.clone());
            return Err(Error::UnitMismatch { from: start, from_unit, to: end, to_unit });
        }
        if let Some(present) = self.feeding(&connection.to, &connection.input) {
            return Err(Error::AlreadyConnected {
                to: end,
                present: present.source(),
                from: start,
            });
        }
        self.connections.push(connection);
        Ok(self)
    }

    /// Feeds an input from a connector of the system itself: from the column of the table that has the
    /// connector's name, scaled, otherwise with the input's own value.
    pub fn connect_input(
        &mut self,
        connector: &str,
        instance: &str,
        input: &str,
        scale: Linear,
    ) -> Result<(), Error> {
        let to = self.instances[self.index(instance)?].variable(input)?;
        let end = format!("{instance}.{input}");
        if to.causality != Causality::Input {
            return Err(Error::WrongCausality { end, need: "input", got: to.causality });
        }
        if to.kind != Kind::Real && scale != Linear::IDENTITY {
            let (from, kind) = (connector.to_owned(), to.kind);
            return Err(Error::ScaledKind { from, to: end, kind });
        }
        let connected = self.feeding(instance, input).map(Connection::source);
        let outside = self.inputs.iter().find(|i| i.instance == instance && i.input == input);
        if let Some(present) = connected.or(outside.map(|i| i.connector.clone())) {
            return Err(Error::AlreadyConnected { to: end, present, from: connector.to_owned() });
        }
        let (instance, input) = (instance.to_owned(), input.to_owned());
        self.inputs.push(OutsideInput { connector: connector.to_owned(), instance, input, scale });
        Ok(())
    }

    /// Whether a column of the table names an input: by the connector of the system that feeds it, as
    /// `instance.input`, or, where no connector of the system has the name, as `input`.
    pub(super) fn is_column_of(&self, column: &str, index: usize, input: &str) -> bool {
        if self.path(index, input) == column {
            return true;
        }
        let named = || self.inputs.iter().filter(|outside| outside.connector == column);
        let instance = self.instances[index].name();
        match named().next() {
            Some(_) => named().any(|i| i.instance == instance && i.input == input),
            None => input == column,
        }
    }

    /// The change of a column's values on the way to an input: that of the connector by which the column is named.
    pub(super) fn scale_of_column(&self, column: &str, index: usize, input: &str) -> Linear {
        let instance = self.instances[index].name();
        let mut named = self.inputs.iter().filter(|outside| outside.connector == column);
        let outside = named.find(|i| i.instance == instance && i.input == input);
        outside.map_or(Linear::IDENTITY, |outside| outside.scale)
    }

    /// Wires each input that has no connection yet by its name ([`wires_by_name`]); an input without a
    /// counterpart stays as it is. Returns the new connections, or makes none.
    pub fn connect_by_name(
        &mut self,
        measurements: &[Measurement<'_>],
    ) -> Result<Vec<Connection>, Error> {
        let units: Vec<Unit<'_>> =
            self.instances.iter().map(|i| Unit::new(i.name(), i.model().variables())).collect();
        let is_fed = |unit: &Unit<'_>, input: &str| self.feeding(unit.name, input).is_some();
        let mut new = wires_by_name(&units, measurements, &is_fed)?;
        // Measurements may come from the table.
        new.retain(|c| c.output == c.input || !self.is_in_table(&c.to, &c.input));
        let before = self.connections.len();
        for connection in &new {
            if let Err(error) = self.connect(connection.clone()).map(drop) {
                // All of them or none.
                self.connections.truncate(before);
                return Err(error);
            }
        }
        Ok(new)
    }

    /// Whether a column of the table names an input.
    fn is_in_table(&self, instance: &str, input: &str) -> bool {
        self.table.as_ref().is_some_and(|table| {
            let path = format!("{instance}.{input}");
            table.columns().iter().any(|column| *column == input || *column == path)
        })
    }

    /// The connection that feeds an input.
    pub(super) fn feeding(&self, instance: &str, input: &str) -> Option<&Connection> {
        self.connections.iter().find(|c| c.to == instance && c.input == input)
    }
}
