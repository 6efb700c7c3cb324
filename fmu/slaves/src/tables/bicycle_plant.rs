//! Variables of `BicyclePlant`.

use model_description::DependsOn::{Nothing, On};

super::variables! {
    /// Variables of the bicycle plant. The states, which start where they are set to, are listed by
    /// the layer, and so are the dependencies on them.
    Variable, "BicyclePlant", "two-wheel bicycle model: steering angle and speed in, yaw rate and pose out";
    SteeringAngle = 0, real "steering_angle", Input, Continuous,
        .unit("rad").display_unit("deg").nominal(0.1).description("steering angle, positive to the left");
    Speed = 1, real "speed", Input, Continuous,
        .unit("m/s").display_unit("km/h").min(0.0).nominal(10.0).description("longitudinal velocity");
    YawRate = 10, real "yaw_rate", Output, Continuous,
        .unit("rad/s").display_unit("deg/s").nominal(0.1).depends_on(Nothing).initial_depends_on(Nothing)
        .description("yaw rate, positive to the left");
    Yaw = 11, real "yaw", Output, Continuous,
        .unit("rad").display_unit("deg").depends_on(Nothing).initial_depends_on(On(&["initial_yaw"]))
        .description("yaw, not wrapped");
    X = 12, real "x", Output, Continuous,
        .unit("m").nominal(100.0).depends_on(Nothing).initial_depends_on(On(&["initial_x"])).description("position of the centre of gravity");
    Y = 13, real "y", Output, Continuous,
        .unit("m").nominal(100.0).depends_on(Nothing).initial_depends_on(On(&["initial_y"])).description("position of the centre of gravity");
    LateralVelocity = 14, real "lateral_velocity", Output, Continuous,
        .unit("m/s").nominal(0.1).depends_on(Nothing).initial_depends_on(Nothing)
        .description("velocity to the left of the centre of gravity");
    LateralAcceleration = 15, real "lateral_acceleration", Output, Continuous,
        .unit("m/s2").depends_on(On(&["speed"]))
        .initial_depends_on(On(&["speed", "mass", "distance_front", "distance_rear",
            "cornering_stiffness_front", "cornering_stiffness_rear"]))
        .description("acceleration to the left of the centre of gravity");
    Mass = 20, real "mass", Parameter, Fixed,
        .unit("kg").min(1.0).nominal(1000.0).description("mass m");
    YawInertia = 21, real "yaw_inertia", Parameter, Fixed,
        .unit("kg.m2").min(0.1).nominal(1000.0).description("yaw inertia J");
    DistanceFront = 22, real "distance_front", Parameter, Fixed,
        .unit("m").min(0.01).description("centre of gravity to front axle L_f");
    DistanceRear = 23, real "distance_rear", Parameter, Fixed,
        .unit("m").min(0.01).description("centre of gravity to rear axle L_r");
    CorneringStiffnessFront = 24, real "cornering_stiffness_front", Parameter, Fixed,
        .unit("N/rad").display_unit("N/deg").min(1.0).nominal(1e5).description("cornering stiffness of the front axle C_f");
    CorneringStiffnessRear = 25, real "cornering_stiffness_rear", Parameter, Fixed,
        .unit("N/rad").display_unit("N/deg").min(1.0).nominal(1e5).description("cornering stiffness of the rear axle C_r");
    ActuatorTimeConstant = 26, real "actuator_time_constant", Parameter, Fixed,
        .unit("s").min(1e-4).nominal(0.1).description("time constant of the steering actuator T_n");
    SteeringRatio = 27, real "steering_ratio", Parameter, Fixed,
        .unit("1").min(1e-3).nominal(10.0).description("steering angle over road-wheel angle, 1/n");
    ActuatorDelay = 28, real "actuator_delay", Parameter, Fixed,
        .unit("s").display_unit("ms").min(0.0).max(10.0).description("delay before the steering actuator");
    InitialX = 30, real "initial_x", Parameter, Fixed,
        .unit("m").nominal(100.0).description("position at the start");
    InitialY = 31, real "initial_y", Parameter, Fixed,
        .unit("m").nominal(100.0).description("position at the start");
    InitialYaw = 32, real "initial_yaw", Parameter, Fixed,
        .unit("rad").display_unit("deg").description("yaw at the start");
}
