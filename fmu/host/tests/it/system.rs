//! Systems: wiring, initialization, the two couplings compared with the recursions they represent.

use crate::support::{Behaviour, instance, open, xml};
use steerwright_host::{
    Connection, Coupling, Error, InputTable, Instance, Phase, Recording, System,
};

const H: f64 = 0.01;

/// Plant (integrator), path (static), PID (sampled) in a loop by equal names, with a path gain of
/// −1.5 and offset 0.3, and a PID gain of 2.
fn steering_loop() -> Option<System> {
    let mut system = unrecorded_loop()?;
    system.record(&["plant.yaw", "path.yaw_reference", "pid.steering_angle"]).unwrap();
    Some(system)
}

fn unrecorded_loop() -> Option<System> {
    let mut system = System::new();
    for (behaviour, name, input, output) in [
        (Behaviour::Integrator, "plant", "steering_angle", "yaw"),
        (Behaviour::Gain, "path", "yaw", "yaw_reference"),
        (Behaviour::Sampled, "pid", "yaw_reference", "steering_angle"),
    ] {
        system.add(instance(behaviour, name, input, output)?).unwrap();
    }
    // `steps`, an output of all three, is not an input.
    let connections = system.connect_by_name(&[]).unwrap();
    assert_eq!(connections.len(), 3);
    for setting in ["path.gain=-1.5", "path.offset=0.3", "pid.gain=2", "plant.offset = 0.1"] {
        system.set_text(setting).unwrap();
    }
    Some(system)
}

fn assert_rows(rows: &[Vec<f64>], expected: &[[f64; 3]]) {
    assert_eq!(rows.len(), expected.len());
    for (k, (row, expected)) in rows.iter().zip(expected).enumerate() {
        for (value, want) in row.iter().zip(expected) {
            assert!((value - want).abs() < 1e-12, "row {k}: {row:?}, not {expected:?}");
        }
    }
}

/// x of the plant, r of the path, s of the PID when all agree.
fn consistent(x: f64) -> [f64; 3] {
    let r = -1.5 * x + 0.3;
    [x, r, 2.0 * r]
}

#[test]
fn gauss_seidel_in_loop_order_has_no_delay() {
    let Some(mut system) = steering_loop() else { return };
    let recording = system.run(Coupling::GaussSeidel, 0.0, 1.0, H).unwrap();
    let mut expected = vec![consistent(0.1)];
    for k in 0..100 {
        let [x, _, s] = expected[k];
        expected.push(consistent(x + H * s));
    }
    assert_rows(&recording.rows, &expected);
    assert!(recording.initially_settled);
}

#[test]
fn jacobi_delays_each_connection_by_a_step() {
    let Some(mut system) = steering_loop() else { return };
    let recording = system.run(Coupling::Jacobi, 0.0, 1.0, H).unwrap();
    let mut expected = vec![consistent(0.1)];
    for k in 0..100 {
        let [x, r, s] = expected[k];
        expected.push([x + H * s, -1.5 * x + 0.3, 2.0 * r]);
    }
    assert_rows(&recording.rows, &expected);
}

/// An integrator of 1 that misbehaves from t = 0.5 s on.
fn misbehaving(misbehaviour: i32) -> Option<System> {
    let mut system = System::new();
    system.add(instance(Behaviour::Integrator, "plant", "u", "y")?).unwrap();
    system.set("plant", "u", 1.0).unwrap();
    system.set("plant", "misbehaviour", misbehaviour).unwrap();
    system.record(&["plant.y"]).unwrap();
    Some(system)
}

