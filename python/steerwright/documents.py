"""The JSON documents, typed. Generated from the crate `formats` by `cargo xtask docs --update`.

Angles are in rad, signs follow ISO 8855; other units are in the names of the keys or in their descriptions.
"""

from __future__ import annotations

from typing import Any, Literal, Union

from ._record import Array, Record

InputKind = Literal[
    "steering",
    "steering*speed",
]
"""Input of the model."""

ManoeuvreKind = Literal[
    "multisine",
    "sweep",
    "slalom",
    "steps",
    "growing-slalom",
    "rising-angle",
]
"""The kind of a manoeuvre."""

EstimationFocus = Literal[
    "prediction",
    "simulation",
]
"""The errors that the estimate minimises."""

Grade = Literal[
    "pass",
    "warn",
    "fail",
]
"""The grade of a model or of one reason; later ones are worse."""

ManoeuvreGoal = Literal[
    "response",
    "understeer",
    "tyre-limit",
]
"""The quantity whose standard error a manoeuvre minimises."""

Intersample = Literal[
    "zoh",
    "foh",
    "bl",
]
"""The behaviour of a channel between its samples (the terms of MATLAB's `InterSample`)."""

FactorMethod = Literal[
    "gram",
    "qr",
]
"""A method to compute the R factor."""

ReasonCode = Literal[
    "not-validated",
    "weak-steering",
    "narrow-band",
    "noisy-yaw-rate",
    "low-validation-fit",
    "slow-log",
    "no-continuous-model",
    "model-error",
    "uncertain-gain",
    "unknown-gear",
    "uncertain-phase",
    "wrong-sign",
    "implausible-gain",
    "implausible-vehicle",
    "non-minimum-phase",
    "short-validation",
    "uninformative-validation",
    "spikes",
    "frozen-yaw-rate",
    "steering-play",
    "offset",
    "coarse-resolution",
    "early-yaw-rate",
    "late-yaw-rate",
    "age-of-fixes",
    "one-sided-turns",
    "unusual-parameter",
    "near-spin",
    "no-actuator",
    "missed-requirement",
    "not-robust",
    "no-brake",
]
"""The subject of a reason; its name in files is stable."""

LoopCoupling = Literal[
    "gauss-seidel",
    "jacobi",
]
"""The order of exchange between the FMUs of a loop."""

ProfileLimit = Literal[
    "speed",
    "lateral-acceleration",
    "acceleration",
    "deceleration",
    "jerk",
    "friction",
    "steering-angle",
    "steering-rate",
]
"""A limit of a speed profile."""

Information = Literal[
    "good",
    "weak",
    "none",
]
"""Whether a log is informative."""

SpeedRampKind = Literal[
    "yaw-steps",
    "constant-radius",
]
"""What the vehicle does while its speed changes."""


class Plant(Record):
    """The identified plant: model, operating point, noise, evidence and provenance. The model's input is
    `steering − steering_offset_rad` (times speed where `InputKind::SteeringTimesSpeed`), delayed by
    `input_delay_s`; its output is `yaw rate − yaw_rate_offset_radps`."""

    schema: str
    """`steerwright/plant/1`."""
    name: str
    """A name, such as the log's."""
    input: InputKind
    """Input of the model."""
    steering_ratio: float
    """Steering angle over road-wheel angle."""
    input_delay_s: float
    """Pure delay from steering angle to the model's input, in seconds."""
    operating_point: OperatingPoint
    """The point about which the model is valid."""
    discrete: Discrete
    """The model in innovation form (eq 3–5)."""
    continuous: Union[Continuous, None]
    """The continuous model (eq 6–11); absent if A has no real logarithm."""
    noise: Noise
    """The noise as identified."""
    sideslip: Union[Sideslip, None]
    """The sideslip; absent if the drive does not determine it."""
    uncertainty: Union[Uncertainty, None]
    """The uncertainty of the model; absent if it was not estimated."""
    evidence: Evidence
    """The evidence for the quality of the model."""
    quality: Union[Quality, None]
    """Whether a controller may be designed on the model."""
    provenance: Provenance
    """The sources of the file."""


class Bicycle(Record):
    """The five-state model of eq 13 at constant speed, with the vehicle data."""

    schema: str
    """`steerwright/bicycle/1`."""
    vehicle: VehicleData
    """The vehicle."""
    coefficients: BicycleCoefficients
    """The coefficients of eq 13."""
    state_matrix: Array
    """State matrix of eq 13 for (y, ẏ, ψ, ψ̇, δ), 5 by 5."""
    input_matrix: Array
    """Input matrix of eq 13, 5 by 1."""
    sideslip: Union[Sideslip, None]
    """The sideslip that the drive determines, which may differ from that of the model; absent if it
    determines none."""
    evidence: Union[BicycleEvidence, None]
    """The evidence for its quality, if it was identified from a log."""
    quality: Union[Quality, None]
    """Whether a controller may be designed on it."""
    provenance: Provenance
    """The sources of the file."""


class Vehicle(Record):
    """A vehicle up to its limits."""

    schema: str
    """`steerwright/vehicle/1`."""
    name: str
    """A name."""
    body: Body
    """Mass, inertia and dimensions."""
    tyres: Tyres
    """The tyres: equal at all wheels except for the stiffness."""
    actuator: SteeringActuator
    """The steering."""
    speed_mps: float
    """Longitudinal velocity that the `speed` input starts with, m/s."""
    sideslip: Union[Sideslip, None]
    """The sideslip that the drive determines, which may differ from that of the model; absent if it
    determines none."""
    evidence: Union[VehicleEvidence, None]
    """The evidence for its quality, if it was identified from a log."""
    quality: Union[Quality, None]
    """Whether a controller may be designed on it."""
    provenance: Union[Provenance, None]
    """The sources of the file, if it was identified from a log."""


class Torque(Record):
    """`a(t) = K·(u(t − d) − f·tanh(ω/ω0)) + ρ·g·sin(roll) + b`, with the lateral acceleration a, the
    command u, and the rate ω of the steering angle. Positive to the left, in the coordinates of the log."""

    schema: str
    """`steerwright/torque/1`."""
    name: str
    """A name, such as the log's."""
    command_unit: str
    """Unit of the command: `Nm`, or `1` for a normalised one."""
    acceleration_per_command: Estimate
    """K, lateral acceleration per command, m/s² per unit of the command."""
    friction: Estimate
    """f, command that overcomes the friction of the steering."""
    friction_rate_radps: float
    """ω0, rate of the steering angle at which friction reaches 76 % of f, rad/s in coordinates of the log."""
    roll_coefficient: Union[Estimate, None]
    """ρ, share of the gravity along the banked road that acts on the lateral acceleration; absent if the
    log has no roll."""
    offset_mps2: Estimate
    """b, lateral acceleration without command on a level road, m/s²."""
    delay_s: Estimate
    """d, delay from command to lateral acceleration, s."""
    covariance: Array
    """Covariance of (K, K·f, ρ, b, d), 5 by 5, in the units of these; zeros where ρ is absent."""
    evidence: TorqueEvidence
    """The evidence."""
    quality: Union[Quality, None]
    """Whether the model may be used."""
    provenance: Provenance
    """The sources of the file."""


class Longitudinal(Record):
    """`dv/dt = p + b − (c0 + c1·v + c2·v²) − ρ·g·sin(grade)`, with the speed v ≥ 0. The drive p follows
    `G(v)·u(t − d)` with the lag τ, where u is the accelerator from 0 to 1, curved by κ, or the
    acceleration command; b follows `−B·w(t − e)` with the lag σ, where w is the brake from 0 to 1."""

    schema: str
    """`steerwright/longitudinal/1`."""
    name: str
    """A name, such as the log's."""
    command_unit: str
    """Unit of the command u: `m/s2` of an acceleration command, or `1` of an accelerator."""
    gains: tuple[SpeedGain, ...]
    """G, table over the speed with increasing speeds, linear between them and constant beyond; one row
    where it does not depend on the speed."""
    gear_gains: Union[tuple[GearGain, ...], None]
    """G by the number of the gear, in place of `gains`, which then holds the mean of all gears as they were
    used; empty where the gear is not an input of the model."""
    pedal_curvature: Union[Estimate, None]
    """κ, curvature of the pedal: an accelerator a acts as `u = a + κ·a·(1 − a)`; absent where it is 0."""
    time_constant_s: Estimate
    """τ, lag of the drive, s."""
    delay_s: Estimate
    """d, delay of the command, s."""
    brake: Union[Brake, None]
    """The brake; absent where the log has none, or none that is used."""
    resistance_mps2: Estimate
    """c0, rolling resistance and drag of the engine, m/s²."""
    resistance_per_speed: Union[Estimate, None]
    """c1, 1/s; absent where it is 0."""
    drag_per_m: Estimate
    """c2, drag, 1/m."""
    grade_source: str
    """Origin of the grade: `grade`, `pitch` or `altitude` of the log, or `none`, where the grade is part of
    the disturbance."""
    grade_coefficient: Union[Estimate, None]
    """ρ, share of the gravity along the road that acts on the speed; absent where the log has no grade that
    varies, and then 1."""
    noise: LongitudinalNoise
    """The errors of the model and of the log."""
    parameters: tuple[str, ...]
    """The names of the rows of `covariance`."""
    covariance: Array
    """Covariance of the parameters, in the units of these."""
    evidence: LongitudinalEvidence
    """The evidence."""
    quality: Union[Quality, None]
    """Whether the model may be used."""
    provenance: Provenance
    """The sources of the file."""


class MultivariablePlant(Record):
    """The identified plant: model, operating point, noise, evidence and provenance. `x⁺ = A x + B (u −
    offset of u) + K e`, `y − offset of y = C x + D (u − offset of u) + e` (eq 3–5), each input delayed
    by its `delay_s`. All values are in the units of the channels."""

    schema: str
    """`steerwright/plant/2`."""
    name: str
    """A name, such as the log's."""
    inputs: tuple[PlantInput, ...]
    """The inputs u, in the order of the columns of B and D."""
    outputs: tuple[PlantOutput, ...]
    """The outputs y, in the order of the rows of C and D."""
    discrete: Discrete
    """The model in innovation form: A n by n, B n by nu, C ny by n, D ny by nu, K n by ny."""
    continuous: Union[Continuous, None]
    """The continuous model (eq 6–11): F n by n, G n by nu, H ny by n; absent if A has no real logarithm."""
    innovation_covariance: Array
    """Covariance of the innovation e, ny by ny, in the products of the outputs' units."""
    uncertainty: Union[MultivariableUncertainty, None]
    """The uncertainty of the model; absent if it was not estimated."""
    evidence: MultivariableEvidence
    """The evidence for the quality of the model."""
    quality: Union[Quality, None]
    """Whether the model may be used."""
    provenance: Provenance
    """The sources of the file."""


class Pid(Record):
    """The controller, its specification, and the results of its design."""

    schema: str
    """`steerwright/pid/1`."""
    name: str
    """A name."""
    sample_time_s: float
    """Sample time, s."""
    gains: PidGains
    """Gains and weights."""
    limits: Limits
    """Limits in steering coordinates."""
    designed_for: DesignedFor
    """The model that the controller was designed on."""
    specification: Specification
    """The specification."""
    evidence: DesignEvidence
    """The results of the design."""
    guidance: GuidanceAdvice
    """Recommended settings of a path follower around this loop."""
    schedule: Union[tuple[ScheduleEntry, ...], None]
    """Gains and guidance over speed, at increasing speeds; linear between them and constant beyond the
    ends. Empty or omitted if those above hold at every speed."""
    provenance: Provenance
    """The sources of the file."""


