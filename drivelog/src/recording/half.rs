//! Numbers of 16 bits.

/// A number of 16 bits (IEEE 754).
pub(super) fn half(bits: u16) -> f64 {
    let sign = if bits & 0x8000 == 0 { 1.0 } else { -1.0 };
    let fraction = f64::from(bits & 0x3FF) / 1024.0;
    sign * match (bits >> 10) & 0x1F {
        0 => fraction * 2_f64.powi(-14),
        0x1F if fraction == 0.0 => f64::INFINITY,
        0x1F => f64::NAN,
        exponent => (1.0 + fraction) * 2_f64.powi(i32::from(exponent) - 15),
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn numbers_of_ieee_754() {
        // numpy.float16
        for (bits, x) in
            [(0x3C00, 1.0), (0xC248, -3.140_625), (0x0001, 2_f64.powi(-24)), (0x7BFF, 65504.0)]
        {
            assert_eq!(super::half(bits), x);
        }
        assert!(super::half(0x7E00).is_nan() && super::half(0xFC00) == f64::NEG_INFINITY);
    }
}