#[test]
fn an_fmu_may_end_the_simulation_which_keeps_its_rows() {
    let Some(mut system) = misbehaving(12) else { return };
    let mut recording = Recording::default();
    let ended =
        system.run_into(&mut recording, Coupling::Jacobi, 0.0, 1.0, 0.1, |_| {}).unwrap_err();
    let Error::Terminated { instance: unit, time, .. } = &ended else { panic!("{ended}") };
    assert_eq!((unit.as_str(), *time), ("plant", 0.525));
    assert_eq!(system.instances()[0].phase(), Phase::Terminated);
    let expected = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.525];
    assert_eq!(recording.times.len(), expected.len());
    for ((time, row), want) in recording.times.iter().zip(&recording.rows).zip(expected) {
        assert!((time - want).abs() < 1e-12 && (row[0] - want).abs() < 1e-12, "{recording:?}");
    }
    // With another FMU the rows end where both are.
    system.add(instance(Behaviour::Integrator, "other", "v", "w").unwrap()).unwrap();
    system.run_into(&mut recording, Coupling::GaussSeidel, 0.0, 1.0, 0.1, |_| {}).unwrap_err();
    assert_eq!(recording.times.last(), Some(&0.5));
    assert_eq!(system.instances()[1].phase(), Phase::Terminated);
}

#[test]
fn a_run_that_fails_keeps_its_rows() {
    let Some(mut system) = misbehaving(13) else { return };
    let mut recording = Recording::default();
    let error =
        system.run_into(&mut recording, Coupling::Jacobi, 0.0, 1.0, 0.1, |_| {}).unwrap_err();
    assert!(error.to_string().contains("returned error at t = 0.5 s"), "{error}");
    assert_eq!((recording.times.len(), recording.rows.len()), (6, 6));
    assert_eq!(recording.times[5], 0.5);
    // A discarded step that does not end the simulation is a failure too.
    let Some(mut system) = misbehaving(1) else { return };
    let error = system.run(Coupling::Jacobi, 0.0, 1.0, 0.1).unwrap_err();
    assert!(error.to_string().contains("returned discard at t = 0 s"), "{error}");
}

#[test]
fn the_order_decides_where_gauss_seidel_delays() {
    let Some(mut system) = steering_loop() else { return };
    system.order(&["pid", "path", "plant"]).unwrap();
    let recording = system.run(Coupling::GaussSeidel, 0.0, 1.0, H).unwrap();
    // Settings moved with their instances; the PID steps with r of the step before, and so on.
    let mut expected = vec![consistent(0.1)];
    for k in 0..100 {
        let [x, r, _] = expected[k];
        let s = 2.0 * r;
        expected.push([x + H * s, -1.5 * x + 0.3, s]);
    }
    assert_rows(&recording.rows, &expected);
    assert!(matches!(system.order(&["pid", "path"]), Err(Error::BadOrder { .. })));
    assert!(matches!(system.order(&["pid", "pid", "plant"]), Err(Error::BadOrder { .. })));
}

#[test]
fn a_second_run_is_the_first_again() {
    let Some(mut system) = steering_loop() else { return };
    let first = system.run(Coupling::GaussSeidel, 0.0, 1.0, H).unwrap();
    assert_eq!(system.instances()[0].phase(), Phase::Terminated);
    let second = system.run(Coupling::GaussSeidel, 0.0, 1.0, H).unwrap();
    assert_eq!(first, second);
    assert_eq!(first.to_csv(), second.to_csv());
    assert_eq!(first.to_csv().lines().count(), 102);
}

#[test]
fn initialization_carries_values_through_a_chain_in_the_worst_order() {
    let mut system = System::new();
    // Each takes from the one added after it.
    for (name, input, output) in [("c", "v2", "v3"), ("b", "v1", "v2"), ("a", "v0", "v1")] {
        let Some(fmu) = instance(Behaviour::Gain, name, input, output) else { return };
        system.add(fmu).unwrap();
        system.set_text(&format!("{name}.gain=3")).unwrap();
    }
    system.connect_by_name(&[]).unwrap();
    system.set("a", "v0", 2.0).unwrap();
    let recording = system.run(Coupling::Jacobi, 0.0, 0.1, 0.1).unwrap();
    assert_eq!(recording.column("c.v2"), None, "a connected input is not recorded again");
    assert_eq!(recording.column("a.v0"), Some(vec![2.0, 2.0]), "a free input is");
    system.record(&["c.v3", "a.v1"]).unwrap();
    let recording = system.run(Coupling::Jacobi, 0.0, 0.1, 0.1).unwrap();
    assert_eq!(recording.rows[0], [54.0, 6.0]);
    // The first reading says 6 of a; two passes carry it to b and c; one more sees it done.
    assert_eq!((recording.initial_passes, recording.initially_settled), (3, true));
}

