//! Whether a drive turns to one side alone. On a banked oval gravity does part of the axles' work, and a vehicle with another
//! wheelbase on a level road would turn alike; turns to the other side, where the bank acts the other way, tell them apart.

use steerwright_drivelog::DriveLog;
use steerwright_formats::{Grade, Quality, Reason, ReasonCode};

/// Share of the square of the lateral acceleration v·r to one side, less that to the other, from which a drive is one-sided.
const ONE_SIDED: f64 = 0.8;

/// The quality of a vehicle's parameters, with the reason where the drive turns to one side alone.
pub(crate) fn graded(quality: Quality, log: &DriveLog) -> Quality {
    let speed = log.speed.as_deref().unwrap_or_default();
    let (mut sided, mut all) = (0.0, 0.0);
    for (v, r) in speed.iter().zip(&log.output) {
        let acceleration = v * r;
        sided += acceleration * acceleration.abs();
        all += acceleration * acceleration;
    }
    let share = f64::abs(sided / all);
    if share.is_nan() || share <= ONE_SIDED {
        return quality;
    }
    let message = "the drive turns to one side alone, where a bank of the road and the vehicle's parameters are one";
    let reason = Reason::new(ReasonCode::OneSidedTurns, Grade::Warn, message);
    let advice = "record turns to both sides, on a level road or on one with the same bank";
    quality.with_reason(reason.compared(share, ONE_SIDED, "1"), advice.into())
}
