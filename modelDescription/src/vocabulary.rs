//! The enumerations of FMI 2.0 (section 2.2.7) and the values of variables.

/// Declares an enum whose members have fixed names in the XML.
macro_rules! words {
    ($(#[$meta:meta])* $name:ident { $($(#[$doc:meta])* $member:ident = $text:literal,)* }) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum $name { $($(#[$doc])* $member,)* }

        impl $name {
            /// Every member, in the standard's order.
            pub const ALL: &'static [Self] = &[$(Self::$member),*];

            /// The word as it stands in the XML.
            #[must_use]
            pub const fn as_str(self) -> &'static str {
                match self { $(Self::$member => $text),* }
            }

            /// The member with this word in the XML.
            #[must_use]
            pub fn from_word(word: &str) -> Option<Self> {
                match word { $($text => Some(Self::$member),)* _ => None }
            }
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(self.as_str())
            }
        }
    };
}

pub(crate) use words;

words! {
    /// The type of a variable. Enumerations are read as Integer: their values travel as such.
    #[derive(Default)]
    #[allow(missing_docs)]
    Kind {
        #[default]
        Real = "Real",
        Integer = "Integer",
        Boolean = "Boolean",
        String = "String",
    }
}

words! {
    /// The source of a variable's value.
    #[derive(Default)]
    Causality {
        /// Set by the environment before the simulation (and, tunable, during it).
        Parameter = "parameter",
        /// Computed from parameters.
        CalculatedParameter = "calculatedParameter",
        /// Set by the environment at communication points.
        Input = "input",
        /// Offered to the environment.
        Output = "output",
        /// Internal; not to be connected.
        #[default]
        Local = "local",
        /// Usually time.
        Independent = "independent",
    }
}

words! {
    /// When a variable may change.
    #[derive(Default)]
    Variability {
        /// Never.
        Constant = "constant",
        /// Not after initialization.
        Fixed = "fixed",
        /// At communication points, by the environment.
        Tunable = "tunable",
        /// At events, and at communication points.
        Discrete = "discrete",
        /// At any time; only Real variables.
        #[default]
        Continuous = "continuous",
    }
}

words! {
    /// How a variable is initialized.
    Initial {
        /// With its start value.
        Exact = "exact",
        /// By iteration from its start value.
        Approx = "approx",
        /// From other variables.
        Calculated = "calculated",
    }
}

words! {
    /// How an unknown depends on a known (section 2.2.8).
    DependencyKind {
        /// With no particular structure.
        Dependent = "dependent",
        /// By a constant factor.
        Constant = "constant",
        /// By a factor fixed after initialization.
        Fixed = "fixed",
        /// By a factor that is tunable.
        Tunable = "tunable",
        /// By a factor that changes at events.
        Discrete = "discrete",
    }
}

words! {
    /// How the names of variables are built.
    #[derive(Default)]
    NamingConvention {
        /// Any names.
        #[default]
        Flat = "flat",
        /// Hierarchies with dots, arrays with brackets, derivatives as `der(x)`.
        Structured = "structured",
    }
}

/// A value of a variable.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)] // named by the type of the variable
pub enum Value {
    /// In the variable's unit.
    Real(f64),
    Integer(i32),
    Boolean(bool),
    String(String),
}

impl Value {
    /// The type of variable that has such a value.
    #[must_use]
    pub const fn kind(&self) -> Kind {
        match self {
            Self::Real(_) => Kind::Real,
            Self::Integer(_) => Kind::Integer,
            Self::Boolean(_) => Kind::Boolean,
            Self::String(_) => Kind::String,
        }
    }

    /// The number of a Real or Integer value, for comparison with limits.
    #[must_use]
    pub fn as_number(&self) -> Option<f64> {
        match self {
            Self::Real(value) => Some(*value),
            Self::Integer(value) => Some(f64::from(*value)),
            Self::Boolean(_) | Self::String(_) => None,
        }
    }
}

/// Declares the conversions to [`Value`].
macro_rules! values {
    ($($type:ty => $member:ident;)*) => {$(
        impl From<$type> for Value {
            fn from(value: $type) -> Self {
                Self::$member(value.into())
            }
        }
    )*};
}

values! { f64 => Real; i32 => Integer; bool => Boolean; String => String; &str => String; }
