//! Runs a platform's libraries with the host in plain C (`tests/abi/host.c`) and this machine's own
//! with the same, and compares what both print.

use super::archives::{find, stem};
use super::differences::{Differences, differences};
use super::platform::{Platform, Runner};
use super::{LIBRARIES, apt, folder, library_file, setup};
use crate::files::{read, remove};
use crate::run::{root, run, shown};
use roxmltree::{Document, Node};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use zip::ZipArchive;

/// Communication steps of a run.
const STEPS: usize = 3000;
/// A difference beyond this part of the largest value is more than the last digits of a sine.
const TOLERANCE: f64 = 1e-9;
/// How far the first input of a unit swings; the next does half as far, and so on: a controller
/// whose reference and measurement were equal would do nothing.
const SWING: [(&str, f64); 2] = [("rad", 0.125), ("m", 16.0)];

/// What a library runs on.
struct Subject {
    name: String,
    guid: String,
    step: String,
    /// The variables that are read, in the order of the output's columns after the time.
    columns: Vec<String>,
    /// The host's words, for each run.
    runs: Vec<(&'static str, Vec<String>)>,
    folder: PathBuf,
}

/// Compares the trajectories of a platform's libraries with this machine's own, which are in the
/// archives below `native`.
pub(crate) fn compare(platform: Platform, native: &Path) -> Result<(), String> {
    let work = folder().join("runs");
    fs::create_dir_all(&work).map_err(|e| format!("{}: {e}", work.display()))?;
    let own_host = compile(None, &work)?;
    let host = compile(Some(platform), &work)?;
    let mut seen = Vec::new();
    let mut unlike = Vec::new();
    for archive in find(native)? {
        let name = stem(&archive);
        // One of each: the archives of a demo differ in their models, not in their libraries.
        if seen.contains(&name) || !LIBRARIES.iter().any(|(_, library)| *library == name) {
            continue;
        }
        let subject = unpack(&archive, &work.join(&name))?;
        let own = subject.folder.join(format!("binaries/linux64/{name}.so"));
        let other = library_file(platform, &name);
        for (what, words) in &subject.runs {
            let out = |of: &str| work.join(format!("{name} {what} {of}.txt"));
            let ours = drive(None, &own_host, &own, &subject, words, &out("native"))?;
            let theirs =
                drive(Some(platform), &host, &other, &subject, words, &out(platform.name()))?;
            let found = differences(&ours, &theirs, &subject.columns)
                .map_err(|e| format!("{name}, {what}: {e}"))?;
            println!("{}/{name}, {what}: {found}", platform.name());
            if !alike(platform, &found) {
                unlike.push(format!("{name}, {what}"));
            }
        }
        seen.push(name);
    }
    if platform.runner() == Runner::Wine {
        stop_wine();
    }
    if let Some((_, missing)) = LIBRARIES.iter().find(|(_, name)| !seen.iter().any(|s| s == name)) {
        return Err(format!("no archive of {missing} in {}", native.display()));
    }
    if unlike.is_empty() {
        Ok(())
    } else {
        Err(format!("not what this machine's own library gives: {}", unlike.join("; ")))
    }
}

/// Whether the difference is one that the platform may make: none on the same processor with the
/// same C library, and elsewhere the last digits of the C library's functions.
fn alike(platform: Platform, found: &Differences) -> bool {
    match platform.runner() {
        Runner::Itself => found.largest == 0.0,
        _ => found.largest <= TOLERANCE,
    }
}

/// Compiles the host, for this machine or another platform.
fn compile(platform: Option<Platform>, work: &Path) -> Result<PathBuf, String> {
    let source = root().join("tests/abi/host.c");
    let mut host = work.join(format!("host-{}", platform.map_or("native", Platform::name)));
    let mut compiler = match platform.map_or(Runner::Itself, Platform::runner) {
        Runner::Itself | Runner::Nothing => Command::new("cc"),
        Runner::Wine => {
            host.set_extension("exe");
            Command::new("x86_64-w64-mingw32-gcc")
        }
        Runner::Qemu => {
            let mut zig = Command::new(setup::zig()?.join("python-zig"));
            zig.args(["cc", "-target", "aarch64-linux-gnu.2.17"]);
            zig.env("ZIG_GLOBAL_CACHE_DIR", folder().join("tools/zig-cache"));
            zig
        }
    };
    compiler.args(["-std=c99", "-O1", "-I"]).arg(source.with_file_name("fmi2")).arg(&source);
    compiler.arg("-o").arg(&host);
    if host.extension().is_none() {
        compiler.args(["-ldl", "-lm"]);
    }
    run(&mut compiler)?;
    Ok(host)
}

/// Unpacks an archive and reads from its description what a run takes.
fn unpack(archive: &Path, to: &Path) -> Result<Subject, String> {
    let said = |e: &dyn std::fmt::Display| format!("{}: {e}", archive.display());
    remove(to)?;
    let file = File::open(archive).map_err(|e| said(&e))?;
    ZipArchive::new(file).and_then(|mut zip| zip.extract(to)).map_err(|e| said(&e))?;
    let text = fs::read_to_string(to.join("modelDescription.xml")).map_err(|e| said(&e))?;
    let document = Document::parse(&text).map_err(|e| said(&e))?;
    let text_of = |element: Option<Node<'_, '_>>, name: &str| {
        element.and_then(|node| node.attribute(name)).map(str::to_owned)
    };
    let element = |name: &str| document.descendants().find(|node| node.has_tag_name(name));

    let mut subject = Subject {
        name: stem(archive),
        guid: text_of(document.root_element().into(), "guid").ok_or_else(|| said(&"no guid"))?,
        step: text_of(element("DefaultExperiment"), "stepSize").unwrap_or_else(|| "0.01".into()),
        columns: Vec::new(),
        runs: Vec::new(),
        folder: to.to_path_buf(),
    };
    let mut words = Vec::new();
    let mut noise = None;
    for variable in document.descendants().filter(|node| node.has_tag_name("ScalarVariable")) {
        let reference = variable.attribute("valueReference").unwrap_or_default();
        let name = variable.attribute("name").unwrap_or_default();
        let Some(kind) = variable.children().find(Node::is_element) else { continue };
        let letter = match kind.tag_name().name() {
            "Real" => "",
            "Integer" => "i",
            "Boolean" => "b",
            _ => continue,
        };
        match variable.attribute("causality").unwrap_or("local") {
            "input" if letter.is_empty() => {
                let unit = kind.attribute("unit").unwrap_or_default();
                if let Some((_, swing)) = SWING.iter().find(|(of, _)| *of == unit) {
                    let count = words.len() as i32;
                    words.push(format!("{reference}~{}", swing * 0.5_f64.powi(count)));
                }
            }
            "output" | "local" => {
                subject.columns.push(name.to_owned());
                words.push(format!("{letter}{reference}"));
            }
            "parameter" if name == "noise_scale" => noise = Some(format!("{reference}=1")),
            _ => {}
        }
    }
    subject.runs.push(("inputs swinging", words.clone()));
    if let Some(noise) = noise {
        words.push(noise);
        subject.runs.push(("with noise", words));
    }
    Ok(subject)
}

/// One run; what it printed is kept in a file.
fn drive(
    platform: Option<Platform>,
    host: &Path,
    library: &Path,
    subject: &Subject,
    words: &[String],
    out: &Path,
) -> Result<String, String> {
    let resources = subject.folder.join("resources").display().to_string().replace(' ', "%20");
    let runner = platform.map_or(Runner::Itself, Platform::runner);
    let (mut command, library, uri) = match runner {
        Runner::Itself | Runner::Nothing => {
            (Command::new(host), library.display().to_string(), format!("file://{resources}"))
        }
        Runner::Qemu => {
            let mut qemu = Command::new("qemu-aarch64-static");
            qemu.args(["-L", setup::ARM_ROOT]).arg(host);
            (qemu, library.display().to_string(), format!("file://{resources}"))
        }
        Runner::Wine => {
            let mut wine = wine("wine64")?;
            wine.arg(host);
            // Wine's drive Z: is this machine's root.
            let library = format!("Z:{}", library.display()).replace('/', "\\");
            (wine, library, format!("file:///Z:{resources}"))
        }
    };
    command.arg(library).args([&subject.guid, &uri, &subject.step, &STEPS.to_string()]);
    // At last each of the functions once more.
    command.args(words).arg("calls").stdin(Stdio::null());
    // Files, not pipes: wine's services outlive the program and would hold a pipe open.
    let log = out.with_extension("log");
    let create = |path: &Path| File::create(path).map_err(|e| format!("{}: {e}", path.display()));
    command.stdout(create(out)?).stderr(create(&log)?);
    let line = shown(&command);
    let status = command.status().map_err(|e| format!("{line}: {e}"))?;
    if !status.success() {
        let log = fs::read(&log).unwrap_or_default();
        return Err(format!("{}: {status}\n{}", subject.name, String::from_utf8_lossy(&log)));
    }
    read(out)
}

/// A program of wine, with a Windows of its own in the target folder.
fn wine(program: &str) -> Result<Command, String> {
    let mut wine = Command::new(apt::find(program).ok_or_else(|| format!("no {program}"))?);
    wine.env("WINEPREFIX", folder().join("tools/wine"))
        .env("WINEDEBUG", "-all")
        // It would offer to download both.
        .env("WINEDLLOVERRIDES", "mscoree,mshtml=")
        .env_remove("DISPLAY");
    Ok(wine)
}

/// Ends wine's services, which would run longer than the program.
fn stop_wine() {
    let stopped = ["wineserver", "wineserver64"].into_iter().find_map(|program| {
        let mut wineserver = wine(program).ok()?;
        wineserver.arg("--kill").status().ok()
    });
    if stopped.is_none() {
        eprintln!("note: wine's services end by themselves");
    }
}
