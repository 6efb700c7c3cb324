//! Properties of the packed FMUs outside the loop: ticks, start values, states, refusals.

use crate::support::archives;
use steerwright_formats::{LargeErrors, LateralAcceleration, PidGains};
use steerwright_host::{Archive, Causality, Instance};
use steerwright_models::{Pid, PidInput, PidParameters};
use steerwright_packaging::Fmu;

const TS: f64 = 0.01;
fn archive(name: &str) -> Archive {
    Archive::open(archives().join(format!("{name}.fmu"))).unwrap()
}

/// An instance in initialization mode.
fn initializing(archive: &Archive) -> Instance {
    let mut instance = Instance::new(archive, "one").unwrap();
    instance.setup_experiment(0.0, None, None).unwrap();
    instance.enter_initialization_mode().unwrap();
    instance
}

/// An instance at its first communication point, with nothing set.
fn initialized(archive: &Archive) -> Instance {
    let mut instance = initializing(archive);
    instance.exit_initialization_mode().unwrap();
    instance
}

/// The parameters that the FMU reports.
fn parameters(pid: &mut Instance) -> PidParameters {
    let mut real = |name: &str| pid.real(name).unwrap();
    PidParameters {
        gains: PidGains {
            kp: real("kp"),
            ki: real("ki"),
            kd: real("kd"),
            derivative_filter_time_s: real("derivative_filter_time"),
            setpoint_weight_proportional: real("setpoint_weight_proportional"),
            setpoint_weight_derivative: real("setpoint_weight_derivative"),
            anti_windup_time_s: real("anti_windup_time"),
        },
        max_angle: real("max_angle"),
        max_increment: real("max_increment"),
        max_rate: real("max_rate"),
        large_errors: LargeErrors {
            max_yaw_error_rad: real("max_yaw_error"),
            yaw_rate_lag_s: real("yaw_rate_lag"),
            sustained_rate_radps: real("sustained_rate"),
            rate_reserve_time_s: real("rate_reserve_time"),
        },
        lateral_acceleration: LateralAcceleration {
            max_mps2: real("max_lateral_acceleration"),
            steering_per_curvature_radm: real("steering_per_curvature"),
            understeer_gradient_rads2pm: real("understeer_gradient"),
        },
        sample_time: real("sample_time"),
    }
}

fn input(yaw_reference: f64, yaw: f64) -> PidInput {
    PidInput { yaw_reference, yaw, steering_feedforward: 0.0, enabled: true, speed: 0.0 }
}

#[test]
fn start_values_are_those_of_an_initialization_in_which_nothing_was_set() {
    for fmu in Fmu::ALL {
        let name = fmu.name();
        let archive = archive(name);
        let mut instance = initialized(&archive);
        let variables = archive.model().variables();
        let mut compared = 0;
        for variable in variables {
            if let Some(start) = &variable.start {
                assert_eq!(
                    &instance.value(&variable.name).unwrap(),
                    start,
                    "{name}.{}",
                    variable.name
                );
                compared += 1;
            }
        }
        // Of the rows for channels an archive has those of its document.
        let expected = fmu
            .table()
            .variables
            .iter()
            .filter(|row| matches!(row.causality, Causality::Input | Causality::Parameter))
            .filter(|row| variables.iter().any(|variable| variable.reference == row.reference))
            .count();
        assert!(compared >= expected, "{name}: {compared} start values of {expected}");
    }
}

#[test]
fn the_first_step_commits_the_inputs_that_were_last_read() {
    let archive = archive("LateralPid");
    let mut fmu = initializing(&archive);
    fmu.set("yaw_reference", 0.001).unwrap();
    fmu.set("yaw", 0.0).unwrap();
    fmu.exit_initialization_mode().unwrap();
    let p = parameters(&mut fmu);
    let speed = fmu.real("speed").unwrap();
    let input = |reference: f64, yaw: f64| PidInput { speed, ..input(reference, yaw) };
    // Importers may iterate: each read is tick 0 of the present inputs, from scratch.
    for reference in [0.001, 0.003, 0.002] {
        fmu.set("yaw_reference", reference).unwrap();
        let expected = Pid::default().tick(&p, &input(reference, 0.0)).steering_angle;
        assert_eq!(fmu.real("steering_angle").unwrap(), expected);
        assert!(expected > 0.0);
    }
    // Set but not read before the step: these are the inputs of tick 1.
    fmu.set("yaw_reference", 0.004).unwrap();
    fmu.set("yaw", 0.0005).unwrap();
    fmu.do_step(0.0, TS).unwrap();
    let mut pid = Pid::default();
    pid.tick(&p, &input(0.002, 0.0));
    let expected = pid.tick(&p, &input(0.004, 0.0005)).steering_angle;
    assert_eq!(fmu.real("steering_angle").unwrap(), expected);
}

#[test]
fn inputs_that_were_never_set_kick_nothing() {
    let archive = archive("LateralPid");
    let mut fmu = initialized(&archive);
    assert_eq!(fmu.real("steering_angle").unwrap(), 0.0);
    // The vehicle points anywhere; both arrive only now.
    fmu.set("yaw", 2.0).unwrap();
    fmu.set("yaw_reference", 2.0).unwrap();
    fmu.do_step(0.0, TS).unwrap();
    assert_eq!(fmu.real("steering_angle").unwrap(), 0.0);
}

