//! Sine, cosine and arctangent of the same bits on every platform, compiled into the step instead of
//! called in the platform's mathematics library.
//!
//! The angle is reduced by the nearest multiple of π/2, whose bits are cut into three parts
//! (Cody and Waite 1980) such that the products with the first two are exact; the remainder, at most
//! π/4, is the argument of the Taylor series. No fused operation and no table: additions and multiplications
//! that IEEE 754 rounds the same way everywhere. Both results are within 3e-16 of the true ones.

use std::f64::consts::{FRAC_2_PI, FRAC_PI_2, FRAC_PI_4, PI, TAU};

/// π/2, the first and the second 33 bits and the rest.
const QUARTER: [f64; 3] = [
    f64::from_bits(0x3FF9_21FB_5440_0000),
    f64::from_bits(0x3DD0_B461_1A60_0000),
    f64::from_bits(0x3BA3_198A_2E03_7073),
];

/// Beyond it, about 2²⁰ quarter turns, the products are not exact any more.
const LARGEST: f64 = 1.6e6;

/// 1.5·2⁵²: a number added to it is rounded to an integer in the lowest bits.
const TO_INTEGER: f64 = 6_755_399_441_055_744.0;

/// Coefficients of `(sin r − r)/r³` and `(cos r − 1 + r²/2)/r⁴`, by r².
const SERIES: [[f64; 2]; 7] = {
    let mut series = [[0.0; 2]; 7];
    let (mut k, mut factorial) = (0, 2.0);
    while k < 7 {
        let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
        let order = (2 * k + 3) as f64;
        factorial *= order;
        series[k][0] = -sign / factorial;
        factorial *= order + 1.0;
        series[k][1] = sign / factorial;
        k += 1;
    }
    series
};

/// Sine and cosine of an angle, rad; NaN where it is not finite.
#[inline]
#[must_use]
pub fn sin_cos(angle: f64) -> (f64, f64) {
    if angle.abs() <= LARGEST { of_moderate(angle) } else { of_large(angle) }
}

/// The remainder is exact, and taking TAU for 2π is a rounding of the angle in its 55th bit.
#[cold]
fn of_large(angle: f64) -> (f64, f64) {
    of_moderate(angle % TAU)
}

#[inline]
fn of_moderate(angle: f64) -> (f64, f64) {
    let shifted = angle * FRAC_2_PI + TO_INTEGER;
    let quarters = shifted - TO_INTEGER;
    let rest = ((angle - quarters * QUARTER[0]) - quarters * QUARTER[1]) - quarters * QUARTER[2];

    // Both polynomials at once, a lane each, in terms that do not wait for each other (Estrin).
    let q = rest * rest;
    let (q2, q4) = (q * q, (q * q) * (q * q));
    let mut sum = [0.0; 2];
    for (lane, sum) in sum.iter_mut().enumerate() {
        let c = |k: usize| SERIES[k][lane];
        let (low, middle, high) = (c(0) + c(1) * q, c(2) + c(3) * q, c(4) + c(5) * q + c(6) * q2);
        *sum = low + middle * q2 + high * q4;
    }
    let sin = rest + rest * q * sum[0];
    let cos = 1.0 + q * (-0.5 + q * sum[1]);

    // By bits: a vehicle that turns gives a branch nothing to predict.
    let quadrant = shifted.to_bits();
    let swapped = 0_u64.wrapping_sub(quadrant & 1);
    let difference = (sin.to_bits() ^ cos.to_bits()) & swapped;
    let negative = |quadrant: u64| (quadrant & 2) << 62;
    (
        f64::from_bits(sin.to_bits() ^ difference ^ negative(quadrant)),
        f64::from_bits(cos.to_bits() ^ difference ^ negative(quadrant.wrapping_add(1))),
    )
}

/// Largest root of the sum of squares for [`sin_cos_small`]'s series, rad.
const SMALL: f64 = 0.125;

const S3: f64 = -1.0 / 6.0;
const S5: f64 = 1.0 / 120.0;
const S7: f64 = -1.0 / 5040.0;
const S9: f64 = 1.0 / 362_880.0;
const C2: f64 = -0.5;
const C4: f64 = 1.0 / 24.0;
const C6: f64 = -1.0 / 720.0;
const C8: f64 = 1.0 / 40_320.0;
const C10: f64 = -1.0 / 3_628_800.0;

/// Sines and cosines of some angles, rad; by a short series where they are small.
#[inline(always)]
#[must_use]
pub fn sin_cos_small<const N: usize>(angles: &[f64; N]) -> ([f64; N], [f64; N]) {
    let square = angles.map(|a| a * a);
    // One test for all, written so that NaN goes the long way.
    if square.iter().sum::<f64>() <= SMALL * SMALL {
        let mut of = ([0.0; N], [0.0; N]);
        // Coefficients, not nested quotients: a division costs ten multiplications.
        for i in 0..N {
            let (a, q) = (angles[i], square[i]);
            of.0[i] = a + a * q * (S3 + q * (S5 + q * (S7 + q * S9)));
            of.1[i] = 1.0 + q * (C2 + q * (C4 + q * (C6 + q * (C8 + q * C10))));
        }
        of
    } else {
        each(angles)
    }
}

