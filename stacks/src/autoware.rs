//! Autoware: `simple_planning_simulator` (`DELAY_STEER_*`) and `mpc_lateral_controller` (`kinematics`).
//!
//! Both hold a road-wheel angle δ with `δ̇ = (δ_command(t − delay) − δ)/τ` and `yaw rate = v·tan δ/wheel_base`; the
//! simulator reports `δ + steer_bias` as its measurement.
//!
//! | stack | formula | parameters | source |
//! |---|---|---|---|
//! | Autoware | `d(steer)/dt = (command(t − delay) − steer)/tau`, `yaw rate = v·tan(steer)/wheel_base`, measured angle = `steer + steer_bias` | `steer_time_delay`, `steer_time_constant`, `steer_bias`, `steer_lim`, `steer_rate_lim`; MPC: `input_delay`, `vehicle_model_steer_tau`; `wheel_base` | `simple_planning_simulator` and `mpc_lateral_controller` |

use crate::export::{Export, StatedValues};
use crate::lateral::{Lateral, Quantity};

const SIMULATOR: &str = "simulator_model.param.yaml";
const MPC: &str = "mpc.param.yaml";
const VEHICLE: &str = "vehicle_info.param.yaml";

pub(crate) fn fill(export: &mut Export, lateral: &Lateral, stated: &StatedValues) {
    export.convention("angles are of the road wheel, positive to the left, rad");
    export.convention(
        "formula: d(steer)/dt = (command(t - delay) - steer)/tau, yaw rate = v*tan(steer)/wheel_base; measured steer = steer + steer_bias",
    );
    export.convention(format!(
        "tau contains the lag of the vehicle's yaw rate at {:.1} m/s, since Autoware's model has none of its own",
        lateral.speed_mps
    ));
    match &lateral.timing {
        Some(timing) => {
            let total = timing.total_s.value;
            let delay = format!("with the time constant, {total:.4} s in all");
            export.set(SIMULATOR, "steer_time_delay", timing.delay_s, "s", &delay);
            let lag = "from command to yaw rate";
            export.set(SIMULATOR, "steer_time_constant", timing.lag_s, "s", lag);
            export.set(MPC, "input_delay", timing.delay_s, "s", delay);
            export.set(MPC, "vehicle_model_steer_tau", timing.lag_s, "s", lag);
        }
        None => {
            let keys = [
                "steer_time_delay",
                "steer_time_constant",
                "input_delay",
                "vehicle_model_steer_tau",
            ];
            keys.iter().for_each(|key| export.missing(key, LEADS));
        }
    }
    match lateral.steering_offset_rad {
        Some(offset) => {
            export.set(
                SIMULATOR,
                "steer_bias",
                offset,
                "rad",
                "measured angle that drives straight",
            );
        }
        None => export.missing("steer_bias", "the model is not of a drive; identify it from a log"),
    }
    let keys = ["steer_lim", "steer_rate_lim"];
    let rates = (lateral.largest_rate_radps, lateral.driven_rate_radps);
    export.limits(SIMULATOR, stated, rates, keys, ("rad/s", 1.0));
    export.missing(
        "steering_offset",
        "the MPC learns it while driving (enable_auto_steering_offset_removal); steer_bias is where it should converge",
    );
    wheelbase(export, VEHICLE, "wheel_base", lateral, stated);
}

pub(crate) const LEADS: &str =
    "the yaw rate of the model leads the steering; check the clocks of the channels";

/// The wheelbase, compared with the effective one at the model's speed.
pub(crate) fn wheelbase(
    export: &mut Export,
    group: &'static str,
    key: &'static str,
    lateral: &Lateral,
    stated: &StatedValues,
) {
    let effective = lateral.effective_wheelbase_m;
    let error =
        effective.standard_error.map_or(String::new(), |e| format!(" (standard error {e:.4} m)"));
    let at_speed = format!(
        "v*steer/(yaw rate) in steady turns at {:.1} m/s is {:.4} m{error}, with understeer",
        lateral.speed_mps, effective.value
    );
    match stated.wheelbase_m.map(Quantity::stated).or(lateral.wheelbase_m) {
        Some(length) => export.set(group, key, length, "m", format!("axle to axle; {at_speed}")),
        None => export.missing(
            key,
            format!(
                "one speed does not determine it: {at_speed}; measure the wheelbase and state it"
            ),
        ),
    }
}
