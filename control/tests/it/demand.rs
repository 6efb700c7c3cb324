//! What a road needs of a controller, computed before it is driven.

use crate::common::{car, source};
use steerwright_control::paths::{PathComposer, reference_road};
use steerwright_control::{
    Demand, DesignOptions, DesignPlant, OtherSpeed, PlantModel, Quantity, demands, design,
    guidance_for, model_sideslip, track_with, with_sideslip,
};
use steerwright_formats::{Guidance, LoopCoupling, Model, Path, Pid, ScheduleEntry};

/// A car at 15 m/s with an actuator of 0.6 rad/s, and its controller.
fn controller() -> Pid {
    let options = DesignOptions { max_rate_radps: Some(0.6), ..DesignOptions::default() };
    let plant = DesignPlant::from_bicycle(&car(1.0)).unwrap();
    design(&plant, &source(), &options).unwrap()
}

/// 50 m straight, 20 m of clothoid, 50 m of arc, 20 m of clothoid, 50 m straight.
fn bend(pid: &Pid, curvature: f64, speed: f64) -> Path {
    let composed = PathComposer::new()
        .straight(50.0)
        .clothoid(0.0, curvature, 20.0)
        .arc(curvature, 50.0)
        .clothoid(curvature, 0.0, 20.0)
        .straight(50.0);
    let mut path = composed.finish("bend", speed).unwrap();
    let sideslip =
        model_sideslip(&Model::Bicycle(Box::new(car(1.0))), Some(speed)).unwrap().unwrap();
    path.guidance = with_sideslip(guidance_for(pid, speed), &sideslip, speed);
    path
}

fn find(all: &[Demand], quantity: Quantity) -> Demand {
    *all.iter().find(|demand| demand.quantity == quantity).unwrap()
}

const ALL: [Quantity; 3] =
    [Quantity::LateralAcceleration, Quantity::SteeringAngle, Quantity::SteeringRate];

#[test]
fn a_bend_needs_what_a_car_on_it_steers() {
    let pid = controller();
    let (curvature, speed) = (0.015, 15.0);
    let path = bend(&pid, curvature, speed);
    let all = demands(&path, &pid, None).unwrap();
    let [acceleration, angle, rate] = ALL.map(|quantity| find(&all, quantity));
    let bound = pid.limits.lateral_acceleration.unwrap();
    let per_curvature =
        bound.steering_per_curvature_radm + bound.understeer_gradient_rads2pm * speed * speed;
    assert!((acceleration.needed - curvature * speed * speed).abs() < 1e-9, "{acceleration:?}");
    assert!((70.0..=120.0).contains(&acceleration.distance_m), "{acceleration:?}");
    assert!((angle.needed - curvature * per_curvature).abs() < 1e-6, "{angle:?}");
    // The curvature grows by 0.015 in 20 m.
    let slope = curvature / 20.0 * per_curvature * speed;
    assert!((rate.needed / slope - 1.0).abs() < 1e-3, "{rate:?}, {slope}");
    assert!((45.0..75.0).contains(&rate.distance_m) || rate.distance_m > 115.0, "{rate:?}");
    let limits = [bound.max_mps2, pid.limits.max_angle_rad, pid.limits.max_rate_radps];
    assert_eq!([acceleration, angle, rate].map(|demand| demand.limit), limits);
    assert!(all.iter().all(|demand| !demand.is_excessive() && demand.feasible_speed_mps.is_none()));

    // The car in closed loop steers by this angle, and by more than this rate where the curvature begins to change.
    // Its feedforward alone is less.
    let plant = PlantModel::from_bicycle(&car(1.0)).unwrap();
    let trace =
        track_with(plant, &pid, &path, &path.guidance, 30.0, LoopCoupling::GaussSeidel).unwrap();
    let steered = trace.steering.iter().fold(0.0_f64, |most, angle| most.max(angle.abs()));
    println!("steered {steered}, needed {}", angle.needed);
    assert!((steered / angle.needed - 1.0).abs() < 0.1, "{steered} {}", angle.needed);
    let tenth = (0.1 / pid.sample_time_s) as usize;
    let turned = trace.steering.windows(tenth + 1).map(|w| (w[tenth] - w[0]).abs() / 0.1);
    let turned = turned.fold(0.0, f64::max);
    println!("turned {turned}, needed {}", rate.needed);
    assert!((1.0..1.5).contains(&(turned / rate.needed)), "{turned} {}", rate.needed);
    assert!(path.guidance.feedforward_gain_radm.abs() < 0.8 * per_curvature);
}

#[test]
fn the_speed_that_would_do_is_the_highest_that_needs_no_more_than_nine_tenths() {
    let mut pid = controller();
    let speed = 15.0;
    let path = bend(&pid, 0.02, speed);
    let before = demands(&path, &pid, None).unwrap();
    let [acceleration, angle, rate] = ALL.map(|quantity| find(&before, quantity).needed);
    // Each is 0.95 of its limit.
    pid.limits.max_angle_rad = angle / 0.95;
    pid.limits.max_rate_radps = rate / 0.95;
    pid.limits.lateral_acceleration.as_mut().unwrap().max_mps2 = acceleration / 0.95;
    for demand in demands(&path, &pid, None).unwrap() {
        assert!((demand.share() - 0.95).abs() < 1e-9 && demand.is_excessive(), "{demand:?}");
        let feasible = demand.feasible_speed_mps.unwrap();
        let share = |speed: f64| {
            let slower = Path { speed_mps: speed, ..path.clone() };
            find(&demands(&slower, &pid, None).unwrap(), demand.quantity).share()
        };
        println!("{demand}");
        assert!(feasible < speed && share(feasible) <= 0.9, "{demand:?}, {}", share(feasible));
        assert!(share(feasible + 0.15) > 0.9, "{demand:?}, {}", share(feasible + 0.15));
        let text = demand.to_string();
        assert!(text.contains(", 0.95 of the ") && text.contains("m/s or slower"), "{text}");
    }
    let by_acceleration = find(&demands(&path, &pid, None).unwrap(), ALL[0]);
    let expected = (10.0 * speed * (0.9_f64 / 0.95).sqrt()).floor() / 10.0;
    assert!((by_acceleration.feasible_speed_mps.unwrap() - expected).abs() < 0.11);
}

