//! Choices out of bytes.

/// Reads choices from bytes; zeros after their end.
pub(crate) struct Cursor<'a> {
    bytes: &'a [u8],
}

impl<'a> Cursor<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }

    pub(crate) fn byte(&mut self) -> u8 {
        match self.bytes.split_first() {
            Some((&first, rest)) => {
                self.bytes = rest;
                first
            }
            None => 0,
        }
    }

    /// One in `n`.
    pub(crate) fn rarely(&mut self, n: u8) -> bool {
        self.byte() % n == n - 1
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        if n == 0 { 0 } else { usize::from(self.byte()) % n }
    }

    fn word(&mut self) -> u64 {
        u64::from_le_bytes(std::array::from_fn(|_| self.byte()))
    }

    /// Small numbers mostly, then limits and non-numbers, then anything.
    pub(crate) fn real(&mut self) -> f64 {
        let choice = self.byte();
        match choice {
            0..=199 => (f64::from(choice) - 100.0) / 50.0,
            200..=219 => f64::from(choice) * 10.0 - 2100.0,
            220..=239 => [0.0, -0.0, 1e-300, 1e300, f64::MAX, 5e-324, 1e6, 1e-9][self.below(8)],
            240..=249 => [f64::NAN, f64::INFINITY, f64::NEG_INFINITY][self.below(3)],
            _ => f64::from_bits(self.word()),
        }
    }

    /// A step size: what importers use mostly, then anything.
    pub(crate) fn step(&mut self) -> f64 {
        match self.byte() {
            0..=99 => 0.01,
            100..=149 => 1.0 / 60.0,
            150..=179 => 0.1,
            180..=199 => 1e-5,
            200..=209 => 1.0,
            210..=214 => 60.0,
            _ => self.real(),
        }
    }

    pub(crate) fn integer(&mut self) -> i32 {
        let choice = self.byte();
        if choice < 250 { i32::from(choice) - 3 } else { self.word() as i32 }
    }
}
