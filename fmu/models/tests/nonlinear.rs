//! The nonlinear vehicle against the linear bicycle and physics.
#![allow(clippy::unwrap_used)]

use proptest::prelude::*;
use steerwright_models::{BicyclePlant, Error, NonlinearParameters, NonlinearVehicle};

const GRAVITY: f64 = 9.81;

fn car() -> NonlinearParameters {
    NonlinearParameters::default()
}

fn altered(
    mut parameters: NonlinearParameters,
    change: impl FnOnce(&mut NonlinearParameters),
) -> NonlinearParameters {
    change(&mut parameters);
    parameters
}

fn vehicle(parameters: NonlinearParameters, speed: f64) -> NonlinearVehicle {
    let mut vehicle = NonlinearVehicle::new(parameters).unwrap();
    vehicle.speed = speed;
    vehicle
}

fn run(vehicle: &mut NonlinearVehicle, time: f64, h: f64) {
    for _ in 0..(time / h).round() as usize {
        vehicle.step(h).unwrap();
    }
}

/// A millionth of a radian: eq 13 to as many digits as slip is small.
#[test]
fn at_small_slip_it_is_the_bicycle() {
    let p = altered(car(), |q| q.actuator.steering_ratio = 12.0);
    for v in [0.0, 0.2, 0.7, 0.999, 1.0, 5.0, 15.0, 40.0] {
        let mut ours = vehicle(p, v);
        let mut linear = BicyclePlant::new(p.bicycle()).unwrap();
        linear.speed = v;
        let amplitude = 12e-6;
        let (mut scale, mut largest) = (1e-12_f64, 1e-12_f64);
        for k in 0..200 {
            let steering = amplitude * (f64::from(k) * 0.07).sin();
            (ours.steering_angle, linear.steering_angle) = (steering, steering);
            ours.step(0.01).unwrap();
            linear.step(0.01).unwrap();
            scale = scale.max(linear.yaw_rate().abs());
            for (a, b) in [
                (ours.yaw_rate(), linear.yaw_rate()),
                (ours.lateral_velocity(), linear.lateral_velocity()),
                (ours.yaw(), linear.yaw()),
                (ours.road_wheel_angle() * v, linear.road_wheel_angle() * v),
                (ours.y() / v.max(1.0), linear.y() / v.max(1.0)),
            ] {
                assert!((a - b).abs() < 3e-6 * scale, "{v} m/s, step {k}: {a:e} {b:e}");
            }
            assert!((ours.x() - linear.x()).abs() < 1e-9);
            let (a, b) = (ours.lateral_acceleration(), linear.lateral_acceleration());
            largest = largest.max(b.abs());
            assert!((a - b).abs() < 3e-6 * largest, "{v}: {a:e} {b:e}");
        }
    }
}

/// Where no bicycle would: the tyres give what friction allows, and turn by that.
#[test]
fn friction_bounds_a_step_steer() {
    for friction in [0.3, 1.0489] {
        let p = altered(car(), |q| {
            // An understeering car, so that the front axle saturates first and it stays on its path.
            q.tyres.friction_coefficient = friction;
            q.body.roll_stiffness_front = 0.9;
            q.tyres.cornering_stiffness_rear_npr = 160_000.0;
        });
        let mut v = vehicle(p, 25.0);
        v.steering_angle = 0.3;
        let mut largest = 0.0_f64;
        for _ in 0..800 {
            v.step(0.01).unwrap();
            largest = largest.max(v.lateral_acceleration().abs());
            assert!(v.lateral_acceleration().abs() <= friction * GRAVITY);
        }
        // Most of what friction gives, and steady: it slides over its front axle.
        assert!(largest > 0.8 * friction * GRAVITY, "{largest}");
        let a_y = v.lateral_acceleration();
        assert!((a_y - 25.0 * v.yaw_rate()).abs() < 1e-3 * a_y, "{a_y}");
        assert!(
            a_y > 0.7 * friction * GRAVITY && a_y < p.bicycle().yaw_rate_gain(25.0) * 0.3 * 25.0
        );
        assert!((v.states()[3] - a_y).abs() < 1e-3 * a_y);
    }
}

