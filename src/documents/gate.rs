//! Models that failed validation become no controllers or FMUs without `--accept-untrusted`.

use crate::documents::files;
use crate::failure::Failure;
use std::path::Path;
use steerwright_formats::{Document, Model, Pid, Quality, SourceFile, SpeedController};

/// Whether a model that failed validation is used.
#[derive(clap::Args, Debug, Clone, Copy, Default)]
pub(crate) struct GateArguments {
    /// Use a model that failed validation; all files made from it state its quality
    #[arg(long, help_heading = None::<&'static str>)]
    accept_untrusted: bool,
}

impl GateArguments {
    /// Refuses a model whose quality is `fail`; `what` is the file or the model in messages.
    pub(crate) fn check(self, what: &str, quality: &Quality) -> Result<(), Failure> {
        if self.allows(quality) {
            return Ok(());
        }
        let steps = quality.advice.iter().map(|advice| format!("{advice}\n      "));
        let (codes, summary) = (quality.codes(), &quality.summary);
        Err(Failure::requirement(
            format!("{what}: the quality of the model is fail ({codes}): {summary}"),
            steps.collect::<String>() + "or use the model nevertheless with --accept-untrusted",
        ))
    }

    pub(crate) fn allows(self, quality: &Quality) -> bool {
        self.accept_untrusted || quality.allows_design()
    }

    /// The model in a file, if its quality allows it, and the file's text.
    pub(crate) fn read(self, path: &Path) -> Result<(Model, SourceFile, String), Failure> {
        let text = files::read_text(path)?;
        let file = path.display().to_string();
        let model = Model::from_json(&text, &file)?;
        self.check(&file, model.quality())?;
        Ok((model, SourceFile::from_bytes(path, text.as_bytes()), text))
    }
}

/// The quality that a document states of the model that it holds or was made from; `None` for
/// documents that state none, such as paths.
pub(crate) fn quality_of(text: &str, file: &str) -> Result<Option<Quality>, Failure> {
    if Model::is_in(text) {
        return Ok(Some(Model::from_json(text, file)?.quality().clone()));
    }
    Ok(match steerwright_formats::schema_of(text).as_deref() {
        Some(Pid::SCHEMA) => Some(Pid::from_json(text, file)?.designed_for.quality),
        Some(SpeedController::SCHEMA) => Some(SpeedController::from_json(text, file)?.quality),
        _ => None,
    })
}
