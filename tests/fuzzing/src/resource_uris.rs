//! The resource location as an importer passes it.

use fmi2_export::uri;

/// A location is refused with a reason, or gives paths that can be opened.
pub(crate) fn resource_uris(bytes: &[u8]) {
    for windows in [false, true] {
        match uri::candidates(bytes, windows) {
            Ok(paths) => {
                assert!(!paths.is_empty());
                assert!(paths.iter().all(|path| !path.is_empty()));
            }
            Err(problem) => assert!(!problem.is_empty()),
        }
    }
    // A path that is escaped by RFC 8089 is returned unchanged.
    if bytes.first() == Some(&b'/') && bytes.get(1) != Some(&b'/') && !bytes.contains(&0) {
        let mut location = b"file://".to_vec();
        for &byte in bytes {
            if byte.is_ascii_alphanumeric() || b"-._~/".contains(&byte) {
                location.push(byte);
            } else {
                location.extend(format!("%{byte:02X}").into_bytes());
            }
        }
        let paths = uri::candidates(&location, false).expect("a good location");
        assert_eq!(paths[0], bytes, "{}", String::from_utf8_lossy(&location));
    }
}
