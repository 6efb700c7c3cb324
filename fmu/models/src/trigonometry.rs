//! Sine and cosine of the same bits on every platform, compiled into the step instead of called in
//! the platform's mathematics library.
//!
//! The angle is reduced by the nearest multiple of π/2, whose bits are cut into three parts
//! (Cody and Waite 1980) such that the products with the first two are exact; what is left, at most
//! π/4, goes into the Taylor series. No fused operation and no table: additions and multiplications
//! that IEEE 754 rounds the same way everywhere. Both results are within 3e-16 of the true ones.

use std::f64::consts::{FRAC_2_PI, TAU};

/// π/2, the first and the second 33 bits and the rest.
const QUARTER: [f64; 3] = [
    f64::from_bits(0x3FF9_21FB_5440_0000),
    f64::from_bits(0x3DD0_B461_1A60_0000),
    f64::from_bits(0x3BA3_198A_2E03_7073),
];

/// Beyond it, about 2²⁰ quarter turns, the products are not exact any more.
const LARGEST: f64 = 1.6e6;

/// 1.5·2⁵²: what is added to it is rounded to an integer, which stands in the lowest bits.
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

/// Sines and cosines of some angles, rad; by a short series where they are small, as they are
/// within a panel.
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::FRAC_PI_2;

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
