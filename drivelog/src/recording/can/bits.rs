//! Bits of a frame as numbers, in both byte orders.

/// The order of the bytes of a signal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Order {
    /// The first bit is the lowest.
    Intel,
    /// The first bit is the highest.
    Motorola,
}

/// The place of a signal in a frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bits {
    /// First byte.
    from: usize,
    /// Bits of the first byte before it: below it (Intel) or above it (Motorola).
    before: u32,
    length: u32,
    order: Order,
    is_signed: bool,
    is_float: bool,
}

/// A number before it is scaled.
pub(super) enum Raw {
    Integer(i128),
    Float(f64),
}

impl Bits {
    /// `start` as a DBC counts it; `None` where a frame has no such place.
    pub(super) fn new(start: u32, length: u32, order: Order, is_signed: bool) -> Option<Self> {
        if !(1..=64).contains(&length) || start >= 512 {
            return None;
        }
        let before = match order {
            Order::Intel => start % 8,
            Order::Motorola => 7 - start % 8,
        };
        Some(Self { from: start as usize / 8, before, length, order, is_signed, is_float: false })
    }

    /// The bits are a floating-point number; `None` where they are not as many.
    pub(super) fn become_float(&mut self, length: u32) -> Option<()> {
        self.is_float = self.length == length;
        if self.is_float { Some(()) } else { None }
    }

    /// The number; `None` where the frame is too short.
    pub(super) fn raw(&self, data: &[u8]) -> Option<Raw> {
        let count = (self.before + self.length).div_ceil(8);
        let bytes = data.get(self.from..self.from + count as usize)?;
        let join = |all: u128, byte: &u8| all << 8 | u128::from(*byte);
        let bits = match self.order {
            Order::Intel => bytes.iter().rev().fold(0, join) >> self.before,
            Order::Motorola => {
                bytes.iter().fold(0, join) >> (8 * count - self.before - self.length)
            }
        };
        let bits = (bits & ((1 << self.length) - 1)) as u64;
        Some(match (self.is_float, self.length) {
            (true, 32) => Raw::Float(f64::from(f32::from_bits(bits as u32))),
            (true, _) => Raw::Float(f64::from_bits(bits)),
            _ if self.is_signed => {
                // The sign is moved to the highest bit and back.
                let shift = 64 - self.length;
                Raw::Integer(i128::from((bits << shift) as i64 >> shift))
            }
            _ => Raw::Integer(i128::from(bits)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn integer(
        start: u32,
        length: u32,
        order: Order,
        is_signed: bool,
        data: &[u8],
    ) -> Option<i128> {
        match Bits::new(start, length, order, is_signed)?.raw(data)? {
            Raw::Integer(x) => Some(x),
            Raw::Float(_) => None,
        }
    }

    #[test]
    fn both_orders_and_signs() {
        let data = [0x12, 0x34, 0x56, 0x78, 0x9A, 0xBC, 0xDE, 0xF0];
        use Order::{Intel, Motorola};
        assert_eq!(integer(8, 16, Intel, false, &data), Some(0x5634));
        assert_eq!(integer(15, 16, Motorola, false, &data), Some(0x3456));
        assert_eq!(integer(4, 12, Intel, false, &data), Some(0x341));
        assert_eq!(integer(3, 12, Motorola, false, &data), Some(0x234));
        assert_eq!(integer(56, 8, Intel, true, &data), Some(-16));
        assert_eq!(integer(7, 64, Motorola, false, &data), Some(0x1234_5678_9ABC_DEF0));
        assert_eq!(integer(0, 64, Intel, true, &data), Some(-0x0F21_4365_87A9_CBEE));
        assert_eq!(integer(60, 8, Intel, false, &data), None);
        assert_eq!(integer(0, 65, Intel, false, &data), None);
    }
}
