"""The options of each function. Generated from those of the command line by `cargo xtask wheel --update`.

Numbers are in SI units and radians, shares are fractions; texts are as on the command line, such as `"22deg"`.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping, Sequence
from types import ModuleType
from typing import Any, Literal, TypedDict, Union


class _Callable(ModuleType):
    """This module, which stands in the package where its function `options` was."""

    def __call__(self, command: str) -> None:
        from .commands import options

        options(command)


sys.modules[__name__].__class__ = _Callable

Stack = Literal["autoware", "openpilot", "ardupilot", "px4"]
"""A driving stack that `export` writes the parameters of."""
Quantity = Union[float, str]
"""A number in SI units, or a text with its unit."""
File = Union[str, "os.PathLike[str]"]


class ReadOptions(TypedDict, total=False):
    """The options of `read`."""

    response: Literal["yaw-rate", "lateral-acceleration", "speed", "motion", "channels"]
    """What responds: the yaw rate to the steering angle; for the structure single-track also
    accelerations and sideslip (motion); for the structure torque, the lateral acceleration to a steering
    torque or its normalised command; or, for the structure longitudinal, the speed to accelerator and
    brake or to an acceleration command (default yaw-rate)."""
    time_channel: str
    """Column of the time in every file; by default the first one with such a name."""
    unit: Union[Mapping[str, Any], Sequence[str], str]
    """Unit of a channel whose name does not state it, such as steer=deg; may be repeated."""
    topic: Union[str, Sequence[str]]
    """Topic, message or channel group to use; may be repeated. By default all."""
    dbc: Union[File, Sequence[File]]
    """CAN database that decodes a raw bus; may be repeated."""
    ros_definitions: Union[File, Sequence[File]]
    """Folder with definitions of ROS messages (PACKAGE/msg/NAME.msg), for bags that have none; may be
    repeated."""
    mapping: File
    """Mapping file with the channels, units and databases of a team's vehicles. Options of the command
    line override it."""
    mapping_vehicle: str
    """Vehicle of the mapping file."""
    header_line: int
    """Line of the header of text files, from 1; by default the row of names above the first row of
    values."""
    decimal: Literal["point", "comma"]
    """Decimal mark of the numbers; by default the one that the first rows determine."""
    row_period: Quantity
    """Time between rows of files without a clock."""
    input_channel: Union[str, Sequence[str]]
    """Channel of the steering angle or, for the structure torque, of the torque, for longitudinal of the
    accelerator or of the acceleration command; recognised by its name by default. For all channels:
    -CHANNEL reverses the sign, FILE:CHANNEL selects one of several files, GROUP.CHANNEL one of several
    topics or messages, "A + 0.1 * B" combines channels of one of these. May be repeated: with several
    inputs or outputs, or with one of each that is no steering angle and no yaw rate, a plant of any
    system is identified, whose channels keep their units."""
    output_channel: Union[str, Sequence[str]]
    """Channel of the yaw rate, or of the yaw, which is then differenced, or, for the structure torque,
    of the lateral acceleration, for longitudinal of the speed; recognised by its name by default. May be
    repeated, as inputs."""
    speed_channel: str
    """Channel of the speed; recognised by its name by default, and optional."""
    channel: Union[Mapping[str, Any], Sequence[str], str]
    """Further channel: steering_command beside a measured steering angle, from which the actuator
    between both is identified; for the structure torque steering (its angle), roll, engaged or override;
    for single-track and auto lateral_acceleration, longitudinal_acceleration, lateral_velocity or
    sideslip; for longitudinal brake, grade, pitch (positive with the nose down), altitude or gear; may
    be repeated. All but steering_command are recognised by their names by default."""
    steering_full_scale: Quantity
    """Steering angle at 1 of a normalised steering command, of unit 1 or %; by default the command is
    taken as it is."""
    steering_ratio: float
    """Steering angle over road-wheel angle; needed where the log has the steering wheel."""
    vehicle_class: Literal["car", "truck", "bus", "scale"]
    """Class of the vehicle: a model whose wheelbase or mean speed is not of this class fails. By default
    they must be those of one of the classes."""
    drive: Union[File, Sequence[File]]
    """Files that form one drive; may be repeated. By default each file with steering and yaw rate is a
    drive, and all other files are channels of one drive."""
    window: Union[Union[tuple[Quantity, Quantity], str], Sequence[Union[tuple[Quantity, Quantity], str]]]
    """Part of each drive to use, counted from its first sample, such as 10s..60s; may be repeated."""
    speed_window: Union[tuple[Quantity, Quantity], str]
    """Use the segments in which the speed, averaged over a second, stays within a range, such as 14..16
    (m/s) or 50km/h..60km/h."""
    sample_time: Quantity
    """Sample time of the merged log; by default chosen from the log's rate."""
    intersample: Literal["auto", "zoh", "foh", "bl"]
    """Behaviour of the steering between its samples: held (zoh, a command), band-limited (bl, a measured
    angle) or along straight lines (foh); auto decides by name, unit and values (default auto)."""
    max_gap: Quantity
    """Longest gap in a channel that is bridged; a longer one splits the drive (default 0.5s)."""
    gnss_latency: Quantity
    """Age of a GNSS fix at the time the log states for it. From a log with fixes (x_m and y_m, or
    latitude and longitude) course and gyro determine the sideslip in plant.json, and an error of the age
    is an error of the sideslip. By default the age is estimated from speed changes on straights; without
    them no sideslip is stated."""
    antenna_x: Quantity
    """Position of the antenna ahead of the centre of gravity; negative behind it (default 0m)."""


