//! Angles on the circle.

use std::f64::consts::{PI, TAU};

/// The angle in (−π, π] that points the same way, rad.
///
/// Angles already inside come back bit by bit.
#[must_use]
pub fn wrap_angle(angle: f64) -> f64 {
    if angle > -PI && angle <= PI {
        return angle;
    }
    // `%` is exact, so no turn is lost however far the angle has wound up.
    let rest = angle % TAU;
    if rest > PI {
        rest - TAU
    } else if rest <= -PI {
        rest + TAU
    } else {
        rest
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn half_open_interval() {
        assert_eq!(wrap_angle(PI), PI);
        assert_eq!(wrap_angle(-PI), PI);
        assert_eq!(wrap_angle(0.0), 0.0);
        assert!((wrap_angle(3.0 * PI) - PI).abs() < 1e-14);
        assert!((wrap_angle(TAU + 0.25) - 0.25).abs() < 1e-14);
        assert!(wrap_angle(f64::INFINITY).is_nan());
    }

    proptest! {
        #[test]
        fn same_direction_and_in_range(angle in -1e6..1e6_f64) {
            let wrapped = wrap_angle(angle);
            prop_assert!(wrapped > -PI && wrapped <= PI);
            prop_assert!((wrapped.sin() - angle.sin()).abs() < 1e-9);
            prop_assert!((wrapped.cos() - angle.cos()).abs() < 1e-9);
        }
    }
}
