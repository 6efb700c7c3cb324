//! Table 4.2.4 of FMI 2.0.5, written down from its text: which function is allowed in which state.
//!
//! I instantiated, M initialization mode, C step complete, T terminated, E error. The columns "step
//! in progress", "step failed" and "step canceled" are left out, as nothing leads there: no step is
//! asynchronous, and no step returns `fmi2Discard`. The meaning of an x with a restriction (the
//! standard's footnotes 1 to 8) is in [`super::values`].

use fmi2_export::calls::{Call, State};

/// A state of the table that an instance can be brought to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Place {
    /// Instantiated.
    I,
    /// Initialization mode.
    M,
    /// Step complete, before the first step.
    C,
    /// Step complete, after some steps.
    Stepped,
    /// Terminated.
    T,
    /// Error.
    E,
}

impl Place {
    pub(super) const ALL: [Self; 6] = [Self::I, Self::M, Self::C, Self::Stepped, Self::T, Self::E];

    /// The table's column.
    pub(super) fn letter(self) -> char {
        match self {
            Self::I => 'I',
            Self::M => 'M',
            Self::C | Self::Stepped => 'C',
            Self::T => 'T',
            Self::E => 'E',
        }
    }
}

/// The rows. GetXXX and its like "for debugging only" are allowed in E.
pub(super) const TABLE: [(&str, &str); 34] = [
    ("fmi2GetTypesPlatform", "IMCTE"),
    ("fmi2GetVersion", "IMCTE"),
    ("fmi2SetDebugLogging", "IMCTE"),
    ("fmi2Instantiate", "IMCTE"), // makes another instance, whatever this one does
    ("fmi2FreeInstance", "IMCTE"),
    ("fmi2SetupExperiment", "I"),
    ("fmi2EnterInitializationMode", "I"),
    ("fmi2ExitInitializationMode", "M"),
    ("fmi2Terminate", "C"),
    ("fmi2Reset", "IMCTE"),
    ("fmi2GetReal", "MCTE"),
    ("fmi2GetInteger", "MCTE"),
    ("fmi2GetBoolean", "MCTE"),
    ("fmi2GetString", "MCTE"),
    ("fmi2SetReal", "IMC"),
    ("fmi2SetInteger", "IMC"),
    ("fmi2SetBoolean", "IMC"),
    ("fmi2SetString", "IMC"),
    ("fmi2GetFMUstate", "IMCTE"),
    ("fmi2SetFMUstate", "IMCTE"),
    ("fmi2FreeFMUstate", "IMCTE"),
    ("fmi2SerializedFMUstateSize", "IMCTE"),
    ("fmi2SerializeFMUstate", "IMCTE"),
    ("fmi2DeSerializeFMUstate", "IMCTE"),
    ("fmi2GetDirectionalDerivative", "MCTE"),
    ("fmi2DoStep", "C"),
    ("fmi2CancelStep", ""),
    ("fmi2GetStatus", "CT"),
    ("fmi2GetRealStatus", "CT"),
    ("fmi2GetIntegerStatus", "CT"),
    ("fmi2GetBooleanStatus", "CT"),
    ("fmi2GetStringStatus", "CT"),
    ("fmi2SetRealInputDerivatives", "IMC"),
    ("fmi2GetRealOutputDerivatives", "CTE"),
];

/// Whether the table allows the function there.
pub(super) fn is_legal(function: &str, place: Place) -> bool {
    let row = TABLE.iter().find(|(name, _)| *name == function).expect(function);
    row.1.contains(place.letter())
}

/// The layer's own table equals this one.
#[test]
fn the_layer_has_the_same_table() {
    let states = [
        ('I', State::Instantiated),
        ('M', State::Initialization),
        ('C', State::StepComplete),
        ('T', State::Terminated),
        ('E', State::Error),
    ];
    for (function, legal) in TABLE {
        let call = Call::ALL.iter().find(|call| call.name() == function).expect(function);
        for (letter, state) in states {
            assert_eq!(call.is_legal_in(state), legal.contains(letter), "{function} in {letter}");
        }
    }
    let mut names = TABLE.map(|(name, _)| name);
    let mut found = crate::api::NAMES;
    names.sort_unstable();
    found.sort_unstable();
    assert_eq!(names, found);
}
