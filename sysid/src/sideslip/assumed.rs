//! The distance from centre of gravity to rear axle where the speed of a drive changes too little to determine it.
//!
//! S of one speed v₀ and the slip κ of usual rear tyres give `b = v₀·(S + κ·v₀)`; the wheelbase of the steady turn,
//! `L + K·v₀²` with the understeer gradient K, gives b as a share of it. Both are known with an error, and are weighted
//! by it. Without b, S would be that of v₀ at every speed, which is what no vehicle does.

use steerwright_formats::{Sideslip, SideslipTerm};

/// A mean and a standard deviation.
type Normal = [f64; 2];

/// Slip of the rear tyres per lateral acceleration, κ = m·Lf/(Cr·L) = 1/(β·η·L), s²/m: of a yaw acceleration β of 40 to
/// 110 rad/s² per rad of slip, a dynamic index η of 1 and a wheelbase of 2.7 m, as the bicycle's prior has them.
const REAR_SLIP: Normal = [0.005, 0.002];
/// Understeer gradient of the road wheel, rad per m/s²: 0 to 3 °/g.
const UNDERSTEER: Normal = [0.002, 0.0015];
/// Share of the wheelbase that lies behind the centre of gravity.
const REAR_SHARE: Normal = [0.54, 0.06];

/// b, m, of the sideslip at a speed, m/s, and of the wheelbase by the steady turn there, m, where it is known.
pub(super) fn assumed_distance(
    found: &Sideslip,
    speed: f64,
    steady_wheelbase: Option<f64>,
) -> Option<SideslipTerm> {
    if speed <= 0.0 {
        return None;
    }
    let mut known = vec![[
        speed * (found.sideslip_per_yaw_rate_s + REAR_SLIP[0] * speed),
        speed * found.standard_error_s.hypot(REAR_SLIP[1] * speed),
    ]];
    if let Some(steady) = steady_wheelbase {
        let wheelbase = steady - UNDERSTEER[0] * speed * speed;
        let error = (REAR_SHARE[1] * steady).hypot(REAR_SHARE[0] * UNDERSTEER[1] * speed * speed);
        known.push([REAR_SHARE[0] * wheelbase, error]);
    }
    let weights: f64 = known.iter().map(|[_, error]| error.powi(-2)).sum();
    let value = known.iter().map(|[mean, error]| mean * error.powi(-2)).sum::<f64>() / weights;
    if value > 0.0 && value.is_finite() {
        return Some(SideslipTerm { value, standard_error: weights.powf(-0.5) });
    }
    None
}