/// Steering for a lateral acceleration in a steady turn: by bisection, with small steps towards it.
fn steering_for(p: NonlinearParameters, speed: f64, acceleration: f64) -> f64 {
    let (mut low, mut high) = (0.0, 0.2);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        let mut v = vehicle(p, speed);
        v.steering_angle = middle;
        run(&mut v, 8.0, 0.1);
        if v.lateral_acceleration() < acceleration {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[test]
fn understeer_follows_the_bicycle_and_then_the_load_transfer() {
    let v = 20.0;
    let p = altered(car(), |q| q.tyres.cornering_stiffness_rear_npr = 125_000.0);
    let bicycle = p.bicycle();
    let handling =
        |p: NonlinearParameters, a: f64| steering_for(p, v, a) - bicycle.wheelbase() * a / v / v;
    // The slope at small accelerations is the bicycle's understeer gradient.
    let gradient = handling(p, 0.05) / 0.05;
    assert!((gradient / bicycle.understeer_gradient() - 1.0).abs() < 1e-3, "{gradient}");
    // A stiff front axle in roll understeers more, one without roll stiffness less.
    let share =
        |roll_stiffness_front| altered(p, |q| q.body.roll_stiffness_front = roll_stiffness_front);
    let [soft, even, stiff] = [0.2, 0.5, 0.8].map(|s| handling(share(s), 7.0));
    assert!(soft < even && even < stiff, "{soft} {even} {stiff}");
    // Without height there is no transfer, and without sensitivity it has no effect.
    let flat = |s| altered(share(s), |q| q.body.centre_of_gravity_height_m = 0.0);
    assert_eq!(handling(flat(0.2), 7.0), handling(flat(0.8), 7.0));
    let even = |s| {
        altered(share(s), |q| {
            q.tyres.friction_load_sensitivity = 0.0;
            q.tyres.stiffness_load_sensitivity = 0.0;
        })
    };
    assert!((handling(even(0.2), 7.0) - handling(even(0.8), 7.0)).abs() < 1e-9);
}

#[test]
fn left_and_right_are_mirror_images() {
    let p = altered(car(), |q| q.actuator.delay_s = 0.037);
    for speed in [0.4, 8.0, 33.0] {
        let (mut left, mut right) = (vehicle(p, speed), vehicle(p, speed));
        for k in 0..300 {
            let steering = 0.3 * (f64::from(k) * 0.11).sin() + 0.05;
            (left.steering_angle, right.steering_angle) = (steering, -steering);
            (left.steering_slope, right.steering_slope) = (1.7, -1.7);
            left.step(0.013).unwrap();
            right.step(0.013).unwrap();
            assert_eq!(left.states().map(|x| -x), right.states());
            assert_eq!(left.lateral_acceleration(), -right.lateral_acceleration());
            assert_eq!((left.x(), left.y(), left.yaw()), (right.x(), -right.y(), -right.yaw()));
        }
    }
}

proptest! {
    /// With the wheels straight every tyre's force is against its own sideways motion: what the
    /// lateral energy gains, the prescribed speed has given.
    #[test]
    fn tyres_only_take_energy(
        vy in -20.0..20.0_f64, r in -3.0..3.0_f64, roll in -12.0..12.0_f64, v in 1.0..50.0_f64,
    ) {
        let p = car();
        let mut vehicle = vehicle(p, v);
        vehicle.initial_states = [vy, r, 0.0, roll];
        vehicle.start().unwrap();
        let [vy_rate, r_rate, ..] = vehicle.derivatives();
        let power = p.body.mass_kg * vy * (vy_rate + v * r) + p.body.yaw_inertia_kgm2 * r * r_rate;
        prop_assert!(power <= 1e-6, "{}", power);
    }

    /// Whatever is done, the tyres give no more than friction times weight.
    #[test]
    fn never_more_than_friction(
        steps in prop::collection::vec((-2.0..2.0_f64, 1.0..60.0_f64, -20.0..20.0_f64), 1..30),
    ) {
        let p = altered(car(), |q| q.actuator.road_wheel_rate_max_radps = 5.0);
        let mut vehicle = vehicle(p, 10.0);
        for (steering, v, slope) in steps {
            (vehicle.steering_angle, vehicle.speed, vehicle.steering_slope) = (steering, v, slope);
            vehicle.step(0.07).unwrap();
            let limit = p.tyres.friction_coefficient * GRAVITY * (1.0 + 1e-12);
            prop_assert!(vehicle.lateral_acceleration().abs() <= limit);
            prop_assert!(vehicle.road_wheel_angle().abs() <= p.actuator.road_wheel_angle_max_rad);
        }
    }

    /// The actuator's closed form against its equation, stepped in microseconds.
    #[test]
    fn actuator_follows_its_equation(
        lag in 0.01..0.2_f64, rate in 0.05..2.0_f64, stop in 0.05..0.6_f64,
        start in -1.0..1.0_f64, command in -1.5..1.5_f64, slope in -8.0..8.0_f64,
    ) {
        let p = altered(car(), |q| {
q.actuator.time_constant_s = lag;
q.actuator.road_wheel_rate_max_radps = rate;
q.actuator.road_wheel_angle_max_rad = stop;
});
        let mut vehicle = vehicle(p, 15.0);
        vehicle.initial_states[2] = start * stop;
        vehicle.start().unwrap();
        (vehicle.steering_angle, vehicle.steering_slope) = (command, slope);
        let mut angle = start * stop;
        let (fine, mut time) = (2e-6, 0.0);
        for _ in 0..20 {
            vehicle.step(0.015).unwrap();
            vehicle.steering_angle += slope * 0.015;
            for _ in 0..7500 {
                let at = |t: f64, d: f64| {
                    let command = (command + slope * t).clamp(-stop, stop);
                    ((command - d) / lag).clamp(-rate, rate)
                };
                let half = angle + 0.5 * fine * at(time, angle);
                angle += fine * at(time + 0.5 * fine, half);
                time += fine;
            }
            prop_assert!((vehicle.road_wheel_angle() - angle).abs() < 1e-8);
        }
    }

    /// A ramp cut into steps of any size is one ramp, also through the delay.
    #[test]
    fn steps_do_not_matter(
        cuts in prop::collection::vec(0.001..0.06_f64, 2..12), delay in 0.0..0.2_f64,
        slope in -3.0..3.0_f64, speed in 0.3..40.0_f64,
    ) {
        let p = altered(car(), |q| q.actuator.delay_s = delay);
        let (mut once, mut cut) = (vehicle(p, speed), vehicle(p, speed));
        let total: f64 = cuts.iter().sum();
        (once.steering_angle, once.steering_slope) = (0.1, slope);
        once.step(total).unwrap();
        let mut time = 0.0;
        for h in cuts {
            (cut.steering_angle, cut.steering_slope) = (0.1 + slope * time, slope);
            cut.step(h).unwrap();
            time += h;
        }
        for (a, b) in once.states().iter().zip(cut.states()) {
            prop_assert!((a - b).abs() < 1e-7, "{:?} {:?}", once.states(), cut.states());
        }
        prop_assert!((once.y() - cut.y()).abs() < 1e-7);
    }

    /// A damaged or invented state is an error or a vehicle, never a panic.
    #[test]
    fn restores_or_refuses(at in 0..4096_usize, with in any::<u8>()) {
        let mut vehicle = vehicle(altered(car(), |q| q.actuator.delay_s = 0.05), 15.0);
        run(&mut vehicle, 0.1, 0.01);
        let mut bytes = serde_json::to_vec(&vehicle.save()).unwrap();
        let length = bytes.len();
        bytes[at % length] = with;
        if let Ok(saved) = serde_json::from_slice(&bytes)
            && let Ok(mut other) = NonlinearVehicle::restore(saved)
        {
            let _ = other.step(0.01);
            let _ = other.start();
        }
    }
}

/// The delayed vehicle does what the other did a delay ago.
#[test]
fn delay_shifts_the_response() {
    let delay = 0.08;
    let (mut prompt, mut late) =
        (vehicle(car(), 15.0), vehicle(altered(car(), |q| q.actuator.delay_s = delay), 15.0));
    let ramps = [(0.0, 0.7), (0.028, -1.0), (0.0, 0.0), (0.1, 0.3)];
    let mut seen = Vec::new();
    for k in 0..40 {
        let (start, slope) = ramps[k % ramps.len()];
        for v in [&mut prompt, &mut late] {
            (v.steering_angle, v.steering_slope) = (start, slope);
            v.step(0.04).unwrap();
        }
        seen.push(prompt.states());
        let expected = if k < 2 { [0.0; 4] } else { seen[k - 2] };
        for (a, b) in late.states().iter().zip(expected) {
            assert!((a - b).abs() < 1e-9, "step {k}: {a} {b}");
        }
    }
}

/// Derivatives are those of what a step does.
#[test]
fn derivatives_are_the_limit_of_steps() {
    for (speed, delay) in [(0.5, 0.0), (20.0, 0.0), (20.0, 0.05)] {
        let mut v = vehicle(altered(car(), |q| q.actuator.delay_s = delay), speed);
        v.steering_angle = 0.06;
        v.step(0.1).unwrap();
        v.steering_angle = 0.065;
        let h = 1e-6;
        let mut next = v.clone();
        next.step(h).unwrap();
        let (before, after) = (v.states(), next.states());
        for (i, d) in v.derivatives().into_iter().enumerate() {
            let quotient = (after[i] - before[i]) / h;
            assert!((quotient - d).abs() < 1e-4 * (1.0 + d.abs()), "state {i}: {quotient} {d}");
        }
        let quotients =
            [(next.yaw() - v.yaw()) / h, (next.x() - v.x()) / h, (next.y() - v.y()) / h];
        for (quotient, d) in quotients.into_iter().zip(v.pose_derivatives()) {
            assert!((quotient - d).abs() < 1e-4, "{quotient} {d}");
        }
        let quotient = (next.lateral_acceleration() - v.lateral_acceleration()) / h;
        let d = v.lateral_acceleration_derivative();
        assert!((quotient - d).abs() < 1e-3 * (1.0 + d.abs()), "{quotient} {d}");
    }
}

#[test]
fn stands_still_and_drives_off() {
    let mut v = vehicle(car(), 0.0);
    v.steering_angle = 0.5;
    run(&mut v, 2.0, 0.01);
    assert_eq!((v.y(), v.yaw()), (0.0, 0.0));
    assert!(v.x().abs() < 1e-12 && v.lateral_acceleration().abs() < 1e-9);
    // At walking pace the rear axle rolls on the kinematic circle, also at a large angle.
    v.speed = 0.02;
    run(&mut v, 20.0, 0.1);
    let kinematic = 0.02 * 0.5_f64.tan() / car().bicycle().wheelbase();
    assert!((v.yaw_rate() / kinematic - 1.0).abs() < 2e-3, "{}", v.yaw_rate() / kinematic);
    assert!((v.lateral_velocity() / v.yaw_rate() / car().body.distance_rear_m - 1.0).abs() < 2e-3);
    // Nothing jumps at 1 m/s.
    let respond = |speed: f64| {
        let mut v = vehicle(car(), speed);
        v.steering_angle = 0.5;
        run(&mut v, 1.0, 0.01);
        [v.yaw_rate(), v.lateral_velocity(), v.lateral_acceleration(), v.y()]
    };
    for speed in [1e-9, 0.5, 1.0] {
        for (a, b) in respond(speed - 1e-9).iter().zip(respond(speed + 1e-9)) {
            assert!((a - b).abs() < 1e-6, "{speed}: {a} {b}");
        }
    }
}

#[test]
fn saved_and_restored_it_goes_on_as_if_nothing_had_happened() {
    let mut v = vehicle(altered(car(), |q| q.actuator.delay_s = 0.033), 22.0);
    let drive = |v: &mut NonlinearVehicle, k: u32| {
        v.steering_angle = 0.1 * f64::from(k).sin();
        v.steering_slope = f64::from(k).cos();
        v.step(0.01).unwrap();
    };
    (0..57).for_each(|k| drive(&mut v, k));
    let mut other = NonlinearVehicle::restore(v.save()).unwrap();
    assert_eq!(v, other);
    for k in 57..100 {
        drive(&mut v, k);
        drive(&mut other, k);
        assert_eq!(v, other);
    }
}

#[test]
fn refuses_what_is_no_vehicle() {
    let refused = |p: NonlinearParameters| NonlinearVehicle::new(p).unwrap_err();
    assert!(matches!(
        refused(altered(car(), |q| q.body.mass_kg = -1.0)),
        Error::NotPositive { .. }
    ));
    for p in [
        altered(car(), |q| q.tyres.friction_coefficient = 0.0),
        altered(car(), |q| q.tyres.shape_factor = 2.0),
        altered(car(), |q| q.tyres.curvature_factor = f64::NAN),
        altered(car(), |q| q.tyres.friction_load_sensitivity = 1.0),
        altered(car(), |q| q.body.roll_stiffness_front = 1.1),
        altered(car(), |q| q.body.roll_time_constant_s = 0.0),
        altered(car(), |q| q.actuator.delay_s = -0.1),
        altered(car(), |q| q.actuator.road_wheel_angle_max_rad = 2.0),
    ] {
        assert!(matches!(refused(p), Error::Range { .. }), "{p:?}");
    }
    let mut v = vehicle(car(), 15.0);
    for h in [0.0, -1.0, f64::NAN, 1e9] {
        assert!(matches!(v.step(h), Err(Error::Step { .. })));
    }
    // As quick an actuator as there is: an hour would take longer than anybody waits.
    let mut quick = vehicle(altered(car(), |q| q.actuator.time_constant_s = 1e-4), 15.0);
    assert!(matches!(quick.step(3600.0), Err(Error::Step { .. })));
    v.initial_states[2] = 1.2;
    assert!(v.start().unwrap_err().to_string().contains("road-wheel angle"));
}

/// A small crosswind: yaw rate and lateral velocity of the linear bicycle under a constant force at its place.
#[test]
fn a_crosswind_pushes_the_bicycle() {
    for (speed, wind, arm) in [(10.0, 1.0, 0.3), (28.0, -2.0, 0.3), (28.0, 2.0, -0.5)] {
        let p = altered(car(), |q| q.body.side_force_arm_m = arm);
        let mut ours = vehicle(p, speed);
        ours.crosswind = wind;
        run(&mut ours, 10.0, 0.01);
        let (b, m) = (p.bicycle(), p.body.mass_kg);
        let pressure = 0.5 * 1.225 * (speed * speed + wind * wind);
        let force = pressure * p.body.side_force_area_m2 * (wind / speed).atan();
        // C_f·α_f + C_r·α_r + F = m·v·r and L_f·C_f·α_f − L_r·C_r·α_r + arm·F = 0, by Cramer's rule.
        let [cf, cr] = [b.cornering_stiffness_front, b.cornering_stiffness_rear];
        let [lf, lr] = [b.distance_front, b.distance_rear];
        let moment = lf * cf - lr * cr;
        let [a11, a12] = [cf + cr, moment + m * speed * speed];
        let [a21, a22] = [moment, lf * lf * cf + lr * lr * cr];
        let determinant = a11 * a22 - a12 * a21;
        let lateral_velocity = speed * force * (a22 - arm * a12) / determinant;
        let yaw_rate = speed * force * (arm * a11 - a21) / determinant;
        assert!((ours.yaw_rate() / yaw_rate - 1.0).abs() < 2e-3, "{} {yaw_rate}", ours.yaw_rate());
        let found = ours.lateral_velocity();
        assert!((found / lateral_velocity - 1.0).abs() < 2e-3, "{found} {lateral_velocity}");
    }
}

#[test]
fn a_standing_vehicle_stays_in_the_wind() {
    let mut ours = vehicle(car(), 0.0);
    ours.crosswind = 30.0;
    run(&mut ours, 5.0, 0.01);
    assert_eq!((ours.x(), ours.y(), ours.yaw()), (0.0, 0.0, 0.0));
}

/// The wheels reach as far as the servo less half the gap, and stand still while the servo crosses it.
#[test]
fn the_wheels_follow_through_the_play() {
    let play = 0.02;
    let p = altered(car(), |q| q.actuator.play_rad = play);
    for h in [0.01, 0.003] {
        let mut ours = vehicle(p, 15.0);
        let (mut wheel_before, mut furthest) = (0.0, [0.0_f64; 2]);
        for k in 0..(4.0 / h) as usize {
            ours.steering_angle = 0.05 * (3.0 * h * k as f64).sin();
            ours.step(h).unwrap();
            let (servo, wheel) = (ours.states()[2], ours.road_wheel_angle());
            assert!((servo - wheel).abs() <= 0.5 * play + 1e-15);
            let moved: f64 = wheel - wheel_before;
            // Where the servo has turned within the step, it may have left the edge again.
            let left = (servo - wheel - 0.5 * play * moved.signum()).abs();
            assert!(moved == 0.0 || left < 1e-5, "{servo} {wheel}");
            wheel_before = wheel;
            furthest = [furthest[0].max(servo), furthest[1].max(wheel)];
        }
        let [servo, wheel] = furthest;
        assert!((servo - wheel - 0.5 * play).abs() < 1e-5, "{servo} {wheel}");
    }
}

#[test]
fn one_long_step_is_many_short_ones_through_the_play() {
    let p = altered(car(), |q| q.actuator.play_rad = 0.01);
    let ends = [1, 10, 100].map(|count| {
        let mut ours = vehicle(p, 20.0);
        let h = 1.0 / f64::from(count);
        for k in 0..count {
            ours.steering_angle = 0.06 - 0.15 * h * f64::from(k);
            ours.steering_slope = -0.15;
            ours.step(h).unwrap();
        }
        [ours.yaw_rate(), ours.lateral_velocity(), ours.road_wheel_angle(), ours.y()]
    });
    for end in &ends[1..] {
        for (a, b) in end.iter().zip(&ends[0]) {
            assert!((a - b).abs() < 1e-9, "{ends:?}");
        }
    }
}

/// A lag that is over within a step, at once and in steps that it takes many of.
#[test]
fn a_short_lag_is_resolved_whatever_the_step() {
    for time_constant_s in [1e-4, 2e-4, 7e-4, 1.9e-3] {
        for (speed, rate) in [(15.0, 1e3), (30.0, 40.0)] {
            let parameters = altered(car(), |q| {
                q.actuator.time_constant_s = time_constant_s;
                q.actuator.road_wheel_rate_max_radps = rate;
            });
            let mut once = vehicle(parameters, speed);
            let mut cut = once.clone();
            for k in 0..40 {
                let angle = 0.05 * (0.9 * f64::from(k)).sin();
                (once.steering_angle, cut.steering_angle) = (angle, angle);
                once.step(0.01).unwrap();
                for _ in 0..400 {
                    cut.step(0.01 / 400.0).unwrap();
                }
                for (a, b) in once.states().iter().zip(cut.states()) {
                    assert!((a - b).abs() < 1e-6, "{time_constant_s} {k}: {a} {b}");
                }
            }
        }
    }
}
