//! A table with every type of variable and dependency.
#![allow(clippy::unwrap_used)] // helpers of tests are not seen as tests

use model_description::{
    Causality, DefaultExperiment, DependsOn, Initial, LogCategory, ModelDescription, Table, Value,
    Variability, VariableSpec, VendorAnnotation, guid,
};

const VARIABLES: &[VariableSpec] = &[
    VariableSpec::real("angle", 10, Causality::Output, Variability::Continuous)
        .unit("rad")
        .display_unit("deg")
        .description("Angle < 90° & \"quoted\"")
        .depends_on(DependsOn::On(&["speed"]))
        .initial_depends_on(DependsOn::On(&["speed", "gain", "gain"])),
    VariableSpec::real("gain", 11, Causality::Parameter, Variability::Tunable)
        .min(1e-300)
        .max(1e300),
    VariableSpec::integer("seed", 12, Causality::Parameter, Variability::Fixed).min(0.0).max(7.0),
    VariableSpec::boolean("enabled", 13, Causality::Input, Variability::Discrete),
    VariableSpec::string("label", 14, Causality::Parameter, Variability::Fixed),
    VariableSpec::real("speed", 15, Causality::Input, Variability::Continuous)
        .unit("m/s")
        .display_unit("km/h")
        .min(0.0)
        .nominal(10.0),
    VariableSpec::real("scale", 16, Causality::CalculatedParameter, Variability::Fixed)
        .initial_depends_on(DependsOn::Nothing),
    VariableSpec::integer("count", 17, Causality::Output, Variability::Discrete)
        .initial(Initial::Exact)
        .depends_on(DependsOn::Nothing),
    VariableSpec::real("all", 18, Causality::Output, Variability::Discrete),
];

pub(crate) const TABLE: Table = Table::new("Everything", "1.2.3", "One of each", VARIABLES);

pub(crate) fn starts() -> Vec<Value> {
    vec![
        Value::Real(0.25),
        Value::Real(0.1 + 0.2),
        Value::Integer(7),
        Value::Boolean(true),
        Value::from("line one\nline two\t<&>'\""),
        Value::Real(1.0 / 3.0),
        Value::Real(2.0),
        Value::Integer(-4),
        Value::Real(f64::NAN), // not written: it is calculated
    ]
}

pub(crate) fn description() -> ModelDescription {
    let experiment = DefaultExperiment {
        start_time: Some(0.0),
        stop_time: Some(60.0),
        tolerance: Some(1e-6),
        step_size: Some(0.01),
    };
    let id = guid(&TABLE, &[]);
    let mut description =
        ModelDescription::from_table(&TABLE, &starts(), &id, Some(experiment)).unwrap();
    description.author = Some("Ünal & Søn".into());
    description.license = Some("MIT".into());
    description.generation_tool = Some("test".into());
    description.log_categories =
        vec![LogCategory { name: "logAll".into(), description: Some("Everything".into()) }];
    description.vendor_annotations =
        vec![VendorAnnotation { tool: "steerwright".into(), xml: "<Table version=\"1\"/>".into() }];
    description
}
