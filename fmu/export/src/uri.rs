//! The resource location in the spellings that importers use.
//!
//! RFC 8089 defines `file:/p` and `file:///p`. Importers also pass `file:////p` (FMU containers),
//! unescaped spaces and UTF-8, a plain path without a scheme, and on Windows `file:///C:/p`,
//! `file://C:/p`, `file:C:/p`, `file:////server/share/p`.

use crate::resources::ResourceError;
use std::path::PathBuf;

/// The folder of a location: the first candidate that exists, else the first candidate.
pub(crate) fn folder(location: &[u8]) -> Result<PathBuf, ResourceError> {
    let candidates = candidates(location, cfg!(windows)).map_err(|problem| {
        let location = String::from_utf8_lossy(location).into_owned();
        ResourceError::Location { location, problem }
    })?;
    let mut paths: Vec<PathBuf> = candidates.into_iter().map(path).collect();
    let existing = paths.iter().position(|path| path.is_dir());
    Ok(paths.swap_remove(existing.unwrap_or(0)))
}

#[cfg(unix)]
fn path(bytes: Vec<u8>) -> PathBuf {
    use std::os::unix::ffi::OsStringExt;
    std::ffi::OsString::from_vec(bytes).into()
}

#[cfg(not(unix))]
fn path(bytes: Vec<u8>) -> PathBuf {
    String::from_utf8_lossy(&bytes).into_owned().into()
}

/// The possible paths of a location, the most likely first: with escapes decoded, then literally (a
/// folder may be called `a%20b`, and not every importer escapes it). Never empty.
///
/// # Errors
/// Why the location is not a path.
pub fn candidates(location: &[u8], windows: bool) -> Result<Vec<Vec<u8>>, String> {
    let scheme = location.get(..5).filter(|scheme| scheme.eq_ignore_ascii_case(b"file:"));
    let path = match scheme {
        None if contains(location, b"://") => return Err("is not a file: URI".into()),
        None => {
            return if location.is_empty() {
                Err("is empty".into())
            } else {
                Ok(vec![location.into()])
            };
        }
        Some(scheme) => strip_host(&location[scheme.len()..], windows)?,
    };
    let path = local(&path, windows);
    if path.is_empty() {
        return Err("names no folder".into());
    }
    let decoded = decode(&path);
    Ok(if decoded == path { vec![path] } else { vec![decoded, path] })
}

fn contains(text: &[u8], part: &[u8]) -> bool {
    text.windows(part.len()).any(|window| window == part)
}

/// `//host/path` without its host if the host is this machine.
fn strip_host(rest: &[u8], windows: bool) -> Result<Vec<u8>, String> {
    let Some(authority) = rest.strip_prefix(b"//") else { return Ok(rest.into()) };
    let end = authority.iter().position(|byte| *byte == b'/').unwrap_or(authority.len());
    let (host, path) = authority.split_at(end);
    if host.is_empty() || host.eq_ignore_ascii_case(b"localhost") {
        Ok(path.into())
    } else if is_drive(host) {
        Ok(authority.into())
    } else if windows {
        Ok(rest.into())
    } else {
        Err(format!("is on another host, {}", String::from_utf8_lossy(host)))
    }
}

fn is_drive(text: &[u8]) -> bool {
    matches!(text, [letter, b':' | b'|'] if letter.is_ascii_alphabetic())
}

/// The leading slashes of the system's paths: none before a drive, two before a server, else one.
fn local(path: &[u8], windows: bool) -> Vec<u8> {
    let slashes = path.iter().take_while(|byte| **byte == b'/').count();
    let bare = &path[slashes..];
    let drive = windows
        && bare.get(..2).is_some_and(is_drive)
        && bare.get(2).is_none_or(|byte| matches!(byte, b'/' | b'\\'));
    if drive {
        let mut path = bare.to_vec();
        path[1] = b':';
        return path;
    }
    let keep = if windows { slashes.min(2) } else { slashes.min(1) };
    path[slashes - keep..].into()
}

/// Decodes escapes such as `%20`; a `%` that two hexadecimal digits do not follow is kept.
fn decode(text: &[u8]) -> Vec<u8> {
    let digit = |byte: Option<&u8>| byte.and_then(|byte| char::from(*byte).to_digit(16));
    let mut decoded = Vec::with_capacity(text.len());
    let mut i = 0;
    while let Some(&byte) = text.get(i) {
        match (byte, digit(text.get(i + 1)), digit(text.get(i + 2))) {
            (b'%', Some(high), Some(low)) => {
                decoded.push(u8::try_from(high * 16 + low).unwrap_or(b'?'));
                i += 3;
            }
            _ => {
                decoded.push(byte);
                i += 1;
            }
        }
    }
    decoded
}

#[cfg(test)]
mod tests {
    use super::*;

    fn first(location: &str, windows: bool) -> String {
        let mut candidates = candidates(location.as_bytes(), windows).unwrap();
        String::from_utf8(candidates.swap_remove(0)).unwrap()
    }

    #[test]
    fn every_spelling_of_a_path() {
        for spelling in ["file:/tmp/a b", "file:///tmp/a%20b", "file:////tmp/a b", "/tmp/a b"] {
            assert_eq!(first(spelling, false), "/tmp/a b", "{spelling}");
        }
        for spelling in ["file://localhost/tmp/ü", "FILE:///tmp/%C3%BC", "file:///tmp/%c3%bc"] {
            assert_eq!(first(spelling, false), "/tmp/ü", "{spelling}");
        }
    }

    #[test]
    fn windows_drives_and_servers() {
        for spelling in ["file:///C:/a", "file:/C:/a", "file:C:/a", "file://C:/a", "file:////C:/a"]
        {
            assert_eq!(first(spelling, true), "C:/a", "{spelling}");
        }
        assert_eq!(first("file:///C|/a", true), "C:/a");
        assert_eq!(first("C:\\a", true), "C:\\a");
        for spelling in ["file:////server/share/a", "file://server/share/a"] {
            assert_eq!(first(spelling, true), "//server/share/a", "{spelling}");
        }
    }

    #[test]
    fn percent_signs_that_escape_nothing() {
        assert_eq!(first("file:///tmp/100%", false), "/tmp/100%");
        assert_eq!(first("file:///tmp/%zz%2", false), "/tmp/%zz%2");
        assert_eq!(candidates(b"file:///a%20b", false).unwrap()[1], b"/a%20b");
    }

    #[test]
    fn no_paths() {
        for location in ["", "file:", "file://", "http://example.org/a", "file://elsewhere/a"] {
            assert!(candidates(location.as_bytes(), false).is_err(), "{location}");
        }
    }
}
