//! Displacement segments between fixes: by how much fixes and gyro differ in their direction, and
//! how each term of the sideslip contributes to it. A displacement is `D + S·E_S + Q·E_Q + C·E_C`
//! but for where it starts and turns to, D by gyro and speed alone, `E_S = ∫ v·r·n dt, E_Q = ∫
//! v·r·a²·n dt, E_C = ∫ v·ṙ·n dt, a = v·r` (at most g), n the direction to the left: a term turns
//! it by the part of its E across D, over the length of D, to first order.
//!
//! Where S and Q are those of a reference speed v₀ and follow the speed (docs/methods/sideslip.md), E_S and
//! E_Q count by v/v₀, and the distance b to the rear axle adds `b/v₀·E_b`, `E_b = ∫ v·(v₀/v − v/v₀)·r·n dt`.
//!
//! Braking takes load off the rear axle, which then slips more: `P·E_P`, `E_P = ∫ v·a·v̇·n dt`. A drive that brakes
//! before its bends and accelerates out of them has that effect in Q, unless P is estimated beside it. P is no part of the
//! sideslip that is stated, which is that of a steady speed.

/// Terms of the sideslip, by their places: S, Q, C, b/v₀ and P.
pub(super) const TERMS: usize = 5;
pub(super) const RATE: usize = 0;
pub(super) const GROWTH: usize = 1;
pub(super) const ACCELERATION: usize = 2;
pub(super) const DISTANCE: usize = 3;
pub(super) const BRAKING: usize = 4;

/// The speed changes by what it does over so long to either side, s.
const AROUND_S: f64 = 0.25;

/// Below this speed, m/s, S and b are those of this speed: 1/v would grow without bound.
const LEAST_SPEED: f64 = 1.0;

/// Length of segments, s: for S alone and which terms there are, and for their values.
pub(super) const SEGMENT_S: f64 = 1.0;
pub(super) const SHORT_SEGMENT_S: f64 = 0.5;

/// The time that has a yaw and a bias of its own, s, and the least that is used of it.
pub(super) const BLOCK_S: f64 = 10.0;
pub(super) const LEAST_BLOCK_S: f64 = 6.0;

/// Fewest segments in a block, and fewest blocks from which scatter is computed.
pub(super) const LEAST_SEGMENTS: usize = 8;
pub(super) const LEAST_BLOCKS: usize = 6;

/// Residuals beyond so many deviations (by their median) are those of bad fixes.
pub(super) const OUTLIER: f64 = 6.0;

/// The terms of a displacement's length, by the places of the sideslip's.
pub(super) const AGE: usize = RATE;
pub(super) const SCALE: usize = GROWTH;

/// A drive between two gaps: gyro and speed on one clock, fixes on theirs with the same zero.
#[derive(Debug, Default)]
pub(super) struct SideslipPiece {
    /// Instants of the gyro's readings, s.
    pub(crate) time: Vec<f64>,
    pub(crate) yaw_rate: Vec<f64>,
    /// Speed, m/s; empty for one that does not change.
    pub(crate) speed: Vec<f64>,
    /// Instants at which the fixes were valid, s.
    pub(crate) fix_time: Vec<f64>,
    /// East and north, m.
    pub(crate) fix: Vec<[f64; 2]>,
}

impl SideslipPiece {
    /// Speed at an instant; `None` outside the gyro's readings.
    pub(super) fn speed_at(&self, time: f64) -> Option<f64> {
        let after = self.time.partition_point(|t| *t < time).max(1);
        let (t, v) = (self.time.get(after - 1..=after)?, self.speed.get(after - 1..=after)?);
        Some(v[0] + (v[1] - v[0]) * (time - t[0]) / (t[1] - t[0]))
    }

    /// v̇ at each of the gyro's instants, m/s², as a mean that the noise of a speed does not dominate.
    fn longitudinal_acceleration(&self) -> Vec<f64> {
        let (time, last) = (&self.time, self.speed.len().saturating_sub(1));
        let mut acceleration = vec![0.0; time.len()];
        let (mut from, mut to) = (0, 0);
        for k in 0..self.speed.len().min(time.len()) {
            while time[k] - time[from] > AROUND_S {
                from += 1;
            }
            while to < last && time[to] - time[k] < AROUND_S {
                to += 1;
            }
            if time[to] > time[from] {
                acceleration[k] = (self.speed[to] - self.speed[from]) / (time[to] - time[from]);
            }
        }
        acceleration
    }
}

