//! The sideslip per yaw rate in a drive, from where a receiver's fixes lead.
//!
//! Course is yaw plus sideslip. With the gyro integrated, the direction χ in which the fixes lead and
//! the direction χ̂ in which speed and gyro alone lead over the same second differ by
//!
//! ```text
//! χ − χ̂ = ψ0 + b·t + S·r̄
//! ```
//!
//! ψ0 the yaw at the beginning, b the gyro's bias, r̄ the second's mean yaw rate, S the sideslip per yaw
//! rate. A second is long against the transients of the sideslip and the noise of a fix, and short
//! against a turn. ψ0 and b are those of 10 s each, so that what a gyro drifts by matters little; S is
//! one number, by least squares (Frisch and Waugh: ψ0 and b taken out of both sides). Its standard error
//! is that of clusters, one of 10 s (Liang and Zeger 1986), since seconds that overlap share fixes.
//!
//! **Latency.** A fix that is told to be τ younger than it is turns S into S − τ: in a steady turn the
//! two cannot be told apart. So the age of a fix is stated, never estimated, and its error is one of S.
//! **Antenna.** One that is `a` ahead of the centre of gravity moves by a·r to the side: with it comes
//! S + a/v.

use formats::Sideslip;

/// Length of the ways whose directions are compared, s.
const WAY_S: f64 = 1.0;

/// How much longer a way may become where fixes are missing, relative to it.
const STRETCH: f64 = 1.5;

/// Shortest way whose direction tells something, m.
const SHORTEST_M: f64 = 2.0;

/// The time that has a yaw and a bias of its own, s, and the least that is used of it.
const BLOCK_S: f64 = 10.0;
const LEAST_BLOCK_S: f64 = 6.0;

/// Fewest ways in a block, and fewest blocks that say something of scatter.
const LEAST_WAYS: usize = 8;
const LEAST_BLOCKS: usize = 6;

/// Residuals beyond so many deviations (by their median) are those of bad fixes.
const OUTLIER: f64 = 6.0;

/// The largest standard error with which a sideslip is told, s: a turn of 4 m/s² at 15 m/s then leads
/// 3 mrad astray, some 4 cm at a look-ahead of a second.
pub(crate) const LARGEST_ERROR_S: f64 = 0.01;

/// A drive between two gaps: gyro and, where there is one, speed on one clock; fixes on their own, which
/// has the same zero.
#[derive(Debug, Default)]
pub(crate) struct Piece {
    /// Instants of the gyro's readings, s.
    pub(crate) time: Vec<f64>,
    /// Yaw rate, rad/s.
    pub(crate) yaw_rate: Vec<f64>,
    /// Speed, m/s; empty for one that does not change.
    pub(crate) speed: Vec<f64>,
    /// Instants at which the fixes were valid, s.
    pub(crate) fix_time: Vec<f64>,
    /// East and north, m.
    pub(crate) fix: Vec<[f64; 2]>,
}

/// What is told beforehand, and goes into the file.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Receiver {
    pub(crate) latency_s: f64,
    pub(crate) antenna_x_m: f64,
}

/// A way: its middle, its mean yaw rate and by how much fixes and gyro differ in its direction.
#[derive(Debug, Clone, Copy)]
struct Way {
    time: f64,
    yaw_rate: f64,
    difference: f64,
}

