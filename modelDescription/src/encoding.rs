//! The encoding of a description's bytes. FMI 2.0 requires UTF-8 (2.2); some tools write ISO-8859-1.

/// The encoding that an XML declaration at the start of the bytes states.
#[must_use]
pub fn declared_encoding(bytes: &[u8]) -> Option<&str> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let declaration = bytes.strip_prefix(b"<?xml")?;
    declaration.first().filter(|byte| byte.is_ascii_whitespace())?;
    let end = declaration.windows(2).position(|pair| pair == b"?>")?;
    let declaration = std::str::from_utf8(&declaration[..end]).ok()?;
    let (_, rest) = declaration.split_once("encoding")?;
    let rest = rest.trim_start().strip_prefix('=')?.trim_start();
    let quote = rest.chars().next().filter(|c| matches!(c, '"' | '\''))?;
    rest[1..].split(quote).next()
}

/// The text of a description, and the encoding in which it was read, where that is not UTF-8. Bytes that are
/// UTF-8 are read as such, whatever they declare; others as the encoding that they declare.
///
/// # Errors
/// The first byte that is not UTF-8, where another encoding is not declared or not supported.
pub fn decoded(bytes: Vec<u8>) -> Result<(String, Option<&'static str>), usize> {
    let (bytes, at) = match String::from_utf8(bytes) {
        Ok(text) => return Ok((text, None)),
        Err(error) => {
            let at = error.utf8_error().valid_up_to();
            (error.into_bytes(), at)
        }
    };
    let declared = declared_encoding(&bytes).map(str::to_ascii_lowercase).unwrap_or_default();
    let latin_1 = |byte: &u8| char::from(*byte);
    match declared.as_str() {
        "iso-8859-1" | "iso8859-1" | "iso_8859-1" | "latin1" | "latin-1" => {
            Ok((bytes.iter().map(latin_1).collect(), Some("ISO-8859-1")))
        }
        "windows-1252" | "cp1252" => {
            let text = bytes.iter().map(|byte| match byte {
                0x80..=0x9f => WINDOWS_1252[usize::from(*byte) - 0x80],
                byte => latin_1(byte),
            });
            Ok((text.collect(), Some("windows-1252")))
        }
        _ => Err(at),
    }
}

/// The characters 0x80 to 0x9f, in which windows-1252 differs from ISO-8859-1.
#[rustfmt::skip]
const WINDOWS_1252: [char; 32] = [
    '€', '\u{81}', '‚', 'ƒ', '„', '…', '†', '‡', 'ˆ', '‰', 'Š', '‹', 'Œ', '\u{8d}', 'Ž', '\u{8f}',
    '\u{90}', '‘', '’', '“', '”', '•', '–', '—', '˜', '™', 'š', '›', 'œ', '\u{9d}', 'ž', 'Ÿ',
];

#[cfg(test)]
mod tests {
    use super::*;

    fn xml(encoding: &str, name: &[u8]) -> Vec<u8> {
        [format!("<?xml version=\"1.0\" encoding={encoding}?>").as_bytes(), name].concat()
    }

    #[test]
    fn the_declared_encoding_is_used_where_the_bytes_are_not_utf_8() {
        let read = |encoding: &str, name: &[u8]| {
            let (text, other) = decoded(xml(encoding, name))?;
            Ok::<_, usize>((text.split_once("?>").unwrap().1.to_owned(), other))
        };
        let latin = "ISO-8859-1";
        assert_eq!(read("'iso-8859-1'", b"L\xe4nge"), Ok(("Länge".into(), Some(latin))));
        assert_eq!(read("\"latin1\" standalone='no'", b"\xb0"), Ok(("°".into(), Some(latin))));
        let windows = Ok(("€ä".into(), Some("windows-1252")));
        assert_eq!(read("\"Windows-1252\"", b"\x80\xe4"), windows);
        // Plain or wrongly declared.
        assert_eq!(read("\"ISO-8859-1\"", b"Laenge"), Ok(("Laenge".into(), None)));
        assert_eq!(read("\"ISO-8859-1\"", "Länge".as_bytes()), Ok(("Länge".into(), None)));
        assert_eq!(read("\"UTF-8\"", b"L\xe4nge"), Err(39));
        assert_eq!(read("\"UTF-7\"", b"L\xe4nge"), Err(39));
        assert_eq!(decoded(b"\xe4".to_vec()), Err(0));
    }
}