#[test]
fn ticks_fall_on_the_same_times_whatever_the_step() {
    let archive = archive("LateralPid");
    let run = |step: f64, count: usize| {
        let mut fmu = initializing(&archive);
        fmu.set("yaw_reference", 0.002).unwrap();
        fmu.set("yaw", 0.0).unwrap();
        fmu.exit_initialization_mode().unwrap();
        let mut all = vec![fmu.real("steering_angle").unwrap()];
        for k in 0..count {
            fmu.do_step(k as f64 * step, step).unwrap();
            all.push(fmu.real("steering_angle").unwrap());
        }
        all
    };
    let at_ticks = run(TS, 10);
    let thirds = run(TS / 3.0, 30);
    for (k, value) in thirds.iter().enumerate() {
        assert_eq!(*value, at_ticks[k / 3], "a third of a sample, step {k}");
    }
    let long = run(2.5 * TS, 4);
    assert_eq!(long, [at_ticks[0], at_ticks[2], at_ticks[5], at_ticks[7], at_ticks[10]]);
    assert!(at_ticks.windows(2).all(|w| w[0] != w[1]));
}

#[test]
fn disabled_it_puts_out_the_feedforward_and_enabling_is_bumpless() {
    let archive = archive("LateralPid");
    let mut fmu = initializing(&archive);
    fmu.set("yaw_reference", 0.001).unwrap();
    fmu.set("yaw", 0.0).unwrap();
    fmu.set("enabled", false).unwrap();
    fmu.set("steering_feedforward", 0.002).unwrap();
    fmu.exit_initialization_mode().unwrap();
    fmu.do_step(0.0, TS).unwrap();
    assert_eq!(fmu.real("steering_angle").unwrap(), 0.002);
    fmu.set("enabled", true).unwrap();
    fmu.do_step(TS, TS).unwrap();
    let (enabled, ki) = (fmu.real("steering_angle").unwrap(), fmu.real("ki").unwrap());
    // No jump: at most what one tick of integral action adds.
    assert!((enabled - 0.002).abs() <= ki * TS * 0.001 + 1e-12, "{enabled}");
}

#[test]
fn a_step_of_ages_is_refused_at_once_and_reset_brings_the_instance_back() {
    // A path has nothing that a step would move.
    for name in Fmu::ALL.into_iter().filter(|fmu| *fmu != Fmu::ReferencePath).map(Fmu::name) {
        let archive = archive(name);
        let mut fmu = initialized(&archive);
        assert!(fmu.do_step(0.0, 1e12).is_err(), "{name}");
        fmu.reset().unwrap();
        fmu.setup_experiment(0.0, None, None).unwrap();
        fmu.enter_initialization_mode().unwrap();
        fmu.exit_initialization_mode().unwrap();
        fmu.do_step(0.0, TS).unwrap();
    }
}

/// Yaw rate and pose over some steps.
fn drive(plant: &mut Instance, from: usize, count: usize) -> Vec<[u64; 4]> {
    (from..from + count)
        .map(|k| {
            plant.set("steering_angle", 0.02 * (k as f64 * 0.1).sin()).unwrap();
            plant.do_step(k as f64 * TS, TS).unwrap();
            ["yaw_rate", "yaw", "x", "y"].map(|name| plant.real(name).unwrap().to_bits())
        })
        .collect()
}

/// A plant with noise, at a pose, at its first communication point.
fn noisy(archive: &Archive, scale: f64, seed: i32) -> Instance {
    let mut plant = initializing(archive);
    plant.set("noise_scale", scale).unwrap();
    plant.set("noise_seed", seed).unwrap();
    plant.set("initial_x", 3.0).unwrap();
    plant.set("initial_yaw", 1.0).unwrap();
    plant.exit_initialization_mode().unwrap();
    plant
}

#[test]
fn saved_run_restored_run_is_the_same_to_the_bit() {
    let archive = archive("IdentifiedPlant");
    let mut plant = noisy(&archive, 1.0, 7);
    assert_eq!(plant.real("yaw").unwrap(), 1.0);
    assert_eq!(plant.real("x").unwrap(), 3.0);
    drive(&mut plant, 0, 37);
    let state = plant.get_state().unwrap();
    let first = drive(&mut plant, 37, 50);
    plant.set_state(&state).unwrap();
    assert_eq!(drive(&mut plant, 37, 50), first);
    drop(state);
    // Reset equals a fresh instance.
    plant.reset().unwrap();
    plant.setup_experiment(0.0, None, None).unwrap();
    plant.enter_initialization_mode().unwrap();
    plant.exit_initialization_mode().unwrap();
    assert_eq!(drive(&mut plant, 0, 20), drive(&mut initialized(&archive), 0, 20));
}

#[test]
fn noise_is_named_by_its_seed() {
    let archive = archive("IdentifiedPlant");
    let run = |scale, seed| drive(&mut noisy(&archive, scale, seed), 0, 200);
    assert_eq!(run(1.0, 1), run(1.0, 1));
    assert_ne!(run(1.0, 1), run(1.0, 2));
    assert_eq!(run(0.0, 1), run(0.0, 2));
}

#[test]
fn another_guid_is_refused() {
    for name in Fmu::ALL.map(Fmu::name) {
        let archive = archive(name);
        let other = "00000000-0000-0000-0000-000000000000";
        assert!(Instance::with_guid(&archive, "one", Default::default(), other).is_err(), "{name}");
    }
}