#[cold]
fn each<const N: usize>(angles: &[f64; N]) -> ([f64; N], [f64; N]) {
    (angles.map(|a| sin_cos(a).0), angles.map(|a| sin_cos(a).1))
}

/// tan(π/8) and tan(3π/8).
const TAN_EIGHTHS: [f64; 2] = [0.414_213_562_373_095_03, 2.414_213_562_373_095];

/// π/4 and π/2, rounded, and the rounding error.
const EIGHTHS: [[f64; 2]; 2] =
    [[FRAC_PI_4, 3.061_616_997_868_383e-17], [FRAC_PI_2, 6.123_233_995_736_766e-17]];

/// Coefficients of `(atan t − t)/t³` by t², interpolated at the Chebyshev points of t² in
/// [0, tan²(π/8)]: within 7e-18 of it, times t².
const ARCTANGENT: [f64; 11] = [
    -0.333_333_333_333_333_3,
    0.199_999_999_999_955_2,
    -0.142_857_142_846_665_42,
    0.111_111_110_152_563_61,
    -0.090_909_045_781_239_03,
    0.076_921_831_908_260_87,
    -0.066_645_114_473_819_48,
    0.058_581_489_128_022_1,
    -0.050_854_497_379_402_6,
    0.039_231_658_295_587_18,
    -0.019_176_887_119_062_253,
];

/// Arctangents of some numbers, rad; within 3e-16 of the true ones.
///
/// `atan a = π/4 + atan((a − 1)/(a + 1)) = π/2 + atan(−1/a)` bring the argument of the series below
/// tan(π/8). One division, no branch, so that the lanes of an array are computed together.
#[inline(always)]
#[must_use]
pub fn atan<const N: usize>(values: &[f64; N]) -> [f64; N] {
    let (mut t, mut base, mut rest) = ([0.0; N], [0.0; N], [0.0; N]);
    for i in 0..N {
        let a = values[i].abs();
        let (low, middle) = (a <= TAN_EIGHTHS[0], a <= TAN_EIGHTHS[1]);
        // Without a choice of constants by an index, which would be a load for each lane.
        let choose = |of_low: f64, of_middle: f64, of_high: f64| {
            let above = if middle { of_middle } else { of_high };
            if low { of_low } else { above }
        };
        base[i] = choose(0.0, EIGHTHS[0][0], EIGHTHS[1][0]);
        rest[i] = choose(0.0, EIGHTHS[0][1], EIGHTHS[1][1]);
        t[i] = choose(a, a - 1.0, -1.0) / choose(1.0, a + 1.0, a);
    }
    let mut result = [0.0; N];
    for i in 0..N {
        let c = &ARCTANGENT;
        let z = t[i] * t[i];
        let (z2, z4) = (z * z, (z * z) * (z * z));
        let low = (c[0] + c[1] * z) + (c[2] + c[3] * z) * z2;
        let middle = (c[4] + c[5] * z) + (c[6] + c[7] * z) * z2;
        let high = (c[8] + c[9] * z) + c[10] * z2;
        let series = low + (middle + high * z4) * z4;
        let sum = base[i] + (t[i] + (t[i] * z * series + rest[i]));
        result[i] = sum.copysign(values[i]);
    }
    result
}

/// π, rounded, and the rounding error.
const HALF_TURN: [f64; 2] = [PI, 1.224_646_799_147_353_2e-16];

/// Coefficients of `(sin r − r)/r³` by r², interpolated at the Chebyshev points of r² in
/// [0, (π/2)²]: within 3e-17 of it, times r².
const SINE: [f64; 8] = [
    -0.166_666_666_666_666_66,
    0.008_333_333_333_333_316,
    -0.000_198_412_698_412_549_74,
    2.755_731_921_916_323_4e-6,
    -2.505_210_761_699_618_2e-8,
    1.605_897_731_246_408_7e-10,
    -7.643_970_296_798_572e-13,
    2.731_444_766_986_399_5e-15,
];

