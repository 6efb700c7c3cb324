//! A bicycle and its evidence, for people.

use crate::evidence::{channels, conclusion, not_negative, validation_data, with_error};
use std::fmt::Write;
use steerwright_formats::{Bicycle, BicycleEvidence};

pub(super) fn text(bicycle: &Bicycle, tables: &str) -> String {
    let text = bicycle.evidence.as_ref().map(|e| evidence(e, bicycle, tables)).unwrap_or_default();
    text + &vehicle(bicycle)
}

fn vehicle(bicycle: &Bicycle) -> String {
    let v = &bicycle.vehicle;
    let [m, j, lf, lr] = [v.mass_kg, v.yaw_inertia_kgm2, v.distance_front_m, v.distance_rear_m];
    let [cf, cr] = [v.cornering_stiffness_front_npr, v.cornering_stiffness_rear_npr];
    format!(
        "vehicle  m {m:.0} kg, J {j:.0} kg·m², Lf {lf:.3} m, Lr {lr:.3} m, Cf {cf:.0} N/rad, Cr {cr:.0} N/rad, Tn {:.4} s, delay {:.4} s, steering ratio {:.3}\n",
        v.actuator_time_constant_s, v.actuator_delay_s, v.steering_ratio
    )
}

fn evidence(e: &BicycleEvidence, bicycle: &Bicycle, tables: &str) -> String {
    let channels = channels(&e.channels, Some(&bicycle.provenance));
    let mut text = format!("{channels}\n{tables}");
    let fit = match &e.held_out {
        Some(h) => with_error(e.validation_fit, h.fit_standard_error, h.without_standard_error()),
        None => format!("{:.2} %", e.validation_fit),
    };
    let _ = writeln!(
        text,
        "fit      {fit} simulated on validation data, {:.2} % on estimation data",
        e.estimation_fit
    );
    text.extend(e.held_out.as_ref().map(validation_data));
    let d = &e.with_delay;
    let _ = writeln!(
        text,
        "delay    {}, with which {:.2} % and {:.2} %; {}",
        not_negative(1e3 * d.input_delay_s, 2e3 * d.standard_error_s, 1, " ms"),
        d.validation_fit,
        d.estimation_fit,
        if bicycle.vehicle.actuator_delay_s > 0.0 { "in the file" } else { "not in the file" }
    );
    let _ = writeln!(
        text,
        "offsets  {:.3}° of the steering angle, {:.3}°/s of the yaw rate; in the file as evidence, not part of the model",
        e.steering_offset_rad.to_degrees(),
        e.yaw_rate_offset_radps.to_degrees()
    );
    text + &conclusion(&e.warnings, &bicycle.quality)
}