/// How much longer a segment may become where fixes are missing, relative to it.
const LONGEST_OVER_LENGTH: f64 = 1.5;

/// Shortest displacement whose direction is informative, m.
const SHORTEST_M: f64 = 2.0;

/// A segment that turns by more has no information about the fixes' age, rad.
const STRAIGHT: f64 = 0.15;

/// No tyre carries more, m/s²: a reading beyond is none of sideslip.
const GRAVITY: f64 = 9.81;

/// By how much fixes and gyro differ in direction, and how much each term turns it.
#[derive(Debug, Clone, Copy)]
pub(super) struct DisplacementSegment {
    pub(super) time: f64,
    pub(super) difference: f64,
    pub(super) terms: [f64; TERMS],
}

/// The segments by blocks, for terms that follow the speed from a reference speed (m/s), or for constant
/// ones.
pub(super) fn blocks(
    piece: &SideslipPiece,
    length: f64,
    reference_speed: Option<f64>,
) -> Vec<Vec<DisplacementSegment>> {
    let mut blocks = by_time(segments(piece, length, reference_speed));
    for block in &mut blocks {
        for k in 1..block.len() {
            let last = block[k - 1].difference;
            block[k].difference = last + wrapped(block[k].difference - last);
        }
    }
    long_enough(&mut blocks);
    blocks
}

/// The lengths of the straight segments of a piece whose fixes are so old (s), by blocks.
pub(super) fn advances(piece: &SideslipPiece, seconds: f64) -> Vec<Vec<DisplacementSegment>> {
    let mut blocks = by_time(straights(piece, seconds));
    long_enough(&mut blocks);
    blocks
}

fn by_time(segments: Vec<DisplacementSegment>) -> Vec<Vec<DisplacementSegment>> {
    let mut blocks: Vec<Vec<DisplacementSegment>> = Vec::new();
    for displacement in segments {
        match blocks.last_mut() {
            Some(block) if displacement.time - block[0].time <= BLOCK_S => block.push(displacement),
            _ => blocks.push(vec![displacement]),
        }
    }
    blocks
}

fn long_enough(blocks: &mut Vec<Vec<DisplacementSegment>>) {
    blocks.retain(|segments| {
        segments.len() >= LEAST_SEGMENTS
            && segments[segments.len() - 1].time - segments[0].time >= LEAST_BLOCK_S
    });
}

/// Fixes of a piece about so long (s) apart.
fn pairs(piece: &SideslipPiece, length: f64) -> Vec<(usize, usize)> {
    let mut pairs = Vec::new();
    let mut later = 0;
    for (from, &begin) in piece.fix_time.iter().enumerate() {
        later = later.max(from);
        while later < piece.fix_time.len() && piece.fix_time[later] < begin + length - 1e-9 {
            later += 1;
        }
        let Some(&end) = piece.fix_time.get(later) else { break };
        if end - begin <= LONGEST_OVER_LENGTH * length {
            pairs.push((from, later));
        }
    }
    pairs
}

fn straights(piece: &SideslipPiece, seconds: f64) -> Vec<DisplacementSegment> {
    let Some(odometry) = Odometry::from_piece(piece, None) else { return Vec::new() };
    let displacement = |(from, later): (usize, usize)| {
        let (begin, end) = (piece.fix_time[from] - seconds, piece.fix_time[later] - seconds);
        let (a, b) = (odometry.place_at(begin)?, odometry.place_at(end)?);
        let change = piece.speed_at(end)? - piece.speed_at(begin)?;
        let led = [0, 1].map(|i| piece.fix[later][i] - piece.fix[from][i]);
        let displacement = [0, 1].map(|i| b.moved[0][i] - a.moved[0][i]);
        let (led, displacement) = (led[0].hypot(led[1]), displacement[0].hypot(displacement[1]));
        let is_straight = (b.yaw - a.yaw).abs() <= STRAIGHT && displacement.min(led) >= SHORTEST_M;
        if is_straight {
            Some(terms_of_age(led, displacement, change, 0.5 * (begin + end)))
        } else {
            None
        }
    };
    pairs(piece, SEGMENT_S).into_iter().filter_map(displacement).collect()
}

