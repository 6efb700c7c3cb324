//! Random numbers that depend on the study's seed, a name and a run's index alone.
//!
//! A stream is ChaCha with 8 rounds (Bernstein 2008) under a key that is the SHA-256 of seed and
//! name, and the run's index as nonce (`docs/decisions/0035-sweep-rows.md`).

use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use sha2::{Digest, Sha256};

/// A stream's key.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Key([u8; 32]);

impl Key {
    /// The key of a named quantity under a seed.
    #[must_use]
    pub fn new(seed: u64, name: &str) -> Self {
        let mut hash = Sha256::new();
        hash.update(b"steerwright/sweep/1");
        hash.update(seed.to_le_bytes());
        hash.update(name.as_bytes());
        Self(hash.finalize().into())
    }

    /// The stream of a run.
    #[must_use]
    pub fn stream(&self, run: usize) -> ChaCha8Rng {
        let mut stream = ChaCha8Rng::from_seed(self.0);
        stream.set_stream(run as u64);
        stream
    }
}

/// A number, or the place of a varied quantity among a run's draws.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Number {
    Fixed(f64),
    Drawn(usize),
}

impl Number {
    pub(crate) fn evaluate(self, draws: &[f64]) -> f64 {
        match self {
            Self::Fixed(value) => value,
            Self::Drawn(index) => draws[index],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::Rng;

    #[test]
    fn streams_depend_on_seed_name_and_run_alone() {
        let first = |seed, name, run| Key::new(seed, name).stream(run).next_u64();
        assert_eq!(first(1, "speed", 3), first(1, "speed", 3));
        let all =
            [first(1, "speed", 3), first(2, "speed", 3), first(1, "kp", 3), first(1, "speed", 4)];
        for (i, a) in all.iter().enumerate() {
            assert!(!all[..i].contains(a));
        }
    }
}
