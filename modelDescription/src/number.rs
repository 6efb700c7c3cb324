//! Numbers as XML Schema writes them, whatever the host's locale.

/// The fewest digits that read back to the same number.
pub(crate) fn real(value: f64) -> String {
    if value.is_nan() {
        "NaN".into()
    } else if value.is_infinite() {
        if value > 0.0 { "INF".into() } else { "-INF".into() }
    } else {
        format!("{value:?}")
    }
}

/// A number as `xs:double` has it.
pub(crate) fn parse_real(text: &str) -> Option<f64> {
    text.trim().parse().ok()
}

/// A truth value as `xs:boolean` has it.
pub(crate) fn parse_boolean(text: &str) -> Option<bool> {
    match text.trim() {
        "true" | "1" => Some(true),
        "false" | "0" => Some(false),
        _ => None,
    }
}
