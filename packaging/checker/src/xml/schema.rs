//! The XML schema of FMI 2.0 as data: elements, their attributes and their children in order.
//!
//! It has the content of fmi2ModelDescription.xsd and the six files that it includes.

pub(super) struct Element {
    pub(super) name: &'static str,
    pub(super) attributes: &'static [Attribute],
    pub(super) content: Content,
}

pub(super) enum Content {
    /// Nothing, not even white space.
    Empty,
    Slots(&'static [Slot]),
    /// At most one element, with any name.
    One,
    Anything,
}

pub(super) struct Slot {
    pub(super) elements: &'static [&'static Element],
    pub(super) min: usize,
    pub(super) max: usize,
}

pub(super) struct Attribute {
    pub(super) name: &'static str,
    pub(super) kind: AttributeKind,
    pub(super) required: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum AttributeKind {
    /// `xs:string` and `xs:normalizedString`: every text is valid.
    Text,
    Boolean,
    Int,
    UnsignedInt,
    Double,
    DateTime,
    Word(&'static [&'static str]),
    Indices,
    Words(&'static [&'static str]),
}

use AttributeKind::{Boolean, DateTime, Double, Indices, Int, Text, UnsignedInt, Word, Words};
use Content::{Anything, Empty, One, Slots};

const MANY: usize = usize::MAX;

/// Attributes, each with `need` or `may`, its name and its type.
macro_rules! attributes {
    ($($need:ident $name:literal $kind:expr),*) => { &[$($need($name, $kind)),*] };
}

const fn need(name: &'static str, kind: AttributeKind) -> Attribute {
    Attribute { name, kind, required: true }
}

const fn may(name: &'static str, kind: AttributeKind) -> Attribute {
    Attribute { name, kind, required: false }
}

const fn optional(elements: &'static [&'static Element]) -> Slot {
    Slot { elements, min: 0, max: 1 }
}

const fn exactly_one(elements: &'static [&'static Element]) -> Slot {
    Slot { elements, min: 1, max: 1 }
}

const fn some(elements: &'static [&'static Element]) -> Slot {
    Slot { elements, min: 1, max: MANY }
}

const fn leaf(name: &'static str, attributes: &'static [Attribute]) -> Element {
    Element { name, attributes, content: Empty }
}

const fn list(name: &'static str, slots: &'static [Slot]) -> Element {
    Element { name, attributes: &[], content: Slots(slots) }
}

pub(super) static ROOT: Element = Element {
    name: "fmiModelDescription",
    attributes: attributes!(
        need "fmiVersion" Word(&["2.0"]), need "modelName" Text, need "guid" Text,
        may "description" Text, may "author" Text, may "version" Text, may "copyright" Text,
        may "license" Text, may "generationTool" Text, may "generationDateAndTime" DateTime,
        may "variableNamingConvention" Word(&["flat", "structured"]),
        may "numberOfEventIndicators" UnsignedInt
    ),
    content: Slots(&[
        // (ModelExchange? CoSimulation?) once or twice; the rule `interface-twice` rejects duplicates.
        Slot { elements: &[&MODEL_EXCHANGE, &CO_SIMULATION], min: 0, max: 4 },
        optional(&[&UNIT_DEFINITIONS]),
        optional(&[&TYPE_DEFINITIONS]),
        optional(&[&LOG_CATEGORIES]),
        optional(&[&DEFAULT_EXPERIMENT]),
        optional(&[&VENDOR_ANNOTATIONS]),
        exactly_one(&[&MODEL_VARIABLES]),
        exactly_one(&[&MODEL_STRUCTURE]),
    ]),
};

static MODEL_EXCHANGE: Element = Element {
    name: "ModelExchange",
    attributes: attributes!(
        need "modelIdentifier" Text, may "needsExecutionTool" Boolean,
        may "completedIntegratorStepNotNeeded" Boolean,
        may "canBeInstantiatedOnlyOncePerProcess" Boolean,
        may "canNotUseMemoryManagementFunctions" Boolean, may "canGetAndSetFMUstate" Boolean,
        may "canSerializeFMUstate" Boolean, may "providesDirectionalDerivative" Boolean
    ),
    content: Slots(&[optional(&[&SOURCE_FILES])]),
};

static CO_SIMULATION: Element = Element {
    name: "CoSimulation",
    attributes: attributes!(
        need "modelIdentifier" Text, may "needsExecutionTool" Boolean,
        may "canHandleVariableCommunicationStepSize" Boolean, may "canInterpolateInputs" Boolean,
        may "maxOutputDerivativeOrder" UnsignedInt, may "canRunAsynchronuously" Boolean,
        may "canBeInstantiatedOnlyOncePerProcess" Boolean,
        may "canNotUseMemoryManagementFunctions" Boolean, may "canGetAndSetFMUstate" Boolean,
        may "canSerializeFMUstate" Boolean, may "providesDirectionalDerivative" Boolean
    ),
    content: Slots(&[optional(&[&SOURCE_FILES])]),
};

static SOURCE_FILES: Element = list("SourceFiles", &[some(&[&FILE])]);
static FILE: Element = leaf("File", &[need("name", Text)]);

