//! `steerwright bicycle`: the two-wheel model of a vehicle's data.

use crate::documents::files;
use crate::failure::{Failure, Outcome};
use crate::options::Global;
use crate::output::{OutputKind, Outputs};
use crate::terminal::console;
use std::path::PathBuf;
use steerwright_formats::Bicycle;

/// Make the two-wheel bicycle model (eq 13) of a vehicle's data
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Vehicle data as TOML
    #[arg(value_name = "VEHICLE.toml")]
    vehicle: PathBuf,
    /// Write the model here
    #[arg(long = "output", short = 'o', value_name = "FILE", default_value = "bicycle.json")]
    out: PathBuf,
}

pub(crate) fn run(arguments: &Arguments, global: &Global) -> Result<Outcome, Failure> {
    let out = Outputs::new(global.force, [&arguments.vehicle])
        .file(&arguments.out, OutputKind::for_document::<Bicycle>())?;
    let text = files::read_text(&arguments.vehicle)?;
    let bicycle =
        steerwright_control::bicycle_from_toml(&text, &arguments.vehicle.display().to_string())?;
    out.document(&bicycle)?;
    let (k, v) = (&bicycle.coefficients, &bicycle.vehicle);
    let [a1, a2, a3, a4, b1, b2, n] = [k.a1, k.a2, k.a3, k.a4, k.b1, k.b2, k.n];
    let text = format!(
        "{} at {:.1} m/s\nA1 {a1:.4}  A2 {a2:.4}  A3 {a3:.4}  A4 {a4:.4}  B1 {b1:.4}  B2 {b2:.4}  n {n:.4}  Tn {} s",
        v.name, v.speed_mps, k.tn
    );
    console::result(&text, &bicycle)?;
    console::note(format!("written to {out}"));
    Ok(Outcome::Done)
}
