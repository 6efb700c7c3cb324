//! Whether wheelbase and speed can be those of one class of road vehicles. A wrong unit of the speed multiplies the
//! wheelbase that a drive at several speeds determines; at one speed only the speed itself shows it.

use steerwright_drivelog::VehicleClass;
use steerwright_formats::{Grade, Reason, ReasonCode};

/// Mean speed on a road above which the unit is in doubt where no class is stated, m/s: 180 km/h.
const DOUBTFUL_MPS: f64 = 50.0;
/// Standard errors that a wheelbase may be beyond a limit.
const WITHIN: f64 = 2.0;

/// Least and largest wheelbase, m, and the largest mean speed, m/s. Karts have 1.0 m and limousines 3.9 m, trucks and
/// buses up to 8 m; scale cars are 1:28 to 1:3, as are small robots.
fn limits(class: VehicleClass) -> ([f64; 2], f64) {
    match class {
        VehicleClass::Car => ([0.9, 4.2], 110.0),
        VehicleClass::Truck => ([2.6, 8.0], 40.0),
        VehicleClass::Bus => ([3.2, 8.0], 40.0),
        VehicleClass::Scale => ([0.08, 1.0], 30.0),
    }
}

/// The reason against a wheelbase with its standard error, m, where the data determine it, and a mean speed, m/s.
pub(crate) fn implausible_vehicle(
    class: Option<VehicleClass>,
    wheelbase: Option<[f64; 2]>,
    speed_mps: f64,
) -> Option<(Reason, String)> {
    let fits = |class: VehicleClass| {
        let ([shortest, longest], fastest) = limits(class);
        let is_long = wheelbase.is_none_or(|[l, error]| l + WITHIN * error >= shortest);
        let is_short = wheelbase.is_none_or(|[l, error]| l - WITHIN * error <= longest);
        is_long && is_short && speed_mps <= fastest
    };
    let cause = "check the unit of the speed (km/h in a column of m/s), the steering ratio and the units of the angle and the yaw rate; where they are right, state the class of the vehicle (--vehicle-class, vehicle_class in Python)";
    let fits_one = match class {
        Some(class) => fits(class),
        None => VehicleClass::ALL.into_iter().any(fits),
    };
    if !fits_one {
        let of = class.map_or("any road vehicle".to_owned(), |class| format!("a {}", class.name()));
        let length = match wheelbase {
            Some([l, error]) => {
                format!("a wheelbase of {l:.2} ± {:.2} m and ", WITHIN * error)
            }
            None => String::new(),
        };
        let message = format!("{length}a mean speed of {speed_mps:.1} m/s are not those of {of}");
        let reason = Reason::new(ReasonCode::ImplausibleVehicle, Grade::Fail, message);
        return Some((reason, cause.into()));
    }
    if class.is_none() && speed_mps > DOUBTFUL_MPS {
        let message = format!(
            "the mean speed of {speed_mps:.1} m/s is {:.0} km/h: as km/h it would be {:.1} m/s",
            3.6 * speed_mps,
            speed_mps / 3.6
        );
        let reason = Reason::new(ReasonCode::ImplausibleVehicle, Grade::Warn, message);
        return Some((reason.compared(speed_mps, DOUBTFUL_MPS, "m/s"), cause.into()));
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use VehicleClass::{Bus, Car, Scale, Truck};

    fn grade(class: Option<VehicleClass>, wheelbase: f64, speed_mps: f64) -> Option<Grade> {
        implausible_vehicle(class, Some([wheelbase, 0.05]), speed_mps).map(|(r, _)| r.grade)
    }

    #[test]
    fn vehicles_fit_their_class_and_wrong_units_fit_none() {
        for (class, wheelbase, speed) in [
            (Car, 1.05, 20.0),
            (Car, 2.7, 35.0),
            (Truck, 6.5, 24.0),
            (Bus, 6.0, 20.0),
            (Scale, 0.26, 2.0),
        ] {
            assert_eq!(grade(None, wheelbase, speed), None, "{class:?}");
            assert_eq!(grade(Some(class), wheelbase, speed), None, "{class:?}");
        }
        // km/h taken for m/s, a car of 2.5 m at 15 m/s; and of a truck of 5 m.
        assert_eq!(grade(None, 8.95, 53.0), Some(Grade::Fail));
        assert_eq!(grade(None, 18.0, 72.0), Some(Grade::Fail));
        assert_eq!(grade(Some(Car), 6.5, 24.0), Some(Grade::Fail));
        // A race car is one where it is stated.
        assert_eq!(grade(None, 2.5, 72.0), Some(Grade::Warn));
        assert_eq!(grade(Some(Car), 2.5, 72.0), None);
        // What the data do not determine is no reason.
        assert!(implausible_vehicle(None, Some([9.5, 2.0]), 20.0).is_none());
        assert!(implausible_vehicle(None, None, 20.0).is_none());
    }
}
