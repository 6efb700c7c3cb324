//! `steerwright identify --structure bicycle`: the bicycle in a drive log.

use crate::console;
use crate::evidence::{band, channels, conclusion, not_negative, traces_csv, validation_data};
use crate::failure::{Failure, Outcome};
use crate::output::Output;
use crate::progress::Progress;
use std::fmt::Write;
use steerwright_drivelog::DriveLog;
use steerwright_formats::{Bicycle, BicycleEvidence};
use steerwright_sysid::bicycle::{BicycleOptions, IdentifiedBicycle, identify_bicycle};

pub(crate) fn run(
    log: &DriveLog,
    options: &BicycleOptions,
    out: &Output,
    traces: Option<&Output>,
) -> Result<Outcome, Failure> {
    let progress = Progress::start("identifying");
    let found = identify_bicycle(log, options)?;
    drop(progress);
    present(&found, out, traces)
}

/// Writes and prints a bicycle.
pub(crate) fn present(
    found: &IdentifiedBicycle,
    out: &Output,
    traces: Option<&Output>,
) -> Result<Outcome, Failure> {
    out.document(&found.bicycle)?;
    if let Some(traces) = traces {
        traces.write(traces_csv(&found.traces, None).as_bytes())?;
    }
    let bicycle = &found.bicycle;
    let mut text = bicycle.evidence.as_ref().map(|e| evidence(e, bicycle)).unwrap_or_default();
    text += &vehicle(&found.bicycle);
    console::result(&text, &found.bicycle)?;
    console::note(format!("written to {out}"));
    Ok(Outcome::of(&found.bicycle.quality))
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

/// Whether a quantity is one of a size: only the gradient and the offsets have either sign.
fn is_positive(name: &str) -> bool {
    name != "understeer_gradient" && !name.contains("offset")
}

fn evidence(e: &BicycleEvidence, bicycle: &Bicycle) -> String {
    let mut identified =
        steerwright_report::Table::new(["identified", "value", "95 % band", "unit"]);
    for q in &e.identified {
        identified = identified.row([
            q.name.replace('_', " "),
            format!("{:.5}", q.value),
            band(q.value, 2.0 * q.standard_error, is_positive(&q.name)),
            q.unit.clone(),
        ]);
    }
    let mut stated = steerwright_report::Table::new(["not identified", "value", "origin"]);
    for s in &e.stated {
        stated = stated.row([s.name.clone(), format!("{}", s.value), s.origin.clone()]);
    }
    let channels = channels(&e.channels, Some(&bicycle.provenance));
    let (identified, stated) = (console::table(&identified), console::table(&stated));
    let mut text = format!("{channels}\n{identified}\n{stated}\n");
    let error = e.held_out.as_ref().and_then(|h| h.fit_standard_error);
    let error = error.map_or_else(String::new, |error| format!(" ± {:.2}", 2.0 * error));
    let _ = writeln!(
        text,
        "fit      {:.2}{error} % simulated on validation data, {:.2} % on estimation data",
        e.validation_fit, e.estimation_fit
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
