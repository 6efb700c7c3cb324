//! `NonlinearVehicle` from its file to the packed FMU: the numbers are those of the pure model.

use crate::support::{data, steerwright, text_of};
use steerwright_host::{Archive, Instance};
use steerwright_models::{NonlinearParameters, NonlinearVehicle};

const OUTPUTS: [&str; 6] =
    ["yaw_rate", "yaw", "x", "y", "lateral_velocity", "lateral_acceleration"];

fn outputs(v: &NonlinearVehicle) -> [f64; 6] {
    [v.yaw_rate(), v.yaw(), v.x(), v.y(), v.lateral_velocity(), v.lateral_acceleration()]
}

#[test]
fn packed_from_its_file_it_is_the_model() {
    let folder = tempfile::tempdir().unwrap();
    let file = data().join("multibody/vehicle.json");
    let output = steerwright(
        folder.path(),
        &["package".as_ref(), file.as_os_str(), "--out".as_ref(), "fmu".as_ref()],
    );
    assert!(output.status.success(), "{}", text_of(&output));
    let archive = Archive::open(folder.path().join("fmu/NonlinearVehicle.fmu")).unwrap();

    let mut fmu = Instance::new(&archive, "one").unwrap();
    fmu.setup_experiment(0.0, None, None).unwrap();
    fmu.enter_initialization_mode().unwrap();
    for variable in archive.model().variables() {
        if let Some(start) = &variable.start {
            assert_eq!(&fmu.value(&variable.name).unwrap(), start, "{}", variable.name);
        }
    }
    let (delay, friction) = (0.03, 0.4);
    fmu.set("actuator_delay", delay).unwrap();
    fmu.set("friction_coefficient", friction).unwrap();
    fmu.set("initial_yaw", 0.5).unwrap();
    fmu.exit_initialization_mode().unwrap();

    let mut parameters = NonlinearParameters::default();
    parameters.actuator.delay_s = delay;
    parameters.tyres.friction_coefficient = friction;
    let mut model = NonlinearVehicle::new(parameters).unwrap();
    model.initial_yaw = 0.5;
    model.start().unwrap();
    // From standstill to where a slippery road lets the car slide.
    let mut largest = 0.0_f64;
    for k in 0..500 {
        let speed = 0.05 * f64::from(k);
        let steering = 0.1 * (f64::from(k) * 0.02).sin();
        (model.speed, model.steering_angle) = (speed, steering);
        fmu.set("speed", speed).unwrap();
        fmu.set("steering_angle", steering).unwrap();
        model.step(0.01).unwrap();
        fmu.do_step(f64::from(k) * 0.01, 0.01).unwrap();
        largest = largest.max(model.lateral_acceleration().abs());
        // Another build of the same code, perhaps with other instructions.
        for (name, expected) in OUTPUTS.iter().zip(outputs(&model)) {
            let value = fmu.real(name).unwrap();
            assert!((value - expected).abs() < 1e-9 * (1.0 + expected.abs()), "{name}, step {k}");
        }
    }
    assert!(largest > 0.7 * friction * 9.81, "{largest}");
    assert!(fmu.do_step(5.0, 1e12).is_err());
}
