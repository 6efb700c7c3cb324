//! Units of the channels of a multivariable plant: symbols of the SI and of engineering, with prefixes, products,
//! quotients and powers, such as `V`, `kPa`, `N.m/rad`, `J/(kg.K)`, `1/min` and `degC`.
//!
//! A channel keeps the unit of its log. What a unit is in base units of the SI is needed where it leaves the project, in
//! the XML of an FMU.

/// A unit in base units of the SI: `value in base units = factor · value + offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhysicalUnit {
    /// Exponents of kg, m, s, A, K, mol, cd and rad.
    pub exponents: [i32; 8],
    /// Base units in one unit.
    pub factor: f64,
    /// Value of 0 in base units: 273.15 of `degC`, 0 of units without a zero of their own.
    pub offset: f64,
}

/// Base unit, its exponents of kg, m, s, A, K, mol, cd and rad, and whether it takes prefixes.
type Symbol = (&'static [&'static str], f64, [i32; 8], bool);

const SYMBOLS: &[Symbol] = &[
    (&["1"], 1.0, [0; 8], false),
    (&["%"], 0.01, [0; 8], false),
    (&["m"], 1.0, [0, 1, 0, 0, 0, 0, 0, 0], true),
    (&["s", "sec"], 1.0, [0, 0, 1, 0, 0, 0, 0, 0], true),
    (&["A"], 1.0, [0, 0, 0, 1, 0, 0, 0, 0], true),
    (&["K"], 1.0, [0, 0, 0, 0, 1, 0, 0, 0], true),
    (&["mol"], 1.0, [0, 0, 0, 0, 0, 1, 0, 0], true),
    (&["cd"], 1.0, [0, 0, 0, 0, 0, 0, 1, 0], true),
    (&["rad"], 1.0, [0, 0, 0, 0, 0, 0, 0, 1], true),
    (&["deg", "°"], std::f64::consts::PI / 180.0, [0, 0, 0, 0, 0, 0, 0, 1], false),
    (&["arcmin"], std::f64::consts::PI / 10_800.0, [0, 0, 0, 0, 0, 0, 0, 1], false),
    (&["rev"], std::f64::consts::TAU, [0, 0, 0, 0, 0, 0, 0, 1], false),
    (&["rpm"], std::f64::consts::TAU / 60.0, [0, 0, -1, 0, 0, 0, 0, 1], false),
    (&["Hz"], 1.0, [0, 0, -1, 0, 0, 0, 0, 0], true),
    (&["N"], 1.0, [1, 1, -2, 0, 0, 0, 0, 0], true),
    (&["Nm"], 1.0, [1, 2, -2, 0, 0, 0, 0, 0], true),
    (&["Pa"], 1.0, [1, -1, -2, 0, 0, 0, 0, 0], true),
    (&["bar"], 1e5, [1, -1, -2, 0, 0, 0, 0, 0], true),
    (&["J"], 1.0, [1, 2, -2, 0, 0, 0, 0, 0], true),
    (&["W"], 1.0, [1, 2, -3, 0, 0, 0, 0, 0], true),
    (&["Wh"], 3600.0, [1, 2, -2, 0, 0, 0, 0, 0], true),
    (&["V"], 1.0, [1, 2, -3, -1, 0, 0, 0, 0], true),
    (&["ohm", "Ω"], 1.0, [1, 2, -3, -2, 0, 0, 0, 0], true),
    (&["C"], 1.0, [0, 0, 1, 1, 0, 0, 0, 0], true),
    (&["F"], 1.0, [-1, -2, 4, 2, 0, 0, 0, 0], true),
    (&["H"], 1.0, [1, 2, -2, -2, 0, 0, 0, 0], true),
    (&["T"], 1.0, [1, 0, -2, -1, 0, 0, 0, 0], true),
    (&["Wb"], 1.0, [1, 2, -2, -1, 0, 0, 0, 0], true),
    (&["min"], 60.0, [0, 0, 1, 0, 0, 0, 0, 0], false),
    (&["h"], 3600.0, [0, 0, 1, 0, 0, 0, 0, 0], false),
    (&["l", "L"], 1e-3, [0, 3, 0, 0, 0, 0, 0, 0], true),
    (&["t"], 1000.0, [1, 0, 0, 0, 0, 0, 0, 0], false),
    (&["mph"], 0.447_04, [0, 1, -1, 0, 0, 0, 0, 0], false),
    (&["knots", "knot"], 1852.0 / 3600.0, [0, 1, -1, 0, 0, 0, 0, 0], false),
    // As logs of vehicles state accelerations; a mass in grams has a prefix.
    (&["g"], 9.806_65, [0, 1, -2, 0, 0, 0, 0, 0], false),
];

