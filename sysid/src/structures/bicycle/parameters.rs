//! What the yaw rate determines of a bicycle, and the parameters made of it: ln α, ln β, ln L, ln η
//! and the offsets (docs/methods/bicycle.md, *What yaw rate identifies*).
//!
//! α = a·f/ρ and β = b·g/ρ are the yaw acceleration by a front and a rear slip angle, η = J/(m·a·b)
//! the dynamic index, with f = Cf/m, g = Cr/m and ρ = J/m. The mass and the front axle's share λ =
//! b/L of the weight are stated. The steady turn is `r = v·δ/(L + K·v²)` with K = (β −
//! α)/(α·β·η·L). Where the wheelbase is stated, a factor on the road-wheel angle takes its place.

use crate::linalg::dual::{Dual, Scalar};
use crate::structures::bicycle::options::BicycleOptions;
use steerwright_formats::{Estimated, VehicleData};

/// Number of parameters, and of the two initial states after them.
pub(super) const PARAMETERS: usize = 10;
/// With the initial v_y and r of a segment.
pub(super) const ALL: usize = PARAMETERS + 2;

/// The first parameters, on which the motion from one sample to the next depends.
pub(super) const OF_MOTION: usize = 6;
/// Places of ln α, ln β, ln L, ln η, ln Tn, τ, the offsets, and ln of the steering factor and of the largest rate.
pub(super) const FRONT: usize = 0;
pub(super) const REAR: usize = 1;
pub(super) const WHEELBASE: usize = 2;
pub(super) const INDEX: usize = 3;
pub(super) const LAG: usize = 4;
pub(super) const DELAY: usize = 5;
pub(super) const STEERING_OFFSET: usize = 6;
pub(super) const YAW_RATE_OFFSET: usize = 7;
pub(super) const STEERING_FACTOR: usize = 8;
pub(super) const RATE: usize = 9;

/// Below this speed the plant's dynamics are those of this speed, m/s, as in the FMU.
pub(super) const BLEND_SPEED: f64 = 1.0;

/// Shortest time constant of BicyclePlant, s.
const LEAST_LAG_S: f64 = 1e-4;

/// A rate of the road wheels that nothing reaches, rad/s.
pub(super) const UNLIMITED_RATE: f64 = 1e6;

/// A normal distribution of a parameter, wide enough for a kart and a lorry.
#[derive(Debug, Clone, Copy)]
pub(super) struct Prior {
    pub(super) mean: f64,
    pub(super) deviation: f64,
}

/// What is known of the steering's geometry.
#[derive(Debug, Clone, Copy)]
pub(super) struct Geometry {
    /// Stated, the steering factor is identified in its place, m.
    pub(super) wheelbase: Option<f64>,
    /// Whether the steering of the log is an angle.
    pub(super) is_angle: bool,
}

/// The prior of each parameter.
pub(super) fn priors(geometry: Geometry) -> [Prior; PARAMETERS] {
    let of = |mean: f64, deviation: f64| Prior { mean, deviation };
    [
        // Road cars have 40 to 110 rad/s² per rad at either axle.
        of(60.0_f64.ln(), 0.7),
        of(60.0_f64.ln(), 0.7),
        of(geometry.wheelbase.unwrap_or(2.7).ln(), 0.5),
        of(0.0, 0.2),
        // From a sensor of the angle itself, which has none, to a slow servo.
        of(0.005_f64.ln(), 2.0),
        of(0.0, 0.05),
        // A degree of misalignment and half a degree a second of gyro bias.
        of(0.0, 0.02),
        of(0.0, 0.01),
        // The angle at a command of 1 may be that of a servo or of a steering wheel.
        if geometry.is_angle { of(0.0, 0.3) } else { of(0.4_f64.ln(), 1.5) },
        // Fixed there unless the drive shows one.
        of(UNLIMITED_RATE.ln(), 1.0),
    ]
}

