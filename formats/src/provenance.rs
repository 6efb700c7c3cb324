//! The sources of a file's content.

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::io::Read;

/// The sources and options of a file; without times and absolute paths.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// Version of steerwright that wrote the file.
    pub version: String,
    /// The files read, by name and content.
    pub sources: Vec<SourceFile>,
    /// The options in force, defaults included, by name.
    pub options: BTreeMap<String, String>,
}

/// A file that was read.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SourceFile {
    /// The file's name without its folder.
    pub name: String,
    /// SHA-256 of its bytes, in hexadecimal.
    pub sha256: String,
    /// Whether the hash is of the samples that were read: a large file is not read as a whole for it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub of_samples: bool,
}

impl SourceFile {
    /// Names a file by the last part of its path and the hash of its bytes.
    #[must_use]
    pub fn from_bytes(path: &std::path::Path, bytes: &[u8]) -> Self {
        let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        Self::named(name, bytes)
    }

    /// A file with this name, which may have folders in it, and the hash of its bytes.
    #[must_use]
    pub fn named(name: impl Into<String>, bytes: &[u8]) -> Self {
        Self { name: name.into(), sha256: sha256_hex(bytes), of_samples: false }
    }
}

/// SHA-256 in lower-case hexadecimal.
#[must_use]
pub fn sha256_hex(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

fn hex(digest: &[u8]) -> String {
    digest.iter().map(|b| format!("{b:02x}")).collect()
}

/// Hashes the bytes read through it, so that a file need not be kept in memory for its hash.
pub struct HashingReader<R> {
    inner: R,
    hash: Sha256,
}

impl<R: Read> HashingReader<R> {
    /// Around `inner`.
    #[must_use]
    pub fn new(inner: R) -> Self {
        Self { inner, hash: Sha256::new() }
    }

    /// SHA-256 of the bytes read so far, in lower-case hexadecimal.
    #[must_use]
    pub fn sha256_hex(&self) -> String {
        hex(&self.hash.clone().finalize())
    }
}

/// Hashes samples, channel by channel, in pieces of any length.
#[derive(Default)]
pub struct SampleHash {
    channels: Vec<(String, Sha256)>,
}

impl SampleHash {
    /// Adds samples of a channel.
    pub fn update(&mut self, channel: &str, samples: &[f64]) {
        let at = self.channels.iter().position(|(name, _)| name == channel);
        let at = at.unwrap_or_else(|| {
            self.channels.push((channel.into(), Sha256::new()));
            self.channels.len() - 1
        });
        let hash = &mut self.channels[at].1;
        samples.iter().for_each(|x| hash.update(x.to_le_bytes()));
    }

    /// SHA-256 of the names and samples, whatever the order of the channels, in hexadecimal.
    #[must_use]
    pub fn sha256_hex(mut self) -> String {
        self.channels.sort_by(|a, b| a.0.cmp(&b.0));
        let mut all = Sha256::new();
        for (name, hash) in self.channels {
            all.update((name.len() as u64).to_le_bytes());
            all.update(name);
            all.update(hash.finalize());
        }
        hex(&all.finalize())
    }
}

impl<R: Read> Read for HashingReader<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let count = self.inner.read(buffer)?;
        self.hash.update(&buffer[..count]);
        Ok(count)
    }
}