const GRAM: (f64, [i32; 8]) = (1e-3, [1, 0, 0, 0, 0, 0, 0, 0]);

const PREFIXES: &[(&str, f64)] = &[
    ("n", 1e-9),
    ("u", 1e-6),
    ("m", 1e-3),
    ("c", 1e-2),
    ("d", 1e-1),
    ("h", 1e2),
    ("k", 1e3),
    ("M", 1e6),
    ("G", 1e9),
];

/// Units with a zero of their own, which stand alone: symbol, kelvins in one, and the kelvins of 0.
const TEMPERATURES: &[(&str, f64, f64)] =
    &[("degC", 1.0, 273.15), ("degF", 5.0 / 9.0, 459.67 * 5.0 / 9.0)];

impl PhysicalUnit {
    /// The unit of no dimension.
    pub const ONE: Self = Self { exponents: [0; 8], factor: 1.0, offset: 0.0 };

    /// The unit of a text as [`Self::plain`] writes it or as people do; `None` for another text.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        let text = Self::plain(text);
        if let Some((_, factor, offset)) = TEMPERATURES.iter().find(|(name, ..)| *name == text) {
            return Some(Self {
                exponents: [0, 0, 0, 0, 1, 0, 0, 0],
                factor: *factor,
                offset: *offset,
            });
        }
        let mut rest = text.as_str();
        let unit = product(&mut rest)?;
        rest.is_empty().then_some(unit)
    }

    /// The text with `.` for products, digits for powers, and letters for the degree sign, the micro sign and the ohm.
    #[must_use]
    pub fn plain(text: &str) -> String {
        let mut text = text.trim().to_owned();
        for (from, to) in [
            ("Â°", "°"),
            ("º", "°"),
            ("˚", "°"),
            ("°C", "degC"),
            ("°F", "degF"),
            ("°", "deg"),
            ("µ", "u"),
            ("μ", "u"),
            ("Ω", "ohm"),
            ("⁻", "-"),
            ("¹", "1"),
            ("²", "2"),
            ("³", "3"),
            ("⁴", "4"),
            ("^", ""),
            (" / ", "/"),
            ("·", "."),
            ("*", "."),
            (" ", "."),
        ] {
            text = text.replace(from, to);
        }
        match text.as_str() {
            "min-1" => "1/min".into(),
            "s-1" => "1/s".into(),
            _ => text,
        }
    }

    fn times(self, other: Self, power: i32) -> Self {
        let exponents = std::array::from_fn(|k| self.exponents[k] + power * other.exponents[k]);
        Self { exponents, factor: self.factor * other.factor.powi(power), offset: 0.0 }
    }
}

/// Factors with `.` or `/` between them, up to the end or a closing bracket.
fn product(rest: &mut &str) -> Option<PhysicalUnit> {
    let mut unit = PhysicalUnit::ONE;
    let mut sign = 1;
    loop {
        let (of_factor, power) = factor(rest)?;
        unit = unit.times(of_factor, sign * power);
        sign = match rest.chars().next() {
            Some('.') => 1,
            Some('/') => -1,
            _ => return Some(unit),
        };
        *rest = &rest[1..];
    }
}

/// A symbol or a product in brackets, and its power.
fn factor(rest: &mut &str) -> Option<(PhysicalUnit, i32)> {
    let unit = if let Some(inside) = rest.strip_prefix('(') {
        *rest = inside;
        let unit = product(rest)?;
        *rest = rest.strip_prefix(')')?;
        unit
    } else if let Some(after) = rest.strip_prefix('1') {
        *rest = after;
        return Some((PhysicalUnit::ONE, 1));
    } else {
        let is_of_symbol = |c: char| c.is_alphabetic() || c == '%';
        let end = rest.find(|c| !is_of_symbol(c)).unwrap_or(rest.len());
        let unit = symbol(&rest[..end])?;
        *rest = &rest[end..];
        unit
    };
    let digits = rest.strip_prefix('-').unwrap_or(rest);
    let count = digits.find(|c: char| !c.is_ascii_digit()).unwrap_or(digits.len());
    if count == 0 {
        return Some((unit, 1));
    }
    let end = rest.len() - digits.len() + count;
    let power: i32 = rest[..end].parse().ok().filter(|p: &i32| (-8..=8).contains(p))?;
    *rest = &rest[end..];
    Some((unit, power))
}