class SpeedController(Record):
    """The controller, its specification, the results of its design, and the model that it inverts."""

    schema: str
    """`steerwright/speed-controller/1`."""
    name: str
    """A name."""
    sample_time_s: float
    """Sample time, s."""
    gains: SpeedGains
    """Gains."""
    limits: SpeedLimits
    """Limits and thresholds."""
    specification: SpeedSpecification
    """The specification."""
    evidence: SpeedEvidence
    """The results of the design."""
    quality: Union[Quality, None]
    """Whether the controller may be used: the quality of the model, and of the design."""
    model: Longitudinal
    """The model that the controller was designed on, and that its feedforward inverts."""
    provenance: Provenance
    """The sources of the file."""


class Path(Record):
    """A reference path: points in arc length, x and y in a local plane."""

    schema: str
    """`steerwright/path/1`."""
    name: str
    """A name."""
    closed: bool
    """Whether the last point meets the first."""
    guidance: Guidance
    """The guidance of a vehicle along it."""
    schedule: Union[tuple[GuidanceEntry, ...], None]
    """Parameters of the guidance over speed, at increasing speeds; linear between them and constant beyond
    the ends. Empty or omitted if those of `guidance` hold at every speed."""
    speed_mps: float
    """The speed for which the path was computed, m/s."""
    points: tuple[PathPoint, ...]
    """At least two, at increasing distance."""
    profile: Union[SpeedProfile, None]
    """The speed along it; absent if it is driven at `speed_mps`."""
    provenance: Provenance
    """The sources of the file."""


class Manoeuvre(Record):
    """A steering manoeuvre for an identification: its signals, when each is driven, and what it determines.
    Angles are those of the log that the model is from: at the steering wheel where `steering_ratio` is
    that of a steering wheel."""

    schema: str
    """`steerwright/excitation/1`."""
    name: str
    """The name of the vehicle or of its log."""
    kind: ManoeuvreKind
    """The kind of its signals."""
    purpose: ManoeuvrePurpose
    """What is to be known."""
    limits: ManoeuvreLimits
    """The limits that it keeps."""
    noise_density: float
    """Spectral density of the errors of the yaw rate that is assumed, (rad/s)²/Hz, two-sided."""
    estimation_share: float
    """Share of the recording that estimates; the rest validates."""
    steering_ratio: float
    """Steering angle over road-wheel angle."""
    sample_time_s: float
    """Time from one sample of the signals to the next, s; each is held."""
    block_s: float
    """Length of a block, s: a signal, and straight driving up to the next."""
    schedule: tuple[ManoeuvreBlock, ...]
    """The blocks in the order to drive."""
    signals: tuple[SteeringSignal, ...]
    """The signals of the blocks."""
    expected: ExpectedErrors
    """What the recording determines."""
    alternatives: tuple[Alternative, ...]
    """The best manoeuvre of each kind."""
    quality: Union[Quality, None]
    """The quality of the model that it was designed on."""
    provenance: Provenance
    """The sources of the file."""


class Estimator(Record):
    """Sensors, their noise, and the initial uncertainty."""

    schema: str
    """`steerwright/estimator/1`."""
    name: str
    """A name."""
    gnss: Gnss
    """The receiver and its antenna."""
    sideslip_per_yaw_rate_s: float
    """Sideslip angle per yaw rate in a steady turn, s; at small lateral acceleration if the growth is
    stated."""
    sideslip_growth_s5pm2: Union[float, None]
    """Growth of the sideslip per yaw rate, per squared lateral acceleration, s⁵/m²; 0 or omitted if
    unknown."""
    sideslip_per_yaw_acceleration_s2: Union[float, None]
    """Sideslip angle per yaw acceleration, s²; 0 may be omitted."""
    distance_rear_m: Union[float, None]
    """Distance from centre of gravity to rear axle, m, by which the sideslip follows the speed from that at
    `speed_mps`; 0 or omitted if unknown, which keeps the sideslip per yaw rate at all speeds."""
    noise: SensorNoise
    """Noise of gyro and speed."""
    initial: InitialUncertainty
    """Uncertainty of the initial state."""
    speed_mps: float
    """Longitudinal velocity that the `speed` input starts with, and at which the sideslip is stated, m/s."""


class Start(Record):
    """Start values of Real parameters and inputs, by name, in the variables' units."""

    schema: str
    """`steerwright/start/1`."""
    values: dict[str, Any]
    """A value for each variable."""


class AccumulatedDrives(Record):
    """The windows of accumulated drives."""

    schema: str
    """`steerwright/factor/2`."""
    name: str
    """A name, such as the first log's."""
    input: InputKind
    """Input of the model."""
    steering_ratio: float
    """Steering angle over road-wheel angle."""
    sample_time_s: float
    """Sample time T."""
    horizon: int
    """Block rows of past and of future."""
    estimation_samples: int
    """Samples to estimate from."""
    validation_samples: int
    """Number of validation samples."""
    speed: Union[AccumulatedSpeed, None]
    """The speed over all samples, if every drive has one."""
    channels: tuple[ChannelSummary, ...]
    """The channels of the logs; drives with equal columns are combined."""
    warnings: tuple[str, ...]
    """Warnings of the log reader."""
    provenance: Provenance
    """The sources of the file."""
    estimation: str
    """State of the estimation data's windows, in hexadecimal."""
    validation: str
    """State of the validation data's windows, in hexadecimal."""
    spectra: Array
    """Sums of Welch's spectra of all samples: number of windows, variance of their average, then \\|U\\|²,
    \\|Y\\|² and the parts of U*Y at each frequency."""
    sha256: str
    """SHA-256 of this file with an empty string in this place."""


class OperatingPoint(Record):
    """The point about which the model is linear."""

    speed_mps: float
    """Mean speed of the drive, m/s."""
    steering_offset_rad: float
    """The steering angle that drives straight, in steering coordinates."""
    yaw_rate_offset_radps: float
    """The yaw rate at that angle; zero if the model has a steady-state gain, by which the steering offset
    then represents it."""


class Discrete(Record):
    """`x⁺ = A x + B u + K e`, `y = C x + D u + e` (eq 3–5)."""

    sample_time_s: float
    """Sample time T."""
    A: Array
    """State matrix, n by n."""
    B: Array
    """Input matrix, n by 1."""
    C: Array
    """Output matrix, 1 by n."""
    D: Array
    """Feedthrough, 1 by 1."""
    K: Array
    """Kalman gain, n by 1."""
    x0: Array
    """State at the log's first sample."""


class Continuous(Record):
    """`ẋ = F x + G u`, `y = H x + D u` (eq 6–8), the exact zero-order-hold inverse of `Discrete`."""

    F: Array
    """State matrix, n by n."""
    G: Array
    """Input matrix, n by 1."""
    H: Array
    """Output matrix, 1 by n."""


class Noise(Record):
    """The noise as identified."""

    innovation_variance: float
    """Variance of the innovation e, (rad/s)²."""


class Sideslip(Record):
    """The sideslip of the centre of gravity, from the course of GNSS fixes: with the yaw rate r and the
    lateral acceleration `a = v·r`, course minus yaw is `(S + Q·a²)·r + C·dr/dt` at a speed. With the
    distance b to the rear axle, `S = b/v − κ·v` at all speeds v."""

    speed_mps: Union[float, None]
    """The speed at which it is stated, m/s; absent in plants of former versions, which state it at their
    operating point."""
    sideslip_per_yaw_rate_s: float
    """S, sideslip angle per yaw rate, s: in gentle turns if the growth is stated, else the mean over the
    drive's turns."""
    standard_error_s: float
    """Its standard error, s, from the noise of the fixes and the gyro, and from the age of the fixes if
    that is estimated."""
    sideslip_growth_s5pm2: Union[SideslipTerm, None]
    """Q, the growth of S per squared lateral acceleration, s⁵/m²; absent if the drive does not determine
    it."""
    sideslip_per_yaw_acceleration_s2: Union[SideslipTerm, None]
    """C, sideslip angle per yaw acceleration, s²; absent if the drive does not determine it."""
    distance_rear_m: Union[SideslipTerm, None]
    """b, distance from centre of gravity to rear axle, m; absent if the drive does not determine it, by too
    little change of its speed."""
    gnss_latency_s: float
    """The assumed age of a fix, s: an error of it is an error of the sideslip."""
    gnss_latency_standard_error_s: Union[float, None]
    """The standard error of that age, s; absent if the age was stated."""
    antenna_x_m: float
    """The assumed position of the antenna ahead of the centre of gravity, m."""


class Uncertainty(Record):
    """The uncertainty of an identified plant's model."""

    focus: EstimationFocus
    """The errors that the estimate minimises, which determines the covariance."""
    poles: tuple[UncertainPole, ...]
    """The eigenvalues of A."""
    steady_state_gain: Union[Estimate, None]
    """Yaw rate over the model's input at rest; absent for an integrator."""
    frequency_response: tuple[FrequencyBand, ...]
    """From the model's input to yaw rate, without the input delay."""
    step_response: tuple[StepBand, ...]
    """Yaw rate after a unit step of the model's input, without the input delay."""
    open_hold_s: Union[float, None]
    """Period of the steering in the log, s, where it is not known whether the steering is held between its
    samples: the standard errors of `frequency_response` then also cover the other case, in phase by half
    a period or more. Absent where it is known, and in files of earlier versions."""
    directions: Array
    """The covariance factor, with one row for each independent standard normal number ξ: the change of the
    entries of A, B, C, D, K, each row by row, for ξ = 1. A model drawn from the estimate's distribution
    is `nominal + Σ ξ_i · row_i`. Changes of the state's basis only are left out."""


class Evidence(Record):
    """The evidence for the quality of an identified model."""

    method: str
    """`n4sid`, `moesp`, `cva`, `ssarx` or `pbsid`."""
    horizon: int
    """Block rows s of the Hankel matrices (past and future horizon)."""
    factor: Union[DataFactor, None]
    """How the data were reduced, and how well that is conditioned."""
    delay: Union[DelayEstimate, None]
    """Estimate of a pure delay; absent where the delay was stated or cannot be estimated."""
    held_for: Union[Continuous, None]
    """The vehicle, without a delay, for which the steering was held over each sample; absent where it was
    held as it was read, and in files of earlier versions."""
    estimation_samples: int
    """Samples used for estimation."""
    validation_samples: int
    """Number of validation samples."""
    fit: Fits
    """Fits in percent."""
    order_table: tuple[OrderRow, ...]
    """One row for each order tried."""
    feedback: Union[ResidualTest, None]
    """Test of the estimation data for feedback from yaw rate to steering, which decides between open-loop
    and closed-loop methods; it passes where none is seen."""
    whiteness: ResidualTest
    """Autocorrelation of the one-step residuals on validation data."""
    independence: ResidualTest
    """Cross-correlation of past input and one-step residuals on validation data."""
    excitation: Excitation
    """Information in the log."""
    held_out: Union[HeldOut, None]
    """Prediction of the validation data."""
    play: Union[SteeringPlay, None]
    """Play of the steering; absent if the data do not show any."""
    actuator: Union[IdentifiedActuator, None]
    """The actuator behind the steering command beside the measured angle; absent where no such command was
    read."""
    yaw_rate_lead_s: Union[float, None]
    """Least lead of the yaw rate before the steering that causes it, s; absent if it does not lead."""
    yaw_rate_lag_s: Union[float, None]
    """Lag of the yaw rate behind the steering beyond the lag of tyres and an actuator, s; absent if it is
    no more than a vehicle's."""
    residuals: Union[ResidualCorrelation, None]
    """The residuals lag by lag."""
    frequency_response: Union[FrequencyResponse, None]
    """Measured and modelled frequency response."""
    poles_and_zeros: Union[PoleZeroMap, None]
    """Poles and zeros."""
    stabilised_from: Union[float, None]
    """Largest eigenvalue modulus of A before stability was enforced; absent if it was stable."""
    conversion_round_trip: Union[float, None]
    """Relative error ‖exp(F·T) − A‖/‖A‖ and the same for B, the larger (eq 9–10)."""
    channels: tuple[ChannelSummary, ...]
    """The channels of the log, after resampling."""
    warnings: tuple[str, ...]
    """Warnings of the log reader and of the identification."""


