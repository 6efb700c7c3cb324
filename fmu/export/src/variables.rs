//! The macro that declares a variable table.

/// Declares an enum of variables and its [`Table`](crate::model_description::Table), `Enum::TABLE`, from
/// one list.
///
/// A row is `Variant = reference, type "name", causality, variability, .setter(…)…;`. The types are `real`,
/// `integer`, `boolean` and `string`, the setters those of
/// [`VariableSpec`](crate::model_description::VariableSpec). Rows that FMI 2.0 forbids and duplicate value
/// references or names do not compile. The version of the FMU is that of the calling package.
///
/// With `Enum of CoSimulationUnit` a row may also have, after its variability, `at field.field`, the place of a Real in the
/// unit, which the function `place` of the enum gives.
///
/// ```
/// use fmi2_export::model_description::DependsOn::Nothing;
///
/// fmi2_export::variables! {
///     /// Variables of a low-pass filter.
///     Variable, "LowPass", "A first-order low-pass filter";
///     Input = 0, real "u", Input, Continuous;
///     TimeConstant = 1, real "tau", Parameter, Tunable, .unit("s").min(1e-6);
///     Output = 2, real "y", Output, Continuous, .depends_on(Nothing).initial_depends_on(Nothing);
/// }
/// assert_eq!(Variable::TABLE.variables.len(), 3);
/// ```
///
/// ```compile_fail
/// fmi2_export::variables! {
///     /// An output that is declared tunable: FMI 2.0 forbids it.
///     Variable, "Bad", "";
///     Output = 0, real "y", Output, Tunable;
/// }
/// ```
#[macro_export]
macro_rules! variables {
    // The place of a row in the unit, or none.
    (@place $unit:ident) => { None };
    (@place $unit:ident $($place:ident).+) => { Some(&mut $unit.$($place).+) };
    (
        $(#[$documentation:meta])*
        $name:ident of $unit:ty, $model:literal, $description:literal;
        $($variant:ident = $reference:literal, $kind:ident $variable:literal, $causality:ident,
            $variability:ident $(, at $($place:ident).+)? $(, $(.$setter:ident($($argument:expr),*))+)?;)*
    ) => {
        $crate::variables! {
            $(#[$documentation])*
            $name, $model, $description;
            $($variant = $reference, $kind $variable, $causality,
                $variability $(, $(.$setter($($argument),*))+)?;)*
        }

        impl $name {
            /// Where the unit keeps a Real that can be set; `None` for the others.
            #[inline]
            fn place(self, unit: &mut $unit) -> Option<&mut f64> {
                match self {
                    $(Self::$variant => $crate::variables!(@place unit $($($place).+)?),)*
                }
            }
        }
    };
    (
        $(#[$documentation:meta])*
        $name:ident, $model:literal, $description:literal;
        $($variant:ident = $reference:literal, $kind:ident $variable:literal, $causality:ident,
            $variability:ident $(, $(.$setter:ident($($argument:expr),*))+)?;)*
    ) => {
        $(#[$documentation])*
        #[allow(missing_docs, unreachable_pub)]
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[repr(u32)]
        pub enum $name { $($variant = $reference),* }

        impl $name {
            /// The table of the FMU.
            #[allow(unreachable_pub)]
            pub const TABLE: &'static $crate::model_description::Table =
                &$crate::model_description::Table::new(
                    $model,
                    env!("CARGO_PKG_VERSION"),
                    $description,
                    &[$(
                        $crate::model_description::VariableSpec::$kind(
                            $variable,
                            $reference,
                            $crate::model_description::Causality::$causality,
                            $crate::model_description::Variability::$variability,
                        )$($(.$setter($($argument),*))+)?
                    ),*],
                );
        }

        impl $crate::VariableId for $name {
            #[inline]
            fn from_reference(reference: u32) -> Option<Self> {
                match reference {
                    $($reference => Some(Self::$variant),)*
                    _ => None,
                }
            }

            #[inline]
            fn spec(self) -> &'static $crate::model_description::VariableSpec {
                /// The row of a reference; every variant has one.
                const fn row(reference: u32) -> usize {
                    const INDEX: &[u32] = &[$($reference),*];
                    let mut row = 0;
                    while INDEX[row] != reference {
                        row += 1;
                    }
                    row
                }
                // Evaluated at compile time, since every call of the FMU needs it.
                let row = match self {
                    $(Self::$variant => const { row($reference) }),*
                };
                &Self::TABLE.variables[row]
            }
        }
    };
}