/// The sideslip of the pieces, or why they do not tell it. `speed` is their mean, m/s.
pub(crate) fn sideslip(
    pieces: &[Piece],
    receiver: Receiver,
    speed: f64,
) -> Result<Sideslip, String> {
    let mut blocks: Vec<Vec<Way>> = pieces.iter().flat_map(blocks).collect();
    let told = |blocks: &[Vec<Way>]| match blocks.len() {
        n if n < LEAST_BLOCKS => Err(format!(
            "{:.0} s of fixes while driving are too few: {:.0} s are needed",
            n as f64 * BLOCK_S,
            LEAST_BLOCKS as f64 * BLOCK_S
        )),
        _ => Ok(regression(blocks)),
    };
    let first = told(&blocks)?;
    let mut sizes: Vec<f64> = first.residuals.iter().flatten().map(|r| r.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let bound = OUTLIER * 1.4826 * sizes[sizes.len() / 2];
    for (ways, residuals) in blocks.iter_mut().zip(&first.residuals) {
        let mut residuals = residuals.iter();
        ways.retain(|_| residuals.next().is_some_and(|r| r.abs() <= bound));
    }
    blocks.retain(|ways| ways.len() >= LEAST_WAYS);
    let Regression { slope, standard_error, .. } = told(&blocks)?;
    // A drive without a turn has none.
    if standard_error.is_nan() || standard_error > LARGEST_ERROR_S {
        return Err(format!(
            "its standard error would be {standard_error:.3} s, above {LARGEST_ERROR_S} s: drive \
             more turns, or with better fixes"
        ));
    }
    let of_antenna = if speed > 0.0 { receiver.antenna_x_m / speed } else { 0.0 };
    Ok(Sideslip {
        sideslip_per_yaw_rate_s: slope - of_antenna,
        standard_error_s: standard_error,
        gnss_latency_s: receiver.latency_s,
        antenna_x_m: receiver.antenna_x_m,
    })
}

struct Regression {
    slope: f64,
    standard_error: f64,
    residuals: Vec<Vec<f64>>,
}

/// S over all blocks, each with a yaw and a bias of its own.
fn regression(blocks: &[Vec<Way>]) -> Regression {
    let detrended: Vec<(Vec<f64>, Vec<f64>)> = blocks
        .iter()
        .map(|ways| {
            let of = |f: &dyn Fn(&Way) -> f64| ways.iter().map(f).collect::<Vec<f64>>();
            let time = of(&|w| w.time);
            (without_line(&time, of(&|w| w.yaw_rate)), without_line(&time, of(&|w| w.difference)))
        })
        .collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let square: f64 = detrended.iter().map(|(rate, _)| dot(rate, rate)).sum();
    let slope = detrended.iter().map(|(rate, angle)| dot(rate, angle)).sum::<f64>() / square;
    let residuals: Vec<Vec<f64>> = detrended
        .iter()
        .map(|(rate, angle)| rate.iter().zip(angle).map(|(r, a)| a - slope * r).collect())
        .collect();
    let scatter: f64 =
        detrended.iter().zip(&residuals).map(|((rate, _), u)| dot(rate, u).powi(2)).sum();
    let n = blocks.len() as f64;
    Regression { slope, standard_error: (n / (n - 1.0) * scatter).sqrt() / square, residuals }
}

/// What is left of values over time without their straight line.
fn without_line(time: &[f64], mut values: Vec<f64>) -> Vec<f64> {
    let n = time.len() as f64;
    let mean = |x: &[f64]| x.iter().sum::<f64>() / n;
    let (t0, v0) = (mean(time), mean(&values));
    let square: f64 = time.iter().map(|t| (t - t0).powi(2)).sum();
    let product: f64 = time.iter().zip(&values).map(|(t, v)| (t - t0) * (v - v0)).sum();
    let slope = if square > 0.0 { product / square } else { 0.0 };
    values.iter_mut().zip(time).for_each(|(v, t)| *v -= v0 + slope * (t - t0));
    values
}

/// The ways of a piece, by blocks.
fn blocks(piece: &Piece) -> Vec<Vec<Way>> {
    let mut blocks: Vec<Vec<Way>> = Vec::new();
    for way in ways(piece) {
        match blocks.last_mut() {
            Some(block) if way.time - block[0].time <= BLOCK_S => {
                let last = block[block.len() - 1].difference;
                block.push(Way { difference: last + wrapped(way.difference - last), ..way });
            }
            _ => blocks.push(vec![way]),
        }
    }
    blocks.retain(|ways| {
        ways.len() >= LEAST_WAYS && ways[ways.len() - 1].time - ways[0].time >= LEAST_BLOCK_S
    });
    blocks
}

fn ways(piece: &Piece) -> Vec<Way> {
    let Some(reckoned) = Reckoned::of(piece) else { return Vec::new() };
    let mut ways = Vec::new();
    let mut later = 0;
    for (from, &begin) in piece.fix_time.iter().enumerate() {
        later = later.max(from);
        while later < piece.fix_time.len() && piece.fix_time[later] < begin + WAY_S - 1e-9 {
            later += 1;
        }
        let Some(&end) = piece.fix_time.get(later) else { break };
        if end - begin > STRETCH * WAY_S {
            continue;
        }
        let (Some(a), Some(b)) = (reckoned.at(begin), reckoned.at(end)) else { continue };
        let led = [0, 1].map(|i| piece.fix[later][i] - piece.fix[from][i]);
        if led[0].hypot(led[1]) < SHORTEST_M || (b[0] - a[0]).hypot(b[1] - a[1]) <= 0.0 {
            continue;
        }
        let difference = wrapped(led[1].atan2(led[0]) - (b[1] - a[1]).atan2(b[0] - a[0]));
        let yaw_rate = (b[2] - a[2]) / (end - begin);
        ways.push(Way { time: 0.5 * (begin + end), yaw_rate, difference });
    }
    ways
}

/// Position and yaw by gyro and speed alone, at the gyro's instants.
struct Reckoned<'a> {
    time: &'a [f64],
    pose: Vec<[f64; 3]>,
}

impl<'a> Reckoned<'a> {
    fn of(piece: &'a Piece) -> Option<Self> {
        let speed = |k: usize| piece.speed.get(k).copied().unwrap_or(1.0);
        let mut pose = vec![[0.0; 3]];
        for k in 1..piece.time.len() {
            let h = piece.time[k] - piece.time[k - 1];
            let [x, y, yaw] = *pose.last()?;
            let turn = 0.5 * h * (piece.yaw_rate[k - 1] + piece.yaw_rate[k]);
            let way = 0.5 * h * (speed(k - 1) + speed(k));
            let middle = yaw + 0.5 * turn;
            pose.push([x + way * middle.cos(), y + way * middle.sin(), yaw + turn]);
        }
        (piece.time.len() > 1).then_some(Self { time: &piece.time, pose })
    }

    /// Between two readings by a straight line; `None` outside.
    fn at(&self, time: f64) -> Option<[f64; 3]> {
        let after = self.time.partition_point(|t| *t < time);
        if after == 0 {
            return (self.time[0] <= time).then(|| self.pose[0]);
        }
        let (a, b) = (self.pose[after - 1], self.pose.get(after)?);
        let part = (time - self.time[after - 1]) / (self.time[after] - self.time[after - 1]);
        Some([0, 1, 2].map(|i| a[i] + part * (b[i] - a[i])))
    }
}

fn wrapped(angle: f64) -> f64 {
    angle.sin().atan2(angle.cos())
}
