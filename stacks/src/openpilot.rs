//! openpilot: `CarParams` of the vehicle model, for cars steered by angle or torque.
//!
//! Its vehicle model is the steady state of eq 13: `yaw rate = v/(L·(1 − sf·v²))·δ/steerRatio` with
//! `sf = m(C_f·L_f − C_r·L_r)/(L²·C_f·C_r)`; its lag from command to lateral acceleration is
//! `steerActuatorDelay + 0.2 s`.
//!
//! | stack | formula | parameters | source |
//! |---|---|---|---|
//! | openpilot | `yaw rate = v·angle/(steerRatio·wheelbase·(1 − sf·v²))`, `sf = m(Cf·a − Cr·b)/(L²·Cf·Cr)`; lateral delay = `steerActuatorDelay + 0.2 s` | `steerActuatorDelay`, `steerRatio`, `wheelbase`, `mass`, `rotationalInertia`, `centerToFront`, `tireStiffnessFront`, `tireStiffnessRear` | `vehicle_model.py` |

use crate::autoware::LEADS;
use crate::export::{Export, StatedValues};
use crate::lateral::{Lateral, Quantity, Timing};

/// The part of the lateral delay that openpilot adds to `steerActuatorDelay`, s.
pub(crate) const ADDED: f64 = 0.2;
pub(crate) const GROUP: &str = "CarParams";

pub(crate) fn fill(export: &mut Export, lateral: &Lateral, _: &StatedValues) {
    export.convention(
        "angles are of the steering wheel, positive to the left; stiffnesses are of an axle",
    );
    export.convention(
        "formula: yaw rate = v*angle/(steerRatio*wheelbase*(1 - sf*v^2)), sf = mass*(Cf*centerToFront - Cr*centerToRear)/(wheelbase^2*Cf*Cr)",
    );
    export.convention(
        "formula: lateral delay = steerActuatorDelay + 0.2 s, of command to lateral acceleration",
    );
    match &lateral.timing {
        Some(Timing { total_s, .. }) => {
            let note = format!(
                "the delay and lag of {:.4} s from angle to yaw rate, minus 0.2 s",
                total_s.value
            );
            let quantity = Quantity { value: (total_s.value - ADDED).max(0.0), ..*total_s };
            export.set(GROUP, "steerActuatorDelay", quantity, "s", note);
        }
        None => export.missing("steerActuatorDelay", LEADS),
    }
    let Some(vehicle) = &lateral.vehicle else {
        for key in [
            "steerRatio",
            "wheelbase",
            "mass",
            "rotationalInertia",
            "centerToFront",
            "tireStiffnessFront",
            "tireStiffnessRear",
        ] {
            export.missing(
                key,
                "one speed does not determine it; identify the bicycle on a drive of varying speed, and export that",
            );
        }
        torque(export);
        return;
    };
    if let Some(wheelbase) = lateral.wheelbase_m {
        export.set(GROUP, "wheelbase", wheelbase, "m", "axle to axle");
    }
    let stated = Quantity::stated;
    if lateral.steering_ratio.value > 1.0 {
        export.set(
            GROUP,
            "steerRatio",
            lateral.steering_ratio,
            "1",
            "steering wheel over road wheel",
        );
    } else {
        export.missing(
            "steerRatio",
            "the model's steering angle is of the road wheel; identify it from the steering wheel's angle",
        );
    }
    let [stiffness_front, stiffness_rear] = vehicle.axle_stiffness();
    for (key, value, unit, note) in [
        ("mass", vehicle.mass_kg, "kg", "stated"),
        ("rotationalInertia", vehicle.yaw_inertia_kgm2, "kg.m2", "in proportion to the mass"),
        ("centerToFront", vehicle.distance_front_m, "m", "centre of gravity to front axle"),
        ("tireStiffnessFront", stiffness_front, "N/rad", "in proportion to the mass"),
        ("tireStiffnessRear", stiffness_rear, "N/rad", "in proportion to the mass"),
    ] {
        export.set(GROUP, key, stated(value), unit, note);
    }
    torque(export);
}

fn torque(export: &mut Export) {
    export.missing(
        "lateralTuning.torque",
        "latAccelFactor, latAccelOffset and friction require a model of the steering torque; identify the structure torque, and export that",
    );
}
