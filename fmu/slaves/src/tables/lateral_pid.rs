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
}
