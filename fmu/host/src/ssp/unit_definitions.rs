//! `Units` of an `.ssd` or `.ssv` file.

use model_description::{BaseUnit, Unit};

use super::read::Element;
use crate::Error;

/// The units that an element defines; `namespace` is that of its file, `common` that of
/// `ssc:Unit`.
pub(super) fn read(
    parent: Element<'_, '_>,
    namespace: &'static str,
    common: &'static str,
) -> Result<Vec<Unit>, Error> {
    let all = parent.child(namespace, "Units").into_iter().flat_map(Element::children);
    all.filter(|element| element.is(common, "Unit"))
        .map(|element| {
            let name = element.attribute("name")?.to_owned();
            let base = element.child(common, "BaseUnit").map(base).transpose()?;
            Ok(Unit { name, base, display_units: Vec::new() })
        })
        .collect()
}

fn base(element: Element<'_, '_>) -> Result<BaseUnit, Error> {
    let mut exponents = [0; 8];
    for (exponent, symbol) in exponents.iter_mut().zip(BaseUnit::SYMBOLS) {
        if let Some(text) = element.optional(symbol) {
            let bad = || element.error(format!("{symbol} is {text:?}, not a whole number"));
            *exponent = text.trim().parse().map_err(|_| bad())?;
        }
    }
    let factor = element.number("factor")?.unwrap_or(1.0);
    if factor == 0.0 {
        return Err(element.error("the factor of a unit is 0"));
    }
    Ok(BaseUnit { exponents, factor, offset: element.number("offset")?.unwrap_or(0.0) })
}
