//! The bicycle model of vehicle data.

use super::{significant, value};
use crate::section::{Block, Section};
use crate::table::Table;
use steerwright_formats::Bicycle;

/// Vehicle data and coefficients of eq 13.
pub(crate) fn bicycle(bicycle: &Bicycle, fit: Option<f64>) -> Section {
    let (v, c) = (&bicycle.vehicle, &bicycle.coefficients);
    let mut table = Table::new(["quantity", "value"]);
    for (name, number, unit) in v.in_words() {
        table.push([name.to_owned(), format!("{} {unit}", significant(number)).trim_end().into()]);
    }
    let coefficients = Table::new(["A1", "A2", "A3", "A4", "B1", "B2", "n", "Tn"])
        .row([c.a1, c.a2, c.a3, c.a4, c.b1, c.b2, c.n, c.tn].map(significant));
    let mut blocks = vec![
        Block::Text(format!("Two-wheel model of {} (eq 13).", v.name)),
        Block::Table(table),
        Block::Heading("Coefficients of eq 13".into()),
        Block::Table(coefficients),
    ];
    if let Some(fit) = fit {
        blocks.push(Block::Text(format!(
            "Driven by the recorded steering it fits the measured yaw rate by {}.",
            value(fit, 2, "%")
        )));
    }
    Section::new("The bicycle model", blocks)
}
