//! `steerwright identify --structure single-track`: the vehicle in a drive log, up to the limit of its grip.

use crate::console;
use crate::evidence::{channels, conclusion, traces_csv, with_error};
use crate::failure::{Failure, Outcome};
use crate::output::Output;
use crate::progress::Progress;
use std::fmt::Write;
use steerwright_drivelog::DriveLog;
use steerwright_formats::{
    SimulationFit, Vehicle, VehicleEvidence, VehicleParameter, correlated, too_few_blocks,
};
use steerwright_sysid::single_track::{
    IdentifiedVehicle, IdentifyVehicleOptions, identify_vehicle,
};

pub(crate) fn run(
    log: &DriveLog,
    options: &IdentifyVehicleOptions,
    out: &Output,
    traces: Option<&Output>,
) -> Result<Outcome, Failure> {
    let progress = Progress::start("identifying");
    let found = identify_vehicle(log, options)?;
    drop(progress);
    present(&found, out, traces)
}

/// Writes and prints a vehicle.
pub(crate) fn present(
    found: &IdentifiedVehicle,
    out: &Output,
    traces: Option<&Output>,
) -> Result<Outcome, Failure> {
    out.document(&found.vehicle)?;
    if let Some(traces) = traces {
        traces.write(traces_csv(&found.traces, None).as_bytes())?;
    }
    let vehicle = &found.vehicle;
    let evidence = vehicle.evidence.as_ref();
    let text = evidence.map(|e| evidence_text(e, vehicle)).unwrap_or_default();
    console::result(&(text + &data(vehicle)), vehicle)?;
    console::note(format!("written to {out}"));
    Ok(Outcome::of(&vehicle.quality))
}

fn data(vehicle: &Vehicle) -> String {
    let (b, t, a) = (&vehicle.body, &vehicle.tyres, &vehicle.actuator);
    format!(
        "vehicle  m {:.0} kg, J {:.0} kg·m², Lf {:.3} m, Lr {:.3} m, Cf {:.0} N/rad, Cr {:.0} N/rad, friction {:.3}, Tn {:.4} s, delay {:.4} s, steering ratio {:.3}\n",
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

/// Where the value of a parameter comes from.
fn origin(p: &VehicleParameter) -> &'static str {
    match (p.prior.standard_deviation > 0.0, p.is_determined, p.is_at_bound) {
        (false, ..) => "stated",
        (_, _, true) => "bound",
        (_, true, _) => "drive",
        (..) if p.posterior_per_prior > 0.9 => "prior",
        _ => "both",
    }
}

/// With the digits that an error leaves two of.
fn as_its_error(value: f64, error: f64) -> String {
    let digits = (1.0 - error.abs().max(1e-9).log10().floor()).max(0.0) as usize;
    format!("{value:.digits$}")
}

/// From and to, with the digits that the width leaves two of.
fn range_text([low, high]: [f64; 2]) -> String {
    let half = 0.5 * (high - low);
    format!("{} to {}", as_its_error(low, half), as_its_error(high, half))
}

/// The prior to one standard deviation, within the bounds.
fn prior_range(p: &VehicleParameter) -> [f64; 2] {
    let prior = &p.prior;
    let end = |deviations: f64| {
        let by = deviations * prior.standard_deviation;
        let value = if p.is_logarithmic { prior.mean * by.exp() } else { prior.mean + by };
        value.clamp(prior.min, prior.max)
    };
    [end(-1.0), end(1.0)]
}

fn evidence_text(e: &VehicleEvidence, vehicle: &Vehicle) -> String {
    let columns = ["parameter", "value", "95 % band", "prior (68 %)", "moved by", "from"];
    let mut table = steerwright_report::Table::new(columns);
    for p in &e.parameters {
        let is_stated = p.prior.standard_deviation == 0.0;
        let unless_stated = |text: String| if is_stated { "–".into() } else { text };
        let error = 0.5 * (p.band_95[1] - p.band_95[0]);
        let unit = if p.unit.is_empty() { String::new() } else { format!(", {}", p.unit) };
        table = table.row([
            p.name.replace('_', " ") + &unit,
            if is_stated { format!("{}", p.value) } else { as_its_error(p.value, error) },
            unless_stated(range_text(p.band_95)),
            unless_stated(range_text(prior_range(p))),
            unless_stated(format!("{:+.1}", p.moved_deviations)),
            origin(p).into(),
        ]);
    }
    let channels = channels(&e.channels, vehicle.provenance.as_ref());
    let mut text = format!("{channels}\n{}\n", console::table(&table));
    for (a, b, correlation) in correlated(e) {
        let (a, b) = (a.replace('_', " "), b.replace('_', " "));
        let _ = writeln!(text, "         correlation {correlation:+.2} of {a} and {b}");
    }
    let _ = writeln!(text, "fitted   {}", e.fitted.join(", ").replace('_', " "));
    let seconds = |samples: usize| samples as f64 * e.sample_time_s;
    let _ = writeln!(
        text,
        "data     {:.0} s estimation data, {:.0} s validation data, {:.1} to {:.1} m/s, to {:.1} m/s²",
        seconds(e.estimation_samples),
        seconds(e.validation_samples),
        e.speed.min_mps,
        e.speed.max_mps,
        e.lateral_acceleration_mps2
    );
    for (fit, of) in [(e.validation, "validation"), (Some(e.estimation), "estimation")] {
        let Some(fit) = fit else { continue };
        let _ = writeln!(text, "fit      {} simulated on {of} data", fit_text(&fit));
    }
    let _ = writeln!(
        text,
        "spin     not with {:.0} % less friction at the rear axle, on the estimation data",
        100.0 * e.spin_margin
    );
    text + &conclusion(&e.warnings, &vehicle.quality)
}

fn fit_text(fit: &SimulationFit) -> String {
    let error = fit.yaw_rate_standard_error;
    let mut text =
        format!("{} of yaw rate", with_error(fit.yaw_rate, error, too_few_blocks(fit.blocks)));
    if let Some(lateral) = fit.lateral_acceleration {
        let _ = write!(text, ", {lateral:.2} % of lateral acceleration");
    }
    if let Some([error, size]) =
        fit.sideslip_rms_error_rad.zip(fit.sideslip_rms_rad).map(<[f64; 2]>::from)
    {
        let (error, size) = (error.to_degrees(), size.to_degrees());
        let _ = write!(text, ", {error:.2}° RMS of {size:.2}° of sideslip");
    }
    let _ = write!(text, ", at worst {:.3} rad/s RMS in 5 s,", fit.worst_window_radps);
    text
}
