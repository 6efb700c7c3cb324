//! One instance: values, phases, errors, states.

use crate::support::{Behaviour, instance, open, xml};
use model_description::Value;
use steerwright_host::{Error, Instance, InstanceOptions, MAX_LOG_LINES, Phase, Status};

fn integrator() -> Option<Instance> {
    instance(Behaviour::Integrator, "plant", "u", "y")
}

fn stepping() -> Option<Instance> {
    let mut fmu = integrator()?;
    fmu.setup_experiment(0.0, None, None).unwrap();
    fmu.enter_initialization_mode().unwrap();
    fmu.exit_initialization_mode().unwrap();
    Some(fmu)
}

#[test]
fn an_integrator_integrates() {
    let Some(mut fmu) = integrator() else { return };
    fmu.set("gain", 2.0).unwrap();
    fmu.set("offset", 0.5).unwrap();
    fmu.set("label", "grün").unwrap();
    fmu.setup_experiment(1.0, Some(2.0), Some(1e-6)).unwrap();
    fmu.enter_initialization_mode().unwrap();
    fmu.set("u", 3.0).unwrap();
    assert_eq!(fmu.real("y").unwrap(), 0.5);
    fmu.exit_initialization_mode().unwrap();
    for k in 0..4 {
        fmu.do_step(1.0 + 0.25 * f64::from(k), 0.25).unwrap();
    }
    assert_eq!(fmu.real("y").unwrap(), 6.5);
    assert_eq!(fmu.value("steps").unwrap(), Value::Integer(4));
    assert!(fmu.boolean("is_positive").unwrap());
    assert_eq!(fmu.value("label").unwrap(), Value::String("grün".to_owned()));
    fmu.set("enabled", false).unwrap();
    fmu.do_step(2.0, 0.25).unwrap();
    assert_eq!(fmu.real("y").unwrap(), 6.5);
    let mut derivative = [0.0];
    fmu.get_directional_derivative(&[1], &[0], &[1.0], &mut derivative).unwrap();
    fmu.set_real_input_derivatives(&[0], &[1], &[1.0]).unwrap();
    fmu.get_real_output_derivatives(&[1], &[1], &mut derivative).unwrap();
    assert_eq!(derivative, [3.0]);
    fmu.terminate().unwrap();
    assert_eq!(fmu.real("y").unwrap(), 6.5);
    fmu.reset().unwrap();
    assert_eq!(fmu.phase(), Phase::Instantiated);
}

#[test]
fn misspelt_names_and_wrong_kinds_are_reported() {
    let Some(mut fmu) = stepping() else { return };
    let error = fmu.real("gian").unwrap_err();
    assert!(error.to_string().contains("near it: gain"), "{error}");
    let error = fmu.set("gain", true).unwrap_err().to_string();
    assert!(error.contains("plant.gain is Real, not Boolean"), "{error}");
    assert!(matches!(fmu.integer("y"), Err(Error::WrongKind { .. })));
    let error = fmu.set_real(&[0, 2], &[1.0]).unwrap_err().to_string();
    assert!(error.contains("2 value references and 1 values"), "{error}");
}

#[test]
fn illegal_calls_never_reach_the_fmu() {
    let Some(mut fmu) = integrator() else { return };
    let phase = |error: Error| assert!(matches!(error, Error::Phase { .. }), "{error}");
    phase(fmu.do_step(0.0, 0.1).unwrap_err());
    phase(fmu.real("y").unwrap_err());
    phase(fmu.exit_initialization_mode().unwrap_err());
    phase(fmu.terminate().unwrap_err());
    let input = fmu.set("u", 1.0).unwrap_err();
    assert!(input.to_string().contains("before initialization mode: it is an input"), "{input}");
    fmu.setup_experiment(0.0, None, None).unwrap();
    fmu.enter_initialization_mode().unwrap();
    phase(fmu.setup_experiment(0.0, None, None).unwrap_err());
    fmu.exit_initialization_mode().unwrap();
    let fixed = fmu.set("offset", 1.0).unwrap_err();
    assert!(matches!(fixed, Error::NotSettable { .. }), "{fixed}");
    fmu.set("gain", 1.0).unwrap();
    assert!(matches!(fmu.do_step(f64::NAN, 0.1), Err(Error::NotFinite { .. })));
    assert!(matches!(fmu.do_step(0.0, f64::INFINITY), Err(Error::NotFinite { .. })));
    fmu.terminate().unwrap();
    phase(fmu.do_step(0.0, 0.1).unwrap_err());
    // Had any of them reached it, the FMU would be in its error state and have logged.
    assert!(fmu.take_log().is_empty());
}