fn segments(
    piece: &SideslipPiece,
    length: f64,
    reference_speed: Option<f64>,
) -> Vec<DisplacementSegment> {
    let Some(odometry) = Odometry::from_piece(piece, reference_speed) else { return Vec::new() };
    let mut segments = Vec::new();
    for (from, later) in pairs(piece, length) {
        let (begin, end) = (piece.fix_time[from], piece.fix_time[later]);
        let (Some(a), Some(b)) = (odometry.place_at(begin), odometry.place_at(end)) else {
            continue;
        };
        let led = [0, 1].map(|i| piece.fix[later][i] - piece.fix[from][i]);
        let [displacement, terms @ ..] = std::array::from_fn::<_, { TERMS + 1 }, _>(|i| {
            [b.moved[i][0] - a.moved[i][0], b.moved[i][1] - a.moved[i][1]]
        });
        let square = displacement[0].powi(2) + displacement[1].powi(2);
        if led[0].hypot(led[1]) < SHORTEST_M || square <= 0.0 {
            continue;
        }
        segments.push(DisplacementSegment {
            time: 0.5 * (begin + end),
            difference: wrapped(led[1].atan2(led[0]) - displacement[1].atan2(displacement[0])),
            terms: terms.map(|e| (displacement[0] * e[1] - displacement[1] * e[0]) / square),
        });
    }
    segments
}

/// Where gyro and speed alone lead, and what each term of the sideslip adds to it for each unit.
#[derive(Debug, Clone, Copy, Default)]
struct DeadReckoned {
    yaw: f64,
    moved: [[f64; 2]; TERMS + 1],
}

/// [`DeadReckoned`] at the gyro's instants.
struct Odometry<'a> {
    time: &'a [f64],
    places: Vec<DeadReckoned>,
}

impl<'a> Odometry<'a> {
    fn from_piece(piece: &'a SideslipPiece, reference_speed: Option<f64>) -> Option<Self> {
        let speed = |k: usize| piece.speed.get(k).copied().unwrap_or(1.0);
        let longitudinal = piece.longitudinal_acceleration();
        let mut place = DeadReckoned::default();
        let mut places = vec![place];
        for (k, longitudinal) in longitudinal.into_iter().enumerate().skip(1) {
            let h = piece.time[k] - piece.time[k - 1];
            let (before, after) = (piece.yaw_rate[k - 1], piece.yaw_rate[k]);
            let rate = 0.5 * (before + after);
            let speed = 0.5 * (speed(k - 1) + speed(k));
            let (sin, cos) = (place.yaw + 0.5 * h * rate).sin_cos();
            let acceleration = (speed * rate).clamp(-GRAVITY, GRAVITY);
            let turned = h * rate;
            let [share, distance] = match reference_speed {
                None => [1.0, 0.0],
                Some(v0) => {
                    let v = speed.max(LEAST_SPEED);
                    [v / v0, v0 / v - v / v0]
                }
            };
            let terms = [
                share * turned,
                share * turned * acceleration * acceleration,
                after - before,
                distance * turned,
                turned * speed * longitudinal,
            ];
            let ahead = [h * speed * cos, h * speed * sin];
            let aside = terms.map(|term| [-term * speed * sin, term * speed * cos]);
            for (moved, by) in place.moved.iter_mut().zip(std::iter::once(ahead).chain(aside)) {
                moved[0] += by[0];
                moved[1] += by[1];
            }
            place.yaw += turned;
            places.push(place);
        }
        if piece.time.len() > 1 { Some(Self { time: &piece.time, places }) } else { None }
    }

    fn place_at(&self, time: f64) -> Option<DeadReckoned> {
        let after = self.time.partition_point(|t| *t < time);
        if after == 0 {
            return if self.time[0] <= time { Some(self.places[0]) } else { None };
        }
        let (a, b) = (self.places[after - 1], self.places.get(after)?);
        let part = (time - self.time[after - 1]) / (self.time[after] - self.time[after - 1]);
        let between = |a: f64, b: f64| a + part * (b - a);
        Some(DeadReckoned {
            yaw: between(a.yaw, b.yaw),
            moved: std::array::from_fn(|i| {
                [0, 1].map(|axis| between(a.moved[i][axis], b.moved[i][axis]))
            }),
        })
    }
}

fn wrapped(angle: f64) -> f64 {
    angle.sin().atan2(angle.cos())
}

/// Fixes `led` apart, while the speed covers `displacement` and changes by `change`.
fn terms_of_age(led: f64, displacement: f64, change: f64, time: f64) -> DisplacementSegment {
    let mut terms = [0.0; TERMS];
    (terms[AGE], terms[SCALE]) = (-change, displacement);
    DisplacementSegment { time, difference: led - displacement, terms }
}
