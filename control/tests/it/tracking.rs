//! The whole loop on the reference road.

use crate::common::{car, designed, identified_car, options as usual};
use steerwright_control::paths::{PathComposer, reference_road};
use steerwright_control::{
    DesignOptions, DesignPlant, PlantModel, TrackTrace, guidance_for, track, track_with,
    with_sideslip,
};
use steerwright_formats::{LoopCoupling, Pid};

fn pid(plant: &DesignPlant, loop_delay_s: f64) -> Pid {
    designed(plant, &DesignOptions { loop_delay_s, ..usual() })
}

/// Root mean square of the cross-track error, m.
fn rms(trace: &TrackTrace) -> f64 {
    let sum: f64 = trace.cross_track_error.iter().map(|e| e * e).sum();
    (sum / trace.cross_track_error.len().max(1) as f64).sqrt()
}

/// Largest cross-track error to either side, m.
fn largest(trace: &TrackTrace) -> f64 {
    trace.cross_track_error.iter().fold(0.0, |m, e| m.max(e.abs()))
}

fn print(what: &str, trace: &TrackTrace) {
    println!("{what}: rms {:.4} m, largest {:.4} m", rms(trace), largest(trace));
}

#[test]
fn the_identified_plant_keeps_the_reference_road_at_4_mps2() {
    let plant = identified_car();
    let pid = pid(&DesignPlant::from_plant(&plant).expect("a plant"), 0.0);
    let road = reference_road(15.0, 4.0).expect("a road");
    let model = PlantModel::from_plant(&plant).expect("a model");
    let trace =
        track(model.clone(), &pid, &road, 60.0, LoopCoupling::GaussSeidel).expect("a drive");
    print("identified, Gauss-Seidel", &trace);
    assert!(trace.finished);
    assert!(rms(&trace) < 0.05, "{}", rms(&trace));
    assert!(largest(&trace) < 0.1, "{}", largest(&trace));
    // The road requires 4 m/s², which is about reached.
    let rate = trace.yaw_rate.iter().fold(0.0_f64, |m, r| m.max(r.abs()));
    assert!((15.0 * rate - 4.0).abs() < 0.6, "{}", 15.0 * rate);
    // It drives straight on after the road with the offset of its steering, 0.01 rad.
    assert!((trace.steering[trace.steering.len() - 1] - 0.01).abs() < 2e-3);

    let jacobi = track(model, &pid, &road, 60.0, LoopCoupling::Jacobi).expect("a drive");
    print("identified, Jacobi", &jacobi);
    assert!(jacobi.finished && largest(&jacobi) < 0.15);
    assert_ne!(jacobi.yaw, trace.yaw);
}

/// The bicycle has sideslip: the guidance must contain it, since course and yaw differ.
#[test]
fn the_bicycle_needs_its_sideslip() {
    let bicycle = car(1.0);
    let pid = pid(&DesignPlant::from_bicycle(&bicycle).expect("a plant"), 0.0);
    let road = reference_road(15.0, 4.0).expect("a road");
    let model = || PlantModel::from_bicycle(&bicycle).expect("a model");
    let plain = guidance_for(&pid, 15.0);
    let sideslip = steerwright_models::files::bicycle_parameters(&bicycle.vehicle).sideslip(15.0);
    let guidance = with_sideslip(plain, &sideslip, 15.0);
    let drive =
        |g| track_with(model(), &pid, &road, g, 60.0, LoopCoupling::GaussSeidel).expect("a drive");
    let trace = drive(&guidance);
    print("bicycle, Gauss-Seidel", &trace);
    assert!(trace.finished && largest(&trace) < 0.1);
    assert!(largest(&drive(&plain)) > 2.0 * largest(&trace));
}

