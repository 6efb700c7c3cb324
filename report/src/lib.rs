//! Plots, tables and the report, from the files of the other stages alone.
//!
//! - [`Figure`]: panels of curves, bands and marks, drawn as SVG; [`figures`] makes those of a
//!   report from plain data.
//! - [`Traces`], [`StepResponse`], [`Track`]: the tables behind them.
//! - [`Report`]: everything on one self-contained HTML page ([`report_html`] for other content).
//! - [`Table`]: aligned text for a terminal, HTML on the page.
//!
//! SI and radians everywhere but in what people see, where angles are in degrees. The same content
//! gives the same bytes. This crate has no part in identification, design or FMUs: it takes the
//! numbers as the files state them.

mod axis;
mod canvas;
mod data;
mod decimate;
mod draw;
mod error;
mod figure;
pub mod figures;
mod html;
mod layout;
mod legend;
mod markup;
mod page_text;
pub mod palette;
mod read;
mod report;
mod section;
mod sections;
mod table;

pub use error::Error;
pub use figure::{Figure, Mark, MarkPlace, Panel, Series, Style, Symbol};
pub use figures::ChannelSignals;
pub use html::{notebook_html, report_html};
pub use page_text::{TextStyle, page_text};
pub use palette::Color;
pub use read::{StepResponse, Traces, Track, TrackErrors};
pub use report::{Controller, LoopStep, Report};
pub use section::{Block, Section, Tone};
pub use sections::{
    channel_table, controller_section, manoeuvre_page, manoeuvre_sections, shortfalls,
    speed_controller_section,
};
pub use table::{COLUMNS, Table};

/// Name of this program in the files that it writes.
pub const GENERATOR: &str = "steerwright";
/// Usual width of a figure, px.
pub const WIDTH: u32 = 900;
