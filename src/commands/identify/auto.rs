//! `steerwright identify --structure auto`: the structure with the smallest error on the validation data.

use crate::failure::Failure;
use crate::terminal::console;
use steerwright_drivelog::DriveLog;
use steerwright_formats::Structure;
use steerwright_report::Table;
use steerwright_sysid::{Choice, ChoiceOptions, IdentifiedModel, StructureRow, identify_structure};

/// The model, with the table of the structures where there is more than one.
pub(super) fn identify(
    log: &DriveLog,
    options: &ChoiceOptions,
) -> Result<(IdentifiedModel, Option<String>), Failure> {
    let Choice { identified, rows } = identify_structure(log, options)?;
    let is_choice = rows.iter().filter(|row| row.fit.is_ok()).count() > 1;
    let table = if is_choice { Some(table(&rows, identified.model.structure())) } else { None };
    Ok((identified, table))
}

fn table(rows: &[StructureRow], chosen: Structure) -> String {
    let mut table =
        Table::new(["structure", "fit on common validation data", "errors over the chosen"]);
    let mut reasons = Vec::new();
    for row in rows {
        let structure = row.structure;
        let fit = match &row.fit {
            Ok((fit, Some(error))) => format!("{fit:.2} ± {:.2} %", 2.0 * error),
            Ok((fit, None)) => format!("{fit:.2} %"),
            Err(reason) => reason.clone(),
        };
        let errors = row.errors.map_or_else(String::new, |(ratio, error)| {
            if structure == chosen {
                return String::from("smallest, chosen");
            }
            let is_undecided = (ratio - 1.0).abs() <= 2.0 * error;
            let undecided = if is_undecided { ", undecided" } else { "" };
            let excluded = if row.excluded.is_some() { ", not chosen" } else { undecided };
            format!("{ratio:.2} ± {:.2}{excluded}", 2.0 * error)
        });
        if let (Ok(_), Some(reason)) = (&row.fit, row.excluded) {
            reasons.push(format!(
                "{structure} is not chosen: {reason}; --structure {structure} identifies it"
            ));
        }
        table = table.row([
            structure.to_string() + if structure == chosen { " <" } else { "" },
            fit,
            errors,
        ]);
    }
    reasons.insert(0, console::table(&table));
    reasons.join("\n")
}