/// The model's coefficients, with derivatives where `S` carries them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Coefficients<S> {
    pub(super) a1: S,
    pub(super) a2: S,
    pub(super) a3: S,
    pub(super) a4: S,
    pub(super) b1: S,
    pub(super) b2: S,
    /// 1/Tn.
    pub(super) rate: S,
    /// Of the road wheels, rad/s.
    pub(super) rate_max: S,
    pub(super) delay: S,
    pub(super) steering_offset: S,
    pub(super) yaw_rate_offset: S,
    pub(super) steering_factor: S,
    /// L.
    wheelbase: S,
    /// K of the road wheel.
    gradient: S,
    /// Lr and m·Lf/(Cr·L), of which v_y/r of a steady turn is made.
    rear: S,
    rear_slip: S,
}

impl<S: Scalar> Coefficients<S> {
    /// Of the parameters and the front axle's share λ.
    pub(super) fn new(p: &[S; PARAMETERS], share: f64) -> Self {
        let (alpha, beta, wheelbase) = (p[FRONT].exp(), p[REAR].exp(), p[WHEELBASE].exp());
        let index = p[INDEX].exp();
        let (a, b) = (wheelbase.times(1.0 - share), wheelbase.times(share));
        // f = α·ρ/a and g = β·ρ/b with ρ = η·a·b.
        let (f, g) = (alpha * index * b, beta * index * a);
        Self {
            a1: -(f + g),
            a2: b * g - a * f,
            a3: beta - alpha,
            a4: -(alpha * a + beta * b),
            b1: f,
            b2: alpha,
            rate: (-p[LAG]).exp(),
            rate_max: p[RATE].exp(),
            delay: p[DELAY],
            steering_offset: p[STEERING_OFFSET],
            yaw_rate_offset: p[YAW_RATE_OFFSET],
            steering_factor: p[STEERING_FACTOR].exp(),
            wheelbase,
            gradient: (beta - alpha) * (alpha * beta * index * wheelbase).inverse(),
            rear: b,
            rear_slip: a * (g * wheelbase).inverse(),
        }
    }

    /// F(v) for (v_y, r), row by row, and the column of δ; blended below [`BLEND_SPEED`].
    pub(super) fn at_speed(&self, speed: f64) -> ([S; 4], [S; 2]) {
        let v = speed.max(BLEND_SPEED);
        let i = 1.0 / v;
        let lateral = [
            self.a1.times(i),
            self.a2.times(i) - S::constant(v),
            self.a3.times(i),
            self.a4.times(i),
        ];
        if speed >= BLEND_SPEED {
            return (lateral, [self.b1, self.b2]);
        }
        let turn = (self.wheelbase + self.gradient.times(speed * speed)).inverse().times(speed);
        let sideways = (self.rear - self.rear_slip.times(speed * speed)) * turn;
        let steer = -(lateral[0] * sideways + lateral[1] * turn);
        (lateral, [steer, self.b2.times(speed)])
    }
}

/// A combination that yaw rate identifies: name, unit, and value with its derivatives.
pub(super) type Combination = (&'static str, &'static str, Dual<{ PARAMETERS + 1 }>);

