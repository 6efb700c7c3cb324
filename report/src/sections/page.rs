//! The page: which sections it has, in which order.

use super::{design, evidence, identification, outcome};
use crate::{Report, Section, report_html};

impl Report<'_> {
    /// The sections of the page.
    fn sections(&self) -> Vec<Section> {
        let mut out = vec![outcome::summary(self)];
        if let Some(plant) = self.plant {
            out.push(identification::log(plant, self.traces));
            out.push(identification::model(plant, self.traces, self.bicycle_fit));
            out.extend(evidence::evidence(plant));
        }
        if let Some(bicycle) = self.bicycle {
            out.push(design::bicycle(bicycle, self.bicycle_fit));
        }
        out.extend(self.controllers.iter().map(design::controller));
        if self.path.is_some() || !self.tracks.is_empty() {
            out.push(outcome::tracking(self.path, &self.tracks));
        }
        out.push(outcome::provenance(self));
        out
    }

    /// The page.
    #[must_use]
    pub fn to_html(&self) -> String {
        let lead = "Angles are in degrees, positive to the left (ISO 8855); a fit is \
                    100·(1 − ‖y − ŷ‖/‖y − mean(y)‖) in percent, of a simulation unless said otherwise.";
        report_html(&self.title, lead, &self.sections())
    }
}
