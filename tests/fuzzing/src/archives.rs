//! Archives as the importing side opens them.

use steerwright_host::Archive;

/// An archive is refused with a reason or opened; nothing of it is ever run.
pub(crate) fn archives(bytes: &[u8]) {
    if let Err(error) = Archive::from_bytes(bytes, "fuzzed.fmu") {
        assert!(!error.to_string().is_empty());
        assert!(!error.hint().is_empty());
    }
    // The description alone, without a zip around it.
    if let Ok(text) = std::str::from_utf8(bytes)
        && let Ok(description) = model_description::ModelDescription::from_xml(text)
    {
        let _ = description.findings();
        let again = model_description::ModelDescription::from_xml(&description.to_xml());
        assert!(again.is_ok(), "{again:?}");
    }
}
