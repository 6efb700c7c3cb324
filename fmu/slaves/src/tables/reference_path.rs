//! Variables of `ReferencePath`.

use model_description::DependsOn::Nothing;

super::variables! {
    /// Variables of the path follower. Its outputs are evaluated in a step, from the inputs set
    /// before it, so at a communication point they depend on no input.
    Variable, "ReferencePath", "reference road and guidance along it: pose in, yaw reference and feedforward out";
    X = 0, real "x", Input, Continuous,
        .unit("m").nominal(100.0).description("position of the vehicle");
    Y = 1, real "y", Input, Continuous,
        .unit("m").nominal(100.0).description("position of the vehicle");
    Yaw = 2, real "yaw", Input, Continuous,
        .unit("rad").display_unit("deg").description("yaw of the vehicle, positive to the left");
    Speed = 3, real "speed", Input, Continuous,
        .unit("m/s").display_unit("km/h").min(0.0).nominal(10.0).description("speed of the vehicle");
    YawReference = 10, real "yaw_reference", Output, Continuous,
        .unit("rad").display_unit("deg").depends_on(Nothing).description("yaw to steer for, not wrapped");
    SteeringFeedforward = 11, real "steering_feedforward", Output, Continuous,
        .unit("rad").display_unit("deg").nominal(0.1).depends_on(Nothing).description("steering angle for the curvature");
    CrossTrackError = 12, real "cross_track_error", Output, Continuous,
        .unit("m").depends_on(Nothing).description("distance from the path, positive to its left");
    HeadingError = 13, real "heading_error", Output, Continuous,
        .unit("rad").display_unit("deg").depends_on(Nothing).description("yaw minus the path's heading, in (-pi, pi]");
    Curvature = 14, real "curvature", Output, Continuous,
        .unit("1/m").nominal(0.01).depends_on(Nothing).description("curvature of the path at the vehicle, positive to the left");
    Distance = 15, real "distance", Output, Continuous,
        .unit("m").nominal(100.0).depends_on(Nothing).description("distance along the path");
    Finished = 16, boolean "finished", Output, Discrete,
        .depends_on(Nothing).description("whether the path's end is reached");
    LookaheadTime = 20, real "lookahead_time", Parameter, Tunable,
        .unit("s").min(0.0).description("look-ahead distance over speed");
    LookaheadMin = 21, real "lookahead_min", Parameter, Tunable,
        .unit("m").min(0.01).nominal(10.0).description("least look-ahead distance");
    PreviewTime = 22, real "preview_time", Parameter, Tunable,
        .unit("s").min(0.0).description("how far ahead heading and curvature are read");
    FeedforwardGain = 23, real "feedforward_gain", Parameter, Tunable,
        .unit("rad.m").display_unit("deg.m").nominal(10.0).description("steering angle per curvature");
    SideslipPerYawRate = 24, real "sideslip_per_yaw_rate", Parameter, Tunable,
        .unit("s").nominal(0.1).description("sideslip angle per yaw rate in a steady turn");
    CrossTrackIntegralGain = 25, real "cross_track_integral_gain", Parameter, Tunable,
        .unit("1/s").min(0.0).nominal(0.1).description("how fast the integral of the cross-track error grows; 0: there is none");
    SideslipPerYawAcceleration = 26, real "sideslip_per_yaw_acceleration", Parameter, Tunable,
        .unit("s2").nominal(0.01).description("sideslip angle per yaw acceleration; 0: not known");
    SideslipGrowth = 27, real "sideslip_growth", Parameter, Tunable,
        .unit("s5/m2").nominal(0.001).description("what the sideslip per yaw rate grows by, per squared lateral acceleration");
    YawAccelerationGain = 28, real "yaw_acceleration_gain", Parameter, Tunable,
        .unit("s2").nominal(0.01).description("what of the path's yaw acceleration is added to the yaw reference");
    YawJerkGain = 29, real "yaw_jerk_gain", Parameter, Tunable,
        .unit("s3").nominal(0.001).description("what of the path's yaw jerk is added to the yaw reference");
    SideslipReferenceSpeed = 30, real "sideslip_reference_speed", Parameter, Tunable,
        .unit("m/s").display_unit("km/h").min(0.0).nominal(10.0).description("speed at which the sideslip parameters hold");
    DistanceRear = 31, real "distance_rear", Parameter, Tunable,
        .unit("m").min(0.0).description("distance from centre of gravity to rear axle, by which the sideslip follows the speed; 0: not known, the sideslip parameters hold at all speeds");
}