fn symbol(name: &str) -> Option<PhysicalUnit> {
    let found = |name: &str| SYMBOLS.iter().find(|(names, ..)| names.contains(&name));
    if let Some((_, factor, exponents, _)) = found(name) {
        return Some(PhysicalUnit { exponents: *exponents, factor: *factor, offset: 0.0 });
    }
    for (prefix, size) in PREFIXES {
        let Some(base) = name.strip_prefix(prefix) else { continue };
        let (factor, exponents) = match found(base) {
            _ if base == "g" => GRAM,
            Some((_, factor, exponents, true)) => (*factor, *exponents),
            _ => continue,
        };
        return Some(PhysicalUnit { exponents, factor: size * factor, offset: 0.0 });
    }
    None
}

#[cfg(test)]
mod tests {
    use super::PhysicalUnit;

    /// Factors and exponents of kg, m, s, A, K, mol, cd, rad by hand from the SI Brochure.
    #[test]
    fn units_are_those_of_the_si() {
        for (text, factor, exponents) in [
            ("V", 1.0, [1, 2, -3, -1, 0, 0, 0, 0]),
            ("mA", 1e-3, [0, 0, 0, 1, 0, 0, 0, 0]),
            ("kW", 1e3, [1, 2, -3, 0, 0, 0, 0, 0]),
            ("MPa", 1e6, [1, -1, -2, 0, 0, 0, 0, 0]),
            ("mbar", 100.0, [1, -1, -2, 0, 0, 0, 0, 0]),
            ("N.m", 1.0, [1, 2, -2, 0, 0, 0, 0, 0]),
            ("Nm", 1.0, [1, 2, -2, 0, 0, 0, 0, 0]),
            ("N·m/rad", 1.0, [1, 2, -2, 0, 0, 0, 0, -1]),
            ("J/(kg.K)", 1.0, [0, 2, -2, 0, -1, 0, 0, 0]),
            ("J/kg/K", 1.0, [0, 2, -2, 0, -1, 0, 0, 0]),
            ("W/m²", 1.0, [1, 0, -3, 0, 0, 0, 0, 0]),
            ("m/s^2", 1.0, [0, 1, -2, 0, 0, 0, 0, 0]),
            ("km/h", 1.0 / 3.6, [0, 1, -1, 0, 0, 0, 0, 0]),
            ("deg/s", std::f64::consts::PI / 180.0, [0, 0, -1, 0, 0, 0, 0, 1]),
            ("1/min", 1.0 / 60.0, [0, 0, -1, 0, 0, 0, 0, 0]),
            ("min⁻¹", 1.0 / 60.0, [0, 0, -1, 0, 0, 0, 0, 0]),
            ("l/min", 1e-3 / 60.0, [0, 3, -1, 0, 0, 0, 0, 0]),
            ("kHz", 1e3, [0, 0, -1, 0, 0, 0, 0, 0]),
            ("%", 0.01, [0; 8]),
            ("kg", 1.0, [1, 0, 0, 0, 0, 0, 0, 0]),
            ("g", 9.806_65, [0, 1, -2, 0, 0, 0, 0, 0]),
            ("mΩ", 1e-3, [1, 2, -3, -2, 0, 0, 0, 0]),
        ] {
            let unit = PhysicalUnit::parse(text).unwrap_or_else(|| panic!("{text}"));
            assert!((unit.factor / factor - 1.0).abs() < 1e-12, "{text}: {}", unit.factor);
            assert_eq!(unit.exponents, exponents, "{text}");
            assert_eq!(unit.offset, 0.0);
        }
    }

    #[test]
    fn a_temperature_has_a_zero_of_its_own_and_stands_alone() {
        let celsius = PhysicalUnit::parse("°C").unwrap();
        assert_eq!((celsius.factor, celsius.offset), (1.0, 273.15));
        let fahrenheit = PhysicalUnit::parse("degF").unwrap();
        assert!((212.0 * fahrenheit.factor + fahrenheit.offset - 373.15).abs() < 1e-9);
        assert_eq!(PhysicalUnit::parse("degC/s"), None);
    }

    #[test]
    fn other_texts_are_no_units() {
        for text in
            ["", "turns", "mg2g", "k", "V/", "(V", "V)", "m99", "/s", "counts", "Kg", "nA.."]
        {
            assert_eq!(PhysicalUnit::parse(text), None, "{text}");
        }
    }
}
