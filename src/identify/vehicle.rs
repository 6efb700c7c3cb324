//! A vehicle and its evidence, for people.

use crate::evidence::{channels, conclusion, with_error};
use std::fmt::Write;
use steerwright_formats::{SimulationFit, Vehicle, VehicleEvidence, correlated, too_few_blocks};

pub(super) fn text(vehicle: &Vehicle, tables: &str) -> String {
    let evidence = vehicle.evidence.as_ref();
    let text = evidence.map(|e| evidence_text(e, vehicle, tables)).unwrap_or_default();
    text + &data(vehicle)
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

fn evidence_text(e: &VehicleEvidence, vehicle: &Vehicle, tables: &str) -> String {
    let channels = channels(&e.channels, vehicle.provenance.as_ref());
    let mut text = format!("{channels}\n{tables}");
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
