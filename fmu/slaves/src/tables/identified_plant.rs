//! Variables of `IdentifiedPlant`.

use model_description::DependsOn::{Nothing, On};

super::variables! {
    /// Variables of the identified plant. Without feedthrough no output depends on an input at a
    /// communication point; where a model has one, `Slave::dependency` returns it. The states are
    /// listed by the layer.
    Variable, "IdentifiedPlant", "lateral dynamics identified from a drive: steering angle in, yaw rate and pose out";
    SteeringAngle = 0, real "steering_angle", Input, Continuous,
        .unit("rad").display_unit("deg").nominal(0.1).description("steering angle, positive to the left, in the log's coordinates");
    Speed = 1, real "speed", Input, Continuous,
        .unit("m/s").display_unit("km/h").min(0.0).nominal(10.0).description("speed of the vehicle");
    YawRate = 10, real "yaw_rate", Output, Continuous,
        .unit("rad/s").display_unit("deg/s").nominal(0.1).depends_on(Nothing)
        .initial_depends_on(On(&["noise_scale", "noise_seed"])).description("yaw rate, positive to the left");
    Yaw = 11, real "yaw", Output, Continuous,
        .unit("rad").display_unit("deg").depends_on(Nothing).initial_depends_on(On(&["initial_yaw"]))
        .description("yaw, the integral of the yaw rate, not wrapped");
    X = 12, real "x", Output, Continuous,
        .unit("m").nominal(100.0).depends_on(Nothing).initial_depends_on(On(&["initial_x"])).description("position");
    Y = 13, real "y", Output, Continuous,
        .unit("m").nominal(100.0).depends_on(Nothing).initial_depends_on(On(&["initial_y"])).description("position");
    InitialX = 20, real "initial_x", Parameter, Fixed,
        .unit("m").nominal(100.0).description("position at the start");
    InitialY = 21, real "initial_y", Parameter, Fixed,
        .unit("m").nominal(100.0).description("position at the start");
    InitialYaw = 22, real "initial_yaw", Parameter, Fixed,
        .unit("rad").display_unit("deg").description("yaw at the start");
    NoiseScale = 23, real "noise_scale", Parameter, Fixed,
        .unit("1").min(0.0).description("noise relative to the identified: 0 deterministic, 1 as identified");
    NoiseSeed = 24, integer "noise_seed", Parameter, Fixed,
        .description("names the noise sequence");
}
