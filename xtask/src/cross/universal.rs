//! One library for both processors of macOS, in Apple's universal format: a header in big-endian
//! words (magic, number of slices; for each slice processor, its variant, offset, length and the
//! power of two that the offset is a multiple of) and the libraries as they are.
//!
//! FMI 2.0's `darwin64` means x86-64, but importers that run on ARM look there too.

use super::platform::Platform;
use super::{LIBRARIES, library_file};
use std::fs;

const MAGIC: u32 = 0xcafe_babe;
/// The magic of a 64-bit library, as its little-endian bytes.
const THIN: [u8; 4] = [0xcf, 0xfa, 0xed, 0xfe];
/// A page of ARM's macOS is 2^14 bytes.
const ALIGNMENT: u32 = 14;

/// Puts the ARM libraries into those of `darwin64`, where both were built.
pub(crate) fn join(platforms: &[Platform]) -> Result<(), String> {
    if !platforms.contains(&Platform::Darwin64) || !platforms.contains(&Platform::Aarch64Darwin) {
        return Ok(());
    }
    for (_, name) in LIBRARIES.iter() {
        let file = library_file(Platform::Darwin64, name);
        let read = |platform| {
            let file = library_file(platform, name);
            fs::read(&file).map_err(|e| format!("{}: {e}", file.display()))
        };
        let joined = universal(&[read(Platform::Darwin64)?, read(Platform::Aarch64Darwin)?])
            .map_err(|e| format!("{}: {e}", file.display()))?;
        fs::write(&file, joined).map_err(|e| format!("{}: {e}", file.display()))?;
    }
    eprintln!("darwin64: universal, for both processors");
    Ok(())
}

/// The universal library of thin ones.
fn universal(slices: &[Vec<u8>]) -> Result<Vec<u8>, String> {
    let word = |value: usize| u32::try_from(value).map_err(|_| "too long".to_owned());
    let mut header = Vec::new();
    header.extend(MAGIC.to_be_bytes());
    header.extend(word(slices.len())?.to_be_bytes());
    let page = 1_usize << ALIGNMENT;
    let mut body = Vec::new();
    // The header fits in the first page.
    let mut offset = page;
    for slice in slices {
        if slice.len() < 12 || slice[..4] != THIN {
            return Err("a slice is no 64-bit library of macOS".into());
        }
        // Processor and variant: little-endian in the library, big-endian in the header.
        header.extend(slice[4..8].iter().rev());
        header.extend(slice[8..12].iter().rev());
        header.extend(word(offset)?.to_be_bytes());
        header.extend(word(slice.len())?.to_be_bytes());
        header.extend(ALIGNMENT.to_be_bytes());
        body.resize(offset - page, 0);
        body.extend(slice);
        offset = (offset + slice.len()).next_multiple_of(page);
    }
    header.resize(page, 0);
    header.extend(body);
    Ok(header)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use object::read::macho::{FatArch, MachOFatFile32};

    #[test]
    fn an_independent_reader_finds_both_libraries() {
        let thin = |processor: u32, length: usize| {
            let mut bytes = THIN.to_vec();
            bytes.extend(processor.to_le_bytes());
            bytes.extend([3, 0, 0, 0]);
            bytes.resize(length, u8::try_from(processor & 0xff).unwrap());
            bytes
        };
        let slices = [thin(0x0100_0007, 40_000), thin(0x0100_000c, 1000)];
        let joined = universal(&slices).unwrap();
        let fat = MachOFatFile32::parse(&*joined).unwrap();
        assert_eq!(fat.arches().len(), 2);
        let processors = [object::Architecture::X86_64, object::Architecture::Aarch64];
        for ((arch, slice), processor) in fat.arches().iter().zip(&slices).zip(processors) {
            assert_eq!(arch.architecture(), processor);
            assert_eq!(arch.data(&*joined).unwrap(), slice);
            assert_eq!(arch.offset() % (1 << ALIGNMENT), 0);
        }
    }

    #[test]
    fn a_slice_that_is_no_library_is_refused() {
        assert!(universal(&[b"no library of macOS".to_vec()]).is_err());
        assert!(universal(&[THIN.to_vec()]).is_err());
    }
}