class ModelOptions(TypedDict, total=False):
    """The options of `identify` but for `structure`."""

    time_channel: str
    """Column of the time in every file; by default the first one with such a name."""
    unit: Union[Mapping[str, Any], Sequence[str], str]
    """Unit of a channel whose name does not state it, such as steer=deg; may be repeated."""
    topic: Union[str, Sequence[str]]
    """Topic, message or channel group to use; may be repeated. By default all."""
    dbc: Union[File, Sequence[File]]
    """CAN database that decodes a raw bus; may be repeated."""
    ros_definitions: Union[File, Sequence[File]]
    """Folder with definitions of ROS messages (PACKAGE/msg/NAME.msg), for bags that have none; may be
    repeated."""
    mapping: File
    """Mapping file with the channels, units and databases of a team's vehicles. Options of the command
    line override it."""
    mapping_vehicle: str
    """Vehicle of the mapping file."""
    header_line: int
    """Line of the header of text files, from 1; by default the row of names above the first row of
    values."""
    decimal: Literal["point", "comma"]
    """Decimal mark of the numbers; by default the one that the first rows determine."""
    row_period: Quantity
    """Time between rows of files without a clock."""
    input_channel: Union[str, Sequence[str]]
    """Channel of the steering angle or, for the structure torque, of the torque, for longitudinal of the
    accelerator or of the acceleration command; recognised by its name by default. For all channels:
    -CHANNEL reverses the sign, FILE:CHANNEL selects one of several files, GROUP.CHANNEL one of several
    topics or messages, "A + 0.1 * B" combines channels of one of these. May be repeated: with several
    inputs or outputs, or with one of each that is no steering angle and no yaw rate, a plant of any
    system is identified, whose channels keep their units."""
    output_channel: Union[str, Sequence[str]]
    """Channel of the yaw rate, or of the yaw, which is then differenced, or, for the structure torque,
    of the lateral acceleration, for longitudinal of the speed; recognised by its name by default. May be
    repeated, as inputs."""
    speed_channel: str
    """Channel of the speed; recognised by its name by default, and optional."""
    channel: Union[Mapping[str, Any], Sequence[str], str]
    """Further channel: steering_command beside a measured steering angle, from which the actuator
    between both is identified; for the structure torque steering (its angle), roll, engaged or override;
    for single-track and auto lateral_acceleration, longitudinal_acceleration, lateral_velocity or
    sideslip; for longitudinal brake, grade, pitch (positive with the nose down), altitude or gear; may
    be repeated. All but steering_command are recognised by their names by default."""
    steering_full_scale: Quantity
    """Steering angle at 1 of a normalised steering command, of unit 1 or %; by default the command is
    taken as it is."""
    steering_ratio: float
    """Steering angle over road-wheel angle; needed where the log has the steering wheel."""
    vehicle_class: Literal["car", "truck", "bus", "scale"]
    """Class of the vehicle: a model whose wheelbase or mean speed is not of this class fails. By default
    they must be those of one of the classes."""
    drive: Union[File, Sequence[File]]
    """Files that form one drive; may be repeated. By default each file with steering and yaw rate is a
    drive, and all other files are channels of one drive."""
    window: Union[Union[tuple[Quantity, Quantity], str], Sequence[Union[tuple[Quantity, Quantity], str]]]
    """Part of each drive to use, counted from its first sample, such as 10s..60s; may be repeated."""
    speed_window: Union[tuple[Quantity, Quantity], str]
    """Use the segments in which the speed, averaged over a second, stays within a range, such as 14..16
    (m/s) or 50km/h..60km/h."""
    sample_time: Quantity
    """Sample time of the merged log; by default chosen from the log's rate."""
    intersample: Literal["auto", "zoh", "foh", "bl"]
    """Behaviour of the steering between its samples: held (zoh, a command), band-limited (bl, a measured
    angle) or along straight lines (foh); auto decides by name, unit and values (default auto)."""
    max_gap: Quantity
    """Longest gap in a channel that is bridged; a longer one splits the drive (default 0.5s)."""
    gnss_latency: Quantity
    """Age of a GNSS fix at the time the log states for it. From a log with fixes (x_m and y_m, or
    latitude and longitude) course and gyro determine the sideslip in plant.json, and an error of the age
    is an error of the sideslip. By default the age is estimated from speed changes on straights; without
    them no sideslip is stated."""
    antenna_x: Quantity
    """Position of the antenna ahead of the centre of gravity; negative behind it (default 0m)."""
    method: Literal["auto", "n4sid", "moesp", "cva", "ssarx", "pbsid"]
    """Subspace method: n4sid, moesp and cva for open-loop data, ssarx and pbsid for closed-loop data;
    auto decides by a test for feedback (default auto)."""
    order: Union[int, str]
    """Order of the model (default auto)."""
    max_order: int
    """Highest order among which `order auto` chooses (default 8)."""
    horizon: Union[int, str]
    """Block rows of the Hankel matrices (default auto)."""
    model_input: Literal["steering", "steering*speed"]
    """Input of the model: the steering angle, or its product with the speed (default steering)."""
    delay: Quantity
    """Pure delay of the steering; auto estimates it, and uses none if the data do not support one
    (default auto)."""
    detrend: Literal["mean", "linear", "none"]
    """Offsets and trends to remove: the means of the estimation data, a straight line over time for each
    drive, or none (default mean)."""
    feedthrough: Union[Literal["auto", "on", "off"], bool]
    """Feedthrough: the yaw rate depends on the steering of the same sample (default auto)."""
    max_samples: Union[int, str]
    """Largest number of estimation samples, in blocks spread over a long log (default 60000)."""
    validation_fraction: Quantity
    """Share of the log that is validation data (default 50%)."""
    validation_place: Literal["auto", "end"]
    """Where the validation data are: at the end of the log, or, with auto, in blocks over the whole log
    where a part is hardly steered or the parts differ in speed or lateral acceleration (default auto)."""
    mass: float
    """Mass in bicycle.json or vehicle.json, kg; the fit does not depend on it. By default 1500."""
    wheelbase: float
    """Wheelbase of the bicycle or vehicle, m; the steering ratio is then identified. By default the
    wheelbase is identified, with the steering ratio of the log."""
    front_share: Quantity
    """Share of the weight on the front axle of the bicycle or vehicle; the yaw rate hardly depends on
    it. From 10% to 90% for the bicycle, by default 50%; from 20% to 80% for the vehicle, by default
    identified."""
    track_width: float
    """Left to right wheel in vehicle.json, m; nothing that is fitted depends on it. By default 0.58
    wheelbases."""
    prior: Union[Mapping[str, Any], Sequence[str], str]
    """Prior of a parameter of the structure single-track: its mean, and the standard deviation of the
    parameter or of its logarithm, 0 to fix it. The table of the results has names and priors; may be
    repeated."""
    sideslip: Literal["fit", "compare"]
    """Whether the structure single-track fits the logged sideslip or lateral velocity too, or only
    compares it. By default fit."""
    min_speed: Quantity
    """Lowest speed that is used. By default 15 m/s for the structure torque, 3 m/s for longitudinal,
    otherwise 3 m/s times the root of the wheelbase over 2.6 m."""
    single_gear: bool
    """The drive of the structure longitudinal has one gear, as most electric ones: a log without a gear
    that is too short to show this is then no reason to doubt the model."""
    friction_rate: Quantity
    """Rate of the steering angle at which the friction of the structure torque reaches 76 % of its
    value, in coordinates of the log. By default 0.05rad/s."""