#[test]
fn a_refused_instantiation_says_why() {
    let Some(archive) = open(Behaviour::Integrator, &xml(("u", ""), ("y", ""))) else { return };
    let options = InstanceOptions::default();
    let error = Instance::with_guid(&archive, "plant", options, "{other}").unwrap_err();
    // Where variadic arguments cannot be reached, the bare format has to do.
    assert!(error.to_string().contains("the GUID is "), "{error}");
    if cfg!(target_arch = "x86_64") {
        assert!(error.to_string().contains("the GUID is {other}"), "{error}");
    }
    for name in ["", " \t"] {
        assert!(matches!(Instance::new(&archive, name), Err(Error::InstanceName { .. })));
    }
    assert!(matches!(Instance::new(&archive, "a\0b"), Err(Error::NulInText { .. })));
}

/// Steps once with a misbehaviour of `fmu.c`.
fn misbehave(which: i32) -> Option<(Instance, Result<(), Error>)> {
    let mut fmu = stepping()?;
    fmu.set("misbehaviour", which).unwrap();
    let result = fmu.do_step(0.0, 0.1);
    Some((fmu, result))
}

#[test]
fn discard_and_error_carry_the_log_and_can_be_recovered_from() {
    let Some((mut fmu, result)) = misbehave(1) else { return };
    let error = result.unwrap_err();
    assert!(matches!(error, Error::Step { status: Status::Discard, .. }));
    let text = error.to_string();
    assert!(text.contains("plant: fmi2DoStep returned discard at t = 0 s"), "{text}");
    assert!(text.contains("the step is too long"), "{text}");
    assert_eq!(fmu.phase(), Phase::StepFailed);
    assert!(matches!(fmu.do_step(0.0, 0.1), Err(Error::Phase { .. })));
    fmu.terminate().unwrap();

    let Some((mut fmu, result)) = misbehave(2) else { return };
    let text = result.unwrap_err().to_string();
    // The text holds a conversion itself: it must not be taken for a format.
    assert!(text.contains("the model is broken: 100 %d"), "{text}");
    assert_eq!(fmu.phase(), Phase::Error);
    assert!(matches!(fmu.terminate(), Err(Error::Phase { .. })));
    fmu.reset().unwrap();
    fmu.setup_experiment(0.0, None, None).unwrap();
}

#[test]
fn warnings_are_no_errors_and_undefined_answers_are() {
    let Some((mut fmu, result)) = misbehave(6) else { return };
    result.unwrap();
    let log = fmu.take_log();
    assert_eq!(log.len(), 1);
    assert_eq!(log[0].status, Status::Warning);
    assert_eq!(log[0].category, "logStatusError");
    assert_eq!(log[0].message, "far from the operating point");
    let Some((fmu, result)) = misbehave(5) else { return };
    assert!(matches!(result, Err(Error::Step { status: Status::Undefined(42), .. })));
    assert_eq!(fmu.phase(), Phase::Error);
    let Some((fmu, result)) = misbehave(4) else { return };
    assert!(matches!(result, Err(Error::Step { status: Status::Pending, .. })));
    assert_eq!(fmu.phase(), Phase::StepCanceled);
}

#[test]
fn lines_with_a_foreign_environment_are_those_of_the_instance_of_their_name() {
    let Some(archive) = open(Behaviour::Integrator, &xml(("u", ""), ("y", ""))) else { return };
    let mut other = Instance::new(&archive, "another plant").unwrap();
    let mut fmu = Instance::new(&archive, "the only plant of that name").unwrap();
    fmu.setup_experiment(0.0, None, None).unwrap();
    fmu.enter_initialization_mode().unwrap();
    fmu.exit_initialization_mode().unwrap();
    fmu.set("misbehaviour", 15).unwrap();
    fmu.set("u", 1.0).unwrap();
    fmu.do_step(0.0, 0.5).unwrap();
    assert_eq!(fmu.real("y").unwrap(), 0.5);
    let lines: Vec<String> = fmu.take_log().into_iter().map(|line| line.message).collect();
    assert_eq!(lines, ["a number", "the component"]);
    assert!(other.take_log().is_empty());
}

#[test]
fn the_log_of_a_chatterbox_is_bounded() {
    let Some((mut fmu, result)) = misbehave(8) else { return };
    result.unwrap();
    assert_eq!(fmu.take_log().len(), MAX_LOG_LINES);
}

#[test]
fn after_fatal_no_instance_of_the_fmu_is_called() {
    let Some(archive) = open(Behaviour::Integrator, &xml(("u", ""), ("y", ""))) else { return };
    let mut first = Instance::new(&archive, "first").unwrap();
    let mut second = Instance::new(&archive, "second").unwrap();
    first.setup_experiment(0.0, None, None).unwrap();
    first.enter_initialization_mode().unwrap();
    first.set("misbehaviour", 3).unwrap();
    first.exit_initialization_mode().unwrap();
    let error = first.do_step(0.0, 0.1).unwrap_err();
    assert!(error.to_string().contains("out of order"), "{error}");
    assert!(matches!(first.reset(), Err(Error::Fatal { .. })));
    let other = second.setup_experiment(0.0, None, None);
    assert!(matches!(other, Err(Error::Fatal { .. })));
    assert_eq!(second.phase(), Phase::Fatal);
    assert!(matches!(Instance::new(&archive, "third"), Err(Error::Fatal { .. })));
}

