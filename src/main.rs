//! The program `steerwright`.

use std::process::ExitCode;

fn main() -> ExitCode {
    steerwright::run(std::env::args_os().collect(), None).into()
}
