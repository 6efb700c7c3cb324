//! FMI 2.0 model descriptions: variables, units, legality rules, and the XML written and read.
//!
//! * [`Table`] is written by the author of an FMU: a `const` list of [`VariableSpec`] rows.
//!   A row or table that the standard forbids does not compile (FMI 2.0.5, section 2.2.7).
//! * [`ModelDescription`] is the content of `modelDescription.xml`, of any tool: built from a table
//!   and its start values by [`ModelDescription::from_table`], written by
//!   [`ModelDescription::to_xml`], read by [`ModelDescription::from_xml`], and checked with the
//!   standard's rules by [`ModelDescription::findings`].
//!
//! [`guid`] computes the identifier that binary, description and resources share.
//!
//! Numbers are written with the fewest digits that read back to the same value and never depend on
//! the locale. Nothing written here depends on the clock. Section numbers are those of the FMI 2.0.5
//! text. This crate is independent of vehicles and of the C interface.
//!
//! ```
//! use model_description::*;
//!
//! const VARIABLES: &[VariableSpec] = &[
//!     VariableSpec::real("u", 0, Causality::Input, Variability::Continuous).unit("m/s"),
//!     VariableSpec::real("gain", 1, Causality::Parameter, Variability::Tunable).min(0.0),
//!     VariableSpec::real("y", 2, Causality::Output, Variability::Continuous)
//!         .unit("m/s")
//!         .depends_on(DependsOn::On(&["u"]))
//!         .initial_depends_on(DependsOn::On(&["u", "gain"])),
//! ];
//! const TABLE: Table = Table::new("Gain", "1.0.0", "y = gain u", VARIABLES);
//!
//! let start = [Value::Real(0.0), Value::Real(2.0), Value::Real(0.0)];
//! let description =
//!     ModelDescription::from_table(&TABLE, &start, &guid(&TABLE, &[]), None).unwrap();
//! let read = ModelDescription::from_xml(&description.to_xml()).unwrap();
//! assert_eq!(read, description);
//! assert!(read.findings().is_empty());
//! ```
//!
//! An illegal row does not compile; a parameter is never continuous:
//!
//! ```compile_fail,E0080
//! use model_description::*;
//! const ROW: VariableSpec =
//!     VariableSpec::real("gain", 1, Causality::Parameter, Variability::Continuous);
//! ```
//!
//! nor does a value of `initial` that the combination forbids:
//!
//! ```compile_fail,E0080
//! use model_description::*;
//! const ROW: VariableSpec =
//!     VariableSpec::real("u", 1, Causality::Input, Variability::Continuous)
//!         .initial(Initial::Exact);
//! ```
//!
//! nor a table in which two rows share a value reference:
//!
//! ```compile_fail,E0080
//! use model_description::*;
//! const TABLE: Table = Table::new("Twice", "1.0.0", "", &[
//!     VariableSpec::real("a", 1, Causality::Input, Variability::Continuous),
//!     VariableSpec::real("b", 1, Causality::Input, Variability::Continuous),
//! ]);
//! ```

mod description;
mod encoding;
mod error;
mod excess;
mod from_table;
mod guid;
mod legality;
mod read;
mod rules;
mod table;
mod units;
mod vocabulary;
mod write;

pub use description::{
    CoSimulation, DefaultExperiment, LogCategory, ModelDescription, ModelExchange, Unknown,
    Variable, VendorAnnotation,
};
pub use encoding::{declared_encoding, decoded};
pub use error::Error;
pub use excess::{Excess, ExcessKind};
pub use from_table::ExposedState;
pub use guid::guid;
pub use legality::{allows_start, default_initial, is_legal, needs_start};
pub use rules::{Finding, FindingPlace, List};
pub use table::{DependsOn, Table, VariableSpec, is_c_identifier, is_file_name};
pub use units::{BaseUnit, DisplayUnit, UNITS, Unit, UnitSpec};
pub use vocabulary::{
    Causality, DependencyKind, Initial, Kind, NamingConvention, Value, Variability,
};