#[test]
fn an_algebraic_loop_that_does_not_settle_is_reported() {
    let mut system = System::new();
    for (name, input, output) in [("a", "p", "q"), ("b", "q", "p")] {
        let Some(fmu) = instance(Behaviour::Gain, name, input, output) else { return };
        system.add(fmu).unwrap();
        system.set_text(&format!("{name}.gain=2")).unwrap();
        system.set_text(&format!("{name}.offset=1")).unwrap();
    }
    system.connect_by_name(&[]).unwrap();
    let recording = system.run(Coupling::GaussSeidel, 0.0, 0.1, 0.1).unwrap();
    assert_eq!((recording.initial_passes, recording.initially_settled), (3, false));
}

/// `a` has the input p and the given output, `b` the given input and the output p.
fn pair(from: (&str, &str), to: (&str, &str)) -> Option<System> {
    let mut system = System::new();
    for (name, xml) in [("a", xml(("p", ""), from)), ("b", xml(to, ("p", "")))] {
        let archive = open(Behaviour::Gain, &xml)?;
        system.add(Instance::new(&archive, name).unwrap()).unwrap();
    }
    Some(system)
}

#[test]
fn what_does_not_fit_is_not_connected() {
    let Some(mut system) = pair(("yaw", "rad"), ("yaw", "m")) else { return };
    let error = system.connect_by_name(&[]).unwrap_err().to_string();
    assert!(error.contains("a.yaw is in \"rad\" and b.yaw is in \"m\""), "{error}");
    // Not even p, which fits and comes first.
    assert!(system.connections().is_empty());

    let Some(mut system) = pair(("yaw", "rad"), ("u", "")) else { return };
    let mut connect = |from, output, to, input| {
        system
            .connect(Connection::new(from, output, to, input))
            .map(drop)
            .map_err(|e| e.to_string())
    };
    connect("a", "yaw", "b", "u").unwrap(); // one end states no unit
    let error = connect("b", "p", "b", "u").unwrap_err();
    assert!(error.contains("b.u is already connected to a.yaw"), "{error}");
    let error = connect("a", "yaw", "b", "misbehaviour").unwrap_err();
    assert!(error.contains("a.yaw is Real and b.misbehaviour is Integer"), "{error}");
    let error = connect("a", "p", "b", "enabled").unwrap_err();
    assert!(error.contains("a.p is no output: its causality is input"), "{error}");
    let error = connect("a", "yaw", "b", "gain").unwrap_err();
    assert!(error.contains("b.gain is no input: its causality is parameter"), "{error}");
    let error = connect("a", "yawn", "b", "u").unwrap_err();
    assert!(error.contains("near it: yaw"), "{error}");
    let error = connect("A", "yaw", "b", "u").unwrap_err();
    assert!(error.contains("no instance \"A\"; it has a, b"), "{error}");
}

#[test]
fn two_candidates_for_an_input_are_an_error_that_names_them() {
    let mut system = System::new();
    for (name, input, output) in [("a", "p", "yaw"), ("b", "q", "yaw"), ("pid", "yaw", "s")] {
        let Some(fmu) = instance(Behaviour::Gain, name, input, output) else { return };
        system.add(fmu).unwrap();
    }
    let error = system.connect_by_name(&[]).unwrap_err().to_string();
    assert!(error.contains("pid.yaw could be connected to any of a.yaw, b.yaw"), "{error}");
    assert!(system.connections().is_empty());
    // Made explicit, it is settled.
    system.connect(Connection::new("b", "yaw", "pid", "yaw")).unwrap();
    assert!(system.connect_by_name(&[]).unwrap().is_empty());
    let again = instance(Behaviour::Gain, "a", "p", "yaw").unwrap();
    assert!(matches!(system.add(again), Err(Error::DuplicateInstance { .. })));
    let dotted = instance(Behaviour::Gain, "a.b", "p", "yaw").unwrap();
    assert!(matches!(system.add(dotted), Err(Error::InstanceName { .. })));
}