class IdentifyOptions(ModelOptions, total=False):
    """The options of `identify`."""

    structure: Literal["auto", "state-space", "bicycle", "single-track", "torque", "longitudinal"]
    """Structure of the model: state-space, linear at one speed; the bicycle of eq 13 scheduled by the
    speed, for drives of varying speed; single-track, a vehicle up to the limit of its grip; torque, the
    lateral acceleration that a steering torque or its normalised command causes; or longitudinal, the
    speed that accelerator and brake, or an acceleration command, cause. auto is the one of the first
    three with the smallest error on the validation data. With an option of state-space (all under
    Identification but max_samples and those of the validation data) and from R factors, auto is
    state-space (default auto)."""


class AccumulateOptions(TypedDict, total=False):
    """The options of `accumulate`."""

    horizon: int
    """Block rows of the Hankel matrices, the largest horizon for a later identification (default 30)."""
    model_input: Literal["steering", "steering*speed"]
    """Input of the model: the steering angle, or its product with the speed (default steering)."""
    time_channel: str
    """Column of the time in every file; by default the first one with such a name."""
    unit: Union[Mapping[str, Any], Sequence[str], str]
    """Unit of a channel whose name does not state it, such as steer=deg; may be repeated."""
    topic: Union[str, Sequence[str]]
    """Topic, message or channel group to use; may be repeated. By default all."""
    dbc: Union[File, Sequence[File]]
    """CAN database that decodes a raw bus; may be repeated."""
    ros_definitions: Union[File, Sequence[File]]
    """Folder with definitions of ROS messages (PACKAGE/msg/NAME.msg), for bags that have none; may be
    repeated."""
    mapping: File
    """Mapping file with the channels, units and databases of a team's vehicles. Options of the command
    line override it."""
    mapping_vehicle: str
    """Vehicle of the mapping file."""
    header_line: int
    """Line of the header of text files, from 1; by default the row of names above the first row of
    values."""
    decimal: Literal["point", "comma"]
    """Decimal mark of the numbers; by default the one that the first rows determine."""
    row_period: Quantity
    """Time between rows of files without a clock."""
    input_channel: Union[str, Sequence[str]]
    """Channel of the steering angle or, for the structure torque, of the torque, for longitudinal of the
    accelerator or of the acceleration command; recognised by its name by default. For all channels:
    -CHANNEL reverses the sign, FILE:CHANNEL selects one of several files, GROUP.CHANNEL one of several
    topics or messages, "A + 0.1 * B" combines channels of one of these. May be repeated: with several
    inputs or outputs, or with one of each that is no steering angle and no yaw rate, a plant of any
    system is identified, whose channels keep their units."""
    output_channel: Union[str, Sequence[str]]
    """Channel of the yaw rate, or of the yaw, which is then differenced, or, for the structure torque,
    of the lateral acceleration, for longitudinal of the speed; recognised by its name by default. May be
    repeated, as inputs."""
    speed_channel: str
    """Channel of the speed; recognised by its name by default, and optional."""
    steering_full_scale: Quantity
    """Steering angle at 1 of a normalised steering command, of unit 1 or %; by default the command is
    taken as it is."""
    steering_ratio: float
    """Steering angle over road-wheel angle; needed where the log has the steering wheel."""
    vehicle_class: Literal["car", "truck", "bus", "scale"]
    """Class of the vehicle: a model whose wheelbase or mean speed is not of this class fails. By default
    they must be those of one of the classes."""
    speed_window: Union[tuple[Quantity, Quantity], str]
    """Use the segments in which the speed, averaged over a second, stays within a range, such as 14..16
    (m/s) or 50km/h..60km/h."""
    sample_time: Quantity
    """Sample time of the merged log; by default chosen from the log's rate."""
    intersample: Literal["auto", "zoh", "foh", "bl"]
    """Behaviour of the steering between its samples: held (zoh, a command), band-limited (bl, a measured
    angle) or along straight lines (foh); auto decides by name, unit and values (default auto)."""
    max_gap: Quantity
    """Longest gap in a channel that is bridged; a longer one splits the drive (default 0.5s)."""


