//! The Ackermann rover of PX4.
//!
//! The road-wheel angle is `atan(RO_YAW_RATE_CORR·(yaw rate)·RA_WHEEL_BASE/v)`, divided by `RA_MAX_STR_ANG`.
//!
//! | stack | formula | parameters | source |
//! |---|---|---|---|
//! | PX4 rover | angle = `atan(RO_YAW_RATE_CORR·(yaw rate)·RA_WHEEL_BASE/v)` | `RA_WHEEL_BASE`, `RA_MAX_STR_ANG`, `RA_STR_RATE_LIM`, `RO_YAW_RATE_CORR` | `rover_ackermann` with its guide to rate tuning |

use crate::autoware::wheelbase;
use crate::export::{Export, StatedValues};
use crate::lateral::Lateral;

const ACKERMANN: &str = "Rover Ackermann";
const RATE: &str = "Rover Rate Control";

pub(crate) fn fill(export: &mut Export, lateral: &Lateral, stated: &StatedValues) {
    export.convention("angles are of the road wheel; yaw rates are positive to the right in PX4, and these gains do not depend on the sign");
    export.convention(
        "formula: road-wheel angle = atan(RO_YAW_RATE_CORR*(yaw rate)*RA_WHEEL_BASE/v), output = angle/RA_MAX_STR_ANG",
    );
    wheelbase(export, ACKERMANN, "RA_WHEEL_BASE", lateral, stated);
    let keys = ["RA_MAX_STR_ANG", "RA_STR_RATE_LIM"];
    let degrees = ("deg/s", 1.0_f64.to_degrees());
    let rates = (lateral.largest_rate_radps, lateral.driven_rate_radps);
    export.limits(ACKERMANN, stated, rates, keys, degrees);
    match stated.wheelbase_m.or(lateral.wheelbase_m.map(|l| l.value)) {
        Some(length) => {
            let note =
                format!("effective wheelbase at {:.1} m/s over RA_WHEEL_BASE", lateral.speed_mps);
            let factor = lateral.effective_wheelbase_m.times(1.0 / length);
            export.set(RATE, "RO_YAW_RATE_CORR", factor, "1", note);
        }
        None => export.missing(
            "RO_YAW_RATE_CORR",
            "it is relative to RA_WHEEL_BASE; measure the wheelbase and state it",
        ),
    }
    export.missing(
        "RO_MAX_THR_SPEED",
        "the steering does not determine it; drive at full throttle and read the speed",
    );
}