/// On a long circle nothing is left of the error: preview, sideslip and integral action agree.
#[test]
fn a_circle_is_kept_exactly() {
    let bicycle = car(15.0);
    let pid = pid(&DesignPlant::from_bicycle(&bicycle).expect("a plant"), 0.0);
    let circle = PathComposer::new()
        .straight(30.0)
        .clothoid(0.0, 0.01, 30.0)
        .arc(0.01, 500.0)
        .finish("circle", 15.0)
        .expect("a path");
    let sideslip = steerwright_models::files::bicycle_parameters(&bicycle.vehicle).sideslip(15.0);
    let guidance = with_sideslip(guidance_for(&pid, 15.0), &sideslip, 15.0);
    let model = PlantModel::from_bicycle(&bicycle).expect("a model");
    let trace = track_with(model, &pid, &circle, &guidance, 36.0, LoopCoupling::GaussSeidel)
        .expect("a drive");
    let last = trace.cross_track_error.len() - 1;
    assert!(trace.distance[last] > 500.0);
    assert!(trace.cross_track_error[last].abs() < 1e-3, "{}", trace.cross_track_error[last]);
}

/// A bend that the path shows at one tick is steered for at that tick under Gauss–Seidel, and two
/// ticks later under Jacobi, where the way through the path is two connections long.
#[test]
fn couplings_delay_what_they_should() {
    let mut plant = identified_car();
    plant.operating_point.steering_offset_rad = 0.0;
    let pid = pid(&DesignPlant::from_plant(&plant).expect("a plant"), 0.0);
    let road = PathComposer::new().straight(30.0).arc(0.01, 30.0).finish("bend", 15.0);
    let road = road.expect("a path");
    let first = |coupling| {
        let model = PlantModel::from_plant(&plant).expect("a model");
        let trace = track(model, &pid, &road, 3.0, coupling).expect("a drive");
        trace.steering.iter().position(|u| *u != 0.0).expect("it steers")
    };
    assert_eq!(first(LoopCoupling::Jacobi), first(LoopCoupling::GaussSeidel) + 2);
}

/// A kink of 1.1 degrees throws the vehicle off the road; it comes back without swinging across.
#[test]
fn an_error_dies_out_without_swinging() {
    let mut plant = identified_car();
    plant.operating_point.steering_offset_rad = 0.0;
    let pid = pid(&DesignPlant::from_plant(&plant).expect("a plant"), 0.0);
    let road = PathComposer::new()
        .straight(15.0)
        .clothoid(0.0, 0.02, 1.0)
        .clothoid(0.02, 0.0, 1.0)
        .straight(300.0)
        .finish("kink", 15.0)
        .expect("a path");
    let model = PlantModel::from_plant(&plant).expect("a model");
    let trace = track(model, &pid, &road, 60.0, LoopCoupling::GaussSeidel).expect("a drive");
    let errors = &trace.cross_track_error;
    let from = trace.distance.iter().position(|d| *d > 17.0).expect("driven");
    let (low, high) =
        errors[from..].iter().fold((0.0_f64, 0.0_f64), |(l, h), e| (l.min(*e), h.max(*e)));
    println!("kink: {low:.4} to {high:.4} m");
    let (swing, other) = (high.max(-low), high.min(-low));
    assert!(swing < 0.02 && other < 0.5 * swing, "{low} {high}");
    assert!(errors[errors.len() - 1].abs() < 1e-3, "{}", errors[errors.len() - 1]);
}

#[test]
fn a_design_for_the_jacobi_delay_tracks_under_jacobi() {
    let plant = identified_car();
    let pid = pid(&DesignPlant::from_plant(&plant).expect("a plant"), 0.01);
    let road = reference_road(15.0, 4.0).expect("a road");
    let model = PlantModel::from_plant(&plant).expect("a model");
    let trace = track(model, &pid, &road, 60.0, LoopCoupling::Jacobi).expect("a drive");
    print("identified, Jacobi, designed for it", &trace);
    assert!(trace.finished && largest(&trace) < 0.1);
}