class DesignOptions(TypedDict, total=False):
    """The options of `design`."""

    speeds: Union[tuple[Quantity, Quantity], str]
    """Design for a range of speeds, such as 5..30 (m/s) or 18..108km/h: a table of gains and guidance
    over speed. Requires a model that holds at other speeds, such as bicycle.json or vehicle.json. Of
    longitudinal.json the range is by default that of its drive."""
    accept_untrusted: bool
    """Use a model that failed validation; all files made from it state its quality."""
    requirements: File
    """Read the specification from a file with the names of these options, such as `settling = "1s"`. An
    option overrides the file, and `none` removes a requirement. Without a file the requirements are 1%
    overshoot, 1s settling time, 2% steady-state error and a modulus margin of 0.5; of a speed controller
    5% overshoot, 4s settling time and 2% steady-state error."""
    overshoot: Quantity
    """Largest overshoot."""
    settling: Quantity
    """Longest settling time."""
    steady_state_error: Quantity
    """Largest steady-state error: of the step, with a steering offset of 1° at the road wheel (0.8 of
    the largest angle where that is less), and on a curve of constant curvature with feedforward; of a
    speed controller: of the step, and on a grade that is not measured."""
    rise_time: Quantity
    """Longest rise time, 10 to 90 %."""
    iae: Quantity
    """Largest integral of absolute error (IAE) of the step, divided by its height."""
    gain_margin: Quantity
    """Smallest gain margin, such as 6dB."""
    phase_margin: Quantity
    """Smallest phase margin."""
    modulus_margin: Quantity
    """Smallest distance of the loop from −1."""
    delay_margin: Quantity
    """Smallest additional delay that makes the loop unstable."""
    disk_margin: Quantity
    """Smallest disk margin with zero skew."""
    settling_band: Quantity
    """Band in which the response has settled; by default the steady-state error, or 2%."""
    max_angle: Quantity
    """Largest steering angle in steering coordinates; by default 22deg at the road wheel."""
    max_increment: Quantity
    """Largest change of the steering angle in a sample; by default 15deg at the road wheel."""
    max_rate: Quantity
    """Largest rate of the steering angle that the actuator follows; by default that of the model, which
    a command outran, or else twice the fastest steering of the drive. Required for a model without a
    drive."""
    actuator_lag: Quantity
    """Time constant of the actuator that moves the steering to the commanded angle, for a model whose
    drive has the measured angle: such a model has none."""
    actuator_delay: Quantity
    """Delay of that actuator."""
    max_lateral_acceleration: Quantity
    """Largest lateral acceleration of a steady turn; it limits the steering angle at each speed
    [default: 6m/s2]."""
    max_acceleration: Quantity
    """Largest acceleration that a speed controller demands [default: 2m/s2, that of ISO 15622]."""
    max_deceleration: Quantity
    """Largest deceleration that a speed controller demands [default: 3.5m/s2, that of ISO 15622]."""
    max_jerk: Quantity
    """Largest jerk that a speed controller demands [default: 2.5m/s3, that of ISO 15622]."""
    grade: Quantity
    """Grade on which a speed controller keeps the steady-state error [default: 6%]."""
    pid_sample_time: Quantity
    """Sample time of the controller [default: 10ms]."""
    coupling: Literal["gauss-seidel", "jacobi"]
    """Coupling of the co-simulation that the loop is designed for [default: gauss-seidel]."""
    latency: Quantity
    """Measured latency of every loop, in addition to the delays of the model and the coupling."""
    loop_delay: Quantity
    """Additional delay of the yaw loop."""
    path_delay: Quantity
    """Additional delay of the loop through the path; by default that of the yaw loop."""
    estimator_delay: Quantity
    """Additional delay of the loop through pose estimator and path; by default that of the path."""
    robust: Literal["on", "off"]
    """Design for all plants within the identified uncertainty, for other latencies, and for other speeds
    where the model was identified over speed [default: on]. Requirements that some of these plants miss
    are reported; with an explicit `on` they fail the design."""
    latency_spread: Quantity
    """Latency above and below the designed one that the requirements must tolerate; by default 30ms with
    a stated latency, otherwise one sample."""
    speed_spread: Quantity
    """Speed above and below the designed one that the requirements must tolerate, where the model was
    identified over speed [default: 20%, or 5% with a range of speeds]."""
    ensemble: int
    """Number of plants drawn from the identified uncertainty [default: 100]."""
    seed: int
    """Seed of the starting points and the drawn plants [default: 1]."""


class PathOptions(TypedDict, total=False):
    """The options of `path`."""

    speed: Quantity
    """Speed along the path (default 15m/s)."""
    lateral_acceleration: Quantity
    """Largest lateral acceleration of the standard road (default 4m/s2)."""
    closed: bool
    """Connect the last point of the track with its first."""
    max_deviation: Quantity
    """Largest distance of a recorded point from the path; by default the noise of the points, and 0.1 m
    for the mean of neighbours. Smoothing is reduced to stay within it; the exit status is 1 if it is
    exceeded."""
    poor_fixes: Literal["refuse", "mark"]
    """Use of fixes with fewer than 5 satellites or without correction, if GPX or NMEA report both
    (default refuse)."""
    pid: Any
    """Controller that will follow the path: sets feedforward and preview. A road that needs more than
    0.9 of its lateral acceleration, steering angle or steering rate is reported, with the place and the
    speed at which it needs no more."""
    plant: Any
    """plant.json, bicycle.json or vehicle.json of the vehicle that will follow the path: sets its
    sideslip, with its growth in tight turns and its lead in changing turns."""
    sideslip_per_yaw_rate: Quantity
    """Sideslip angle per yaw rate of the vehicle in a steady turn, such as -40ms: course minus yaw; by
    default that of plant, otherwise 0."""
    cross_track_integral: Quantity
    """Gain of the integral of the cross-track error, such as 0.05/s; none by default (default 0/s)."""
    profile: bool
    """Compute the time-optimal speed along the path within the limits below; `ReferencePath` has it as
    speed_reference and acceleration_reference."""
    max_speed: Quantity
    """Largest speed of the profile; by default speed."""
    max_lateral_acceleration: Quantity
    """Largest lateral acceleration of the profile; by default 0.9 of that of pid, otherwise 0.9 of that
    which the evidence of plant covers, otherwise 4m/s2."""
    max_acceleration: Quantity
    """Largest acceleration of the profile; by default 0.9 of that of speed_controller, otherwise 2m/s2,
    that of ISO 15622."""
    max_deceleration: Quantity
    """Largest deceleration of the profile; by default 0.9 of that of speed_controller, otherwise
    3.5m/s2, that of ISO 15622."""
    max_jerk: Quantity
    """Largest jerk of the profile, or `none`; by default 0.7 of that of speed_controller, otherwise
    2.5m/s3, that of ISO 15622."""
    friction: float
    """Friction coefficient of the road: the vector sum of lateral and longitudinal acceleration stays
    below it times gravity; not limited by default."""
    max_angle: Quantity
    """Largest steering angle of the profile in steering coordinates, or `none`; by default 0.9 of that
    of pid. Requires pid or plant."""
    max_rate: Quantity
    """Largest rate of the steering angle of the profile, or `none`; by default 0.9 of that of pid.
    Requires pid or plant."""
    start_speed: Quantity
    """Speed at the beginning of the path; standstill by default. A closed path has none: a lap ends at
    the speed at which it begins."""
    end_speed: Quantity
    """Speed at the end of the path; standstill by default."""
    speed_controller: File
    """speed_controller.json of the controller that will follow the profile: 0.9 of its limits of
    acceleration and deceleration, and 0.7 of that of jerk, so that it has a reserve."""


