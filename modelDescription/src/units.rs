//! Units: exponents of the SI base units, and the units a person would rather see.
//!
//! A value in the base units is `factor · value + offset` of the value in the unit; a value in a
//! display unit is `factor · value + offset` of the value in the unit (section 2.2.2).

/// A unit in terms of the SI base units and the radian.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BaseUnit {
    /// Exponents of kg, m, s, A, K, mol, cd, rad.
    pub exponents: [i32; 8],
    /// Factor to the base units.
    pub factor: f64,
    /// Offset to the base units.
    pub offset: f64,
}

impl BaseUnit {
    /// The XML attributes of the exponents, in their order.
    pub const SYMBOLS: [&'static str; 8] = ["kg", "m", "s", "A", "K", "mol", "cd", "rad"];
}

/// A unit to show a value in.
#[derive(Debug, Clone, PartialEq)]
pub struct DisplayUnit {
    /// Its name.
    pub name: String,
    /// Display value per value.
    pub factor: f64,
    /// Display value at zero.
    pub offset: f64,
}

/// A unit of a model description.
#[derive(Debug, Clone, PartialEq)]
pub struct Unit {
    /// Its name, as variables cite it.
    pub name: String,
    /// Its base units, if the description states them.
    pub base: Option<BaseUnit>,
    /// The units it may be shown in.
    pub display_units: Vec<DisplayUnit>,
}

/// A unit that tables may use.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnitSpec {
    /// Its name.
    pub name: &'static str,
    /// Exponents of kg, m, s, A, K, mol, cd, rad.
    pub exponents: [i32; 8],
    /// Names and factors of the units it may be shown in.
    pub display_units: &'static [(&'static str, f64)],
}

impl From<&UnitSpec> for Unit {
    fn from(spec: &UnitSpec) -> Self {
        Self {
            name: spec.name.into(),
            base: Some(BaseUnit { exponents: spec.exponents, factor: 1.0, offset: 0.0 }),
            display_units: spec
                .display_units
                .iter()
                .map(|&(name, factor)| DisplayUnit { name: name.into(), factor, offset: 0.0 })
                .collect(),
        }
    }
}

const DEGREES: f64 = 180.0 / std::f64::consts::PI;

const fn unit(
    name: &'static str,
    [kg, m, s, rad]: [i32; 4],
    display_units: &'static [(&'static str, f64)],
) -> UnitSpec {
    UnitSpec { name, exponents: [kg, m, s, 0, 0, 0, 0, rad], display_units }
}

/// The units that tables may use: all SI, factor 1. Exponents are of kg, m, s, rad.
pub const UNITS: &[UnitSpec] = &[
    unit("1", [0, 0, 0, 0], &[("%", 100.0)]),
    unit("1/m", [0, -1, 0, 0], &[]),
    unit("1/s", [0, 0, -1, 0], &[]),
    unit("1/s2", [0, 0, -2, 0], &[]),
    unit("N", [1, 1, -2, 0], &[("kN", 1e-3)]),
    unit("N.m", [1, 2, -2, 0], &[]),
    unit("N/m", [1, 0, -2, 0], &[]),
    unit("N/rad", [1, 1, -2, -1], &[("N/deg", 1.0 / DEGREES)]),
    unit("kg", [1, 0, 0, 0], &[]),
    unit("kg.m2", [1, 2, 0, 0], &[]),
    unit("m2", [0, 2, 0, 0], &[]),
    unit("m", [0, 1, 0, 0], &[]),
    unit("m/s", [0, 1, -1, 0], &[("km/h", 3.6)]),
    unit("m/s2", [0, 1, -2, 0], &[]),
    unit("m/s3", [0, 1, -3, 0], &[]),
    unit("rad", [0, 0, 0, 1], &[("deg", DEGREES)]),
    unit("rad.m", [0, 1, 0, 1], &[("deg.m", DEGREES)]),
    unit("rad.s2/m", [0, -1, 2, 1], &[]),
    unit("rad/m", [0, -1, 0, 1], &[("deg/m", DEGREES)]),
    unit("rad/s", [0, 0, -1, 1], &[("deg/s", DEGREES)]),
    unit("rad/s2", [0, 0, -2, 1], &[("deg/s2", DEGREES)]),
    unit("s", [0, 0, 1, 0], &[("ms", 1000.0)]),
    unit("s2", [0, 0, 2, 0], &[]),
    unit("s3", [0, 0, 3, 0], &[]),
    unit("s5/m2", [0, -2, 5, 0], &[]),
];

impl UnitSpec {
    /// The unit of that name among [`UNITS`].
    #[must_use]
    pub const fn named(name: &str) -> Option<&'static Self> {
        let mut i = 0;
        while i < UNITS.len() {
            if same(UNITS[i].name, name) {
                return Some(&UNITS[i]);
            }
            i += 1;
        }
        None
    }

    /// Whether values in this unit may be shown in that one.
    #[must_use]
    pub const fn shows_as(&self, display_unit: &str) -> bool {
        let mut i = 0;
        while i < self.display_units.len() {
            if same(self.display_units[i].0, display_unit) {
                return true;
            }
            i += 1;
        }
        false
    }
}

/// Equality of strings in a `const` context.
pub(crate) const fn same(a: &str, b: &str) -> bool {
    let (a, b) = (a.as_bytes(), b.as_bytes());
    if a.len() != b.len() {
        return false;
    }
    let mut i = 0;
    while i < a.len() {
        if a[i] != b[i] {
            return false;
        }
        i += 1;
    }
    true
}