class Quality(Record):
    """The quality of a model."""

    grade: Grade
    """The worst grade of the reasons; `pass` without any."""
    summary: str
    """One or two sentences."""
    reasons: Union[tuple[Reason, ...], None]
    """The reasons for the grade, the worst first."""
    remarks: Union[tuple[str, ...], None]
    """Limits of the model and of the log that cause no reason."""
    advice: Union[tuple[str, ...], None]
    """What to do next, such as the manoeuvre to drive."""


class Provenance(Record):
    """The sources and options of a file; without times and absolute paths."""

    version: str
    """Version of steerwright that wrote the file."""
    sources: tuple[SourceFile, ...]
    """The files read, by name and content."""
    options: dict[str, Any]
    """The options in force, defaults included, by name."""


class VehicleData(Record):
    """Vehicle data (also the TOML that `steerwright bicycle` reads)."""

    name: str
    """A name."""
    mass_kg: float
    """Mass m, kg."""
    yaw_inertia_kgm2: float
    """Yaw inertia J, kg·m²."""
    distance_front_m: float
    """Centre of gravity to front axle L_f, m."""
    distance_rear_m: float
    """Centre of gravity to rear axle L_r, m."""
    cornering_stiffness_front_npr: float
    """Cornering stiffness of the front axle C_f, N/rad."""
    cornering_stiffness_rear_npr: float
    """Cornering stiffness of the rear axle C_r, N/rad."""
    actuator_time_constant_s: float
    """Time constant of the steering actuator T_n, s."""
    actuator_delay_s: Union[float, None]
    """Pure delay of the steering angle before the actuator, s; 0 if omitted."""
    actuator_rate_max_radps: Union[float, None]
    """Largest rate of the road wheels, rad/s; beyond that of any drive if omitted."""
    steering_ratio: float
    """Steering angle over road-wheel angle, 1/n."""
    speed_mps: float
    """Longitudinal velocity V, m/s."""


class BicycleCoefficients(Record):
    """The coefficients of eq 13 in the paper's letters."""

    A1: float
    """"""
    A2: float
    """"""
    A3: float
    """"""
    A4: float
    """"""
    B1: float
    """"""
    B2: float
    """"""
    n: float
    """"""
    Tn: float
    """"""


class BicycleEvidence(Record):
    """The results of the identification of a bicycle from a log. Fit is 100·(1 − ‖y − ŷ‖/‖y − mean(y)‖) on
    yaw rate, in percent, of a simulation over the recorded steering and speed with the estimated
    offsets; the initial state is estimated at the start of each part."""

    estimation_samples: int
    """Samples used for estimation."""
    validation_samples: int
    """Number of validation samples."""
    sample_time_s: float
    """Sample time, s."""
    held_for: Union[Continuous, None]
    """The linear vehicle, without a delay, for which the steering was held over each sample; absent where
    it was held as it was read, and in files of earlier versions."""
    open_hold_s: Union[float, None]
    """Period of the steering, s, where the data do not determine whether it is held between its samples."""
    estimation_fit: float
    """Fit on the estimation data, percent."""
    validation_fit: float
    """Fit on validation data, percent."""
    held_out: Union[HeldOut, None]
    """Selection of the validation data, and the fit there."""
    speed: SpeedSummary
    """Speed over the estimation data."""
    identified: tuple[Estimated, ...]
    """The quantities that the yaw rate identifies; angles are of the road wheel, by the log's steering
    ratio."""
    directions: Union[tuple[VehicleDirection, ...], None]
    """The covariance factor of the vehicle's data: one standard deviation along each independent axis of
    the identified quantities. Empty if not stated."""
    stated: tuple[Stated, ...]
    """Parameters that the yaw rate does not determine, with the origin of their values."""
    steering_offset_rad: float
    """Steering angle that drives straight, rad, in the log's coordinates. The plant has none."""
    largest_steering_rate_radps: Union[float, None]
    """Fastest steering of the log, rad/s in its coordinates, by `Excitation::largest_rate`."""
    yaw_rate_offset_radps: float
    """Offset of the yaw rate's sensor, rad/s. The plant has none."""
    with_delay: WithDelay
    """The model with a delay of the steering, which is that of the file if the delay is determined and
    positive."""
    actuator: Union[IdentifiedActuator, None]
    """The actuator behind the steering command beside the measured angle; absent where no such command was
    read."""
    error_correlation_time_s: float
    """How long the simulation errors last, s: their long-run variance over their variance, by the sample
    time. The standard errors count with it."""
    error_std_radps: Union[float, None]
    """Standard deviation of the simulation errors on the estimation data, rad/s; absent in files of earlier
    versions."""
    channels: tuple[ChannelSummary, ...]
    """The channels of the log, after resampling."""
    warnings: tuple[str, ...]
    """Warnings of the log reader and of the identification."""


class Body(Record):
    """Mass, inertia and dimensions."""

    mass_kg: float
    """Mass m, kg."""
    yaw_inertia_kgm2: float
    """Yaw inertia J, kg·m²."""
    distance_front_m: float
    """Centre of gravity to front axle L_f, m."""
    distance_rear_m: float
    """Centre of gravity to rear axle L_r, m."""
    centre_of_gravity_height_m: float
    """Height of the centre of gravity h, m."""
    track_width_m: float
    """Left to right wheel, m."""
    roll_stiffness_front: float
    """Share of the front axle in the roll stiffness, 0 to 1."""
    roll_time_constant_s: float
    """Time constant of the load transfer, s."""
    drive_share_front: Union[float, None]
    """Share of the front axle in the driving force, 0 to 1; 0.5 where it is not stated."""
    brake_share_front: Union[float, None]
    """Share of the front axle in the braking force, 0 to 1; 0.65 where it is not stated."""
    side_force_area_m2: Union[float, None]
    """Area in a crosswind, m²: force to the side over dynamic pressure and angle of the air, rad; 0 where
    it is not stated: the wind then has no effect."""
    side_force_arm_m: Union[float, None]
    """How far ahead of the centre of gravity that force acts, m, negative behind; 0 where it is not stated."""


class Tyres(Record):
    """Tyres by the magic formula."""

    cornering_stiffness_front_npr: float
    """Cornering stiffness of the front axle at the static load, N/rad."""
    cornering_stiffness_rear_npr: float
    """Cornering stiffness of the rear axle at the static load, N/rad."""
    friction_coefficient: float
    """Peak lateral force over load at the static wheel load, of the front axle."""
    friction_balance_rear: Union[float, None]
    """That of the rear axle over that of the front axle; 1 where it is not stated."""
    shape_factor: float
    """C of the magic formula, 1 to 1.99."""
    curvature_factor: float
    """E of the magic formula, −1.5 to 1."""
    friction_load_sensitivity: float
    """Relative loss of friction at twice the static wheel load, 0 to 0.9."""
    stiffness_load_sensitivity: float
    """Relative loss of stiffness over load at twice the static wheel load, 0 to 0.9."""
    combined_slip: Union[float, None]
    """Share of the driving and braking force that the friction bears beside the lateral force, 0 to 1; 0
    where it is not stated: the lateral force is then that of wheels that roll freely."""


class SteeringActuator(Record):
    """The actuator of the road wheels."""

    steering_ratio: float
    """Steering angle over road-wheel angle."""
    time_constant_s: float
    """Time constant, s."""
    delay_s: float
    """Pure delay before it, s."""
    road_wheel_rate_max_radps: float
    """Largest rate of the road-wheel angle, rad/s."""
    road_wheel_angle_max_rad: float
    """Largest road-wheel angle to either side, rad."""
    play_rad: Union[float, None]
    """Play between actuator and road wheels from stop to stop, rad at the road wheel; 0 where it is not
    stated."""


class VehicleEvidence(Record):
    """The results of the identification of a vehicle from a log, by the single-track model of
    docs/methods/single-track.md."""

    channels: tuple[ChannelSummary, ...]
    """The channels of the log, after resampling."""
    estimation_samples: int
    """Samples used for estimation."""
    validation_samples: int
    """Number of validation samples."""
    sample_time_s: float
    """Sample time, s."""
    speed: SpeedSummary
    """Speed over the estimation data."""
    lateral_acceleration_mps2: float
    """Largest lateral acceleration of the estimation data, m/s²: its 99th percentile, from yaw rate times
    speed."""
    fitted: tuple[str, ...]
    """Roles of the channels that were fitted."""
    open_hold_s: Union[float, None]
    """Period of the steering, s, where the data do not determine whether it is held between its samples."""
    estimation: SimulationFit
    """Free simulation of the estimation data."""
    validation: Union[SimulationFit, None]
    """Free simulation of the validation data."""
    parameters: tuple[VehicleParameter, ...]
    """The parameters in the order of the covariance."""
    covariance: Array
    """Covariance of the parameters' coordinates; zero for those that are stated."""
    directions: tuple[VehicleDirection, ...]
    """The covariance factor of the vehicle's data in gentle driving: one standard deviation along each
    independent axis of the parameters that these depend on."""
    largest_steering_rate_radps: float
    """Fastest steering of the log, rad/s in its coordinates, by `Excitation::largest_rate`."""
    actuator: Union[IdentifiedActuator, None]
    """The actuator behind the steering command beside the measured angle; absent where no such command was
    read."""
    spin_margin: float
    """How much less friction the rear axle can have, relative, before the free simulation of estimation or
    validation data spins: at most 0.2, in steps of 0.005 near 0."""
    yaw_rate_noise_density: Union[float, None]
    """Spectral density of the errors of the yaw rate by which it was weighted, (rad/s)²/Hz, two-sided: the
    largest from 0 to 2 Hz."""
    warnings: tuple[str, ...]
    """Warnings of the log reader and of the identification."""


class Estimate(Record):
    """A number with its standard error."""

    value: float
    """The estimate."""
    standard_error: float
    """Its standard deviation."""


class TorqueEvidence(Record):
    """The data of a torque model, and its errors."""

    channels: tuple[ChannelSummary, ...]
    """What was read from each column."""
    estimation_samples: int
    """Number of estimation samples."""
    validation_samples: int
    """Number of validation samples."""
    sample_time_s: float
    """Sample time, s."""
    blocks: int
    """Number of blocks of time whose sums of errors determine the covariance."""
    least_speed_mps: float
    """Lowest speed of the samples, m/s."""
    mean_speed_mps: float
    """Mean speed of the estimation samples, m/s."""
    error_mps2: float
    """Standard deviation of the errors on the estimation data, m/s²."""
    estimation_fit: float
    """Fit on the estimation data, percent."""
    validation_fit: float
    """Fit on validation data, percent."""
    warnings: tuple[str, ...]
    """Warnings of the reader."""


