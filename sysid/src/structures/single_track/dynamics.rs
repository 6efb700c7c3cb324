//! The equations of [`crate::structures::single_track`], per mass, for plain and for dual numbers.

use crate::linalg::dual::Scalar;
use crate::structures::single_track::parameters::{COUNT, Parameter, values};

/// Acceleration of free fall, m/s², as in the FMU.
pub(super) const GRAVITY: f64 = 9.81;
/// Below this speed the slip angles are those of this speed, m/s.
pub(super) const LEAST_SPEED: f64 = 1.0;
/// The load beyond which the sensitivities do not grow, relative to the static one and less one.
const MOST_LOAD: f64 = 1.0;
/// Width of the smooth end of the friction ellipse.
const ELLIPSE_SMOOTHING: f64 = 0.02;

/// What follows from the parameters before a simulation.
#[derive(Debug, Clone, Copy)]
pub(super) struct Constants<S> {
    /// L_f and L_r, m.
    pub(super) distance: [S; 2],
    /// Yaw acceleration per lateral force over mass and lever, 1/m²: m/J.
    inverse_inertia: S,
    /// Static loads over mass, m/s².
    load: [S; 2],
    /// h/L.
    height: S,
    lift: [S; 2],
    drag: S,
    brake: S,
    drive: S,
    axle: [Axle<S>; 2],
    /// Rear slip angle over lateral acceleration in a gentle turn, rad·s²/m.
    pub(super) rear_slip_per_acceleration: S,
    /// 1/σ of the axles, 1/m.
    pub(super) relaxation: [S; 2],
    pub(super) lag_rate: S,
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
    /// Static load over mass, m/s².
    load: S,
    friction_sensitivity: S,
    stiffness_sensitivity: S,
    friction: S,
    shape: S,
    curvature: S,
    /// Stiffness over load, divided by C, 1/rad.
    stiffness: S,
}

/// What is known at an instant.
#[derive(Debug, Clone, Copy)]
pub(super) struct Known {
    /// Speed, m/s.
    pub(super) speed: f64,
    /// Longitudinal acceleration, m/s²: that of an accelerometer, or v̇.
    pub(super) acceleration: f64,
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
        let front = wheelbase * (-share).plus(1.0);
        let rear = wheelbase * share;
        let shape = of(Parameter::ShapeFactor);
        let load = [share.times(GRAVITY), (-share).plus(1.0).times(GRAVITY)];
        let axle = |load: S, stiffness: S, friction: S| Axle {
            load,
            friction_sensitivity: of(Parameter::FrictionLoadSensitivity),
            stiffness_sensitivity: of(Parameter::StiffnessLoadSensitivity),
            friction,
            shape,
            curvature: of(Parameter::CurvatureFactor),
            stiffness: stiffness / shape,
        };
        let friction = of(Parameter::FrictionFront);
        Self {
            distance: [front, rear],
            inverse_inertia: (of(Parameter::DynamicIndex) * front * rear).inverse(),
            load,
            height: of(Parameter::HeightRatio),
            lift: [of(Parameter::LiftFront), of(Parameter::LiftRear)],
            drag: of(Parameter::Drag),
            brake: of(Parameter::BrakeShare),
            drive: of(Parameter::DriveShare),
            axle: [
                axle(load[0], of(Parameter::StiffnessFront), friction),
                axle(
                    load[1],
                    of(Parameter::StiffnessRear),
                    friction * of(Parameter::FrictionBalance),
                ),
            ],
            rear_slip_per_acceleration: of(Parameter::StiffnessRear).times(GRAVITY).inverse(),
            relaxation: [
                of(Parameter::RelaxationFront).inverse(),
                of(Parameter::RelaxationRear).inverse(),
            ],
            lag_rate: of(Parameter::Lag).inverse(),
            delay: of(Parameter::Delay),
            steering_factor: of(Parameter::SteeringFactor),
            steering_offset: of(Parameter::SteeringOffset),
            yaw_rate_offset: of(Parameter::YawRateOffset),
            lateral_acceleration_offset: of(Parameter::LateralAccelerationOffset),
            accelerometer_position: of(Parameter::AccelerometerPosition),
        }
    }

    /// The slip angles of the axles, rad, which the tyres approach over the relaxation length:
    /// `δ − atan((v_y + L_f·r)/v)` and `−atan((v_y − L_r·r)/v)`; below 1 m/s those of 1 m/s with
    /// `v·δ` for δ, so that a vehicle at rest does not turn.
    #[inline]
    pub(super) fn slip(&self, vy: S, r: S, steering: S, speed: f64) -> [S; 2] {
        let v = speed.max(LEAST_SPEED);
        let [a, b] = self.distance;
        let front = (vy + a * r).times(1.0 / v).atan();
        let rear = (vy - b * r).times(1.0 / v).atan();
        [steering.times(speed / v) - front, -rear]
    }

    /// Of the relaxed slip angles, rad.
    #[inline]
    pub(super) fn forces(
        &self,
        slip: [S; 2],
        steering_cos: S,
        tyre_acceleration: S,
        speed: f64,
    ) -> Forces<S> {
        let square = speed * speed;
        // The longitudinal force of all tyres, per mass.
        let pull = tyre_acceleration + self.drag.times(square);
        let share = if pull.value() > 0.0 { self.drive } else { self.brake };
        let moved = self.height * tyre_acceleration;
        let load = [
            self.load[0] - moved - self.lift[0].times(square),
            self.load[1] + moved - self.lift[1].times(square),
        ];
        let front = self.axle[0].force(slip[0], load[0], share * pull) * steering_cos;
        let rear = self.axle[1].force(slip[1], load[1], (-share).plus(1.0) * pull);
        let [a, b] = self.distance;
        Forces { lateral: front + rear, yaw: (a * front - b * rear) * self.inverse_inertia }
    }
}

impl<S: Scalar> Axle<S> {
    /// Lateral force over the vehicle's mass, m/s², at a slip angle (rad), a load and a longitudinal
    /// force, both over the vehicle's mass. The longitudinal force takes from the peak by the friction
    /// ellipse, and leaves the stiffness.
    #[inline]
    fn force(&self, slip: S, load: S, longitudinal: S) -> S {
        // A lifted axle keeps a remainder, so that the equations stay defined.
        let load = if load.value() < 0.5 { S::constant(0.5) } else { load };
        let more = (load / self.load).plus(-1.0);
        let more = if more.value() > MOST_LOAD { S::constant(MOST_LOAD) } else { more };
        let peak = self.friction * load * (-(self.friction_sensitivity * more)).plus(1.0);
        let stiffness = self.stiffness * load * (-(self.stiffness_sensitivity * more)).plus(1.0);
        let used = longitudinal / peak;
        let left = (-(used * used)).plus(1.0);
        // Smoothly positive: a wheel that locks keeps a tenth of the peak.
        let left = (left + (left * left).plus(ELLIPSE_SMOOTHING).sqrt()).times(0.5).sqrt();
        let reduced = peak * left;
        let angle = stiffness / reduced * slip;
        let bent = angle - self.curvature * (angle - angle.atan());
        reduced * (self.shape * bent.atan()).sin()
    }
}
