//! `file:` URIs (RFC 8089) for `fmuResourceLocation`.

use std::path::Path;

/// The `file:///` URI of an absolute path, percent-encoded as UTF-8; on Windows backslashes become
/// slashes and the drive stays readable (`file:///C:/…`).
pub(crate) fn file_uri(path: &Path) -> String {
    let text = path.to_string_lossy();
    let text = if cfg!(windows) {
        // A canonical Windows path may carry the `\\?\` prefix, which has no URI.
        text.trim_start_matches(r"\\?\").replace('\\', "/")
    } else {
        text.into_owned()
    };
    let mut uri = String::from("file://");
    if !text.starts_with('/') {
        uri.push('/');
    }
    for (i, byte) in text.bytes().enumerate() {
        let drive_colon = cfg!(windows) && i == 1 && byte == b':';
        // RFC 3986 unreserved characters and the path separator stay as they are.
        if byte.is_ascii_alphanumeric() || b"-._~/".contains(&byte) || drive_colon {
            uri.push(char::from(byte));
        } else {
            uri.push_str(&format!("%{byte:02X}"));
        }
    }
    uri
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn everything_but_unreserved_characters_is_percent_encoded() {
        assert_eq!(
            file_uri(Path::new("/tmp/ä b#c%d?/x-1._~")),
            "file:///tmp/%C3%A4%20b%23c%25d%3F/x-1._~"
        );
    }
}