#[test]
fn settings_are_checked() {
    let Some(mut system) = steering_loop() else { return };
    let mut fails = |text: &str| system.set_text(text).map(drop).unwrap_err().to_string();
    assert!(fails("pid.gain").contains("instance.variable=value"));
    assert!(fails("gain=1").contains("instance.variable=value"));
    assert!(fails("pid.gain=fast").contains("\"fast\" is not a value of kind Real"));
    assert!(fails("pid.gain=NaN").contains("NaN"));
    assert!(fails("pid.misbehaviour=1.5").contains("kind Integer"));
    assert!(fails("pid.enabled=maybe").contains("kind Boolean"));
    assert!(fails("pid.gian=1").contains("near it: gain"));
    assert!(fails("pdi.gain=1").contains("no instance \"pdi\""));
    // What a connection feeds cannot be set, an output neither.
    system.set_text("plant.steering_angle=1").unwrap();
    let error = system.run(Coupling::GaussSeidel, 0.0, 1.0, H).unwrap_err().to_string();
    assert!(
        error.contains("plant.steering_angle") && error.contains("pid.steering_angle"),
        "{error}"
    );
    let Some(mut system) = steering_loop() else { return };
    system.set_text("plant.yaw=1").unwrap();
    let error = system.run(Coupling::GaussSeidel, 0.0, 1.0, H).unwrap_err();
    assert!(matches!(error, Error::NotSettable { .. }), "{error}");
}

fn fed(table: &str) -> Option<System> {
    let mut system = System::new();
    for name in ["a", "b"] {
        system.add(instance(Behaviour::Integrator, name, "u", "y")?).unwrap();
    }
    system.feed(InputTable::read(table.as_bytes(), "in.csv").unwrap());
    system.record(&["a.u", "a.y", "b.u", "b.y", "b.enabled", "a.gain"]).unwrap();
    Some(system)
}