class ExciteOptions(TypedDict, total=False):
    """The options of `excite`."""

    goal: Literal["response", "understeer", "tyre-limit"]
    """What is to be known: the response in the band, the understeer gradient, or the friction of the
    tyres; the understeer gradient needs two speeds, the friction a large lateral acceleration (default
    response)."""
    by: Literal["robot", "driver"]
    """Who steers; at the tyre limit both steer the same (default robot)."""
    speed: Quantity
    """Speed; by default that of the model, and half of it where the goal is the understeer gradient."""
    speeds: Union[tuple[Quantity, Quantity], str]
    """Range of speeds, of which the lowest, the middle (not of goal understeer) and the highest are
    driven for equal times, such as 10..25."""
    time: Quantity
    """Time of the recording, of which the first half estimates and the second validates (default 120s)."""
    block: Quantity
    """Length of a block: its signal and 2 s straight (default 20s)."""
    band: Union[tuple[Quantity, Quantity], str]
    """Band in which the response is to be known; of other goals that of the steering (default 0.2..2Hz)."""
    response_error: Quantity
    """Largest error of the response in the band, as two standard errors of the gain (relative) and of
    the phase (100% are 1 rad); the exit status is 1 if it is not reached in the time."""
    understeer_error: Quantity
    """Largest error of the understeer gradient at the road wheel, as two standard errors, such as
    0.1deg/g; of goal understeer, with the same exit status."""
    friction_error: Quantity
    """Largest error of the friction coefficients of both axles, as two standard errors, relative; of
    goal tyre-limit, with the same exit status."""
    max_lateral_acceleration: Quantity
    """Largest lateral acceleration [default: 3m/s2; to be stated for goal tyre-limit]."""
    max_angle: Quantity
    """Largest steering angle, in steering coordinates."""
    max_rate: Quantity
    """Largest rate of the steering angle, in steering coordinates."""
    road_width: Quantity
    """Width of the road, within which the vehicle stays."""
    vehicle_width: Quantity
    """Width of the vehicle (default 2m)."""
    noise: Quantity
    """Standard deviation of the yaw rate's noise at each sample; by default that of the log which the
    model is from, otherwise 0.1deg/s."""
    uncertainty: Quantity
    """Standard deviation of each axle's cornering stiffness where the model states no uncertainty, and
    of a vehicle's friction; the limits leave room for it (default 10%)."""
    sample_time: Quantity
    """Time from one sample to the next, of the steering and of the log (default 10ms)."""


class InspectOptions(TypedDict, total=False):
    """The options of `inspect`."""

    channel: Union[str, Sequence[str]]
    """List and draw this channel only, named as it is listed; may be repeated."""
    time_channel: str
    """Column of the time in every file; by default the first one with such a name."""
    unit: Union[Mapping[str, Any], Sequence[str], str]
    """Unit of a channel whose name does not state it, such as steer=deg; may be repeated."""
    topic: Union[str, Sequence[str]]
    """Topic, message or channel group to use; may be repeated. By default all."""
    dbc: Union[File, Sequence[File]]
    """CAN database that decodes a raw bus; may be repeated."""
    ros_definitions: Union[File, Sequence[File]]
    """Folder with definitions of ROS messages (PACKAGE/msg/NAME.msg), for bags that have none; may be
    repeated."""
    mapping: File
    """Mapping file with the channels, units and databases of a team's vehicles. Options of the command
    line override it."""
    mapping_vehicle: str
    """Vehicle of the mapping file."""
    header_line: int
    """Line of the header of text files, from 1; by default the row of names above the first row of
    values."""
    decimal: Literal["point", "comma"]
    """Decimal mark of the numbers; by default the one that the first rows determine."""
    row_period: Quantity
    """Time between rows of files without a clock."""


class PackageOptions(TypedDict, total=False):
    """The options of `package`."""

    out: File
    """Folder for the archives (default .)."""
    step: Quantity
    """Step size that the archives recommend, such as 10ms; by default the controller's sample time in
    its archive, and with ssp in all, otherwise 10ms."""
    ssp: str
    """Also connect variables of equal name and write the FMUs as a system structure package (SSP 1.0)
    into the folder. With a path file they start on its first point, at its speed. With an estimator
    file, path and controller use its pose; its fixes are the pose of the plant, as of a receiver without
    latency or antenna offset: one every gnss.period_s (by default 0.1 s) of gnss.std_m (0.02 m). A path
    or estimator without a sideslip uses that of the plant. A plant of a measured angle is packed behind
    the actuator that the controller was designed for. The variant SpeedInput of the package has one
    input, speed, for all FMUs."""
    accept_untrusted: bool
    """Use a model that failed validation; all files made from it state its quality."""
    force: bool
    """Overwrite an existing file of any content, and replace a folder with changed files; an input is
    never overwritten, a foreign file in a folder never removed."""