class SpeedGain(Record):
    """The gain at a speed."""

    speed_mps: float
    """Speed, m/s."""
    gain: Estimate
    """Acceleration per command, m/s² per unit of the command."""


class GearGain(Record):
    """The gain in a gear."""

    gear: int
    """Number of the gear, as the log has it."""
    gain: Estimate
    """Acceleration per command, m/s² per unit of the command."""


class Brake(Record):
    """The response to the brake."""

    gain_mps2: Estimate
    """B, deceleration at a brake of 1, m/s²."""
    time_constant_s: Estimate
    """σ, lag of the brake, s."""
    delay_s: Estimate
    """e, delay of the brake, s."""


class LongitudinalNoise(Record):
    """The errors of a longitudinal model: the speed in the log is that of the vehicle and white noise, and
    the acceleration that of the model and a disturbance, such as an unknown grade and wind, that decays
    exponentially."""

    speed_mps: float
    """Standard deviation of the noise of the speed, m/s."""
    disturbance_mps2: float
    """Standard deviation of the disturbance, m/s²."""
    disturbance_time_constant_s: float
    """Time constant of the disturbance, s."""


class LongitudinalEvidence(Record):
    """The data of a longitudinal model, and its errors."""

    channels: tuple[ChannelSummary, ...]
    """What was read from each column."""
    gain_variation: Union[GainVariation, None]
    """How far the gain varies at one speed; absent in files of earlier versions."""
    estimation_samples: int
    """Number of estimation samples."""
    validation_samples: int
    """Number of validation samples."""
    sample_time_s: float
    """Sample time, s."""
    least_speed_mps: float
    """Lowest speed of the samples, m/s."""
    speed_mps: Array
    """Smallest, mean and largest speed of the estimation samples, m/s."""
    window_s: float
    """Length of the windows that are simulated, each from an estimated initial speed, s."""
    estimation_fit: float
    """Fit of the simulated speed to the change of the speed in the windows of the estimation data, percent."""
    validation_fit: float
    """The same of the validation data, percent."""
    validation_fit_standard_error: Union[float, None]
    """Standard error of the fit on validation data, percent; absent below 8 windows."""
    validation_windows: int
    """Number of windows of the validation data."""
    prediction_error_ratio: float
    """Standard deviation of the one-step prediction errors on the validation data over that which the noise
    model states: 1 where they agree."""
    residual_correlation: Array
    """Largest autocorrelation of the one-step prediction errors at lags up to 1 s, and largest correlation
    with the command at lags within 2 s."""
    correlation_standard_error: float
    """Standard deviation of a correlation of white errors."""
    warnings: tuple[str, ...]
    """Warnings of the reader and of the identification."""


class PlantInput(Record):
    """An input of the plant."""

    name: str
    """Name: letters, digits and `_`, unlike that of any other channel of the plant."""
    column: str
    """The channel in the log."""
    unit: str
    """Unit, such as `V`; `1` without one."""
    offset: float
    """The value about which the model is linear."""
    standard_deviation: float
    """Standard deviation in the estimation data."""
    delay_s: float
    """Pure delay of the input, a whole number of samples, s."""


class PlantOutput(Record):
    """An output of the plant."""

    name: str
    """Name: letters, digits and `_`, unlike that of any other channel of the plant."""
    column: str
    """The channel in the log."""
    unit: str
    """Unit, such as `degC`; `1` without one."""
    offset: float
    """The value about which the model is linear."""
    standard_deviation: float
    """Standard deviation in the estimation data."""


class MultivariableUncertainty(Record):
    """The uncertainty of the model; standard errors are one standard deviation, to first order."""

    focus: EstimationFocus
    """The errors that the estimate minimises, which determines the covariance."""
    poles: tuple[UncertainPole, ...]
    """The eigenvalues of A."""
    directions: Array
    """The covariance factor, with one row for each independent standard normal number ξ: the change of the
    entries of A, B, C, D, K, each row by row, for ξ = 1. Changes of the state's basis only are left out."""


class MultivariableEvidence(Record):
    """The evidence for the quality of the model."""

    method: str
    """`n4sid`, `moesp`, `cva`, `ssarx` or `pbsid`: the method of the initial estimate."""
    horizon: int
    """Block rows s of the Hankel matrices (past and future horizon)."""
    estimation_samples: int
    """Number of estimation samples."""
    validation_samples: int
    """Number of validation samples."""
    fit: Fits
    """Fits of all outputs together, each in units of its standard deviation, percent."""
    outputs: tuple[OutputEvidence, ...]
    """The evidence of each output."""
    pairs: tuple[PairEvidence, ...]
    """The evidence of each pair: of the first output all inputs, then of the second."""
    order_table: tuple[OrderRow, ...]
    """One row for each order tried."""
    feedback: Union[ResidualTest, None]
    """Test of the estimation data for feedback from outputs to inputs; it passes where none is seen. Absent
    where the data are too few for it."""
    stabilised_from: Union[float, None]
    """Largest eigenvalue modulus of A before stability was enforced; absent if it was stable."""
    conversion_round_trip: Union[float, None]
    """Relative error ‖exp(F·T) − A‖/‖A‖ and the same for B, the larger (eq 9–10)."""
    channels: tuple[ChannelSummary, ...]
    """The channels of the log."""
    warnings: tuple[str, ...]
    """Warnings of the log reader and of the identification."""


class PidGains(Record):
    """Gains of `K(s) = Kp + Ki/s + Kd·s` (eq 14), parallel form, with setpoint weights and filter."""

    kp: float
    """Kp, steering angle per yaw error."""
    ki: float
    """Ki, 1/s."""
    kd: float
    """Kd, s."""
    derivative_filter_time_s: float
    """Time constant of the derivative filter, s."""
    setpoint_weight_proportional: float
    """Weight of the reference in the proportional action."""
    setpoint_weight_derivative: float
    """Weight of the reference in the derivative action."""
    anti_windup_time_s: float
    """Time constant of the anti-windup back-calculation, s."""


class Limits(Record):
    """Limits of the steering angle, in steering coordinates, and of the yaw error."""

    max_angle_rad: float
    """Largest angle to either side, rad."""
    max_increment_rad: float
    """Largest change in one sample, rad."""
    max_rate_radps: float
    """Largest rate, rad/s."""
    large_errors: Union[LargeErrors, None]
    """The limits for large yaw errors; absent if the controller acts on them directly."""
    lateral_acceleration: Union[LateralAcceleration, None]
    """The largest angle by speed; absent if it is the same at every speed."""


class DesignedFor(Record):
    """The model and the loop that the controller was designed for."""

    model: str
    """`plant` (identified) or `bicycle`."""
    name: str
    """The model's name."""
    sha256: str
    """SHA-256 of the model's file."""
    speed_mps: float
    """Speed, m/s."""
    steering_ratio: float
    """Steering angle over road-wheel angle."""
    loop_delay_s: float
    """Delay of the yaw loop beyond the model's own, s (0 under a Gauss–Seidel coupling)."""
    path_delay_s: Union[float, None]
    """Delay of the loop through the path beyond the model's own, s."""
    estimator_delay_s: Union[float, None]
    """Delay of the loop through pose estimator and path beyond the model's own, s."""
    actuator: Union[StatedActuator, None]
    """The actuator before the model; absent where the model has its own, and in files of earlier versions."""
    quality: Union[Quality, None]
    """The quality of the model."""


class Specification(Record):
    """The specification. Every requirement is optional; the other fields define the test it refers to."""

    overshoot_percent: Union[float, None]
    """Largest overshoot, percent of the step."""
    settling_time_s: Union[float, None]
    """Longest settling time, s."""
    steady_state_error_percent: Union[float, None]
    """Largest steady-state error, percent of the step: on the step, with the steering offset, and on the
    curve."""
    rise_time_s: Union[float, None]
    """Longest rise time, 10 to 90 %, s."""
    integral_absolute_error_s: Union[float, None]
    """Largest integral of absolute error over the step's height, s."""
    gain_margin_db: Union[float, None]
    """Smallest gain margin, dB."""
    phase_margin_deg: Union[float, None]
    """Smallest phase margin, degrees."""
    modulus_margin: Union[float, None]
    """Smallest modulus margin."""
    delay_margin_s: Union[float, None]
    """Smallest delay margin, s."""
    disk_margin: Union[float, None]
    """Smallest disk margin, with zero skew."""
    settling_band_percent: Union[float, None]
    """Band within which the response has settled, percent of the step to either side."""
    step_rad: float
    """Height of the step, rad."""
    steering_offset_rad: float
    """Steering offset of the second step, rad at the road wheel; at a speed at which the steering is
    limited to little more, 0.8 of that limit."""
    steady_state_time_s: float
    """When the steady-state error is read, s after the step."""
    curve_lateral_acceleration_mps2: Union[float, None]
    """Lateral acceleration on the curve of constant curvature, m/s²."""


class DesignEvidence(Record):
    """The results of the design."""

    met: bool
    """Whether every requirement is met on the model it was designed on."""
    shortfalls: tuple[Shortfall, ...]
    """Each unmet requirement with its shortfall."""
    advice: Union[tuple[str, ...], None]
    """Remarks, such as the requirement that makes another one infeasible."""
    step: StepMetrics
    """On the step of the specification."""
    step_with_offset: StepMetrics
    """On the same step with the steering offset."""
    small_step: Union[StepMetrics, None]
    """On a tenth of the step, where the limits act less: a design target like the step, so that the
    overshoot is not small because of a limit, but not a requirement."""
    without_limits: Union[StepMetrics, None]
    """The step by linear theory, without limits."""
    curve: Union[OnACurve, None]
    """On the curve of constant curvature, with the advised feedforward and preview."""
    fmu_loops: Union[tuple[FmuLoop, ...], None]
    """In the loop of the packed FMUs."""
    steps: Union[tuple[HeightStep, ...], None]
    """Steps of other heights on the model designed on, with the limits."""
    engagement: Union[Engagement, None]
    """The offsets from which the loop returns to a straight path."""
    margins: Margins
    """Margins of the linear sampled loop, broken at the plant's input."""
    robustness: Union[Robustness, None]
    """For the plants within the uncertainty, other latencies and other speeds."""
    trade_off: Union[tuple[TradeOff, ...], None]
    """The shortest settling time at each modulus margin, with the other requirements met."""
    over_speed: Union[OverSpeed, None]
    """The controller over its range of speeds; absent for one set of gains."""


class GuidanceAdvice(Record):
    """Recommended settings of a path follower around this loop."""

    feedforward_gain_radm: float
    """Steering angle per path curvature, rad·m, in addition to the steering that the previewed yaw
    reference causes. It is not the whole steering of a steady turn, so use it together with the preview."""
    preview_time_s: float
    """Time by which the closed loop lags a yaw ramp, kp·(1 − b)/ki, s."""
    yaw_acceleration_gain_s2: Union[float, None]
    """Gain from the path's yaw acceleration to the yaw reference, s²; part of the feedforward. 0 may be
    omitted."""
    yaw_jerk_gain_s3: Union[float, None]
    """Gain from the path's yaw jerk to the yaw reference, s³. 0 may be omitted."""


