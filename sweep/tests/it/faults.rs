//! Studies that cannot be run: each fault is reported with its place in the file and a hint.

use crate::support::{How, folder, prepare, run_with, study};
use steerwright_sweep::Error;

/// What replaces what in a good study, and what the error must say; `@` is where it must point.
const FAULTS: &[(&str, &str, &str)] = &[
    // the file
    ("seed = 5", "seed = 5\n@tempo = 1", "unknown field `tempo`"),
    ("kind = \"rms\"", "kind = @\"root\"", "unknown variant `root`"),
    ("seed = 5", "seed = @-5", "invalid value: integer `-5`"),
    ("seed = 5\n", "", "missing field `seed`"),
    ("step_s = 0.01", "step_s = @\"10 ms\"", "invalid type: string"),
    (
        "distribution = \"normal\"",
        "distribution = \"normal\"\n@sigma = 1.0",
        "unknown field `sigma`",
    ),
    // times
    ("step_s = 0.01", "step_s = @0.3", "not a whole number of steps"),
    ("step_s = 0.01", "step_s = @0.0", "the step is not above 0"),
    ("step_s = 0.01", "step_s = @nan", "not finite"),
    ("runs = 4", "runs = @0", "runs is 0"),
    ("runs = 4", "runs = @1000000000000", "more than"),
    // FMUs and connections
    ("file = \"plant.fmu\"", "file = @\"lost.fmu\"", "lost.fmu"),
    (
        "file = \"path.fmu\"\nname = \"path\"",
        "file = \"path.fmu\"\nname = \"plant\"",
        "two instances are named \"plant\"",
    ),
    (
        "[set]",
        "[[connect]]\nfrom = @\"pid\"\nto = \"plant.yaw\"\n[set]",
        "not of the form instance.variable",
    ),
    (
        "[set]",
        "@[[connect]]\nfrom = \"pid.steering_angel\"\nto = \"plant.steering_angle\"\n[set]",
        "near it: steering_angle",
    ),
    (
        "[set]",
        "@[[connect]]\nfrom = \"plant.gain\"\nto = \"path.yaw\"\n[set]",
        "plant.gain is no output",
    ),
    (
        "name = \"path\"",
        "name = \"path\"\nrename = { @heading = \"yaw\" }",
        "no variable \"heading\"",
    ),
    // values
    (
        "\"path.gain\" = -1.5",
        "@\"path.gian\" = -1.5",
        "path has no variable \"gian\"; near it: gain",
    ),
    ("\"path.gain\" = -1.5", "@\"paht.gain\" = -1.5", "no instance \"paht\""),
    ("\"path.gain\" = -1.5", "\"path.gain\" = @true", "not a value of kind"),
    ("\"path.gain\" = -1.5", "\"path.gain\" = @inf", "not a value of kind"),
    ("\"path.gain\" = -1.5", "@\"path.yaw\" = 0.5", "is fed by plant.yaw"),
    ("\"path.gain\" = -1.5", "@\"path.steps\" = 5", "cannot be set"),
    ("\"path.gain\" = -1.5", "\"pid.gain\" = -1.5", "already gets its value from [set]"),
    ("\"path.gain\" = -1.5", "\"path.gain\" = @\"3 deg\"", "nothing converts \"deg\""),
    // what varies
    ("maximum = 3.0", "maximum = 0.5", "minimum 1 is not below maximum 0.5"),
    ("maximum = 3.0", "maximum = inf", "maximum is inf"),
    ("maximum = 3.0", "", "uniform needs maximum"),
    ("maximum = 3.0", "maximum = 3.0\nmean = 2.0", "uniform has no mean"),
    (
        "standard_deviation = 0.2",
        "standard_deviation = -0.2",
        "standard_deviation -0.2 is not above 0",
    ),
    (
        "mean = 0.0\nstandard_deviation = 0.2",
        "mean = 0.0\nstandard_deviation = 0.2\nminimum = 1.9\nmaximum = 2.0",
        "normal has no minimum",
    ),
    (
        "distribution = \"normal\"\nmean = 0.0\nstandard_deviation = 0.2",
        "distribution = \"truncated-normal\"\nmean = 0.0\nstandard_deviation = 0.2\nminimum = 1.9\nmaximum = 2.0",
        "of normal(0, 0.2) lies from 1.9 to 2",
    ),
    (
        "distribution = \"uniform\"",
        "distribution = \"log-uniform\"\nunit = \"rad\"",
        "pid.gain is in no unit",
    ),
    (
        "variables = [\"pid.gain\"]\ndistribution = \"uniform\"\nminimum = 1.0",
        "variables = [\"pid.misbehaviour\"]\ndistribution = \"uniform\"\nminimum = 1.5",
        "must be whole numbers",
    ),
    ("variables = [\"pid.gain\"]", "variables = [@\"pid.label\"]", "pid.label is a text"),
    (
        "variables = [\"pid.gain\"]\ndistribution = \"uniform\"\nminimum = 1.0\nmaximum = 3.0",
        "variables = [\"pid.enabled\"]\ndistribution = \"choice\"\nvalues = [0, 2]",
        "0 to 2 is more than a",
    ),
    (
        "variables = [\"pid.gain\"]\ndistribution = \"uniform\"\nminimum = 1.0\nmaximum = 3.0",
        "variables = [\"pid.gain\"]\ndistribution = \"choice\"\nvalues = [1, 2]\nweights = [1.0]",
        "1 weights for 2 values",
    ),
    (
        "variables = [\"pid.gain\"]\ndistribution = \"uniform\"\nminimum = 1.0\nmaximum = 3.0",
        "variables = [\"pid.gain\"]\ndistribution = \"grid\"\nvalues = []",
        "grid has 0 values",
    ),
    (
        "variables = [\"pid.gain\"]\ndistribution = \"uniform\"",
        "variables = [\"pid.gain\"]\ncount = 5\ndistribution = \"linspace\"",
        "would get 3, beyond its maximum 2.5",
    ),
    ("name = \"settled\"", "name = \"status\"", "already named \"status\""),
    // disturbances
    (
        "amplitude = \"kick\"",
        "amplitude = @\"kcik\"",
        "no [[vary]] is named \"kcik\"; there is pid.gain, kick",
    ),
    ("input = \"path.yaw\"", "input = @\"plant.yaw\"", "added to Real inputs"),
    ("duration_s = 0.1\n", "", "needs duration_s"),
    ("duration_s = 0.1", "duration_s = 0.0", "duration_s can be 0"),
    ("bandwidth_hz = 3.0", "", "noise needs bandwidth_hz"),
    ("unit = \"deg\"", "unit = \"m\"", "nothing converts \"m\""),
    // metrics
    (
        "variable = \"plant.yaw\"\nkind = \"rms\"",
        "variable = @\"plant.yow\"\nkind = \"rms\"",
        "no variable \"yow\"; near it: yaw",
    ),
    ("at_most = 0.2", "at_most = 0.2\nat_least = 0.3", "at least 0.3 and at most 0.2"),
    ("kind = \"rms\"", "kind = \"rms\"\nfrom_s = 2.0", "no window of the run"),
    ("kind = \"rms\"", "kind = \"time\"", "time needs either above or below"),
    ("band = 0.05", "", "needs a target, and either band or band_percent"),
    ("target = 0.2", "target = @\"kack\"", "no [[vary]] is named \"kack\""),
    ("name = \"steering_max\"", "name = \"yaw_rms\"", "already named \"yaw_rms\""),
];

