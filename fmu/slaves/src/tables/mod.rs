//! The variable tables, and the macro they are written in.

pub(crate) mod bicycle_plant;
pub(crate) mod identified_plant;
pub(crate) mod lateral_pid;
pub(crate) mod nonlinear_vehicle;
pub(crate) mod pose_estimator;
pub(crate) mod reference_path;

/// Makes an enum of variables and the table behind it from one list.
///
/// A row is `Variant = reference, type "name", causality, variability, .setter(…)…;`. Rows that FMI
/// 2.0 forbids, and value references or names used twice, do not compile.
macro_rules! variables {
    (
        $(#[$documentation:meta])*
        $name:ident, $model:literal, $description:literal;
        $($variant:ident = $reference:literal, $kind:ident $variable:literal, $causality:ident,
            $variability:ident $(, $(.$setter:ident($($argument:expr),*))+)?;)*
    ) => {
        $(#[$documentation])*
        #[allow(missing_docs)]
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[repr(u32)]
        pub enum $name { $($variant = $reference),* }

        impl $name {
            /// The table of the FMU.
            pub const TABLE: &'static model_description::Table =
                &model_description::Table::new(
                    $model,
                    env!("CARGO_PKG_VERSION"),
                    $description,
                    &[$(
                        model_description::VariableSpec::$kind(
                            $variable,
                            $reference,
                            model_description::Causality::$causality,
                            model_description::Variability::$variability,
                        )$($(.$setter($($argument),*))+)?
                    ),*],
                );
        }

        impl fmi2_export::VariableId for $name {
            #[inline]
            fn from_reference(reference: u32) -> Option<Self> {
                match reference {
                    $($reference => Some(Self::$variant),)*
                    _ => None,
                }
            }

            #[inline]
            fn spec(self) -> &'static model_description::VariableSpec {
                /// The row of a reference: every variant has one, in the order of the list.
                const fn row(reference: u32) -> usize {
                    const INDEX: &[u32] = &[$($reference),*];
                    let mut row = 0;
                    while INDEX[row] != reference {
                        row += 1;
                    }
                    row
                }
                // Found while compiling: each call of the FMU passes here.
                let row = match self {
                    $(Self::$variant => const { row($reference) }),*
                };
                &Self::TABLE.variables[row]
            }
        }
    };
}

pub(crate) use variables;
