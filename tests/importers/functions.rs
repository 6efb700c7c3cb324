//! The 34 functions of FMI 2.0 for Co-Simulation, by the names of their types in the headers.

/// Hands every function to another macro: name, name of its type in `fmi2FunctionTypes.h`,
/// parameters and result. What the parameters' types are, the place of the expansion says.
macro_rules! functions {
    ($check:ident) => {
        $check! {
            fmi2GetTypesPlatform fmi2GetTypesPlatformTYPE() -> Text;
            fmi2GetVersion fmi2GetVersionTYPE() -> Text;
            fmi2SetDebugLogging fmi2SetDebugLoggingTYPE(Component, Boolean, usize, *const Text) -> Status;
            fmi2Instantiate fmi2InstantiateTYPE(Text, Type, Text, Text, *const CallbackFunctions, Boolean, Boolean) -> Component;
            fmi2FreeInstance fmi2FreeInstanceTYPE(Component) -> ();
            fmi2SetupExperiment fmi2SetupExperimentTYPE(Component, Boolean, Real, Real, Boolean, Real) -> Status;
            fmi2EnterInitializationMode fmi2EnterInitializationModeTYPE(Component) -> Status;
            fmi2ExitInitializationMode fmi2ExitInitializationModeTYPE(Component) -> Status;
            fmi2Terminate fmi2TerminateTYPE(Component) -> Status;
            fmi2Reset fmi2ResetTYPE(Component) -> Status;
            fmi2GetReal fmi2GetRealTYPE(Component, *const ValueReference, usize, *mut Real) -> Status;
            fmi2GetInteger fmi2GetIntegerTYPE(Component, *const ValueReference, usize, *mut Integer) -> Status;
            fmi2GetBoolean fmi2GetBooleanTYPE(Component, *const ValueReference, usize, *mut Boolean) -> Status;
            fmi2GetString fmi2GetStringTYPE(Component, *const ValueReference, usize, *mut Text) -> Status;
            fmi2SetReal fmi2SetRealTYPE(Component, *const ValueReference, usize, *const Real) -> Status;
            fmi2SetInteger fmi2SetIntegerTYPE(Component, *const ValueReference, usize, *const Integer) -> Status;
            fmi2SetBoolean fmi2SetBooleanTYPE(Component, *const ValueReference, usize, *const Boolean) -> Status;
            fmi2SetString fmi2SetStringTYPE(Component, *const ValueReference, usize, *const Text) -> Status;
            fmi2GetFMUstate fmi2GetFMUstateTYPE(Component, *mut FmuState) -> Status;
            fmi2SetFMUstate fmi2SetFMUstateTYPE(Component, FmuState) -> Status;
            fmi2FreeFMUstate fmi2FreeFMUstateTYPE(Component, *mut FmuState) -> Status;
            fmi2SerializedFMUstateSize fmi2SerializedFMUstateSizeTYPE(Component, FmuState, *mut usize) -> Status;
            fmi2SerializeFMUstate fmi2SerializeFMUstateTYPE(Component, FmuState, *mut Byte, usize) -> Status;
            fmi2DeSerializeFMUstate fmi2DeSerializeFMUstateTYPE(Component, *const Byte, usize, *mut FmuState) -> Status;
            fmi2GetDirectionalDerivative fmi2GetDirectionalDerivativeTYPE(Component, *const ValueReference, usize, *const ValueReference, usize, *const Real, *mut Real) -> Status;
            fmi2SetRealInputDerivatives fmi2SetRealInputDerivativesTYPE(Component, *const ValueReference, usize, *const Integer, *const Real) -> Status;
            fmi2GetRealOutputDerivatives fmi2GetRealOutputDerivativesTYPE(Component, *const ValueReference, usize, *const Integer, *mut Real) -> Status;
            fmi2DoStep fmi2DoStepTYPE(Component, Real, Real, Boolean) -> Status;
            fmi2CancelStep fmi2CancelStepTYPE(Component) -> Status;
            fmi2GetStatus fmi2GetStatusTYPE(Component, StatusKind, *mut Status) -> Status;
            fmi2GetRealStatus fmi2GetRealStatusTYPE(Component, StatusKind, *mut Real) -> Status;
            fmi2GetIntegerStatus fmi2GetIntegerStatusTYPE(Component, StatusKind, *mut Integer) -> Status;
            fmi2GetBooleanStatus fmi2GetBooleanStatusTYPE(Component, StatusKind, *mut Boolean) -> Status;
            fmi2GetStringStatus fmi2GetStringStatusTYPE(Component, StatusKind, *mut Text) -> Status;
        }
    };
}
pub(crate) use functions;