static UNIT_DEFINITIONS: Element = list("UnitDefinitions", &[some(&[&UNIT])]);
static UNIT: Element = Element {
    name: "Unit",
    attributes: &[need("name", Text)],
    content: Slots(&[
        optional(&[&BASE_UNIT]),
        Slot { elements: &[&DISPLAY_UNIT], min: 0, max: MANY },
    ]),
};
static BASE_UNIT: Element = leaf(
    "BaseUnit",
    attributes!(
        may "kg" Int, may "m" Int, may "s" Int, may "A" Int, may "K" Int, may "mol" Int,
        may "cd" Int, may "rad" Int, may "factor" Double, may "offset" Double
    ),
);
static DISPLAY_UNIT: Element =
    leaf("DisplayUnit", &[need("name", Text), may("factor", Double), may("offset", Double)]);

static TYPE_DEFINITIONS: Element = list("TypeDefinitions", &[some(&[&SIMPLE_TYPE])]);
static SIMPLE_TYPE: Element = Element {
    name: "SimpleType",
    attributes: &[need("name", Text), may("description", Text)],
    content: Slots(&[exactly_one(&[
        &TYPE_REAL,
        &TYPE_INTEGER,
        &TYPE_BOOLEAN,
        &TYPE_STRING,
        &TYPE_ENUMERATION,
    ])]),
};
static TYPE_REAL: Element = leaf(
    "Real",
    attributes!(
        may "quantity" Text, may "unit" Text, may "displayUnit" Text,
        may "relativeQuantity" Boolean, may "min" Double, may "max" Double, may "nominal" Double,
        may "unbounded" Boolean
    ),
);
static TYPE_INTEGER: Element =
    leaf("Integer", &[may("quantity", Text), may("min", Int), may("max", Int)]);
// The schema declares no type for these two.
static TYPE_BOOLEAN: Element = Element { name: "Boolean", attributes: &[], content: Anything };
static TYPE_STRING: Element = Element { name: "String", attributes: &[], content: Anything };
static TYPE_ENUMERATION: Element = Element {
    name: "Enumeration",
    attributes: &[may("quantity", Text)],
    content: Slots(&[some(&[&ITEM])]),
};
static ITEM: Element =
    leaf("Item", &[need("name", Text), need("value", Int), may("description", Text)]);

static LOG_CATEGORIES: Element = list("LogCategories", &[some(&[&CATEGORY])]);
static CATEGORY: Element = leaf("Category", &[need("name", Text), may("description", Text)]);

static DEFAULT_EXPERIMENT: Element = leaf(
    "DefaultExperiment",
    attributes!(
        may "startTime" Double, may "stopTime" Double, may "tolerance" Double,
        may "stepSize" Double
    ),
);

static VENDOR_ANNOTATIONS: Element = list("VendorAnnotations", &[some(&[&TOOL])]);
static ANNOTATIONS: Element = list("Annotations", &[some(&[&TOOL])]);
static TOOL: Element = Element { name: "Tool", attributes: &[need("name", Text)], content: One };

static MODEL_VARIABLES: Element = list("ModelVariables", &[some(&[&SCALAR_VARIABLE])]);
static SCALAR_VARIABLE: Element = Element {
    name: "ScalarVariable",
    attributes: attributes!(
        need "name" Text, need "valueReference" UnsignedInt, may "description" Text,
        may "causality" Word(&["parameter", "calculatedParameter", "input", "output", "local", "independent"]),
        may "variability" Word(&["constant", "fixed", "tunable", "discrete", "continuous"]),
        may "initial" Word(&["exact", "approx", "calculated"]),
        may "canHandleMultipleSetPerTimeInstant" Boolean
    ),
    content: Slots(&[
        exactly_one(&[&REAL, &INTEGER, &BOOLEAN, &STRING, &ENUMERATION]),
        optional(&[&ANNOTATIONS]),
    ]),
};
static REAL: Element = leaf(
    "Real",
    attributes!(
        may "declaredType" Text, may "quantity" Text, may "unit" Text, may "displayUnit" Text,
        may "relativeQuantity" Boolean, may "min" Double, may "max" Double, may "nominal" Double,
        may "unbounded" Boolean, may "start" Double, may "derivative" UnsignedInt,
        may "reinit" Boolean
    ),
);
static INTEGER: Element = leaf(
    "Integer",
    attributes!(
        may "declaredType" Text, may "quantity" Text, may "min" Int, may "max" Int, may "start" Int
    ),
);
static BOOLEAN: Element = leaf("Boolean", &[may("declaredType", Text), may("start", Boolean)]);
static STRING: Element = leaf("String", &[may("declaredType", Text), may("start", Text)]);
static ENUMERATION: Element = leaf(
    "Enumeration",
    attributes!(
        need "declaredType" Text, may "quantity" Text, may "min" Int, may "max" Int,
        may "start" Int
    ),
);

static MODEL_STRUCTURE: Element = list(
    "ModelStructure",
    &[optional(&[&OUTPUTS]), optional(&[&DERIVATIVES]), optional(&[&INITIAL_UNKNOWNS])],
);
static OUTPUTS: Element = list("Outputs", &[some(&[&UNKNOWN])]);
static DERIVATIVES: Element = list("Derivatives", &[some(&[&UNKNOWN])]);
static INITIAL_UNKNOWNS: Element = list("InitialUnknowns", &[some(&[&UNKNOWN])]);
static UNKNOWN: Element = leaf(
    "Unknown",
    attributes!(
        need "index" UnsignedInt, may "dependencies" Indices,
        may "dependenciesKind" Words(&["dependent", "constant", "fixed", "tunable", "discrete"])
    ),
);
