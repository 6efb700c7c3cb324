//! The report in headless Chromium: tests/browser, on the page of a build.

use crate::cross;
use crate::files::remove;
use crate::python;
use crate::run::{program, root, run, target};
use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Names of the program on the path.
const NAMES: &[&str] = &["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];
/// Where the programs are that are not on the path.
const PLACES: &[&str] = &[
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
    "C:/Program Files/Google/Chrome/Application/chrome.exe",
    "C:/Program Files (x86)/Microsoft/Edge/Application/msedge.exe",
];

/// Builds a report and runs the tests on it.
///
/// # Errors
/// A test that fails; no Chromium, where it cannot be installed.
pub(crate) fn browser() -> Result<(), String> {
    let chromium = chromium()?;
    let folder = root().join("tests/browser");
    let python =
        python::environment_in(&target().join("browser-python"), &folder.join("requirements.txt"))?;
    let out = target().join("browser");
    build(&program(None)?, &out)?;
    let mut tests = python::command(&python);
    tests.args(["-m", "pytest", "-q", "-p", "no:cacheprovider"]).arg(&folder);
    tests.env("STEERWRIGHT_CHROMIUM", chromium).env("STEERWRIGHT_PAGES", out);
    run(tests.env("PYTHONDONTWRITEBYTECODE", "1"))
}

/// The tutorial's build, and a comparison of its models.
fn build(program: &Path, out: &Path) -> Result<(), String> {
    remove(out)?;
    let data = root().join("examples/drives/multibody");
    let mut build = Command::new(program);
    build.arg("build").arg(data.join("drive.csv"));
    build.args(["--input-channel", "steering_command_rad", "--steering-ratio", "1"]);
    build.args(["--max-rate", "0.4rad/s", "--vehicle"]).arg(data.join("vehicle.toml"));
    run(build.arg("--out").arg(out))?;
    let mut compare = Command::new(program);
    compare.arg("compare").args(["plant.json", "bicycle.json"].map(|name| out.join(name)));
    run(compare.arg("--out").arg(out.join("comparison")))
}

/// Chromium or a relative: the one that STEERWRIGHT_CHROMIUM names, an installed one, or Debian's,
/// which root installs.
pub(crate) fn chromium() -> Result<PathBuf, String> {
    let installed = || {
        let named = env::var_os("STEERWRIGHT_CHROMIUM").map(PathBuf::from);
        let place = || PLACES.iter().map(PathBuf::from).find(|file| file.is_file());
        named.or_else(|| NAMES.iter().find_map(|name| cross::find(name))).or_else(place)
    };
    if installed().is_none() && cross::find("apt-get").is_some() && cross::is_root() {
        cross::apt(&["chromium"])?;
    }
    installed().ok_or_else(|| {
        "the tests of the report need Chromium, which was not found\nhint: `apt-get install chromium`, \
         or name Chromium, Chrome or Edge in STEERWRIGHT_CHROMIUM"
            .into()
    })
}
