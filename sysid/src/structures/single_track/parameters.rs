//! The parameters, their prior distributions and their bounds.
//!
//! Forces are per mass and stiffnesses per axle load: neither yaw rate nor lateral acceleration depends
//! on the mass. The estimator works in coordinates: the logarithm of a parameter that is positive by
//! nature, and the parameter itself elsewhere.

use crate::linalg::dual::Scalar;
use steerwright_formats::Prior;

/// Number of parameters.
pub(super) const COUNT: usize = 20;

/// How a parameter's coordinate is made of its value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// The value.
    Linear,
    /// The natural logarithm of the value.
    Logarithmic,
}

macro_rules! parameters {
    ($($(#[$doc:meta])* $name:ident $text:literal $unit:literal $scale:ident
        $mean:literal $deviation:literal $min:literal $max:literal,)*) => {
        /// A parameter of the single-track model.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
        #[repr(usize)]
        pub enum Parameter {
            $($(#[$doc])* $name,)*
        }

        impl Parameter {
            /// All, in the order of the covariance.
            pub const ALL: [Self; COUNT] = [$(Self::$name,)*];

            /// The name in results.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self { $(Self::$name => $text,)* }
            }

            /// The unit of the value.
            #[must_use]
            pub fn unit(self) -> &'static str {
                match self { $(Self::$name => $unit,)* }
            }

            /// The scale of the coordinate.
            #[must_use]
            pub fn scale(self) -> Scale {
                match self { $(Self::$name => Scale::$scale,)* }
            }

            /// The prior where none is stated: wide enough for road and race cars.
            #[must_use]
            pub fn default_prior(self) -> Prior {
                match self {
                    $(Self::$name => Prior {
                        mean: $mean, standard_deviation: $deviation, min: $min, max: $max,
                    },)*
                }
            }
        }
    };
}

parameters! {
    /// Cornering stiffness of the front axle over its static load.
    StiffnessFront "cornering_stiffness_front_per_load" "1/rad" Logarithmic 13.0 0.5 2.0 80.0,
    /// Cornering stiffness of the rear axle over its static load.
    StiffnessRear "cornering_stiffness_rear_per_load" "1/rad" Logarithmic 15.0 0.5 2.0 80.0,
    /// Peak lateral force of the front axle over its load.
    FrictionFront "friction_coefficient_front" "1" Logarithmic 1.0 0.3 0.1 3.0,
    /// Peak lateral force over load, rear over front: a vehicle that understeers at the limit has
    /// more than 1.
    FrictionBalance "friction_balance_rear" "1" Logarithmic 1.15 0.08 0.9 1.6,
    /// C of the magic formula.
    ShapeFactor "tyre_shape_factor" "1" Linear 1.35 0.1 1.05 1.9,
    /// E of the magic formula.
    CurvatureFactor "tyre_curvature_factor" "1" Linear 0.0 0.3 -1.5 0.95,
    /// Distance between the axles L.
    Wheelbase "wheelbase" "m" Logarithmic 2.6 0.3 0.05 20.0,
    /// Road-wheel angle over the steering angle divided by the stated steering ratio.
    SteeringFactor "steering_factor" "1" Logarithmic 1.0 0.3 0.2 5.0,
    /// Yaw inertia over m·L_f·L_r.
    DynamicIndex "dynamic_index" "1" Logarithmic 1.0 0.15 0.3 3.0,
    /// Share of the front axle in the weight, L_r/L.
    FrontShare "front_share" "1" Linear 0.5 0.05 0.2 0.8,
    /// Height of the centre of gravity over the wheelbase: the load that braking and driving move.
    HeightRatio "centre_of_gravity_height_over_wheelbase" "1" Linear 0.18 0.06 0.0 0.6,
    /// Share of the front axle in the force that drives the vehicle: 0 of rear-wheel drive.
    DriveShare "drive_share_front" "1" Linear 0.5 0.35 0.0 1.0,
    /// Share of the front axle in the force that brakes the vehicle, engine included.
    BrakeShare "brake_share_front" "1" Linear 0.65 0.1 0.3 1.0,
    /// Time constant of the steering actuator.
    Lag "actuator_time_constant" "s" Logarithmic 0.02 1.0 0.0005 1.0,
    /// Delay before the actuator.
    Delay "actuator_delay" "s" Linear 0.0 0.03 0.0 0.5,
    /// Road-wheel angle at which the vehicle drives straight, at an angle of zero in the log, negated.
    SteeringOffset "steering_offset" "rad" Linear 0.0 0.01 -0.2 0.2,
    /// Yaw rate in the log at rest.
    YawRateOffset "yaw_rate_offset" "rad/s" Linear 0.0 0.005 -0.1 0.1,
    /// Lateral acceleration in the log at rest on a level road.
    LateralAccelerationOffset "lateral_acceleration_offset" "m/s2" Linear 0.0 0.2 -3.0 3.0,
    /// How far the accelerometer is ahead of the centre of gravity.
    AccelerometerPosition "accelerometer_position" "m" Linear 0.0 0.2 -3.0 3.0,
    /// Largest rate of the road wheels, which is beyond that of any drive unless the drive shows one.
    RateMax "actuator_rate_max" "rad/s" Logarithmic 10.0 0.0 0.01 10.0,
}

impl Parameter {
    /// Its place in [`Parameter::ALL`].
    #[must_use]
    pub fn index(self) -> usize {
        self as usize
    }

    /// The coordinate of a value.
    #[must_use]
    pub(super) fn coordinate(self, value: f64) -> f64 {
        match self.scale() {
            Scale::Linear => value,
            Scale::Logarithmic => value.max(f64::MIN_POSITIVE).ln(),
        }
    }

    /// The value of a coordinate.
    pub(super) fn value<S: Scalar>(self, coordinate: S) -> S {
        match self.scale() {
            Scale::Linear => coordinate,
            Scale::Logarithmic => coordinate.exp(),
        }
    }
}

/// Values in the units of [`Parameter::unit`], of all parameters.
pub(super) fn values<S: Scalar>(coordinates: &[S; COUNT]) -> [S; COUNT] {
    std::array::from_fn(|i| Parameter::ALL[i].value(coordinates[i]))
}
