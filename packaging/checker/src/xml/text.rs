//! The text of the description: encoding, declaration, nesting.

use crate::archive::Contents;
use crate::finding::{Findings, Location};
use model_description::{Excess, ExcessKind};

pub(crate) const DESCRIPTION: &str = "modelDescription.xml";

/// The largest size of a description, bytes; the largest known ones have about 10⁸.
const LARGEST: usize = 256 << 20;

/// The text of the description, or `None` if it must not be parsed.
pub(super) fn read(contents: &Contents<'_>, findings: &mut Findings) -> Option<String> {
    let Some(bytes) = contents.file(DESCRIPTION) else {
        let elsewhere = contents.names().find(|name| {
            name.rsplit('/').next().is_some_and(|file| file.eq_ignore_ascii_case(DESCRIPTION))
        });
        let message = match elsewhere {
            // A damaged entry is already a finding.
            Some(DESCRIPTION) => return None,
            Some(name) => {
                format!("modelDescription.xml is not at the top of the archive, but at {name:?}")
            }
            None => "modelDescription.xml is missing".into(),
        };
        findings.add("no-description", Location::archive(), message);
        return None;
    };
    let mut report =
        |rule, message: String| findings.add(rule, Location::entry(DESCRIPTION), message);
    if bytes.len() > LARGEST {
        report("not-examined", format!("{} bytes, more than {LARGEST}", bytes.len()));
        return None;
    }
    declaration(&bytes, &mut report);
    let mut text = match model_description::decoded(bytes) {
        Ok((text, _)) => text,
        Err(at) => {
            report("xml-undecodable", format!("it is not UTF-8 from byte {at} on"));
            return None;
        }
    };
    if text.starts_with('\u{feff}') {
        text.remove(0);
    }
    if let Some((rule, problem)) = nesting(&text) {
        report(rule, problem);
        return None;
    }
    Some(text)
}

/// Checks that the XML declaration has the encoding UTF-8 (section 2.2).
fn declaration(bytes: &[u8], report: &mut impl FnMut(&'static str, String)) {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let rest = text.strip_prefix(b"<?xml").and_then(|rest| rest.first());
    match model_description::declared_encoding(bytes) {
        None if rest.is_none_or(|byte| !byte.is_ascii_whitespace()) => {
            let message = "it does not begin with <?xml … encoding=\"UTF-8\"?>";
            report("xml-encoding", message.into());
        }
        None => report("xml-encoding", "its XML declaration has no encoding".into()),
        Some(name) if name.eq_ignore_ascii_case("UTF-8") => {}
        Some(name) => report("xml-encoding", format!("its declared encoding is {name:?}")),
    }
}

/// The rule and message if the text must not be parsed, by a count of open elements and attributes.
pub(crate) fn nesting(text: &str) -> Option<(&'static str, String)> {
    let Excess { kind, .. } = Excess::find(text)?;
    let rule = match kind {
        ExcessKind::Attributes => "xml-refused",
        ExcessKind::Depth => "not-examined",
    };
    Some((rule, kind.to_string()))
}
