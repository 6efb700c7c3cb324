//! Variables of `LateralPid`.

use model_description::DependsOn::Nothing;

super::variables! {
    /// Variables of the steering controller. Its outputs are held between ticks, so at a
    /// communication point they depend on no input.
    Variable, "LateralPid", "PID steering controller: yaw reference and yaw in, steering angle out";
    YawReference = 0, real "yaw_reference", Input, Continuous,
        .unit("rad").display_unit("deg").description("yaw to reach, positive to the left, not wrapped");
    Yaw = 1, real "yaw", Input, Continuous,
        .unit("rad").display_unit("deg").description("yaw of the vehicle, positive to the left");
    SteeringFeedforward = 2, real "steering_feedforward", Input, Continuous,
        .unit("rad").display_unit("deg").nominal(0.1).description("steering angle added to the controller's own");
    Enabled = 3, boolean "enabled", Input, Discrete,
        .description("whether the controller acts; otherwise the limited feedforward is put out");
    Speed = 4, real "speed", Input, Continuous,
        .unit("m/s").min(0.0).nominal(10.0).description("speed that the limits follow; unconnected, that of the design");
    SteeringAngle = 10, real "steering_angle", Output, Discrete,
        .unit("rad").display_unit("deg").nominal(0.1).depends_on(Nothing)
        .description("steering angle to command, in steering coordinates");
    Saturated = 11, boolean "saturated", Output, Discrete,
        .depends_on(Nothing).description("whether a limit acted at the last tick");
    Kp = 20, real "kp", Parameter, Tunable,
        .unit("1").min(0.0).description("proportional gain, steering angle per yaw error");
    Ki = 21, real "ki", Parameter, Tunable,
        .unit("1/s").min(0.0).description("integral gain");
    Kd = 22, real "kd", Parameter, Tunable,
        .unit("s").min(0.0).description("derivative gain");
    DerivativeFilterTime = 23, real "derivative_filter_time", Parameter, Tunable,
        .unit("s").min(0.0).nominal(0.01).description("time constant of the derivative's filter");
    SetpointWeightProportional = 24, real "setpoint_weight_proportional", Parameter, Tunable,
        .unit("1").description("weight of the reference in the proportional action");
    SetpointWeightDerivative = 25, real "setpoint_weight_derivative", Parameter, Tunable,
        .unit("1").description("weight of the reference in the derivative action");
    AntiWindupTime = 26, real "anti_windup_time", Parameter, Tunable,
        .unit("s").min(0.0).description("time constant of the anti-windup back-calculation");
    MaxAngle = 27, real "max_angle", Parameter, Tunable,
        .unit("rad").display_unit("deg").min(0.0).description("largest steering angle to either side");
    MaxIncrement = 28, real "max_increment", Parameter, Tunable,
        .unit("rad").display_unit("deg").min(0.0).nominal(0.1).description("largest change of the steering angle in a tick");
    MaxRate = 29, real "max_rate", Parameter, Tunable,
        .unit("rad/s").display_unit("deg/s").min(0.0).nominal(10.0).description("largest rate of the steering angle");
    SampleTime = 30, real "sample_time", Parameter, Fixed,
        .unit("s").min(1e-6).nominal(0.01).description("time between ticks");
    MaxYawError = 31, real "max_yaw_error", Parameter, Tunable,
        .unit("rad").display_unit("deg").min(0.0).description("largest yaw error acted on at once, beyond the lag behind a ramp; pi for any");
    MaxLateralAcceleration = 32, real "max_lateral_acceleration", Parameter, Tunable,
        .unit("m/s2").min(0.0).nominal(10.0).description("lateral acceleration that the steering angle may cause in a steady turn");
    SteeringPerCurvature = 33, real "steering_per_curvature", Parameter, Tunable,
        .unit("rad.m").min(0.0).description("steering angle per curvature in a slow turn, for that bound");
    UndersteerGradient = 34, real "understeer_gradient", Parameter, Tunable,
        .unit("rad.s2/m").min(0.0).nominal(0.01).description("steering angle per lateral acceleration beyond that, for that bound");
    SustainedRate = 35, real "sustained_rate", Parameter, Tunable,
        .unit("rad/s").display_unit("deg/s").min(0.0).nominal(10.0).description("rate of the steering angle with the slowest actuator looked for");
    RateReserveTime = 36, real "rate_reserve_time", Parameter, Tunable,
        .unit("s").min(0.0).nominal(0.1).description("reserve of time at the largest rate, after which the anti-windup is quicker");
    YawRateLag = 37, real "yaw_rate_lag", Parameter, Tunable,
        .unit("s").min(0.0).nominal(0.1).description("lag of the yaw rate behind the steering angle sent, by which a slow actuator is noticed; 0 for not");
}
