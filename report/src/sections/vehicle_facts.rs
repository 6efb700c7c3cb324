//! What there is to state of the models of a vehicle that have physical parameters.

use super::words::{Facts, not_negative, percent, validation_data, with_error};
use crate::figures::{DEG, text};
use crate::section::Block;
use steerwright_formats::{
    Bicycle, BicycleEvidence, Longitudinal, SimulationFit, Torque, Vehicle, VehicleEvidence,
    correlated, too_few_blocks,
};

pub(super) fn of_bicycle(e: &BicycleEvidence, bicycle: &Bicycle) -> Facts {
    let fit = match &e.held_out {
        Some(h) => with_error(e.validation_fit, h.fit_standard_error, h.without_standard_error()),
        None => percent(e.validation_fit),
    };
    let fit = format!(
        "{fit} simulated on validation data, {} on estimation data",
        percent(e.estimation_fit)
    );
    let mut facts = vec![Block::fact("fit", fit)];
    facts.extend(e.held_out.as_ref().map(|h| Block::fact("validated on", validation_data(h))));
    let d = &e.with_delay;
    facts.push(Block::fact(
        "delay",
        format!(
            "{}; with it the fits are {} and {}; {}",
            not_negative(1e3 * d.input_delay_s, 2e3 * d.standard_error_s, 1, " ms"),
            percent(d.validation_fit),
            percent(d.estimation_fit),
            if bicycle.vehicle.actuator_delay_s > 0.0 { "in the file" } else { "not in the file" }
        ),
    ));
    facts.push(Block::fact(
        "offsets",
        format!(
            "{}° of the steering angle, {}°/s of the yaw rate; in the file as evidence, not part of the model",
            text(DEG * e.steering_offset_rad, 3),
            text(DEG * e.yaw_rate_offset_radps, 3)
        ),
    ));
    facts
}

pub(super) fn bicycle_data(bicycle: &Bicycle) -> String {
    let v = &bicycle.vehicle;
    let [m, j, lf, lr] = [v.mass_kg, v.yaw_inertia_kgm2, v.distance_front_m, v.distance_rear_m];
    let [cf, cr] = [v.cornering_stiffness_front_npr, v.cornering_stiffness_rear_npr];
    let rate = v.actuator_rate_max_radps.map(|rate| format!(", at most {rate:.3} rad/s"));
    format!(
        "m {m:.0} kg, J {j:.0} kg·m², Lf {lf:.3} m, Lr {lr:.3} m, Cf {cf:.0} N/rad, Cr {cr:.0} N/rad, Tn {:.4} s, delay {:.4} s{}, steering ratio {:.3}",
        v.actuator_time_constant_s,
        v.actuator_delay_s,
        rate.unwrap_or_default(),
        v.steering_ratio
    )
}

pub(super) fn vehicle_data(vehicle: &Vehicle) -> String {
    let (b, t, a) = (&vehicle.body, &vehicle.tyres, &vehicle.actuator);
    format!(
        "m {:.0} kg, J {:.0} kg·m², Lf {:.3} m, Lr {:.3} m, Cf {:.0} N/rad, Cr {:.0} N/rad, friction {:.3}, Tn {:.4} s, delay {:.4} s, steering ratio {:.3}",
        b.mass_kg,
        b.yaw_inertia_kgm2,
        b.distance_front_m,
        b.distance_rear_m,
        t.cornering_stiffness_front_npr,
        t.cornering_stiffness_rear_npr,
        t.friction_coefficient,
        a.time_constant_s,
        a.delay_s,
        a.steering_ratio
    )
}