class CheckOptions(TypedDict, total=False):
    """The options of `check`."""

    run: bool
    """Also run the binary of this platform, in a separate process that may crash or hang."""
    time_limit: Quantity
    """Longest duration of a run of run; a longer experiment is cut (default 60s)."""
    strict: bool
    """Treat warnings as errors."""


class CompareOptions(TypedDict, total=False):
    """The options of `compare`."""

    truth: File
    """The vehicle that represents the truth: a plant FMU of any tool (inputs steering_angle and speed,
    outputs x, y, yaw), vehicle.json, plant.json, bicycle.json, or vehicle data (TOML) for a
    NonlinearVehicle."""
    pid: Union[Any, Sequence[Any]]
    """A controller, of the model whose hash it carries, or of the named model; may be repeated."""
    log: Union[File, Sequence[File]]
    """A drive to compare the models with, in any format that `identify` reads; may be repeated for more
    files."""
    validation_fraction: Quantity
    """Share of the log that is validation data, at its end; by default 50%."""
    out: File
    """Folder for figures (SVG), results.csv, the runs, and one HTML page."""
    path: File
    """Drive along this path at its speed; look-ahead, preview, feedforward and sideslip are those of
    each controller and plant."""
    road: Literal["reference", "lane-change", "s-curve"]
    """A standard road (default reference)."""
    road_speed: Quantity
    """Speed on the standard road; by default that of the models."""
    lateral_acceleration: Quantity
    """Largest lateral acceleration of the standard road (default 4m/s2)."""
    cross_track_integral: Quantity
    """Gain of the integral of the cross-track error in the path follower, such as 0.05/s; by default
    that of the path, or none."""
    max_cross_track_error: Quantity
    """A cross-track error beyond this is off the path (default 1.75m)."""
    time_channel: str
    """Column of the time in every file; by default the first one with such a name."""
    unit: Union[Mapping[str, Any], Sequence[str], str]
    """Unit of a channel whose name does not state it, such as steer=deg; may be repeated."""
    topic: Union[str, Sequence[str]]
    """Topic, message or channel group to use; may be repeated. By default all."""
    dbc: Union[File, Sequence[File]]
    """CAN database that decodes a raw bus; may be repeated."""
    ros_definitions: Union[File, Sequence[File]]
    """Folder with definitions of ROS messages (PACKAGE/msg/NAME.msg), for bags that have none; may be
    repeated."""
    mapping: File
    """Mapping file with the channels, units and databases of a team's vehicles. Options of the command
    line override it."""
    mapping_vehicle: str
    """Vehicle of the mapping file."""
    header_line: int
    """Line of the header of text files, from 1; by default the row of names above the first row of
    values."""
    decimal: Literal["point", "comma"]
    """Decimal mark of the numbers; by default the one that the first rows determine."""
    row_period: Quantity
    """Time between rows of files without a clock."""
    input_channel: Union[str, Sequence[str]]
    """Channel of the steering angle or, for the structure torque, of the torque, for longitudinal of the
    accelerator or of the acceleration command; recognised by its name by default. For all channels:
    -CHANNEL reverses the sign, FILE:CHANNEL selects one of several files, GROUP.CHANNEL one of several
    topics or messages, "A + 0.1 * B" combines channels of one of these. May be repeated: with several
    inputs or outputs, or with one of each that is no steering angle and no yaw rate, a plant of any
    system is identified, whose channels keep their units."""
    output_channel: Union[str, Sequence[str]]
    """Channel of the yaw rate, or of the yaw, which is then differenced, or, for the structure torque,
    of the lateral acceleration, for longitudinal of the speed; recognised by its name by default. May be
    repeated, as inputs."""
    speed_channel: str
    """Channel of the speed; recognised by its name by default, and optional."""
    channel: Union[Mapping[str, Any], Sequence[str], str]
    """Further channel: steering_command beside a measured steering angle, from which the actuator
    between both is identified; for the structure torque steering (its angle), roll, engaged or override;
    for single-track and auto lateral_acceleration, longitudinal_acceleration, lateral_velocity or
    sideslip; for longitudinal brake, grade, pitch (positive with the nose down), altitude or gear; may
    be repeated. All but steering_command are recognised by their names by default."""
    steering_full_scale: Quantity
    """Steering angle at 1 of a normalised steering command, of unit 1 or %; by default the command is
    taken as it is."""
    steering_ratio: float
    """Steering angle over road-wheel angle; needed where the log has the steering wheel."""
    vehicle_class: Literal["car", "truck", "bus", "scale"]
    """Class of the vehicle: a model whose wheelbase or mean speed is not of this class fails. By default
    they must be those of one of the classes."""
    drive: Union[File, Sequence[File]]
    """Files that form one drive; may be repeated. By default each file with steering and yaw rate is a
    drive, and all other files are channels of one drive."""
    window: Union[Union[tuple[Quantity, Quantity], str], Sequence[Union[tuple[Quantity, Quantity], str]]]
    """Part of each drive to use, counted from its first sample, such as 10s..60s; may be repeated."""
    speed_window: Union[tuple[Quantity, Quantity], str]
    """Use the segments in which the speed, averaged over a second, stays within a range, such as 14..16
    (m/s) or 50km/h..60km/h."""
    sample_time: Quantity
    """Sample time of the merged log; by default chosen from the log's rate."""
    intersample: Literal["auto", "zoh", "foh", "bl"]
    """Behaviour of the steering between its samples: held (zoh, a command), band-limited (bl, a measured
    angle) or along straight lines (foh); auto decides by name, unit and values (default auto)."""
    max_gap: Quantity
    """Longest gap in a channel that is bridged; a longer one splits the drive (default 0.5s)."""
    gnss_latency: Quantity
    """Age of a GNSS fix at the time the log states for it. From a log with fixes (x_m and y_m, or
    latitude and longitude) course and gyro determine the sideslip in plant.json, and an error of the age
    is an error of the sideslip. By default the age is estimated from speed changes on straights; without
    them no sideslip is stated."""
    antenna_x: Quantity
    """Position of the antenna ahead of the centre of gravity; negative behind it (default 0m)."""
    accept_untrusted: bool
    """Use a model that failed validation; all files made from it state its quality."""
    requirements: File
    """Read the specification from a file with the names of these options, such as `settling = "1s"`. An
    option overrides the file, and `none` removes a requirement. Without a file the requirements are 1%
    overshoot, 1s settling time, 2% steady-state error and a modulus margin of 0.5; of a speed controller
    5% overshoot, 4s settling time and 2% steady-state error."""
    overshoot: Quantity
    """Largest overshoot."""
    settling: Quantity
    """Longest settling time."""
    steady_state_error: Quantity
    """Largest steady-state error: of the step, with a steering offset of 1° at the road wheel (0.8 of
    the largest angle where that is less), and on a curve of constant curvature with feedforward; of a
    speed controller: of the step, and on a grade that is not measured."""
    rise_time: Quantity
    """Longest rise time, 10 to 90 %."""
    iae: Quantity
    """Largest integral of absolute error (IAE) of the step, divided by its height."""
    gain_margin: Quantity
    """Smallest gain margin, such as 6dB."""
    phase_margin: Quantity
    """Smallest phase margin."""
    modulus_margin: Quantity
    """Smallest distance of the loop from −1."""
    delay_margin: Quantity
    """Smallest additional delay that makes the loop unstable."""
    disk_margin: Quantity
    """Smallest disk margin with zero skew."""
    settling_band: Quantity
    """Band in which the response has settled; by default the steady-state error, or 2%."""
    max_angle: Quantity
    """Largest steering angle in steering coordinates; by default 22deg at the road wheel."""
    max_increment: Quantity
    """Largest change of the steering angle in a sample; by default 15deg at the road wheel."""
    max_rate: Quantity
    """Largest rate of the steering angle that the actuator follows; by default that of the model, which
    a command outran, or else twice the fastest steering of the drive. Required for a model without a
    drive."""
    actuator_lag: Quantity
    """Time constant of the actuator that moves the steering to the commanded angle, for a model whose
    drive has the measured angle: such a model has none."""
    actuator_delay: Quantity
    """Delay of that actuator."""
    max_lateral_acceleration: Quantity
    """Largest lateral acceleration of a steady turn; it limits the steering angle at each speed
    [default: 6m/s2]."""
    max_acceleration: Quantity
    """Largest acceleration that a speed controller demands [default: 2m/s2, that of ISO 15622]."""
    max_deceleration: Quantity
    """Largest deceleration that a speed controller demands [default: 3.5m/s2, that of ISO 15622]."""
    max_jerk: Quantity
    """Largest jerk that a speed controller demands [default: 2.5m/s3, that of ISO 15622]."""
    grade: Quantity
    """Grade on which a speed controller keeps the steady-state error [default: 6%]."""
    pid_sample_time: Quantity
    """Sample time of the controller [default: 10ms]."""
    coupling: Literal["gauss-seidel", "jacobi"]
    """Coupling of the co-simulation that the loop is designed for [default: gauss-seidel]."""
    latency: Quantity
    """Measured latency of every loop, in addition to the delays of the model and the coupling."""
    loop_delay: Quantity
    """Additional delay of the yaw loop."""
    path_delay: Quantity
    """Additional delay of the loop through the path; by default that of the yaw loop."""
    estimator_delay: Quantity
    """Additional delay of the loop through pose estimator and path; by default that of the path."""
    robust: Literal["on", "off"]
    """Design for all plants within the identified uncertainty, for other latencies, and for other speeds
    where the model was identified over speed [default: on]. Requirements that some of these plants miss
    are reported; with an explicit `on` they fail the design."""
    latency_spread: Quantity
    """Latency above and below the designed one that the requirements must tolerate; by default 30ms with
    a stated latency, otherwise one sample."""
    speed_spread: Quantity
    """Speed above and below the designed one that the requirements must tolerate, where the model was
    identified over speed [default: 20%, or 5% with a range of speeds]."""
    ensemble: int
    """Number of plants drawn from the identified uncertainty [default: 100]."""
    seed: int
    """Seed of the starting points and the drawn plants [default: 1]."""
    force: bool
    """Overwrite an existing file of any content, and replace a folder with changed files; an input is
    never overwritten, a foreign file in a folder never removed."""


