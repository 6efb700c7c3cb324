//! ArduPilot Rover with Ackermann steering.
//!
//! The steering output (−1 to 1) is `ATC_STR_RAT_FF·(yaw rate in rad/s)`, times `MOT_SPD_SCA_BASE/v` above that
//! speed. With the road wheel at `max_angle` times the output, the yaw rate is the demanded one for
//! `ATC_STR_RAT_FF = L/(MOT_SPD_SCA_BASE·max_angle)`.
//!
//! | stack | formula | parameters | source |
//! |---|---|---|---|
//! | ArduPilot Rover | output = `ATC_STR_RAT_FF·(yaw rate)·MOT_SPD_SCA_BASE/v` | `ATC_STR_RAT_FF`, `MOT_SPD_SCA_BASE`, `TURN_RADIUS` | `AR_AttitudeControl` and `AP_MotorsUGV` |

use crate::export::{Export, StatedValues};
use crate::lateral::{Lateral, Quantity};

/// The default of `MOT_SPD_SCA_BASE`, m/s.
const BASE: f64 = 1.0;
const GROUP: &str = "Rover";

pub(crate) fn fill(export: &mut Export, lateral: &Lateral, stated: &StatedValues) {
    export.convention("yaw rates and outputs are positive to the right in ArduPilot; these gains do not depend on the sign");
    export.convention(
        "formula: output (-1 to 1) = ATC_STR_RAT_FF*(desired yaw rate, rad/s)*MOT_SPD_SCA_BASE/v above MOT_SPD_SCA_BASE",
    );
    export.convention(
        "the output moves the road wheel in proportion, to the stated largest angle at 1",
    );
    let Some(angle) = stated.max_angle_rad else {
        for key in ["ATC_STR_RAT_FF", "TURN_RADIUS"] {
            export.missing(key, "the road-wheel angle at full output is not stated; measure the largest angle and state it");
        }
        trim(export, lateral);
        return;
    };
    export.set(
        GROUP,
        "MOT_SPD_SCA_BASE",
        Quantity::stated(BASE),
        "m/s",
        "ArduPilot's default, on which ATC_STR_RAT_FF depends",
    );
    let note = format!(
        "output per yaw rate at {:.1} m/s, of an effective wheelbase of {:.4} m and {angle:.4} rad at full output",
        lateral.speed_mps, lateral.effective_wheelbase_m.value
    );
    let gain = lateral.effective_wheelbase_m.times(1.0 / (BASE * angle));
    export.set(GROUP, "ATC_STR_RAT_FF", gain, "s/rad", note);
    match stated.wheelbase_m.map(Quantity::stated).or(lateral.wheelbase_m) {
        Some(length) => {
            export.set(
                GROUP,
                "TURN_RADIUS",
                length.times(1.0 / angle.tan()),
                "m",
                "of the rear axle at low speed and full output",
            );
        }
        None => {
            export.missing("TURN_RADIUS", "the wheelbase is not known; measure it and state it")
        }
    }
    trim(export, lateral);
}

fn trim(export: &mut Export, lateral: &Lateral) {
    let offset = match lateral.steering_offset_rad {
        Some(o) => {
            format!(
                "the road wheel stands at {:.5} rad (positive to the left) when driving straight",
                o.value
            )
        }
        None => "the model is not of a drive".to_owned(),
    };
    export.missing(
        "SERVO1_TRIM",
        format!("{offset}; the pulse width of it is found by Save Trim of RCx_OPTION"),
    );
}
