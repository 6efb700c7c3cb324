//! The files in an archive's `resources/`.

use fmi2_export::Resources;
use steerwright_formats::Document;

/// The document of that name, where the archive has it.
pub(crate) fn optional<D: Document>(
    resources: &Resources,
    name: &str,
) -> Result<Option<D>, String> {
    let Some(bytes) = resources.get(name) else { return Ok(None) };
    let text = std::str::from_utf8(bytes).map_err(|e| format!("{name}: not UTF-8 text: {e}"))?;
    D::from_json(text, name).map(Some).map_err(|e| format!("{e}; hint: {}", e.hint()))
}

/// The document of that name.
pub(crate) fn required<D: Document>(resources: &Resources, name: &str) -> Result<D, String> {
    optional(resources, name)?.ok_or_else(|| {
        format!("resources/{name} is missing; pack the archive again with `steerwright package`")
    })
}