class ExportOptions(TypedDict, total=False):
    """The options of `export`."""

    output: File
    """Write the parameters here; by default they are printed."""
    max_angle: Quantity
    """Largest steering angle, in steering coordinates."""
    max_rate: Quantity
    """Largest rate of the steering angle that the actuator reaches, in steering coordinates."""
    wheelbase: float
    """Wheelbase, m; by default that of a bicycle or vehicle."""
    accept_untrusted: bool
    """Use a model that failed validation; all files made from it state its quality."""
    force: bool
    """Overwrite an existing file of any content, and replace a folder with changed files; an input is
    never overwritten, a foreign file in a folder never removed."""


class BuildOptions(IdentifyOptions, total=False):
    """The options of `build`."""

    out: File
    """Folder for all results (default out)."""
    vehicle: File
    """Vehicle data (TOML) of a bicycle model to compare with."""
    track: File
    """Recorded points (CSV, GPX or NMEA) of a road to track, in addition to the standard road."""
    lateral_acceleration: Quantity
    """Largest lateral acceleration on the standard road (default 4m/s2)."""
    accept_untrusted: bool
    """Use a model that failed validation; all files made from it state its quality."""
    requirements: File
    """Read the specification from a file with the names of these options, such as `settling = "1s"`. An
    option overrides the file, and `none` removes a requirement. Without a file the requirements are 1%
    overshoot, 1s settling time, 2% steady-state error and a modulus margin of 0.5; of a speed controller
    5% overshoot, 4s settling time and 2% steady-state error."""
    overshoot: Quantity
    """Largest overshoot."""
    settling: Quantity
    """Longest settling time."""
    steady_state_error: Quantity
    """Largest steady-state error: of the step, with a steering offset of 1° at the road wheel (0.8 of
    the largest angle where that is less), and on a curve of constant curvature with feedforward; of a
    speed controller: of the step, and on a grade that is not measured."""
    rise_time: Quantity
    """Longest rise time, 10 to 90 %."""
    iae: Quantity
    """Largest integral of absolute error (IAE) of the step, divided by its height."""
    gain_margin: Quantity
    """Smallest gain margin, such as 6dB."""
    phase_margin: Quantity
    """Smallest phase margin."""
    modulus_margin: Quantity
    """Smallest distance of the loop from −1."""
    delay_margin: Quantity
    """Smallest additional delay that makes the loop unstable."""
    disk_margin: Quantity
    """Smallest disk margin with zero skew."""
    settling_band: Quantity
    """Band in which the response has settled; by default the steady-state error, or 2%."""
    max_angle: Quantity
    """Largest steering angle in steering coordinates; by default 22deg at the road wheel."""
    max_increment: Quantity
    """Largest change of the steering angle in a sample; by default 15deg at the road wheel."""
    max_rate: Quantity
    """Largest rate of the steering angle that the actuator follows; by default that of the model, which
    a command outran, or else twice the fastest steering of the drive. Required for a model without a
    drive."""
    actuator_lag: Quantity
    """Time constant of the actuator that moves the steering to the commanded angle, for a model whose
    drive has the measured angle: such a model has none."""
    actuator_delay: Quantity
    """Delay of that actuator."""
    max_lateral_acceleration: Quantity
    """Largest lateral acceleration of a steady turn; it limits the steering angle at each speed
    [default: 6m/s2]."""
    max_acceleration: Quantity
    """Largest acceleration that a speed controller demands [default: 2m/s2, that of ISO 15622]."""
    max_deceleration: Quantity
    """Largest deceleration that a speed controller demands [default: 3.5m/s2, that of ISO 15622]."""
    max_jerk: Quantity
    """Largest jerk that a speed controller demands [default: 2.5m/s3, that of ISO 15622]."""
    grade: Quantity
    """Grade on which a speed controller keeps the steady-state error [default: 6%]."""
    pid_sample_time: Quantity
    """Sample time of the controller [default: 10ms]."""
    coupling: Literal["gauss-seidel", "jacobi"]
    """Coupling of the co-simulation that the loop is designed for [default: gauss-seidel]."""
    latency: Quantity
    """Measured latency of every loop, in addition to the delays of the model and the coupling."""
    loop_delay: Quantity
    """Additional delay of the yaw loop."""
    path_delay: Quantity
    """Additional delay of the loop through the path; by default that of the yaw loop."""
    estimator_delay: Quantity
    """Additional delay of the loop through pose estimator and path; by default that of the path."""
    robust: Literal["on", "off"]
    """Design for all plants within the identified uncertainty, for other latencies, and for other speeds
    where the model was identified over speed [default: on]. Requirements that some of these plants miss
    are reported; with an explicit `on` they fail the design."""
    latency_spread: Quantity
    """Latency above and below the designed one that the requirements must tolerate; by default 30ms with
    a stated latency, otherwise one sample."""
    speed_spread: Quantity
    """Speed above and below the designed one that the requirements must tolerate, where the model was
    identified over speed [default: 20%, or 5% with a range of speeds]."""
    ensemble: int
    """Number of plants drawn from the identified uncertainty [default: 100]."""
    seed: int
    """Seed of the starting points and the drawn plants [default: 1]."""
    force: bool
    """Overwrite an existing file of any content, and replace a folder with changed files; an input is
    never overwritten, a foreign file in a folder never removed."""