/// The identified combinations, some at a speed, with the log's steering ratio.
pub(super) fn combinations(p: &[f64; PARAMETERS], share: f64, speed: f64) -> Vec<Combination> {
    let d: [Dual<{ PARAMETERS + 1 }>; PARAMETERS] =
        std::array::from_fn(|i| Dual::parameter(p[i], i));
    let c = Coefficients::new(&d, share);
    let factor = c.steering_factor.inverse();
    let length = c.wheelbase * factor;
    let gradient = c.gradient * factor;
    let (v, square) = (speed, speed * speed);
    let mut all =
        vec![("effective_wheelbase", "m", length), ("understeer_gradient", "rad.s2/m", gradient)];
    // Where L + K·v² is twice L, or nothing.
    let ratio = length * gradient.inverse();
    if ratio.value() > 0.0 {
        all.push(("characteristic_speed", "m/s", ratio.sqrt()));
    } else if ratio.value() < 0.0 {
        all.push(("critical_speed", "m/s", (-ratio).sqrt()));
    }
    let gain = (length + gradient.times(square)).inverse().times(v);
    all.push(("yaw_rate_gain", "1/s", gain));
    all.push(("yaw_acceleration_gain", "1/s2", c.b2 * c.steering_factor));
    let determinant = (c.a1 * c.a4 - c.a2 * c.a3).times(1.0 / square) + c.a3;
    if determinant.value() > 0.0 {
        let frequency = determinant.sqrt();
        let damping = -(c.a1 + c.a4) * (frequency.times(2.0 * v)).inverse();
        all.push(("natural_frequency", "rad/s", frequency));
        all.push(("damping_ratio", "1", damping));
    }
    all.push(("front_stiffness_per_mass", "m/(s2.rad)", c.b1));
    all.push(("rear_stiffness_per_mass", "m/(s2.rad)", -(c.a1 + c.b1)));
    all.push(("dynamic_index", "1", d[INDEX].exp()));
    all.push(("actuator_time_constant", "s", d[LAG].exp()));
    if p[DELAY] > 0.0 {
        all.push(("actuator_delay", "s", d[DELAY]));
    }
    if is_limited(p) {
        all.push((Estimated::LARGEST_RATE, "rad/s", d[RATE].exp()));
    }
    all.push(("steering_offset_road_wheel", "rad", d[STEERING_OFFSET]));
    all.push(("yaw_rate_offset", "rad/s", d[YAW_RATE_OFFSET]));
    all
}

/// Whether the rate of the road wheels is limited.
pub(super) fn is_limited(p: &[f64; PARAMETERS]) -> bool {
    p[RATE] < UNLIMITED_RATE.ln()
}

/// The reverse of [`vehicle`], without offsets, for another steering ratio.
pub(super) fn of_vehicle(data: &VehicleData, steering_ratio: f64) -> [f64; PARAMETERS] {
    let (a, b) = (data.distance_front_m, data.distance_rear_m);
    let (mass, inertia) = (data.mass_kg, data.yaw_inertia_kgm2);
    let [front, rear] = data.axle_stiffness();
    let mut p = [0.0; PARAMETERS];
    p[FRONT] = (a * front / inertia).ln();
    p[REAR] = (b * rear / inertia).ln();
    p[WHEELBASE] = (a + b).ln();
    p[INDEX] = (inertia / (mass * a * b)).ln();
    p[LAG] = data.actuator_time_constant_s.ln();
    p[DELAY] = data.actuator_delay_s;
    p[RATE] = data.actuator_rate_max_radps.unwrap_or(UNLIMITED_RATE).ln();
    p[STEERING_FACTOR] = (steering_ratio / data.steering_ratio).ln();
    p
}

/// The vehicle whose yaw response is the identified one, with the mass and the share that are stated.
pub(super) fn vehicle(
    p: &[f64; PARAMETERS],
    options: &BicycleOptions,
    steering_ratio: f64,
) -> VehicleData {
    let c = Coefficients::new(p, options.front_share());
    let mass = options.mass();
    let wheelbase = p[WHEELBASE].exp();
    let (a, b) = (wheelbase * (1.0 - options.front_share()), wheelbase * options.front_share());
    VehicleData {
        mass_kg: mass,
        yaw_inertia_kgm2: mass * p[INDEX].exp() * a * b,
        distance_front_m: a,
        distance_rear_m: b,
        cornering_stiffness_front_npr: mass * c.b1,
        cornering_stiffness_rear_npr: -mass * (c.a1 + c.b1),
        // No response shows a shorter one, and the FMU takes none.
        actuator_time_constant_s: p[LAG].exp().max(LEAST_LAG_S),
        actuator_delay_s: p[DELAY].max(0.0),
        actuator_rate_max_radps: if is_limited(p) { Some(p[RATE].exp()) } else { None },
        steering_ratio: steering_ratio / c.steering_factor,
        ..VehicleData::default()
    }
}
