//! The programs, one a file, and which of them is run.

mod bicycle;
mod closed_loop;
mod command_line;
mod coverage;
mod factor;
mod focus;
mod large;
mod long_log;
mod multivariable;
mod orders;
mod records;
mod refinement;
mod response;
mod single_track;
mod speed;

use clap::Parser;
use std::error::Error;

/// Runs the program of a name.
pub(crate) fn run(name: &str) -> Result<(), Box<dyn Error>> {
    match name {
        "bicycle" => bicycle::run()?,
        "closed_loop" => closed_loop::run()?,
        "command_line" => command_line::run()?,
        "coverage" => coverage::run()?,
        "factor" => factor::run()?,
        "focus" => focus::run()?,
        "large" => large::run()?,
        "long_log" => long_log::run()?,
        "multivariable" => multivariable::run()?,
        "orders" => orders::run()?,
        "records" => records::run()?,
        "refinement" => refinement::run()?,
        "response" => response::run()?,
        "single_track" => single_track::run()?,
        "speed" => speed::run()?,
        _ => return Err(format!("there is no program {name}").into()),
    }
    Ok(())
}

/// The options of a program, which follow its name.
fn options<A: Parser>() -> A {
    A::parse_from(std::env::args().skip(1))
}