#[test]
fn a_curve_that_is_too_tight_at_every_speed_has_no_speed_that_would_do() {
    let pid = controller();
    let all = demands(&bend(&pid, 0.2, 5.0), &pid, None).unwrap();
    let angle = find(&all, Quantity::SteeringAngle);
    assert!(angle.is_excessive() && angle.feasible_speed_mps.is_none(), "{angle:?}");
    let text = angle.to_string();
    assert!(text.starts_with("needs 29.") && text.contains("of the 22.0° that"), "{text}");
    assert!(text.ends_with("no lower speed is enough, widen the curve there"), "{text}");
}

#[test]
fn a_controller_without_limits_by_speed_has_those_of_the_evidence() {
    let with_bound = controller();
    let mut pid = with_bound.clone();
    pid.limits.lateral_acceleration = None;
    let path = bend(&pid, 0.015, 15.0);
    let all = demands(&path, &pid, None).unwrap();
    assert!(all.iter().all(|demand| demand.quantity != Quantity::LateralAcceleration));
    let stated = find(&demands(&path, &pid, Some(3.0)).unwrap(), Quantity::LateralAcceleration);
    assert_eq!(stated.limit, 3.0);
    assert!(stated.is_excessive());
    // Its gains and its feedforward make the same steady turn as the limits state.
    let expected = demands(&path, &with_bound, None).unwrap();
    for quantity in [Quantity::SteeringAngle, Quantity::SteeringRate] {
        let (by_gains, by_limits) = (find(&all, quantity).needed, find(&expected, quantity).needed);
        assert!((by_gains / by_limits - 1.0).abs() < 1e-3, "{by_gains} {by_limits}");
    }
}

#[test]
fn another_speed_than_the_design_is_found_with_both() {
    let mut pid = controller();
    assert_eq!(OtherSpeed::find(&pid, 15.1), None);
    let other = OtherSpeed::find(&pid, 20.0).unwrap();
    assert_eq!(other.to_string(), "the path is for 20.0 m/s, the controller for 15.0 m/s");
    let entry = |speed_mps| ScheduleEntry {
        speed_mps,
        gains: pid.gains,
        guidance: pid.guidance,
        yaw_rate_lag_s: None,
        rate_reserve_time_s: None,
    };
    pid.schedule = vec![entry(8.0), entry(18.0)];
    assert_eq!(OtherSpeed::find(&pid, 8.0), None);
    assert_eq!(OtherSpeed::find(&pid, 12.0), None);
    let other = OtherSpeed::find(&pid, 20.0).unwrap();
    assert_eq!(other.to_string(), "the path is for 20.0 m/s, the controller for 8.0 to 18.0 m/s");
}

/// Where the pose jumps by 0.2 m on a road that needs 0.93 of the steering rate, the error is removed with the rest of it.
/// With a shorter look-ahead the steering is at its limit in the next bend, and the car leaves the road.
#[test]
fn the_rate_that_a_road_leaves_removes_an_error() {
    let (ratio, speed) = (16.0, 6.5);
    let mut bicycle = car(ratio);
    bicycle.vehicle.speed_mps = speed;
    let plant = DesignPlant::from_bicycle(&bicycle).unwrap();
    let options = DesignOptions { max_rate_radps: Some(0.4 * ratio), ..DesignOptions::default() };
    let pid = design(&plant, &source(), &options).unwrap();
    let road = reference_road(speed, 4.0).unwrap();
    let share = find(&demands(&road, &pid, None).unwrap(), Quantity::SteeringRate).share();
    assert!((0.9..1.0).contains(&share), "{share}");
    let sideslip =
        model_sideslip(&Model::Bicycle(Box::new(bicycle.clone())), Some(speed)).unwrap().unwrap();
    let guidance = with_sideslip(guidance_for(&pid, speed), &sideslip, speed);
    let largest_after = |lookahead_min_m: f64, jump: f64, place: f64| {
        let mut shifted = road.clone();
        for point in shifted.points.iter_mut().filter(|point| point.distance_m > place) {
            point.x_m -= jump * point.heading_rad.sin();
            point.y_m += jump * point.heading_rad.cos();
        }
        let law = Guidance { lookahead_min_m, ..guidance };
        let model = PlantModel::from_bicycle(&bicycle).unwrap();
        let trace =
            track_with(model, &pid, &shifted, &law, 60.0, LoopCoupling::GaussSeidel).unwrap();
        assert!(trace.finished);
        let errors = trace.distance.iter().zip(&trace.cross_track_error);
        errors.filter(|(d, _)| **d > place + 3.0).fold(0.0_f64, |most, (_, e)| most.max(e.abs()))
    };
    for (jump, place) in [(0.2, 10.0), (-0.2, 10.0), (-0.2, 14.0), (0.2, 30.0), (-0.2, 60.0)] {
        let largest = largest_after(guidance.lookahead_min_m, jump, place);
        assert!(largest < 0.2, "{jump} m at {place} m: {largest}");
    }
    let short = largest_after(5.0, -0.2, 14.0);
    assert!(short > 1.0, "{short}");
}
