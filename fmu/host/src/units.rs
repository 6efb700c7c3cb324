//! Units of FMUs and of the packages that they are in, related to each other.
//!
//! A value in the base units is `factor · value + offset` of the value in the unit (FMI 2.0,
//! section 2.2.2; `ssc:BaseUnit` of SSP 1.0 is the same). Display units count as units: with
//! `display = f · value + o` they are `factor/f · display + (offset − factor · o/f)` in base units.

use model_description::{BaseUnit, Unit};

/// Relative difference below which two factors are the same, for constants written to few digits.
const SAME: f64 = 1e-9;

/// A unit name in base units, as defined by an FMU or by the package.
pub(crate) fn base_of(name: &str, fmu: &[Unit], package: &[Unit]) -> Option<BaseUnit> {
    let defined = |units: &[Unit]| units.iter().find(|u| u.name == name).and_then(|u| u.base);
    defined(fmu).or_else(|| defined(package)).or_else(|| {
        fmu.iter().find_map(|unit| {
            let base = unit.base?;
            let shown = unit.display_units.iter().find(|d| d.name == name && d.factor != 0.0)?;
            let factor = base.factor / shown.factor;
            Some(BaseUnit { factor, offset: base.offset - factor * shown.offset, ..base })
        })
    })
}

/// How two units are related.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Relation {
    Same,
    /// The second is `factor · first + offset`.
    Scaled {
        factor: f64,
        offset: f64,
    },
    OtherDimension,
}

/// How values in two units are related.
pub(crate) fn relation(from: &BaseUnit, to: &BaseUnit) -> Relation {
    if from.exponents != to.exponents {
        return Relation::OtherDimension;
    }
    let (factor, offset) = (from.factor / to.factor, (from.offset - to.offset) / to.factor);
    if (factor - 1.0).abs() < SAME && offset.abs() < SAME {
        Relation::Same
    } else {
        Relation::Scaled { factor, offset }
    }
}

/// A value in a unit that the FMU's definitions (or the package's) relate to the variable's unit,
/// as the variable takes it; `None` where nothing relates them or the dimensions differ.
pub(crate) fn converted(
    value: f64,
    given: &str,
    unit: &str,
    fmu: &[Unit],
    package: &[Unit],
) -> Option<f64> {
    // A display unit needs no base units.
    let shown = fmu
        .iter()
        .find(|u| u.name == unit)
        .and_then(|u| u.display_units.iter().find(|d| d.name == given && d.factor != 0.0));
    let value = if let Some(shown) = shown {
        (value - shown.offset) / shown.factor
    } else {
        let (from, to) = (base_of(given, fmu, package)?, base_of(unit, fmu, package)?);
        match relation(&from, &to) {
            Relation::Same => value,
            Relation::Scaled { factor, offset } => factor * value + offset,
            Relation::OtherDimension => return None,
        }
    };
    if value.is_finite() { Some(value) } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;
    use model_description::DisplayUnit;

    fn unit(name: &str, factor: f64, offset: f64, shown: Option<(&str, f64, f64)>) -> Unit {
        let exponents = [0, 0, 0, 0, 1, 0, 0, 0];
        let display_units = shown
            .map(|(name, factor, offset)| DisplayUnit { name: name.into(), factor, offset })
            .into_iter()
            .collect();
        let base = Some(BaseUnit { exponents, factor, offset });
        Unit { name: name.into(), base, display_units }
    }

    #[test]
    fn temperatures_convert_with_their_offsets() {
        // The standard's own example, section 2.2.2: K, degC, degF.
        let kelvin = unit("K", 1.0, 0.0, Some(("degC", 1.0, -273.15)));
        let fahrenheit = unit("degF", 5.0 / 9.0, 273.15 - 32.0 * 5.0 / 9.0, None);
        let to_kelvin = |value, given| {
            let kelvin = std::slice::from_ref(&kelvin);
            converted(value, given, "K", kelvin, std::slice::from_ref(&fahrenheit))
        };
        assert!((to_kelvin(20.0, "degC").unwrap() - 293.15).abs() < 1e-9);
        assert!((to_kelvin(212.0, "degF").unwrap() - 373.15).abs() < 1e-9);
        assert_eq!(to_kelvin(1.0, "m"), None);
        let celsius = base_of("degC", std::slice::from_ref(&kelvin), &[]).unwrap();
        assert!((celsius.offset - 273.15).abs() < 1e-9, "{celsius:?}");
    }
}
