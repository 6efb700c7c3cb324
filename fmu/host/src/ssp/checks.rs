//! Whether the connectors of a package agree with the variables of its FMUs.
//!
//! A connector that differs from the variable of its FMU is reported, and the FMU has priority.
//! Values are converted from the unit of the one end to that of the other.

use model_description::{Causality, Unit, Variable};

use super::structure::{Component, Connector, SspPlace};
use crate::Error;
use crate::archive::Archive;
use crate::names::near_text;
use crate::system::{Connection, Linear};
use crate::units::{Relation, base_of, relation};

/// The differences between a component's connectors and its FMU, one line each.
pub(super) fn connectors(component: &Component, archive: &Archive) -> Vec<String> {
    let mut remarks = Vec::new();
    for connector in &component.connectors {
        let place = &connector.place;
        let path = format!("{}.{}", component.name, connector.name);
        let Some(variable) = archive.model().variable(&connector.name) else {
            let near = near_text(&archive.model().near(&connector.name));
            remarks
                .push(format!("{place}: {path} is a connector and no variable of the FMU{near}"));
            continue;
        };
        let mut differs = |what: &str, fmu: &str, stated: &str| {
            remarks.push(format!(
                "{place}: the connector {path} has the {what} {stated:?}, its FMU has {fmu:?}; \
                 the FMU counts"
            ));
        };
        let causality = variable.causality.to_string();
        if connector.kind != causality {
            differs("kind", &causality, &connector.kind);
        }
        let of_kind = variable.kind.as_str();
        if let Some(stated) = &connector.of_type
            && stated != of_kind
            && !(variable.is_enumeration && stated == "Enumeration")
        {
            differs("type", if variable.is_enumeration { "Enumeration" } else { of_kind }, stated);
        }
        if let (Some(stated), Some(fmu)) = (&connector.unit, &variable.unit)
            && stated != fmu
        {
            differs("unit", fmu, stated);
        }
    }
    remarks
}

/// One end of a connection: a variable of a component, or a connector of the system.
pub(super) struct End<'a> {
    /// The unit that the connector states.
    stated: Option<&'a str>,
    /// `None` for a connector of the system.
    variable: Option<&'a Variable>,
    /// The units of the FMU.
    units: &'a [Unit],
}

impl<'a> End<'a> {
    /// The variable of a component, where there is that component.
    pub(super) fn find(
        mut all: impl Iterator<Item = (&'a Component, &'a Archive)>,
        component: &str,
        name: &str,
    ) -> Option<Self> {
        let (component, archive) = all.find(|(known, _)| known.name == component)?;
        let connector = component.connectors.iter().find(|connector| connector.name == name);
        Some(Self {
            stated: connector.and_then(|connector| connector.unit.as_deref()),
            variable: archive.model().variable(name),
            units: &archive.model().description().units,
        })
    }

    /// A connector of the system.
    pub(super) fn of_system(connector: &'a Connector) -> Self {
        Self { stated: connector.unit.as_deref(), variable: None, units: &[] }
    }

    pub(super) fn causality(&self) -> Option<Causality> {
        self.variable.map(|v| v.causality)
    }

    fn unit_of_fmu(&self) -> Option<&str> {
        self.variable?.unit.as_deref()
    }
}

/// How values pass from the one end to the other: the units of connectors and FMUs must not differ in dimension;
/// where those of the FMUs differ in factor or offset, values are converted, unless the package forbids it
/// (`suppressUnitConversion`). Returns the conversion, and a remark, if there is one.
pub(super) fn units(
    connection: &Connection,
    (from, to): (&End<'_>, &End<'_>),
    package: &[Unit],
    suppressed: bool,
) -> Result<(Linear, Option<String>), Error> {
    let ends = |from_unit: &str, to_unit: &str| {
        let quoted = |path: String, unit: &str| (path, unit.to_owned());
        (quoted(connection.source(), from_unit), quoted(connection.target(), to_unit))
    };
    let related = |one: &str, other: &str| {
        let bases = (base_of(one, from.units, package), base_of(other, to.units, package));
        match bases {
            _ if one == other => Some(Relation::Same),
            (Some(one), Some(other)) => Some(relation(&one, &other)),
            _ => None,
        }
    };
    let other_dimension = |one: &str, other: &str| {
        let ((from, from_unit), (to, to_unit)) = ends(one, other);
        Error::UnitDimension { from, from_unit, to, to_unit }
    };
    let stated = |end: &End<'_>| end.stated.or(end.unit_of_fmu()).map(str::to_owned);
    if let (Some(one), Some(other)) = (stated(from), stated(to))
        && related(&one, &other) == Some(Relation::OtherDimension)
    {
        return Err(other_dimension(&one, &other));
    }
    let meant = |end: &End<'_>| end.unit_of_fmu().or(end.stated).map(str::to_owned);
    let (Some(one), Some(other)) = (meant(from), meant(to)) else {
        return Ok((Linear::IDENTITY, None));
    };
    let relation = related(&one, &other);
    match relation {
        Some(Relation::Same) => Ok((Linear::IDENTITY, None)),
        Some(Relation::OtherDimension) => Err(other_dimension(&one, &other)),
        _ if suppressed => {
            let remark = format!(
                "{connection} passes values in {one:?} to {other:?} as they are: \
                 suppressUnitConversion is true"
            );
            Ok((Linear::IDENTITY, Some(remark)))
        }
        Some(Relation::Scaled { factor, offset }) => Ok((Linear { factor, offset }, None)),
        None => {
            let ((from, from_unit), (to, to_unit)) = ends(&one, &other);
            Err(Error::UnitMismatch { from, from_unit, to, to_unit })
        }
    }
}

/// An error of a connection, with the place and the ends as they are written.
pub(super) fn error_at(
    package: &str,
    place: &SspPlace,
    written: &Connection,
    source: Error,
) -> Error {
    Error::SystemConnection {
        package: package.to_owned(),
        file: place.file.clone(),
        line: place.line,
        start: written.source(),
        end: written.target(),
        source: Box::new(source),
    }
}