class ScheduleEntry(Record):
    """The controller at one speed."""

    speed_mps: float
    """Speed, m/s."""
    gains: PidGains
    """Gains and weights."""
    yaw_rate_lag_s: Union[float, None]
    """Lag of the yaw rate, s, instead of that in `limits.large_errors`; absent if that holds."""
    rate_reserve_time_s: Union[float, None]
    """Reserve of time at the largest rate, s, instead of that in `limits.large_errors`; absent if that
    holds."""
    guidance: GuidanceAdvice
    """Recommended settings of a path follower around this loop."""


class SpeedGains(Record):
    """Gains of a speed controller."""

    kp_per_s: float
    """Proportional gain, acceleration per error of the speed, 1/s."""
    ki_per_s2: float
    """Integral gain, 1/s²."""
    reference_rate_per_s: float
    """Rate at which the reference model approaches the speed reference, 1/s."""


class SpeedLimits(Record):
    """Limits and thresholds of a speed controller."""

    max_acceleration_mps2: float
    """Largest acceleration, m/s²."""
    max_deceleration_mps2: float
    """Largest deceleration, m/s²."""
    max_jerk_mps3: float
    """Largest jerk to either side, m/s³."""
    pedal_hysteresis_mps2: float
    """Demand beyond 0 at which the other pedal is used, m/s²."""
    hold_speed_mps: float
    """Speed below which the vehicle is held where the speed reference is 0, m/s; the brake is released from
    this reference on."""
    hold_deceleration_mps2: float
    """Deceleration of the held brake in addition to that which the grade requires, m/s²."""


class SpeedSpecification(Record):
    """The specification of a speed controller. Every requirement is optional; the other fields define the
    test it refers to."""

    overshoot_percent: Union[float, None]
    """Largest overshoot, percent of the step."""
    settling_time_s: Union[float, None]
    """Longest settling time, s."""
    steady_state_error_percent: Union[float, None]
    """Largest steady-state error, percent of the step: on the step, and on the grade."""
    settling_band_percent: float
    """Band within which the response has settled, percent of the step to either side."""
    step_mps: float
    """Height of the step of the speed, m/s."""
    grade_percent: float
    """Grade that begins at once and is not measured, percent."""
    steady_state_time_s: float
    """When the steady-state error is read, s after the step or the beginning of the grade."""
    speeds_mps: Array
    """Lowest and highest speed of the design, m/s."""


class SpeedEvidence(Record):
    """The results of the design of a speed controller."""

    met: bool
    """Whether the nominal model keeps every requirement at every speed."""
    shortfalls: Union[tuple[Shortfall, ...], None]
    """The requirements that the nominal model misses, each at its worst speed."""
    speeds: tuple[SpeedResponses, ...]
    """The responses of the nominal model at speeds of the range."""
    fmu_loop: Union[tuple[SpeedResponses, ...], None]
    """The same responses in the loop of the packed FMUs, coupled as by Gauss and Seidel, from the tick at
    which the controller reads the reference."""
    ensemble: Union[SpeedEnsemble, None]
    """The vehicles drawn from the covariance of the model; absent where none were drawn."""
    advice: Union[tuple[str, ...], None]
    """What limits the design, and what would allow it."""


class Guidance(Record):
    """Parameters of the guidance law (look-ahead based line of sight)."""

    lookahead_time_s: float
    """Look-ahead distance over speed, s."""
    lookahead_min_m: float
    """Smallest look-ahead distance, m."""
    preview_time_s: float
    """Preview time of heading and curvature, s, which compensates for the loop's lag."""
    feedforward_gain_radm: float
    """Steering angle per curvature, rad·m."""
    sideslip_per_yaw_rate_s: float
    """Sideslip angle per yaw rate in a steady turn, s; at small lateral acceleration if the growth is
    stated."""
    sideslip_per_yaw_acceleration_s2: Union[float, None]
    """Sideslip angle per yaw acceleration, s²; 0 or omitted if unknown."""
    sideslip_growth_s5pm2: Union[float, None]
    """Growth of the sideslip per yaw rate, per squared lateral acceleration, s⁵/m²; 0 or omitted if
    unknown."""
    distance_rear_m: Union[float, None]
    """Distance from centre of gravity to rear axle, m, by which the sideslip follows the speed from that at
    `speed_mps`; 0 or omitted if unknown, which keeps the sideslip per yaw rate at all speeds."""
    yaw_acceleration_gain_s2: Union[float, None]
    """Gain from the path's yaw acceleration to the yaw reference, s², which compensates for the error of
    the loop that remains with preview and feedforward; 0 may be omitted."""
    yaw_jerk_gain_s3: Union[float, None]
    """Gain from the path's yaw jerk to the yaw reference, s³, for the same; 0 may be omitted."""
    sideslip_correction_time_s: Union[float, None]
    """Time in which the sideslip per yaw rate is corrected by the cross-track error of turns, s; 0 or
    omitted for no correction."""
    cross_track_integral_gain_per_s: Union[float, None]
    """Integral gain of the cross-track error, 1/s; 0 or omitted for none."""
    speed_preview_time_s: Union[float, None]
    """Preview time of the speed profile, s, which compensates for lag and delay of the drive; 0 or omitted
    for none."""
    brake_preview_time_s: Union[float, None]
    """The same where the profile decelerates, s, for those of the brake."""


class GuidanceEntry(Record):
    """The parameters of the guidance law at one speed."""

    speed_mps: float
    """Speed, m/s."""
    lookahead_time_s: float
    """Look-ahead distance over speed, s."""
    lookahead_min_m: float
    """Smallest look-ahead distance, m."""
    preview_time_s: float
    """Preview time of heading and curvature, s."""
    feedforward_gain_radm: float
    """Steering angle per curvature, rad·m."""
    yaw_acceleration_gain_s2: Union[float, None]
    """Gain from the path's yaw acceleration to the yaw reference, s²; 0 may be omitted."""
    yaw_jerk_gain_s3: Union[float, None]
    """Gain from the path's yaw jerk to the yaw reference, s³; 0 may be omitted."""


class PathPoint(Record):
    """One point, in the file an array `[distance_m, x_m, y_m, heading_rad, curvature_per_m]`."""

    distance_m: float
    """Arc length from the first point, m."""
    x_m: float
    """Position, m."""
    y_m: float
    """Position, m."""
    heading_rad: float
    """Heading, rad, not wrapped along the path."""
    curvature_per_m: float
    """Curvature, 1/m, positive to the left."""


class SpeedProfile(Record):
    """A speed profile over a path. Between two points the acceleration is linear in the distance, so the
    square of the speed is quadratic. Between a point at standstill with acceleration 0 and its neighbour
    the jerk is constant: the square of the speed is proportional to the distance to the power of 4/3."""

    limits: ProfileLimits
    """The limits that it keeps."""
    time_s: float
    """Time from the first point to the last, s; of a lap on a closed path."""
    binding: tuple[BindingSegment, ...]
    """Where which limit binds, in the order of the path. No limit binds between these segments."""
    points: tuple[ProfilePoint, ...]
    """At least two, at increasing distance from the first point of the path to its last, on a closed path
    to where the second lap begins."""


class ManoeuvrePurpose(Record):
    """What is to be known."""

    goal: Union[ManoeuvreGoal, None]
    """The quantity whose standard error is minimised; absent of the response."""
    band_hz: Array
    """Band of the response from the steering angle to the yaw rate, Hz; of other goals that of the
    steering."""
    max_error: Union[float, None]
    """Two standard errors of the goal, in its unit, that are to be reached; absent where as little as
    possible is wanted."""


class ManoeuvreLimits(Record):
    """Limits of a manoeuvre, in steering coordinates; absent where not limited."""

    max_lateral_acceleration_mps2: float
    """Largest lateral acceleration, m/s²."""
    max_angle_rad: Union[float, None]
    """Largest steering angle, rad."""
    max_rate_radps: Union[float, None]
    """Largest rate of the steering angle, rad/s."""
    max_offset_m: Union[float, None]
    """Largest lateral offset of the centre of gravity to either side, m."""


class ManoeuvreBlock(Record):
    """A block of a manoeuvre."""

    start_s: float
    """Its start, s."""
    signal: int
    """Number of its signal, from 0."""
    mirrored: bool
    """Whether it begins to the other side: the signal times −1."""


class SteeringSignal(Record):
    """A steering signal."""

    speed_mps: float
    """Speed at which it is driven, m/s."""
    frequency_hz: Union[Array, None]
    """Frequency of a slalom, or that from which and to which a sweep or the tones go, Hz; absent of steps."""
    hold_s: Union[float, None]
    """Time for which a step is held, s; absent of other kinds."""
    peaks: SignalPeaks
    """The largest values of the model, and those that the vehicle keeps with a probability of 97.5 % each
    by the uncertainty of the model."""
    steering_rad: Array
    """Steering angle, rad."""


class ExpectedErrors(Record):
    """The standard errors to expect."""

    largest_error: float
    """Standard error of the goal, in its unit: of the response the largest of gain (relative) and phase
    (rad) in the band at all speeds."""
    bound: Union[float, None]
    """The same of the convex problem: no powers of the tones within the limits are better. Absent of other
    kinds than the multisine."""
    gap: Union[float, None]
    """Gap of the solution of the convex problem, as a share of the variance."""
    met: bool
    """Whether the wanted error is reached; true where none is stated."""
    needed_time_s: Union[float, None]
    """Time of the same manoeuvre that would reach it, s; absent where none is stated or no time does."""
    response: tuple[ExpectedResponse, ...]
    """By speed and frequency; empty where the goal is the tyre limit."""
    parameters: tuple[Estimated, ...]
    """Of the parameters at the mean speed."""


class Alternative(Record):
    """The best manoeuvre of a kind."""

    kind: ManoeuvreKind
    """Its kind."""
    largest_error: float
    """Standard error of the goal, in its unit."""


class Gnss(Record):
    """The receiver and its antenna."""

    latency_s: float
    """Age of a fix when it arrives, s; at most 10."""
    antenna_x_m: float
    """The antenna ahead of the centre of gravity, m."""
    antenna_y_m: float
    """The antenna to the left of the centre of gravity, m."""
    std_m: Union[float, None]
    """Standard deviation of a fix in each coordinate that the `gnss_std` input starts with, m; by default
    0, with which no fix is used."""
    period_s: Union[float, None]
    """Time between fixes that are taken from the inputs without a changed count, s; by default there are
    none."""


class SensorNoise(Record):
    """Noise densities: a white noise of density q adds up to q·√t in t seconds."""

    yaw_rate_density: float
    """Of the gyro, (rad/s)/√Hz."""
    yaw_rate_bias_density: float
    """Of what the gyro's bias walks by, (rad/s²)/√Hz."""
    speed_density: float
    """Of the speed, (m/s)/√Hz."""
    lateral_velocity_density: float
    """Of the lateral velocity that the sideslip does not explain, (m/s)/√Hz."""
    sideslip_per_yaw_rate_density: Union[float, None]
    """Of what the sideslip per yaw rate walks by, s/√s; 0 or omitted if it is constant."""


class InitialUncertainty(Record):
    """Standard deviations at the start."""

    position_std_m: float
    """Of each coordinate, m."""
    yaw_std_rad: float
    """Of the yaw, rad; above 0.5 it is initialised from the direction of the first fixes."""
    yaw_rate_bias_std_radps: float
    """Of the gyro's bias, rad/s."""
    sideslip_per_yaw_rate_std_s: Union[float, None]
    """Of the sideslip per yaw rate, s; 0 or omitted if it is known exactly."""


class AccumulatedSpeed(Record):
    """Mean and spread of a speed."""

    mean_mps: float
    """Mean, m/s."""
    standard_deviation_mps: float
    """Standard deviation, m/s."""


