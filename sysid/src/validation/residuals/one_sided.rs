//! Whether a drive turns to one side alone. On a banked oval gravity does part of the axles' work, and a vehicle of another
//! wheelbase on a level road turns alike. Turns to the other side, where the bank acts the other way, separate the two.

use steerwright_drivelog::DriveLog;
use steerwright_formats::{Grade, Quality, Reason, ReasonCode};

/// Share of the squared lateral acceleration to one side from which a drive is one-sided, percent.
const ONE_SIDED: f64 = 90.0;

/// The quality of a vehicle's parameters, with the reason where the drive turns to one side alone; the yaw rate of the log
/// has an offset, rad/s.
pub(crate) fn graded(quality: Quality, log: &DriveLog, offset_radps: f64) -> Quality {
    let speed = log.speed.as_deref().unwrap_or_default();
    let (mut left, mut all) = (0.0, 0.0);
    for (v, r) in speed.iter().zip(&log.output) {
        let acceleration = v * (r - offset_radps);
        let square = acceleration * acceleration;
        all += square;
        left += if acceleration > 0.0 { square } else { 0.0 };
    }
    let share = 100.0 * f64::max(left, all - left) / all;
    if share.is_nan() || share <= ONE_SIDED {
        return quality;
    }
    let message = format!(
        "{share:.0} % of the squared lateral acceleration is to one side (limit {ONE_SIDED:.0} %): a banked road and the vehicle's parameters cannot be separated"
    );
    let reason = Reason::new(ReasonCode::OneSidedTurns, Grade::Warn, message);
    let advice = "record turns to both sides on one road";
    quality.with_reason(reason.compared(share, ONE_SIDED, "%"), advice.into())
}
