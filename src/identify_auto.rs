//! `steerwright identify --structure auto`: the simplest structure that the validation data do not reject.

use crate::failure::{Failure, Outcome};
use crate::identify::{self, Shown};
use crate::output::{Kind, Output, Outputs};
use crate::progress::Progress;
use crate::{console, identify_bicycle, identify_vehicle};
use steerwright_drivelog::DriveLog;
use steerwright_formats::{Bicycle, Plant};
use steerwright_report::Table;
use steerwright_sysid::structures::{
    Choice, IdentifiedModel, StructureOptions, StructureRow, identify_structure,
};

/// `out` is the file that is named; by default it is named after the model that is chosen.
pub(crate) fn run(
    log: &DriveLog,
    options: &StructureOptions,
    out: Option<Output>,
    outputs: &mut Outputs,
    traces: Option<&Output>,
) -> Result<Outcome, Failure> {
    let progress = Progress::start("identifying");
    let Choice { model, rows } = identify_structure(log, options)?;
    drop(progress);
    if rows.iter().filter(|row| row.fit.is_ok()).count() > 1 {
        console::note(table(&rows, &model));
    }
    let (name, kind) = match model {
        IdentifiedModel::Plant(_) => ("plant.json", Kind::of::<Plant>()),
        IdentifiedModel::Bicycle(_) => ("bicycle.json", Kind::of::<Bicycle>()),
        IdentifiedModel::Vehicle(_) => ("vehicle.json", Kind::IdentifiedVehicle),
    };
    let out = out.map_or_else(|| outputs.file(name, kind), Ok)?;
    match model {
        IdentifiedModel::Plant(found) => identify::present(&found, &out, traces, &Shown::default()),
        IdentifiedModel::Bicycle(found) => identify_bicycle::present(&found, &out, traces),
        IdentifiedModel::Vehicle(found) => identify_vehicle::present(&found, &out, traces),
    }
}

fn table(rows: &[StructureRow], chosen: &IdentifiedModel) -> String {
    let name = match chosen {
        IdentifiedModel::Plant(_) => "state-space",
        IdentifiedModel::Bicycle(_) => "bicycle",
        IdentifiedModel::Vehicle(_) => "single-track",
    };
    let mut table = Table::new(["structure", "fit on validation data", "errors over the least"]);
    let mut reasons = Vec::new();
    for row in rows {
        let structure = row.structure.to_string();
        let is_chosen = structure == name;
        let fit = match &row.fit {
            Ok((fit, Some(error))) => format!("{fit:.2} ± {:.2} %", 2.0 * error),
            Ok((fit, None)) => format!("{fit:.2} %"),
            Err(reason) => reason.clone(),
        };
        let errors = row.errors.map_or_else(String::new, |(ratio, error)| {
            let rejected = if row.is_rejected { ", rejected" } else { "" };
            let excluded = if row.excluded.is_some() { ", not chosen" } else { rejected };
            format!("{ratio:.2} ± {:.2}{excluded}", 2.0 * error)
        });
        if let (Ok(_), Some(reason)) = (&row.fit, row.excluded) {
            reasons.push(format!(
                "{structure} is not chosen: {reason}; --structure {structure} identifies it"
            ));
        }
        table = table.row([structure + if is_chosen { " <" } else { "" }, fit, errors]);
    }
    reasons.insert(0, console::table(&table));
    reasons.join("\n")
}