class ChannelSummary(Record):
    """The summary of one channel."""

    role: str
    """`steering`, `yaw_rate`, `speed` …"""
    column: str
    """The column's name in the log."""
    unit: str
    """The unit it was read in."""
    rows: int
    """Rows read."""
    rate_hz: float
    """Median sample rate of the channel's clock, Hz; of a sensor whose values repeat over several rows, the
    rate at which it was updated."""
    intersample: Union[Intersample, None]
    """The assumed behaviour between its samples; absent in files of earlier versions."""
    along_lines: Union[bool, None]
    """Whether it was taken for band-limited, and the data show straight lines between its samples: a
    measured angle behind the steps of a controller."""
    min: float
    """Smallest value, SI."""
    mean: float
    """Mean, SI."""
    max: float
    """Largest value, SI."""
    resolution: Union[float, None]
    """Step of which all values are multiples, SI; absent if there is none."""
    spikes_s: Union[Array, None]
    """Instants of single spikes and dropouts, which are treated as missing, s."""
    frozen_s: Union[Array, None]
    """First and last instants at which the channel was frozen while the vehicle was steered, s; these
    samples are treated as missing."""


class SideslipTerm(Record):
    """A term of the sideslip, in the unit of its name."""

    value: float
    """The estimate."""
    standard_error: float
    """Its standard error, from the noise of the fixes and the gyro only."""


class UncertainPole(Record):
    """A discrete pole; of a complex pair both are listed."""

    re: float
    """Real part."""
    im: float
    """Imaginary part."""
    variance_re: float
    """Variance of the real part."""
    variance_im: float
    """Variance of the imaginary part."""
    covariance: float
    """Covariance of the two."""


class FrequencyBand(Record):
    """The response at one frequency."""

    frequency_hz: float
    """Frequency, Hz."""
    magnitude: float
    """Yaw rate over input."""
    phase_rad: float
    """Phase, rad, within ±π."""
    magnitude_standard_error: float
    """Standard error of the magnitude."""
    phase_standard_error_rad: float
    """Standard error of the phase, rad; not meaningful if that of the magnitude reaches the magnitude."""


class StepBand(Record):
    """The step response at one time."""

    time_s: float
    """Time after the step, s."""
    value: float
    """Yaw rate over the step of the model's input."""
    standard_error: float
    """Its standard error."""


class DataFactor(Record):
    """The reduction of the recorded windows to one R factor."""

    method: FactorMethod
    """The method, chosen by the condition."""
    condition: Union[float, None]
    """Estimated condition number of the windows, scaled to equal size; absent if it is infinite, as for
    data without noise."""
    input_condition: Union[float, None]
    """The same for the windows of the input only, at the requested horizon: beyond 1e12 the input is
    reported as not exciting them."""
    asked_horizon: int
    """Requested block rows; with an automatic horizon, the longest that was tried."""
    horizon: int
    """Block rows that the input excites, at most those requested."""


class DelayEstimate(Record):
    """The pure delay from steering to yaw rate, estimated on the estimation data."""

    estimate_s: float
    """Delay of the best model with a delay, s."""
    standard_error_s: Union[float, None]
    """Its standard error, s, from noise, the spread over model orders, and the ambiguity with a lag; absent
    if the data do not determine it."""
    lag_without_s: float
    """Fastest time constant of the best model without a delay, s: the lag that the delay replaces."""
    evidence: float
    """Difference in BIC by which the delay is preferred to lags; below 6 the delay is not used."""
    taken: bool
    """Whether it is used as the delay of the plant."""


class Fits(Record):
    """Fit is 100·(1 − ‖y − ŷ‖/‖y − mean(y)‖) on yaw rate, in percent. Validation data have the means of the
    estimation data removed and the initial state estimated."""

    estimation: float
    """Simulation on the estimation data."""
    validation: float
    """Simulation on validation data."""
    validation_one_step: float
    """One-step prediction on validation data."""


class OrderRow(Record):
    """One order that was tried."""

    order: int
    """Order n."""
    singular_value: Union[float, None]
    """The n-th singular value, with the method and horizon of the chosen model for all orders; absent if
    there are fewer."""
    estimation_fit: float
    """Simulation fit on the estimation data, percent."""
    validation_fit: float
    """Simulation fit on validation data, percent."""
    stable: bool
    """Whether the model was stable as estimated."""
    criterion: Union[float, None]
    """BIC on the estimation data; the order with the smallest BIC is chosen."""


class ResidualTest(Record):
    """A test of residuals against a χ² bound."""

    lags: int
    """Number of lags."""
    statistic: float
    """The statistic."""
    bound: float
    """The bound at 99 %."""
    pass_: bool
    """Whether statistic ≤ bound."""


class Excitation(Record):
    """Information in the log about the dynamics."""

    road_wheel_std_rad: float
    """Standard deviation of the steering angle at the road wheel, rad."""
    yaw_rate_std_radps: float
    """Standard deviation of the yaw rate, rad/s."""
    noise_to_signal: float
    """Standard deviation of the innovation over that of the yaw rate."""
    informative_up_to_hz: float
    """Largest frequency below which the coherence stays above 0.5, Hz; 0 if it never does."""
    coherence: tuple[CoherencePoint, ...]
    """Coherence of steering and yaw rate."""
    bands: Union[tuple[ExcitationBand, ...], None]
    """Information in the log by bands of frequency."""
    persistence: Union[Persistence, None]
    """The order of persistent excitation of the input."""
    largest_steering_rad: Union[float, None]
    """Largest angle steered to either side of the mean, rad, in steering coordinates."""
    largest_steering_rate_radps: Union[float, None]
    """Fastest steering, rad/s in steering coordinates, by `Excitation::largest_rate`."""


class HeldOut(Record):
    """The predictions of the model on validation data."""

    fit_standard_error: Union[float, None]
    """Standard error of the simulation fit on validation data, percentage points (block jackknife); absent
    where they are too short."""
    blocks: int
    """Number of blocks of time behind it."""
    selection: Union[str, None]
    """How the validation data were chosen: `end` of the log, `excited-blocks` where the end is not excited,
    `speed-blocks` where the speed varies, `windows` of accumulated drives."""
    segments_s: Union[Array, None]
    """First and last instants of each segment of validation data, s."""
    fit_bound: Union[float, None]
    """Fit that noise of the size of the one-step prediction errors allows at most, percent: no simulation
    reaches more on these data."""
    variance_accounted_for: float
    """Variance of the yaw rate that the simulation accounts for, percent."""
    predictions: tuple[PredictionFit, ...]
    """Fits of predictions some steps ahead, by rising number of steps."""


class SteeringPlay(Record):
    """Play between the recorded steering angle and the road wheels, as an angle at the road wheels."""

    road_wheel_rad: float
    """Width of the play from stop to stop, rad at the road wheel."""
    standard_error_rad: float
    """Its standard error, rad."""
    limit_cycle: Union[LimitCycle, None]
    """The limit cycle of a typical loop about the plant; absent if none is expected."""


class IdentifiedActuator(Record):
    """The actuator from a steering command to the measured angle beside it: `T δ̇ + δ = g u(t − τ) + c`,
    and no faster than its largest rate where that shows."""

    time_constant_s: float
    """Time constant T, s."""
    time_constant_standard_error_s: float
    """Its standard error, s."""
    delay_s: float
    """Delay τ, s."""
    delay_standard_error_s: float
    """Its standard error, s."""
    gain: float
    """Angle over command g in a steady turn."""
    max_rate_radps: Union[float, None]
    """Largest rate of the steering angle, rad/s; absent where the drive does not reach it."""
    fit: float
    """Fit of the measured angle by the simulation from the command, percent."""


class ResidualCorrelation(Record):
    """Correlation of the one-step residuals on validation data, lag by lag."""

    autocorrelation: Array
    """Autocorrelation at lags 1, 2, …"""
    autocorrelation_bound: float
    """Bound on their absolute values with a probability of 99 % for white residuals."""
    with_input: Array
    """Correlation of the input at t and the residual at t + k, k from −n to n."""
    with_input_bound: float
    """Bound on their absolute values with a probability of 99 % if input and residuals are uncorrelated."""
    feedback: ResidualTest
    """Test for feedback: whether past residuals explain a part of the input, as with a driver who corrects
    deviations. Passed if they do not."""


class FrequencyResponse(Record):
    """Frequency response measured (Welch's method, H1, less the smear of its windows as the model's own
    simulation shows it), and the model's."""

    confidence: float
    """Probability of each band at one frequency."""
    averages: float
    """Independent averages of the spectra."""
    resolution_hz: float
    """Distance of two frequencies, Hz."""
    significant_coherence: float
    """Coherence that unrelated signals exceed with a probability of 1 %."""
    compared: int
    """Frequencies that are compared: those whose coherence is significant and above 0.5."""
    within: float
    """Share of these at which the model lies within the band."""
    bands: Union[tuple[BandDeparture, ...], None]
    """The model compared with the measured response, in frequency bands in which the log is coherent."""
    points: tuple[ResponsePoint, ...]
    """For the plot: all low frequencies, and a selection of the high ones, which are close together on a
    logarithmic axis."""


class PoleZeroMap(Record):
    """Poles and transmission zeros."""

    poles: tuple[Mode, ...]
    """Eigenvalues of A; of a conjugate pair, the one above the real axis."""
    zeros: tuple[Mode, ...]
    """Finite transmission zeros of the discrete model, likewise."""
    continuous_zeros: Union[Array, None]
    """Finite transmission zeros of the continuous model, rad/s, all of them as (real, imaginary); those of
    the discrete model that come from sampling alone are not among them."""
    continuous_zero_spreads: Union[tuple[Spread, ...], None]
    """Their covariances, in the same order; empty if unknown."""


class Reason(Record):
    """One reason for a grade, with the number that was compared and its limit."""

    code: ReasonCode
    """The subject."""
    grade: Grade
    """The grade that the reason causes: `warn` or `fail`."""
    message: str
    """The message, such as `the fit on validation data is 24 %, below 60 %`."""
    value: Union[float, None]
    """The number that was compared, in `unit`."""
    limit: Union[float, None]
    """The limit that it violates, in `unit`."""
    unit: Union[str, None]
    """Unit of value and limit; empty for none."""


class SourceFile(Record):
    """A file that was read."""

    name: str
    """The file's name without its folder."""
    sha256: str
    """SHA-256 of its bytes, in hexadecimal."""
    of_samples: Union[bool, None]
    """Whether the hash is of the samples that were read: a large file is not read as a whole for it."""


class SpeedSummary(Record):
    """Speeds of a recording, m/s."""

    min_mps: float
    """The lowest, m/s."""
    mean_mps: float
    """Mean, m/s."""
    max_mps: float
    """The highest, m/s."""
    standard_deviation_mps: float
    """Standard deviation, m/s."""


class Estimated(Record):
    """A number with its uncertainty."""

    name: str
    """The quantity."""
    value: float
    """The estimate."""
    standard_error: float
    """Its standard deviation."""
    unit: str
    """Unit of both."""


class VehicleDirection(Record):
    """Natural logarithms of factors on a vehicle's data, and a change of its delay."""

    wheelbase: float
    """On both axles' distances from the centre of gravity."""
    yaw_inertia: float
    """On the yaw inertia."""
    cornering_stiffness_front: float
    """On the front axle's cornering stiffness."""
    cornering_stiffness_rear: float
    """On the rear axle's cornering stiffness."""
    actuator_time_constant: float
    """On the actuator's time constant."""
    steering_ratio: float
    """On the steering ratio."""
    actuator_delay_s: Union[float, None]
    """Change of the actuator's delay, s."""


