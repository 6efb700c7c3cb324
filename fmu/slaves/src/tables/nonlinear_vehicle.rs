//! Variables of `NonlinearVehicle`.

use model_description::DependsOn::{Nothing, On};

/// Dependencies of the lateral acceleration at the start, besides the states.
#[rustfmt::skip]
pub(crate) const FORCES: &[&str] = &[
    "speed", "mass", "distance_front", "distance_rear", "cornering_stiffness_front", "cornering_stiffness_rear",
    "friction_coefficient", "tyre_shape_factor", "tyre_curvature_factor", "friction_load_sensitivity",
    "stiffness_load_sensitivity", "centre_of_gravity_height", "track_width", "roll_stiffness_front",
];

super::variables! {
    /// Variables of the nonlinear vehicle.
    Variable, "NonlinearVehicle", "vehicle with saturating tyres, load transfer and a steering actuator: steering angle and speed in, yaw rate and pose out";
    SteeringAngle = 0, real "steering_angle", Input, Continuous,
        .unit("rad").display_unit("deg").description("steering angle, positive to the left");
    Speed = 1, real "speed", Input, Continuous,
        .unit("m/s").display_unit("km/h").min(0.0).description("longitudinal velocity");
    YawRate = 10, real "yaw_rate", Output, Continuous,
        .unit("rad/s").display_unit("deg/s").depends_on(Nothing).initial_depends_on(Nothing)
        .description("yaw rate, positive to the left");
    Yaw = 11, real "yaw", Output, Continuous,
        .unit("rad").display_unit("deg").depends_on(Nothing).initial_depends_on(On(&["initial_yaw"]))
        .description("yaw, not wrapped");
    X = 12, real "x", Output, Continuous,
        .unit("m").depends_on(Nothing).initial_depends_on(On(&["initial_x"])).description("position of the centre of gravity");
    Y = 13, real "y", Output, Continuous,
        .unit("m").depends_on(Nothing).initial_depends_on(On(&["initial_y"])).description("position of the centre of gravity");
    LateralVelocity = 14, real "lateral_velocity", Output, Continuous,
        .unit("m/s").depends_on(Nothing).initial_depends_on(Nothing)
        .description("velocity to the left of the centre of gravity");
    LateralAcceleration = 15, real "lateral_acceleration", Output, Continuous,
        .unit("m/s2").depends_on(On(&["speed"])).initial_depends_on(On(FORCES))
        .description("acceleration to the left of the centre of gravity");
    Mass = 20, real "mass", Parameter, Fixed,
        .unit("kg").min(1.0).description("mass m");
    YawInertia = 21, real "yaw_inertia", Parameter, Fixed,
        .unit("kg.m2").min(0.1).description("yaw inertia J");
    DistanceFront = 22, real "distance_front", Parameter, Fixed,
        .unit("m").min(0.01).description("centre of gravity to front axle L_f");
    DistanceRear = 23, real "distance_rear", Parameter, Fixed,
        .unit("m").min(0.01).description("centre of gravity to rear axle L_r");
    CorneringStiffnessFront = 24, real "cornering_stiffness_front", Parameter, Fixed,
        .unit("N/rad").min(1.0).description("cornering stiffness of the front axle C_f at the static load");
    CorneringStiffnessRear = 25, real "cornering_stiffness_rear", Parameter, Fixed,
        .unit("N/rad").min(1.0).description("cornering stiffness of the rear axle C_r at the static load");
    ActuatorTimeConstant = 26, real "actuator_time_constant", Parameter, Fixed,
        .unit("s").min(1e-4).max(100.0).description("time constant of the steering actuator T_n");
    SteeringRatio = 27, real "steering_ratio", Parameter, Fixed,
        .unit("1").min(1e-3).description("steering angle over road-wheel angle, 1/n");
    InitialX = 30, real "initial_x", Parameter, Fixed,
        .unit("m").description("position at the start");
    InitialY = 31, real "initial_y", Parameter, Fixed,
        .unit("m").description("position at the start");
    InitialYaw = 32, real "initial_yaw", Parameter, Fixed,
        .unit("rad").display_unit("deg").description("yaw at the start");
    ActuatorDelay = 40, real "actuator_delay", Parameter, Fixed,
        .unit("s").display_unit("ms").min(0.0).max(10.0).description("delay before the steering actuator");
    RoadWheelRateMax = 41, real "road_wheel_rate_max", Parameter, Fixed,
        .unit("rad/s").display_unit("deg/s").min(1e-6).max(1e6).description("largest rate of the road-wheel angle");
    RoadWheelAngleMax = 42, real "road_wheel_angle_max", Parameter, Fixed,
        .unit("rad").display_unit("deg").min(1e-6).max(1.5).description("largest road-wheel angle to either side");
    FrictionCoefficient = 43, real "friction_coefficient", Parameter, Fixed,
        .unit("1").min(0.01).max(10.0).description("peak lateral force over load at the static wheel load mu");
    TyreShapeFactor = 44, real "tyre_shape_factor", Parameter, Fixed,
        .unit("1").min(1.0).max(1.99).description("shape factor C of the magic formula");
    TyreCurvatureFactor = 45, real "tyre_curvature_factor", Parameter, Fixed,
        .unit("1").min(-1.5).max(1.0).description("curvature factor E of the magic formula");
    FrictionLoadSensitivity = 46, real "friction_load_sensitivity", Parameter, Fixed,
        .unit("1").min(0.0).max(0.9).description("relative loss of friction at twice the static wheel load k_mu");
    StiffnessLoadSensitivity = 47, real "stiffness_load_sensitivity", Parameter, Fixed,
        .unit("1").min(0.0).max(0.9).description("relative loss of stiffness over load at twice the static wheel load k_C");
    CentreOfGravityHeight = 48, real "centre_of_gravity_height", Parameter, Fixed,
        .unit("m").min(0.0).max(10.0).description("height of the centre of gravity h");
    TrackWidth = 49, real "track_width", Parameter, Fixed,
        .unit("m").min(0.01).max(100.0).description("left to right wheel");
    RollStiffnessFront = 50, real "roll_stiffness_front", Parameter, Fixed,
        .unit("1").display_unit("%").min(0.0).max(1.0).description("share of the front axle in the roll stiffness");
    RollTimeConstant = 51, real "roll_time_constant", Parameter, Fixed,
        .unit("s").min(1e-3).max(100.0).description("time constant of the load transfer T_phi");
}