pub(super) fn of_vehicle(e: &VehicleEvidence) -> Facts {
    let words = |names: &str| names.replace('_', " ");
    let mut facts: Facts = correlated(e)
        .into_iter()
        .map(|(a, b, correlation)| {
            let text = format!("{correlation:+.2} of {} and {}", words(a), words(b));
            Block::fact("correlation", text)
        })
        .collect();
    facts.push(Block::fact("fitted", words(&e.fitted.join(", "))));
    let seconds = |samples: usize| samples as f64 * e.sample_time_s;
    let data = format!(
        "{:.0} s estimation data, {:.0} s validation data, {:.1} to {:.1} m/s, to {:.1} m/s²",
        seconds(e.estimation_samples),
        seconds(e.validation_samples),
        e.speed.min_mps,
        e.speed.max_mps,
        e.lateral_acceleration_mps2
    );
    facts.push(Block::fact("data", data));
    for (fit, of) in [(e.validation, "validation"), (Some(e.estimation), "estimation")] {
        if let Some(fit) = fit {
            let text = format!("{} simulated on {of} data", simulation_fit(&fit));
            facts.push(Block::fact("fit", text));
        }
    }
    let spin = format!(
        "not with {:.0} % less friction at the rear axle, on this drive",
        100.0 * e.spin_margin
    );
    facts.push(Block::fact("spin", spin));
    facts
}

fn simulation_fit(fit: &SimulationFit) -> String {
    let error = fit.yaw_rate_standard_error;
    let mut text =
        format!("{} of yaw rate", with_error(fit.yaw_rate, error, too_few_blocks(fit.blocks)));
    if let Some(lateral) = fit.lateral_acceleration {
        text += &format!(", {} of lateral acceleration", percent(lateral));
    }
    if let Some((error, size)) = fit.sideslip_rms_error_rad.zip(fit.sideslip_rms_rad) {
        text += &format!(", {:.2}° RMS of {:.2}° of sideslip", DEG * error, DEG * size);
    }
    text + &format!(", at worst {:.3} rad/s RMS in 5 s,", fit.worst_window_radps)
}

pub(super) fn of_torque(torque: &Torque) -> Facts {
    let e = &torque.evidence;
    let seconds = |samples: usize| samples as f64 * e.sample_time_s;
    let fit = format!(
        "{} on validation data, {} on estimation data; errors of {:.3} m/s²",
        percent(e.validation_fit),
        percent(e.estimation_fit),
        e.error_mps2
    );
    let data = format!(
        "{:.0} s estimation data at {:.1} m/s on average, {:.0} s validation data, above {} m/s",
        seconds(e.estimation_samples),
        e.mean_speed_mps,
        seconds(e.validation_samples),
        e.least_speed_mps
    );
    vec![Block::fact("fit", fit), Block::fact("data", data)]
}

pub(super) fn of_longitudinal(model: &Longitudinal) -> Facts {
    let (e, n) = (&model.evidence, &model.noise);
    let without = "too few windows".into();
    let fit = format!(
        "{} of the change of the speed in {:.0} s, simulated on validation data, {} on estimation data",
        with_error(e.validation_fit, e.validation_fit_standard_error, without),
        e.window_s,
        percent(e.estimation_fit)
    );
    let seconds = |samples: usize| samples as f64 * e.sample_time_s;
    let [low, mean, high] = e.speed_mps;
    let data = format!(
        "{:.0} s estimation data from {low:.1} to {high:.1} m/s, {mean:.1} m/s on average, {:.0} s validation data, above {} m/s",
        seconds(e.estimation_samples),
        seconds(e.validation_samples),
        e.least_speed_mps
    );
    let grade = match model.grade_source.as_str() {
        "none" => "not in the log, part of the disturbance",
        "grade" => "from the channel of the grade",
        "pitch" => "from the pitch",
        _ => "from altitude and distance",
    };
    let noise = format!(
        "{:.4} m/s of the speed; a disturbance of {:.3} m/s² that lasts {:.1} s; prediction errors on validation data are {:.2} times those",
        n.speed_mps, n.disturbance_mps2, n.disturbance_time_constant_s, e.prediction_error_ratio
    );
    vec![
        Block::fact("fit", fit),
        Block::fact("data", data),
        Block::fact("grade", grade),
        Block::fact("noise", noise),
    ]
}
