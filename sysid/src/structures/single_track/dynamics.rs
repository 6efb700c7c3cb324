//! The equations of [`crate::structures::single_track`], per mass, for plain and for dual numbers.

use crate::linalg::dual::Scalar;
use crate::structures::single_track::parameters::{COUNT, Parameter, values};

/// Acceleration of free fall, m/s², as in the FMU.
pub(super) const GRAVITY: f64 = 9.81;
/// Below this speed the slip angles are those of this speed, m/s.
pub(super) const LEAST_SPEED: f64 = 1.0;

/// Time constant with which the load follows the acceleration, s.
pub(super) const ROLL_TIME_CONSTANT_S: f64 = 0.12;
/// Most of its static load that an axle gains or loses by braking and driving, of both the more, as in the FMU.
const MOST_TRANSFER: f64 = 0.8;
/// Most of the square of an axle's friction that driving and braking use, as in the FMU.
const MOST_USED: f64 = 0.9;

/// What is known at an instant.
#[derive(Debug, Clone, Copy)]
pub(super) struct DriveMotion {
    /// Speed, m/s.
    pub(super) speed: f64,
    /// Longitudinal acceleration that the load has followed, m/s².
    pub(super) acceleration: f64,
}

/// What follows from the parameters before a simulation.
#[derive(Debug, Clone, Copy)]
pub(super) struct Constants<S> {
    /// L_f and L_r, m.
    pub(super) distance: [S; 2],
    /// Yaw acceleration per lateral force over mass and lever, 1/m²: m/J.
    inverse_inertia: S,
    axle: [Axle<S>; 2],
    /// Of the axles, the load that moves to them per longitudinal acceleration, over the static one, s²/m.
    transfer: [S; 2],
    /// Of driving and of braking, the shares of the axles in the force.
    shares: [[S; 2]; 2],
    /// Acceleration beyond which no more load moves along, m/s².
    most_acceleration: f64,
    /// Rear slip angle over lateral acceleration in a gentle turn, rad·s²/m
    pub(super) rear_slip_per_acceleration: S,
    /// Rate of the faster of v_y and r in a gentle turn, times the speed, m/s².
    pub(super) rate_by_speed: f64,
    pub(super) lag_rate: S,
    /// Of the road wheels, rad/s.
    pub(super) rate_max: S,
    pub(super) delay: S,
    pub(super) steering_factor: S,
    pub(super) steering_offset: S,
    pub(super) yaw_rate_offset: S,
    pub(super) lateral_acceleration_offset: S,
    pub(super) accelerometer_position: S,
}

/// An axle's tyres by the magic formula.
#[derive(Debug, Clone, Copy)]
struct Axle<S> {
    /// D over the vehicle's mass, m/s².
    peak: S,
    /// B, 1/rad.
    stiffness: S,
    /// C.
    shape: S,
    /// E.
    curvature: S,
}

/// Lateral and yaw acceleration of the axle forces.
#[derive(Debug, Clone, Copy)]
pub(super) struct Forces<S> {
    /// (F_f·cos δ + F_r)/m, m/s².
    pub(super) lateral: S,
    /// ṙ, rad/s².
    pub(super) yaw: S,
}

impl<S: Scalar> Constants<S> {
    pub(super) fn new(coordinates: &[S; COUNT]) -> Self {
        let p = values(coordinates);
        let of = |parameter: Parameter| p[parameter.index()];
        let (wheelbase, share) = (of(Parameter::Wheelbase), of(Parameter::FrontShare));
        let rear_share = (-share).plus(1.0);
        let (a, b) = (wheelbase * rear_share, wheelbase * share);
        let inverse_inertia = (of(Parameter::DynamicIndex) * a * b).inverse();
        let shape = of(Parameter::ShapeFactor);
        let axle = |share: S, stiffness: S, friction: S| Axle {
            peak: friction * share.times(GRAVITY),
            stiffness: stiffness / (shape * friction),
            shape,
            curvature: of(Parameter::CurvatureFactor),
        };
        let [front, rear] = [of(Parameter::StiffnessFront), of(Parameter::StiffnessRear)];
        let friction = of(Parameter::FrictionFront);
        let height = of(Parameter::HeightRatio);
        let transfer = [-(height / share.times(GRAVITY)), height / rear_share.times(GRAVITY)];
        let most = transfer[0].value().abs().max(transfer[1].value());
        let of_force = [front * share, rear * rear_share].map(|c| c.times(GRAVITY));
        let yaw = (a * a * of_force[0] + b * b * of_force[1]) * inverse_inertia;
        Self {
            distance: [a, b],
            inverse_inertia,
            axle: [
                axle(share, front, friction),
                axle(rear_share, rear, friction * of(Parameter::FrictionBalance)),
            ],
            transfer,
            shares: [of(Parameter::DriveShare), of(Parameter::BrakeShare)]
                .map(|f| [f, (-f).plus(1.0)]),
            most_acceleration: MOST_TRANSFER / most.max(f64::MIN_POSITIVE),
            rear_slip_per_acceleration: rear.times(GRAVITY).inverse(),
            rate_by_speed: (of_force[0] + of_force[1]).value().max(yaw.value()),
            lag_rate: of(Parameter::Lag).inverse(),
            rate_max: of(Parameter::RateMax),
            delay: of(Parameter::Delay),
            steering_factor: of(Parameter::SteeringFactor),
            steering_offset: of(Parameter::SteeringOffset),
            yaw_rate_offset: of(Parameter::YawRateOffset),
            lateral_acceleration_offset: of(Parameter::LateralAccelerationOffset),
            accelerometer_position: of(Parameter::AccelerometerPosition),
        }
    }

    /// Of the slip angles `δ − atan((v_y + L_f·r)/v)` and `−atan((v_y − L_r·r)/v)`; below 1 m/s of those of 1 m/s
    /// with `v·δ` for δ, so that a vehicle at rest does not turn.
    #[inline(always)]
    pub(super) fn forces(&self, vy: S, r: S, steering: S, known: DriveMotion) -> Forces<S> {
        let DriveMotion { speed, acceleration } = known;
        let v = speed.max(LEAST_SPEED);
        let [a, b] = self.distance;
        let front = (vy + a * r).times(1.0 / v).atan();
        let rear = (vy - b * r).times(1.0 / v).atan();
        let acceleration = acceleration.clamp(-self.most_acceleration, self.most_acceleration);
        let [load_front, load_rear] = self.transfer.map(|t| t.times(acceleration).plus(1.0));
        let along = self.shares[usize::from(acceleration < 0.0)].map(|s| s.times(acceleration));
        let angle = steering.times(speed / v);
        let front = self.axle[0].force(angle - front, load_front, along[0]);
        let front = front * steering.cos();
        let rear = self.axle[1].force(-rear, load_rear, along[1]);
        Forces { lateral: front + rear, yaw: (a * front - b * rear) * self.inverse_inertia }
    }
}

impl<S: Scalar> Axle<S> {
    /// Lateral force over the vehicle's mass, m/s², at a slip angle (rad), a load over the static one, and a force along the
    /// wheels over the mass, by the friction ellipse.
    #[inline(always)]
    fn force(&self, slip: S, load: S, along: S) -> S {
        let angle = self.stiffness * slip;
        let bent = angle - self.curvature * (angle - angle.atan());
        let peak = self.peak * load;
        let used = along / peak;
        let used = used * used;
        let left = if used.value() < MOST_USED {
            (-used).plus(1.0).sqrt()
        } else {
            S::constant((1.0 - MOST_USED).sqrt())
        };
        peak * left * (self.shape * bent.atan()).sin()
    }
}
