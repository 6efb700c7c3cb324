//! openpilot: `CarParams` of a car steered by torque.
//!
//! Its controller commands `desired lateral acceleration/latAccelFactor + friction·sign`, the friction within a small
//! error of the acceleration, and compensates the roll of the road with 9.81 m/s²·sin(roll).
//!
//! | stack | formula | parameters | source |
//! |---|---|---|---|
//! | openpilot, `torque.json` | acceleration = `latAccelFactor·(command − friction·sign(steering rate)) + 9.81·sin(roll) + latAccelOffset`; lateral delay = `steerActuatorDelay + 0.2 s` | `latAccelFactor`, `latAccelOffset`, `friction`, `steerActuatorDelay` | `torqued.py` |

use crate::Error;
use crate::export::{Export, FileForm};
use crate::lateral::Quantity;
use crate::openpilot::{ADDED, GROUP};
use steerwright_formats::{Estimate, Torque};

const TUNING: &str = "CarParams.lateralTuning.torque";

pub(crate) fn export(stack: &'static str, torque: &Torque) -> Result<Export, Error> {
    if torque.command_unit != "1" {
        return Err(Error::NotNormalised { unit: torque.command_unit.clone() });
    }
    let mut export = Export::new(stack, FileForm::Toml, &torque.name, &torque.quality);
    export.convention("the command is from -1 to 1, positive to the left");
    export.convention(
        "formula: lateral acceleration = latAccelFactor*(command - friction*sign(steering rate)) + 9.81*sin(roll) + latAccelOffset",
    );
    export.convention(
        "formula: lateral delay = steerActuatorDelay + 0.2 s, of command to lateral acceleration",
    );
    let delay = torque.delay_s;
    let note = format!("the delay of {:.4} s, minus 0.2 s", delay.value);
    let actuator = Quantity { value: (delay.value - ADDED).max(0.0), ..quantity(delay) };
    export.set(GROUP, "steerActuatorDelay", actuator, "s", note);
    for (key, estimate, unit, note) in [
        (
            "latAccelFactor",
            torque.acceleration_per_command,
            "m/s2",
            "lateral acceleration per command",
        ),
        ("latAccelOffset", torque.offset_mps2, "m/s2", "lateral acceleration without command"),
        ("friction", torque.friction, "1", "command that overcomes the friction of the steering"),
    ] {
        export.set(TUNING, key, quantity(estimate), unit, note);
    }
    Ok(export)
}

fn quantity(estimate: Estimate) -> Quantity {
    Quantity { value: estimate.value, standard_error: Some(estimate.standard_error) }
}