#[test]
fn every_fault_is_reported_with_its_place_and_a_hint() {
    let bounded = |name: &str, xml: String| {
        let gain = "<Real start=\"1\"/></ScalarVariable>";
        let to = "<Real start=\"1\" max=\"2.5\"/></ScalarVariable>";
        if name == "pid" { xml.replace(gain, to) } else { xml }
    };
    let Some(plain) = folder(|_, xml| xml) else { return };
    let tight = folder(bounded).unwrap();
    let mut wrong = Vec::new();
    for (from, to, expected) in FAULTS {
        let good = study(4);
        assert!(good.contains(from), "{from:?} is not in the study");
        let marked = good.replacen(from, to, 1);
        let at = marked.find('@');
        let text = marked.replacen('@', "", 1);
        let folder = if expected.contains("beyond its") { &tight } else { &plain };
        let error = prepare(folder.path(), &text).expect_err(to);
        let message = error.to_string();
        let place = at.map_or("study.toml:".to_owned(), |at| {
            let before = &text[..at];
            let line = before.matches('\n').count() + 1;
            let column = at - before.rfind('\n').map_or(0, |n| n + 1) + 1;
            format!("study.toml:{line}:{column}: ")
        });
        if !message.contains(expected) || !message.starts_with(&place) || error.hint().is_empty() {
            wrong.push(format!("{to:?}: {place} {expected}\n  is {message}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_step_that_no_run_survives_is_the_studys_fault() {
    let Some(folder) = folder(|_, xml| xml) else { return };
    let text = study(4).replace("[set]", "[set]\n\"plant.misbehaviour\" = 1");
    let error = prepare(folder.path(), &text).unwrap_err();
    assert!(matches!(error, Error::FirstStep { .. }), "{error}");
    let message = error.to_string();
    assert!(message.starts_with("study.toml:2:10:") && message.contains("the step is too long"));
}

#[test]
fn trajectories_are_of_runs_that_exist() {
    let Some(folder) = folder(|_, xml| xml) else { return };
    let sweep = prepare(folder.path(), &study(4)).unwrap();
    let out = folder.path().join("results.csv");
    let into = folder.path().join("trajectories");
    let error = run_with(&sweep, &out, How::default(), Some((into, vec![4]))).unwrap_err();
    assert!(matches!(error, Error::NoSuchRun { run: 4, runs: 4 }));
    let nowhere = folder.path().join("plant.fmu/results.csv");
    assert!(matches!(
        run_with(&sweep, &nowhere, How::default(), None).unwrap_err(),
        Error::Io { .. }
    ));
}