/// Sines of some angles between −π and π, rad; within 3e-16 of the true ones.
#[inline(always)]
#[must_use]
pub fn sin_of_half_turn<const N: usize>(angles: &[f64; N]) -> [f64; N] {
    let mut result = [0.0; N];
    for i in 0..N {
        let a = angles[i].abs();
        // The difference is exact.
        let r = if a > FRAC_PI_2 { (HALF_TURN[0] - a) + HALF_TURN[1] } else { a };
        let c = &SINE;
        let q = r * r;
        let (q2, q4) = (q * q, (q * q) * (q * q));
        let low = (c[0] + c[1] * q) + (c[2] + c[3] * q) * q2;
        let high = (c[4] + c[5] * q) + (c[6] + c[7] * q) * q2;
        let sine = r + r * q * (low + high * q4);
        result[i] = sine.copysign(angles[i]);
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn assert_true(angle: f64) {
        let (sin, cos) = sin_cos(angle);
        let (s, c) = angle.sin_cos();
        assert!((sin - s).abs() < 3e-16 && (cos - c).abs() < 3e-16, "{angle}: {sin} {cos}");
    }

    proptest! {
        #[test]
        fn any_angle(angle in prop_oneof![-4.0..4.0_f64, -1e3..1e3_f64, -LARGEST..LARGEST]) {
            assert_true(angle);
        }

        /// Where all leading digits cancel.
        #[test]
        fn near_quarter_turns(quarters in -1_000_000..1_000_000_i64, off in -1e-6..1e-6_f64) {
            let angle = quarters as f64 * FRAC_PI_2;
            for angle in [angle, angle.next_up(), angle.next_down(), angle + off] {
                assert_true(angle);
            }
        }

        /// As near as the angle itself is known.
        #[test]
        fn beyond_the_exact_reduction(angle in LARGEST..1e12_f64) {
            for angle in [angle, -angle] {
                let ((sin, cos), (s, c)) = (sin_cos(angle), angle.sin_cos());
                let known = 3e-16 + 0.2 * f64::EPSILON * angle.abs();
                assert!((sin - s).abs() < known && (cos - c).abs() < known, "{angle}");
            }
        }

        #[test]
        fn together_as_alone(angles in prop::array::uniform4(prop_oneof![-0.1..0.1_f64, -9.0..9.0_f64])) {
            let (sin, cos) = sin_cos_small(&angles);
            for i in 0..4 {
                let (s, c) = angles[i].sin_cos();
                assert!((sin[i] - s).abs() < 3e-16 && (cos[i] - c).abs() < 3e-16);
            }
        }
    }

    #[test]
    fn symmetric_and_exact_where_it_can_be() {
        assert_eq!(sin_cos(0.0), (0.0, 1.0));
        for k in 1..10_000 {
            let angle = f64::from(k) * 0.37;
            let ((s, c), (s_of_less, c_of_less)) = (sin_cos(angle), sin_cos(-angle));
            assert_eq!((s.to_bits(), c.to_bits()), ((-s_of_less).to_bits(), c_of_less.to_bits()));
        }
    }

    #[test]
    fn arctangents() {
        let mut largest = 0.0_f64;
        let about = |x: f64| [x.next_down(), x, x.next_up()];
        let borders = TAN_EIGHTHS.into_iter().flat_map(about);
        let spread = (-40_000..=40_000).map(|k| (f64::from(k) * 5e-4).sinh());
        for x in spread.chain(borders).chain([1e-300, f64::MAX, f64::INFINITY]) {
            for x in [x, -x] {
                let [value] = atan(&[x]);
                largest = largest.max((value - x.atan()).abs() / x.atan().abs().max(1e-300));
            }
        }
        assert!(largest < 3e-16, "{largest:e}");
        let [zero, minus, nan] = atan(&[0.0, -0.0, f64::NAN]);
        assert!(zero.to_bits() == 0 && minus.to_bits() == (-0.0_f64).to_bits() && nan.is_nan());
    }

    #[test]
    fn sines_of_half_a_turn() {
        for k in -31_415..=31_415 {
            let x = f64::from(k) * 1e-4;
            let [value] = sin_of_half_turn(&[x]);
            assert!((value - x.sin()).abs() < 3e-16, "{x}");
        }
        assert!(sin_of_half_turn(&[f64::NAN])[0].is_nan());
        assert_eq!(sin_of_half_turn(&[-0.0])[0].to_bits(), (-0.0_f64).to_bits());
    }

    #[test]
    fn not_finite_is_nan() {
        for angle in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let (sin, cos) = sin_cos(angle);
            assert!(sin.is_nan() && cos.is_nan());
            let (sin, cos) = sin_cos_small(&[0.0, angle]);
            assert!(sin[0] == 0.0 && cos[0] == 1.0 && sin[1].is_nan() && cos[1].is_nan());
        }
    }

    #[test]
    fn small_angles_to_the_last_bit_but_one() {
        for k in -1250..=1250 {
            let a = f64::from(k) * 1e-4;
            let ([s], [c]) = sin_cos_small(&[a]);
            assert!((s - a.sin()).abs() < 1.2e-16 && (c - a.cos()).abs() < 2.3e-16, "{a}");
        }
    }

    #[test]
    fn the_parts_are_a_quarter_turn() {
        assert_eq!(QUARTER[0] + QUARTER[1], FRAC_PI_2);
        for part in &QUARTER[..2] {
            assert_eq!(part.to_bits() & 0xF_FFFF, 0, "33 bits at most");
        }
        // sin π for the double next to π is its distance from π.
        assert!((sin_cos(std::f64::consts::PI).0 - 1.224_646_799_147_353_2e-16).abs() < 1e-31);
    }
}