#[test]
fn instances_are_freed_and_share_one_library() {
    let Some(archive) = open(Behaviour::Integrator, &xml(("u", ""), ("y", ""))) else { return };
    let folder = archive.folder().to_path_buf();
    let mut first = Instance::new(&archive, "first").unwrap();
    let others: Vec<Instance> =
        (0..3).map(|i| Instance::new(&archive, &format!("other {i}")).unwrap()).collect();
    drop(archive);
    first.setup_experiment(0.0, None, None).unwrap();
    first.enter_initialization_mode().unwrap();
    assert_eq!(first.integer("living_instances").unwrap(), 4);
    // From another thread, as an instance may be.
    std::thread::spawn(move || drop(others)).join().unwrap();
    assert_eq!(first.integer("living_instances").unwrap(), 1);
    assert!(folder.exists(), "the files live as long as an instance");
    let Value::String(resources) = first.value("resources").unwrap() else { panic!() };
    assert!(resources.starts_with("file:///") && resources.ends_with("/resources"), "{resources}");
    drop(first);
    assert!(!folder.exists());
}

#[test]
fn an_fmu_for_one_instance_gets_one_at_a_time() {
    let once = xml(("u", ""), ("y", "")).replace(
        "canGetAndSetFMUstate",
        "canBeInstantiatedOnlyOncePerProcess=\"true\" canGetAndSetFMUstate",
    );
    let Some(archive) = open(Behaviour::Integrator, &once) else { return };
    let first = Instance::new(&archive, "first").unwrap();
    assert!(matches!(Instance::new(&archive, "second"), Err(Error::OnlyOnce { .. })));
    drop(first);
    Instance::new(&archive, "second").unwrap();
}

#[test]
fn a_state_brings_back_values_and_phase() {
    let Some(mut fmu) = stepping() else { return };
    fmu.set("u", 1.0).unwrap();
    fmu.do_step(0.0, 0.5).unwrap();
    let half = fmu.get_state().unwrap();
    fmu.do_step(0.5, 0.5).unwrap();
    assert_eq!(fmu.real("y").unwrap(), 1.0);
    fmu.set_state(&half).unwrap();
    assert_eq!(fmu.real("y").unwrap(), 0.5);
    // Out of the error state too.
    fmu.set("misbehaviour", 2).unwrap();
    fmu.do_step(0.5, 0.5).unwrap_err();
    fmu.set_state(&half).unwrap();
    assert_eq!(fmu.phase(), Phase::StepComplete);
    fmu.do_step(0.5, 0.5).unwrap();

    // Into another instance by its bytes, not by the state itself.
    let bytes = fmu.serialize_state(&half).unwrap();
    let Some(mut other) = integrator() else { return };
    let copy = other.deserialize_state(&bytes, Phase::StepComplete).unwrap();
    assert!(matches!(other.set_state(&half), Err(Error::ForeignState { .. })));
    assert!(matches!(other.serialize_state(&half), Err(Error::ForeignState { .. })));
    other.set_state(&copy).unwrap();
    assert_eq!(other.real("y").unwrap(), 0.5);
    other.do_step(0.5, 0.5).unwrap();
    assert!(other.deserialize_state(&bytes[1..], Phase::StepComplete).is_err());
    // A state may outlive its instance.
    drop(other);
    drop(copy);
}

#[test]
fn dropped_states_are_freed_by_the_instance() {
    let Some(mut fmu) = stepping() else { return };
    let _kept = fmu.get_state().unwrap();
    for _ in 0..100 {
        drop(fmu.get_state().unwrap());
    }
    let states = fmu.integer("living_states").unwrap();
    assert!(states <= 2, "{states} states");
}

#[test]
fn states_need_the_capability() {
    let without = xml(("u", ""), ("y", ""))
        .replace("canGetAndSetFMUstate=\"true\" canSerializeFMUstate=\"true\"", "");
    let Some(archive) = open(Behaviour::Integrator, &without) else { return };
    let mut fmu = Instance::new(&archive, "plant").unwrap();
    let error = fmu.get_state().unwrap_err().to_string();
    assert!(error.contains("canGetAndSetFMUstate is false"), "{error}");
}

#[test]
fn opened_and_dropped_a_hundred_times() {
    for _ in 0..100 {
        let Some(fmu) = stepping() else { return };
        drop(fmu);
    }
}