#[test]
fn a_table_is_held_from_its_times_on() {
    let table = "time,u,b.enabled\n-1,1,true\n0.3,4,true\n0.5,4,false\n";
    for coupling in [Coupling::GaussSeidel, Coupling::Jacobi] {
        let Some(mut system) = fed(table) else { return };
        let recording = system.run(coupling, 0.0, 0.7, 0.1).unwrap();
        let close = |name: &str, expected: [f64; 8]| {
            for (value, want) in recording.column(name).unwrap().iter().zip(expected) {
                assert!((value - want).abs() < 1e-12, "{name}: {:?}", recording.column(name));
            }
        };
        close("a.u", [1.0, 1.0, 1.0, 4.0, 4.0, 4.0, 4.0, 4.0]);
        close("b.u", [1.0, 1.0, 1.0, 4.0, 4.0, 4.0, 4.0, 4.0]);
        close("a.y", [0.0, 0.1, 0.2, 0.3, 0.7, 1.1, 1.5, 1.9]);
        close("b.y", [0.0, 0.1, 0.2, 0.3, 0.7, 1.1, 1.1, 1.1]);
        close("b.enabled", [1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
        close("a.gain", [1.0; 8]);
    }
}

#[test]
fn a_row_is_due_though_the_computed_time_falls_short_of_it() {
    let time = 3.0 * 0.3;
    assert!(time < 0.9, "in binary");
    let Some(mut system) = fed("time,u\n0,1\n0.9,4\n1.201,5\n") else { return };
    let recording = system.run(Coupling::Jacobi, 0.0, 1.5, 0.3).unwrap();
    assert_eq!(recording.column("a.u").unwrap(), [1.0, 1.0, 1.0, 4.0, 4.0, 5.0]);
}

#[test]
fn columns_that_fit_nothing_are_refused() {
    let error = |table: &str| {
        let mut system = fed(table)?;
        system.set_text("a.u=1").unwrap();
        Some(system.run(Coupling::Jacobi, 0.0, 1.0, 0.1).unwrap_err().to_string())
    };
    let Some(unknown) = error("time,b.enable\n0,1\n") else { return };
    assert!(
        unknown.contains("\"b.enable\"") && unknown.contains("near it: b.enabled"),
        "{unknown}"
    );
    let late = error("time,b.u\n0.5,1\n").unwrap();
    assert!(late.contains("starts at 0.5 s, after the start of the run at 0 s"), "{late}");
    let kind = error("time,b.enabled\n0,1\n1,0.5\n").unwrap();
    assert!(kind.contains("line 3") && kind.contains("not true or false"), "{kind}");
    let twice = error("time,b.u,u\n0,1,1\n").unwrap();
    assert!(twice.contains("b.u is set to a value, but it is fed by column"), "{twice}");
    let set = error("time,u\n0,1\n").unwrap();
    assert!(set.contains("a.u is set to a value, but it is fed by column \"u\""), "{set}");
    let Some(mut system) = steering_loop() else { return };
    system.feed(InputTable::read("time,pid.yaw_reference\n0,1\n".as_bytes(), "in.csv").unwrap());
    let connected = system.run(Coupling::Jacobi, 0.0, 1.0, 0.1).unwrap_err().to_string();
    assert!(connected.contains("pid.yaw_reference"), "{connected}");
}

#[test]
fn failures_name_the_instance_and_the_time() {
    let Some(mut system) = steering_loop() else { return };
    system.set_text("plant.misbehaviour=7").unwrap();
    let error = system.run(Coupling::GaussSeidel, 0.0, 1.0, 0.1).unwrap_err().to_string();
    assert_eq!(error, "plant.yaw is NaN at t = 0.1 s");
    // The system can be put right and run again.
    system.set_text("plant.misbehaviour=2").unwrap();
    let error = system.run(Coupling::Jacobi, 5.0, 6.0, 0.1).unwrap_err().to_string();
    assert!(error.contains("plant: fmi2DoStep returned error at t = 5 s"), "{error}");
    system.set_text("plant.misbehaviour=0").unwrap();
    system.run(Coupling::Jacobi, 5.0, 6.0, 0.1).unwrap();
    assert!(matches!(system.run(Coupling::Jacobi, 0.0, 1.0, 0.3), Err(Error::BadGrid { .. })));
}

#[test]
fn times_are_computed_and_not_accumulated() {
    let Some(mut system) = steering_loop() else { return };
    // The FMU itself refuses a time more than a thousandth of a step off its own.
    let recording = system.run(Coupling::GaussSeidel, 2.0, 202.0, H).unwrap();
    assert_eq!(recording.times.len(), 20_001);
    for (k, time) in recording.times.iter().enumerate() {
        assert_eq!(*time, 2.0 + k as f64 * H);
    }
}

#[test]
fn the_default_recording_is_all_outputs_and_the_free_inputs() {
    let Some(mut system) = unrecorded_loop() else { return };
    let recording = system.run(Coupling::GaussSeidel, 0.0, 0.1, H).unwrap();
    assert_eq!(
        recording.names,
        [
            "plant.yaw",
            "plant.misbehaviour",
            "plant.steps",
            "plant.enabled",
            "plant.is_positive",
            "path.yaw_reference",
            "path.misbehaviour",
            "path.steps",
            "path.enabled",
            "path.is_positive",
            "pid.steering_angle",
            "pid.misbehaviour",
            "pid.steps",
            "pid.enabled",
            "pid.is_positive"
        ]
    );
    assert_eq!(recording.column("pid.enabled").unwrap()[0], 1.0);
}