class SweepOptions(TypedDict, total=False):
    """The options of `sweep`."""

    output: File
    """Write the results here, a row a run; by default results.csv. With shard the folder of the pieces,
    by default pieces."""
    shard: str
    """Make only this part of the runs, counted from 0, such as 0/100 to 99/100, in a file of the folder
    output whose name states study and runs. A piece that is there is not made again."""
    resume: bool
    """Continue with the unfinished results of an earlier call."""
    threads: int
    """Threads; by default one a core."""
    isolate: bool
    """Run the FMUs of each thread in a separate process: a crash ends one run only, and FMUs that allow
    one instance per process run on all threads."""
    timeout: Quantity
    """Longest duration of a run; a longer run is a row with an error. An FMU that does not return ends
    the sweep, which resume continues; with isolate it ends its run only (default 600s)."""
    trajectories: File
    """Write trajectories of the runs that of names into this folder."""
    of: Union[int, Sequence[int]]
    """Runs to write trajectories of, such as 0,7,12."""
    force: bool
    """Overwrite an existing file of any content, and replace a folder with changed files; an input is
    never overwritten, a foreign file in a folder never removed."""


class MergeSweepOptions(TypedDict, total=False):
    """The options of `sweep merge`."""

    output: File
    """Write the results here, a row a run (default results.csv)."""
    force: bool
    """Overwrite an existing file of any content, and replace a folder with changed files; an input is
    never overwritten, a foreign file in a folder never removed."""


class SimulateOptions(TypedDict, total=False):
    """The options of `simulate`."""

    step: Quantity
    """Communication step; by default the smallest that an FMU recommends."""
    start: Quantity
    """Start time; by default the earliest that an FMU recommends, or 0."""
    stop: Quantity
    """Stop time; by default the latest that an FMU recommends."""
    coupling: Literal["gauss-seidel", "jacobi"]
    """Order of the FMUs within a step (default gauss-seidel)."""
    set: Union[Mapping[str, Any], Sequence[str], str]
    """Set a parameter or a free input, such as LateralPid.kp=1.2; may be repeated."""
    variant: str
    """Structure of the .ssp to run, the name of its .ssd file, such as SpeedInput; by default
    SystemStructure."""