class Stated(Record):
    """A number that was not identified."""

    name: str
    """Key in the vehicle's data."""
    value: float
    """The number."""
    origin: str
    """The origin of the number."""


class WithDelay(Record):
    """The bicycle with a delay of the steering."""

    input_delay_s: float
    """The delay, s; negative if the steering channel lags behind the gyro."""
    standard_error_s: float
    """Its standard deviation, s."""
    actuator_time_constant_s: float
    """The actuator's time constant estimated together with it, s."""
    estimation_fit: float
    """Fit on the estimation data, percent."""
    validation_fit: float
    """Fit on validation data, percent."""


class SimulationFit(Record):
    """A free simulation compared with the measured signals: from steering and speed alone, each segment
    from the steady turn at its first yaw rate. Fits are `100·(1 − ‖y − ŷ‖/‖y − mean y‖)` in percent over
    all segments, −100 where the simulation is worse or leaves all bounds."""

    yaw_rate: float
    """Fit of yaw rate, %."""
    yaw_rate_standard_error: Union[float, None]
    """Its standard error, percentage points (block jackknife); absent where the data are too short."""
    blocks: Union[int, None]
    """Number of blocks of time behind it."""
    lateral_acceleration: Union[float, None]
    """Fit of lateral acceleration, %, where it is measured."""
    sideslip_rms_error_rad: Union[float, None]
    """RMS error of the sideslip angle, rad, above 3 m/s, where lateral velocity is measured."""
    sideslip_rms_rad: Union[float, None]
    """RMS of the measured sideslip angle likewise, rad."""
    worst_window_radps: float
    """Largest RMS error of yaw rate in a window of 5 s, rad/s."""


class VehicleParameter(Record):
    """A parameter of the single-track model with its uncertainty."""

    name: str
    """The quantity."""
    unit: Union[str, None]
    """Its unit; empty for none."""
    value: float
    """The estimate."""
    standard_error: float
    """Its standard error; 0 where it is stated."""
    band_95: Array
    """Ends of the 95 % band, within the bounds."""
    is_logarithmic: bool
    """Whether its coordinate is the natural logarithm."""
    prior: Prior
    """The prior distribution of the coordinate, and the bounds of the value."""
    posterior_per_prior: float
    """Posterior over prior standard deviation: about 1 where the drive is uninformative; 0 where it is
    stated."""
    moved_deviations: float
    """How far the drive moved the coordinate, in standard deviations of the prior; 0 where it is stated."""
    is_determined: bool
    """Whether the drive determines it: a posterior of at most half the prior's deviation."""
    is_at_bound: bool
    """Whether the value is at one of its bounds."""


class GainVariation(Record):
    """Variation of the gain from one stretch of the drive to another at one speed, relative to it, such as
    that of gears which the log does not have."""

    stretch_s: float
    """Length of the stretches, s."""
    deviation: float
    """Standard deviation of greatest likelihood."""
    largest: float
    """Upper end of its 95 % band."""
    log_likelihood_ratio: float
    """Logarithm of the ratio of the likelihoods with and without it."""


class OutputEvidence(Record):
    """The evidence of one output, on validation data."""

    output: str
    """Name of the output."""
    fit: Fits
    """Fits, percent."""
    fit_standard_error: Union[float, None]
    """Standard error of the simulation fit on validation data, percentage points (block jackknife); absent
    where the validation data are too short."""
    one_step_error: float
    """Standard deviation of the one-step prediction errors on validation data, in the unit of the output."""
    whiteness: ResidualTest
    """Autocorrelation of the one-step residuals."""
    coherence: tuple[CoherencePoint, ...]
    """Multiple coherence: the share of the output's power that all inputs together explain, by frequency."""
    coherence_of_chance: float
    """The multiple coherence of unrelated signals stays below with a probability of 95 %."""


class PairEvidence(Record):
    """The evidence of one pair of output and input."""

    output: str
    """Name of the output."""
    input: str
    """Name of the input."""
    delay: Union[PairDelay, None]
    """Pure delay that the impulse response shows; absent where it shows no response."""
    independence: ResidualTest
    """Correlation of the one-step residuals with the past input, on validation data."""
    steady_state_gain: Union[Estimate, None]
    """Gain at rest; absent without uncertainty, and for an integrator."""
    frequency_response: tuple[FrequencyBand, ...]
    """Response of the model with standard errors, with the delay of the input, in the output's unit over
    the input's."""
    measured: tuple[MeasuredPoint, ...]
    """Measured response by spectra of the whole log."""


class LargeErrors(Record):
    """Limits for large yaw errors, which reduce the overshoot of large steps with a rate-limited actuator."""

    max_yaw_error_rad: float
    """Largest yaw error, beyond the lag behind a ramp, that the controller acts on at once, rad; the rest
    is released as a ramp."""
    yaw_rate_lag_s: Union[float, None]
    """Lag of the yaw rate behind the steering angle that was sent, s: by it the controller notices an
    actuator that turns more slowly than the largest rate. 0 may be omitted: no such actuator is looked
    for."""
    sustained_rate_radps: float
    """Rate with the slowest actuator that is looked for, rad/s."""
    rate_reserve_time_s: float
    """Reserve of time at the largest rate, s, after which the anti-windup is quicker: longer than a step of
    the specification needs."""


class LateralAcceleration(Record):
    """A bound on the lateral acceleration a, and the steering angle of a steady turn at speed v:
    `a·(steering_per_curvature/v² + understeer_gradient)`."""

    max_mps2: float
    """The bound, m/s²."""
    steering_per_curvature_radm: float
    """Steering angle per curvature in a slow turn, rad·m."""
    understeer_gradient_rads2pm: float
    """Steering angle per lateral acceleration beyond that, rad·s²/m."""


class StatedActuator(Record):
    """What moves the steering to a commanded angle, where the model's drive has the angle behind it: `T δ̇
    + δ = u(t − τ)`."""

    time_constant_s: float
    """Time constant T, s."""
    delay_s: float
    """Delay τ, s."""


class Shortfall(Record):
    """An unmet requirement."""

    requirement: str
    """The requirement."""
    required: float
    """The requirement."""
    reached: float
    """The value reached."""


class StepMetrics(Record):
    """Metrics of one step response."""

    overshoot_percent: float
    """Overshoot, percent of the step."""
    settling_time_s: Union[float, None]
    """Time after which the response stays within the band; absent if it never does."""
    steady_state_error_percent: float
    """Error at the steady-state time, percent of the step."""
    rise_time_s: Union[float, None]
    """Time from 10 % to 90 %; absent if 90 % is never reached."""
    largest_angle_rad: float
    """Largest steering angle used, rad, in steering coordinates."""
    largest_increment_rad: float
    """Largest change in a sample, rad."""
    integral_absolute_error_s: Union[float, None]
    """Integral of the absolute error over the step's height, s."""


class OnACurve(Record):
    """On a curve of constant curvature that begins at once, at the speed of the design."""

    curvature_1pm: float
    """Curvature of the path, 1/m."""
    steady_state_error_percent: float
    """Yaw less the path's heading at the steady-state time, percent of the step's height."""
    largest_error_percent: float
    """The largest such difference before that, percent of the step's height."""


class FmuLoop(Record):
    """The specification's steps in the loop of the packed FMUs."""

    coupling: LoopCoupling
    """`gauss-seidel` or `jacobi`."""
    loop_delay_s: float
    """The delay that this coupling puts into the yaw loop, s."""
    step: StepMetrics
    """On the step."""
    predicted: StepMetrics
    """The same by the design's own simulation with that delay."""
    step_with_offset: Union[StepMetrics, None]
    """On the step with the steering offset; absent if the plant has no such parameter."""


class HeightStep(Record):
    """A step of some height."""

    height_rad: float
    """Height of the step, rad."""
    step: StepMetrics
    """The metrics of the response; percentages are of this height."""


class Engagement(Record):
    """The offsets from which the loop with its path follower returns to a straight path, at constant speed."""

    plant: str
    """The simulated plant: whether its tyres saturate."""
    offsets_m: Array
    """Lateral offsets that were tried, m, to the left of the path."""
    rows: tuple[EngagementRow, ...]
    """Each speed and heading error."""


class Margins(Record):
    """Margins of the linear sampled loop, broken at the plant's input, with its delay."""

    gain_margin_db: Union[float, None]
    """Gain margin, dB; absent if unlimited."""
    phase_margin_deg: Union[float, None]
    """Phase margin, degrees; absent if the gain never crosses 1."""
    delay_margin_s: Union[float, None]
    """Delay margin, s; absent if unlimited."""
    modulus_margin: float
    """Smallest distance of the loop from −1."""
    disk_margin: Union[float, None]
    """Disk margin with zero skew, `1/max\\|S − ½\\|`: gain and phase may change together by that much."""
    crossover_radps: Union[float, None]
    """Gain crossover, rad/s."""


class Robustness(Record):
    """The same gains on plants other than the nominal one."""

    met: bool
    """Whether every evaluated plant meets every requirement."""
    members: int
    """Plants drawn from the identified uncertainty; 0 if none is stated."""
    members_wanted: Union[int, None]
    """Plants that were asked for; more than `members` where draws are unstable or have no continuous form,
    whose shares of the requirements are then unknown. Absent where all were drawn."""
    seed: int
    """The seed of the draws."""
    loop_delay_range_s: Array
    """Lowest and highest delay of the yaw loop beyond the model's own, s."""
    gain_range: Array
    """Lowest and highest gain of the plant over the nominal one: beyond the lateral acceleration of the
    drive the tyres saturate, which no uncertainty of a linear model contains."""
    speed_range_mps: Union[Array, None]
    """Lowest and highest speed, m/s, if the model is valid at several."""
    plants: int
    """Evaluated plants: members, at the latencies and speeds of the ranges."""
    requirements: tuple[OverEnsemble, ...]
    """Each requirement over them."""
    latency: tuple[Breaking, ...]
    """Delay of the yaw loop beyond the model's own at which each requirement fails, s; nominal plant."""
    speed: Union[tuple[Breaking, ...], None]
    """Speed at which each requirement fails, m/s; nominal plant."""


class TradeOff(Record):
    """The settling time that a modulus margin costs."""

    modulus_margin: float
    """The modulus margin."""
    settling_time_s: Union[float, None]
    """The shortest settling time found with it, the other requirements met; absent if none was found."""


class OverSpeed(Record):
    """The evidence of a controller over a range of speeds."""

    met: bool
    """Whether every requirement is met at every evaluated speed."""
    frozen: tuple[FrozenSpeed, ...]
    """The loop at constant speeds, at the breakpoints of the table and between them, in ascending order."""
    ramps: tuple[SpeedRamp, ...]
    """The loop while the speed changes."""


class SpeedResponses(Record):
    """The responses at a speed."""

    speed_mps: float
    """Speed before the step up, after the step down, and on the grade, m/s."""
    up: SpeedStep
    """Step up."""
    down: SpeedStep
    """Step down."""
    error_on_grade_percent: float
    """Error on the grade at the steady-state time, percent of the step."""
    largest_loss_on_grade_mps: float
    """Largest loss of speed on the grade, m/s."""


