//! The age of a receiver's fixes, from where the speed changes: `led − D = ε·D − τ·Δv` on segments
//! that hardly turn (docs/methods/sideslip.md), by least squares over blocks with an offset and a
//! drift of the speed of their own. The fixes are moved by τ until no more is found.
//!
//! The speed's own lag is unknown by [`SPEED_ERROR_S`], which goes into the standard error; the
//! rest of that is a jackknife over the blocks, since few of them may hold most of the speed's
//! changes.

use crate::sideslip::displacements::{AGE, DisplacementSegment, SCALE, SideslipPiece, advances};
use crate::sideslip::regression::robust;

/// Rounds in which the fixes are moved; each leaves τ²/2 times the change of acceleration.
const ROUNDS: usize = 6;
/// Standard deviation of the speed's own lag: half a row of a usual log, s.
const SPEED_ERROR_S: f64 = 0.005;
/// Ages of a receiver's fix, s; older ones are another clock's.
const OLDEST_S: f64 = 1.0;
/// An age is taken to be one that was not stated: uniform from 0 to 0.3 s, as a standard deviation, s.
pub(crate) const UNKNOWN_ERROR_S: f64 = 0.3 / 3.464_101_615_137_754_4;

/// Groups of blocks of which one is left out at a time: more change little, and a long log has many.
const MOST_GROUPS: usize = 40;

/// How old fixes are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Age {
    pub(crate) seconds: f64,
    pub(crate) standard_error: f64,
}

/// The age of the fixes; `None` where the drive does not determine it better than not at all.
pub(crate) fn age(pieces: &[SideslipPiece]) -> Option<Age> {
    if pieces.iter().any(|piece| piece.speed.is_empty()) {
        return None;
    }
    let mut seconds = 0.0;
    let mut blocks: Vec<Vec<DisplacementSegment>> = Vec::new();
    for _ in 0..ROUNDS {
        blocks = pieces.iter().flat_map(|piece| advances(piece, seconds)).collect();
        seconds += robust(&blocks, &[AGE, SCALE])?.values[AGE];
        if seconds.is_nan() || seconds.abs() > OLDEST_S {
            return None;
        }
    }
    let standard_error = jackknife(&blocks)?.hypot(SPEED_ERROR_S);
    // No fix comes before it was valid, but for the error.
    let is_found = standard_error < UNKNOWN_ERROR_S && seconds >= -3.0 * standard_error;
    if is_found { Some(Age { seconds: seconds.max(0.0), standard_error }) } else { None }
}

/// Standard error of the age by leaving out a group of neighbouring blocks at a time (Efron and Stein 1981).
fn jackknife(blocks: &[Vec<DisplacementSegment>]) -> Option<f64> {
    let groups = blocks.len().min(MOST_GROUPS);
    let without = |left_out: usize| {
        let group = left_out * blocks.len() / groups..(left_out + 1) * blocks.len() / groups;
        let rest = [&blocks[..group.start], &blocks[group.end..]].concat();
        Some(robust(&rest, &[AGE, SCALE])?.values[AGE])
    };
    let ages = (0..groups).map(without).collect::<Option<Vec<f64>>>()?;
    let count = ages.len() as f64;
    let mean = ages.iter().sum::<f64>() / count;
    let squares: f64 = ages.iter().map(|age| (age - mean).powi(2)).sum();
    Some((squares * (count - 1.0) / count).sqrt())
}
