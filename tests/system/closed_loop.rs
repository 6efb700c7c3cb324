//! The closed loop of the packed FMUs against the same loop of the pure Rust functions.

use crate::support::{demo, document};
use std::path::Path;
use steerwright_control::{PlantModel, TrackTrace};
use steerwright_formats::{Bicycle, LoopCoupling, Path as PathFile, Pid, Plant};
use steerwright_host::{Archive, Coupling, Instance, Recording, System};

const LARGEST_DIFFERENCE: f64 = 1e-9;

/// Runs plant, path and controller from archives; gives their columns by name.
fn fmus(folder: &Path, plant: &str, coupling: Coupling, stop: f64) -> Recording {
    let mut system = System::new();
    for name in [plant, "ReferencePath", "LateralPid"] {
        let archive = Archive::open(folder.join(format!("{name}.fmu"))).unwrap();
        system.add(Instance::new(&archive, name).unwrap()).unwrap();
    }
    system.connect_by_name(&steerwright_packaging::ssp::MEASUREMENTS).unwrap();
    system.run(coupling, 0.0, stop, 0.01).unwrap()
}

fn largest_difference(recording: &Recording, plant: &str, trace: &TrackTrace) -> f64 {
    let mut largest = 0.0_f64;
    for (name, pure) in [
        (format!("{plant}.x"), &trace.x),
        (format!("{plant}.y"), &trace.y),
        (format!("{plant}.yaw"), &trace.yaw),
        ("ReferencePath.yaw_reference".into(), &trace.yaw_reference),
        ("LateralPid.steering_angle".into(), &trace.steering),
    ] {
        let column = recording.column(&name).unwrap();
        assert_eq!(column.len(), pure.len(), "{name}");
        let difference = column.iter().zip(pure).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        println!("{name}: largest difference {difference:.3e}");
        largest = largest.max(difference);
    }
    largest
}

fn compare(plant: &str, model: PlantModel, coupling: LoopCoupling, host: Coupling) {
    let folder = demo().folder.join("multibody");
    let pid: Pid = document(&folder.join("pid.json"));
    let path: PathFile = document(&folder.join("path.json"));
    let stop = 12.0;
    let pure = steerwright_control::track(model, &pid, &path, stop, coupling).unwrap();
    let recording = fmus(&folder.join("fmu"), plant, host, stop);
    assert!(largest_difference(&recording, plant, &pure) <= LARGEST_DIFFERENCE);
    let steered = pure.steering.iter().fold(0.0_f64, |a, u| a.max(u.abs()));
    assert!(steered > 0.01, "the loop did not steer");
}

#[test]
fn identified_plant() {
    let plant: Plant = document(&demo().folder.join("multibody/plant.json"));
    let model = || PlantModel::from_plant(&plant).unwrap();
    compare("IdentifiedPlant", model(), LoopCoupling::GaussSeidel, Coupling::GaussSeidel);
    compare("IdentifiedPlant", model(), LoopCoupling::Jacobi, Coupling::Jacobi);
}

#[test]
fn bicycle_plant() {
    let bicycle: Bicycle = document(&demo().folder.join("multibody/bicycle.json"));
    let model = PlantModel::from_bicycle(&bicycle).unwrap();
    compare("BicyclePlant", model, LoopCoupling::GaussSeidel, Coupling::GaussSeidel);
}