class SpeedEnsemble(Record):
    """The vehicles drawn from the covariance of the model."""

    vehicles: int
    """Number of vehicles."""
    keeping: int
    """Vehicles that keep every requirement at every speed."""
    overshoot_percent: float
    """Largest overshoot of all, percent of the step."""
    settling_time_s: Union[float, None]
    """Longest settling time of all, s; absent if one never settles."""
    steady_state_error_percent: float
    """Largest steady-state error of all, percent of the step."""


class ProfileLimits(Record):
    """The limits of a speed profile."""

    max_speed_mps: float
    """Largest speed, m/s."""
    max_lateral_acceleration_mps2: float
    """Largest lateral acceleration v²·κ, m/s²."""
    max_acceleration_mps2: float
    """Largest acceleration along the path, m/s²."""
    max_deceleration_mps2: float
    """Largest deceleration, m/s²."""
    max_jerk_mps3: Union[float, None]
    """Largest jerk along the path to either side, m/s³; absent if it is not limited."""
    friction: Union[float, None]
    """Friction coefficient μ: the vector sum of lateral and longitudinal acceleration is at most μ·g;
    absent if it is not limited."""
    steering: Union[SteeringLimits, None]
    """The limits of the steering; absent if it is not limited."""
    end_speeds_mps: Union[Array, None]
    """Speed at the first and at the last point, m/s; absent on a closed path, where the lap ends as it
    begins."""


class BindingSegment(Record):
    """A part of the path on which one limit binds."""

    limit: ProfileLimit
    """The limit."""
    from_m: float
    """Where it begins to bind, m."""
    to_m: float
    """Where it ceases to bind, m."""
    time_s: float
    """Time on this part, s."""


class ProfilePoint(Record):
    """One point, in the file an array `[distance_m, speed_mps, acceleration_mps2]`."""

    distance_m: float
    """Arc length, as in the points of the path, m."""
    speed_mps: float
    """Speed, m/s."""
    acceleration_mps2: float
    """Acceleration along the path, m/s²."""


class SignalPeaks(Record):
    """The largest absolute values under a signal: of the model, and the bound by its uncertainty."""

    lateral_acceleration_mps2: Array
    """Lateral acceleration, m/s²."""
    offset_m: Array
    """Lateral offset, m."""
    angle_rad: float
    """Steering angle, rad."""
    rate_radps: float
    """Rate of the steering angle, rad/s."""
    end_offset_m: float
    """Lateral offset after the signal, m."""


class ExpectedResponse(Record):
    """The standard errors of a response."""

    speed_mps: float
    """Speed, m/s."""
    frequency_hz: float
    """Frequency, Hz."""
    gain: float
    """Gain of the model, yaw rate over steering angle, 1/s."""
    gain_error: float
    """Relative standard error of the gain."""
    phase_error_rad: float
    """Standard error of the phase, rad."""


class CoherencePoint(Record):
    """Coherence at one frequency."""

    frequency_hz: float
    """Frequency, Hz."""
    coherence: float
    """Magnitude-squared coherence, 0 to 1."""


class ExcitationBand(Record):
    """Information in a log in a band of frequency."""

    from_hz: float
    """Lower end, Hz."""
    to_hz: float
    """Upper end, Hz."""
    road_wheel_std_rad: float
    """Standard deviation of the steering within the band, at the road wheel, rad."""
    yaw_rate_std_radps: float
    """Standard deviation of the yaw rate within the band, rad/s."""
    coherence: float
    """Share of that yaw rate's power that the steering explains, 0 to 1."""
    relative_error: float
    """Standard error of the band's gain from the spectra alone, over that gain: it falls with the square
    root of the time recorded, and as the steering grows."""
    information: Information
    """The conclusion."""


class Persistence(Record):
    """Order of persistent excitation."""

    order: int
    """Largest order found."""
    tried: int
    """Largest order tried; the order may be higher if both are equal."""


class PredictionFit(Record):
    """Fit of k-step predictions: from all inputs, and the outputs up to k samples ago."""

    steps: Union[int, None]
    """Steps k ahead; absent for the simulation, which sees no output."""
    ahead_s: Union[float, None]
    """The same in seconds."""
    fit: float
    """Fit, percent."""
    variance_accounted_for: float
    """Variance accounted for, percent."""


class LimitCycle(Record):
    """A self-sustained oscillation by the describing function of the play."""

    road_wheel_rad: float
    """Amplitude of the steering, rad at the road wheel."""
    yaw_rad: float
    """Amplitude of the yaw angle, rad."""
    period_s: float
    """Period, s."""


class BandDeparture(Record):
    """The model error in a band: the complex factor from the simulated to the measured yaw rate, over all
    frequencies of the band, weighted by the power of the simulation."""

    from_hz: float
    """Lower end, Hz."""
    to_hz: float
    """Upper end, Hz."""
    gain_ratio: float
    """The model's gain over the measured one."""
    phase_ahead_rad: float
    """The model's phase minus the measured one, rad; positive if the model leads."""
    standard_error: float
    """Standard error of the gain ratio over itself, and of the phase in rad."""
    departure: float
    """The relative model error, \\|model − measured\\|/\\|measured\\|, minus twice its standard error; 0 if
    it is within twice the standard error."""


class ResponsePoint(Record):
    """Measured and modelled response at one frequency; gains in yaw rate over the model's input."""

    frequency_hz: float
    """Frequency, Hz."""
    gain: float
    """Measured gain."""
    phase_rad: float
    """Measured phase, rad, continuous over frequency."""
    radius: float
    """Radius of the confidence disk about the measured response, in the unit of the gain."""
    coherence: float
    """Magnitude-squared coherence."""
    coherence_low: float
    """Its lower confidence bound."""
    coherence_high: float
    """Its upper confidence bound."""
    model_gain: float
    """The model's gain."""
    model_phase_rad: float
    """The model's phase, rad, with its input delay."""


class Mode(Record):
    """A pole or zero z, and s = ln(z)/T."""

    discrete: Array
    """z, (real, imaginary)."""
    spread: Union[Spread, None]
    """The covariance of z; absent if unknown."""
    continuous: Union[Array, None]
    """s, rad/s, (real, imaginary); absent for z = 0."""
    natural_frequency_hz: Union[float, None]
    """\\|s\\|/2π, Hz."""
    damping: Union[float, None]
    """−Re s/\\|s\\|."""
    time_constant_s: Union[float, None]
    """−1/Re s, s; absent if it does not decay."""


class Spread(Record):
    """Covariance of a point in the plane, to first order."""

    variance_re: float
    """Variance of the real part."""
    variance_im: float
    """Variance of the imaginary part."""
    covariance: float
    """Covariance of the two."""


class Prior(Record):
    """A normal distribution of a parameter's coordinate, and the bounds of the value."""

    mean: float
    """Mean; of a logarithm the median. In the parameter's unit."""
    standard_deviation: float
    """Standard deviation of the coordinate: of a logarithm relative. Zero states the parameter."""
    min: float
    """Least value."""
    max: float
    """Largest value."""


class PairDelay(Record):
    """The pure delay of a pair by the first lags of its impulse response."""

    estimate_s: float
    """Delay beyond that of a model without feedthrough, s: a whole number of samples."""
    in_input_s: float
    """The part of it that is the input's in the plant, s; the states of the model represent the rest."""


class MeasuredPoint(Record):
    """The measured response of a pair at one frequency."""

    frequency_hz: float
    """Frequency, Hz."""
    gain: float
    """Gain."""
    phase_rad: float
    """Phase, rad, within ±π."""
    radius: float
    """Radius of the confidence disk (95 %) about the response, in the unit of the gain."""


class EngagementRow(Record):
    """One speed and heading error."""

    speed_mps: float
    """Speed, m/s."""
    heading_error_rad: float
    """Yaw less the path's heading at the start, rad; positive away from the path."""
    largest_offset_m: Union[float, None]
    """Largest tried offset from which, as from all smaller ones, it returns; absent if it returns from
    none."""


class OverEnsemble(Record):
    """One requirement over many plants."""

    requirement: str
    """The requirement."""
    required: float
    """The requirement."""
    worst: float
    """The worst value of all plants."""
    share_kept: float
    """Share of the plants that meet it."""
    share_kept_at_nominal: Union[float, None]
    """Share of the drawn plants that meet it at the latency and speed of the design; absent without drawn
    plants."""


class Breaking(Record):
    """The range around the design value in which one requirement is met."""

    requirement: str
    """The requirement."""
    below: Union[float, None]
    """Not met below this; absent if it is met down to the lowest evaluated value."""
    above: Union[float, None]
    """Not met above this; absent if it is met up to the highest evaluated value."""
    looked: Array
    """The lowest and the highest evaluated value."""


class FrozenSpeed(Record):
    """The loop at one constant speed."""

    speed_mps: float
    """Speed, m/s."""
    breakpoint: bool
    """Whether the table has an entry at this speed; otherwise the gains are interpolated."""
    kp: float
    """Kp, steering angle per yaw error."""
    ki: float
    """Ki, 1/s."""
    kd: float
    """Kd, s."""
    max_angle_rad: float
    """Largest steering angle that is allowed at this speed, rad, in steering coordinates."""
    step: StepMetrics
    """On the step of the specification."""
    step_with_offset: StepMetrics
    """On the same step with the steering offset."""
    curve: OnACurve
    """On the curve of constant curvature, with feedforward and preview of this speed."""
    margins: Margins
    """Margins of the linear sampled loop, broken at the plant's input."""
    met: bool
    """Whether every requirement is met."""
    shortfalls: Union[tuple[Shortfall, ...], None]
    """Each unmet requirement with its shortfall."""
    reason: Union[str, None]
    """Why requirements are not met; absent if all are."""
    plants: int
    """Evaluated plants of the ensemble: drawn ones, other latencies and gains. 0 without an ensemble."""
    share_kept: Union[float, None]
    """Share of these plants that meet every requirement; absent without an ensemble."""


class SpeedRamp(Record):
    """The scheduled controller on the model while the speed changes at a constant rate."""

    manoeuvre: SpeedRampKind
    """The manoeuvre."""
    acceleration_mps2: float
    """Change of the speed, m/s²."""
    from_mps: float
    """Speed at the start, m/s."""
    to_mps: float
    """Speed at the end, m/s."""
    overshoot_percent: Union[float, None]
    """Largest overshoot of a step, percent of the step; absent on a path."""
    settling_time_s: Union[float, None]
    """Longest settling time of a step, s; absent on a path, or if a step never settles."""
    radius_m: Union[float, None]
    """Radius of the path, m; absent for steps."""
    rms_cross_track_error_m: Union[float, None]
    """Root mean square of the distance from the path, m; absent for steps."""
    largest_cross_track_error_m: Union[float, None]
    """Largest distance from the path, m; absent for steps."""


class SpeedStep(Record):
    """A step of the speed."""

    overshoot_percent: float
    """Overshoot, percent of the step."""
    settling_time_s: Union[float, None]
    """Time after which the response stays within the band; absent if it never does."""
    steady_state_error_percent: float
    """Error at the steady-state time, percent of the step."""


class SteeringLimits(Record):
    """Limits of the steering angle δ = (L + K·v²)·κ of a steady turn and of its rate dδ/dt, in steering
    coordinates."""

    steering_per_curvature_radm: float
    """L, steering angle per curvature in a slow turn, rad·m."""
    understeer_gradient_rads2pm: float
    """K, steering angle per lateral acceleration beyond that, rad·s²/m."""
    max_angle_rad: Union[float, None]
    """Largest angle to either side, rad; absent if it is not limited."""
    max_rate_radps: Union[float, None]
    """Largest rate, rad/s; absent if it is not limited."""
