//! The importer in C, `host.c`, with the headers of the standard: that the functions can be called
//! as these declare them, and that what it reads is what Rust reads, bit for bit.

use crate::samples::{Sample, samples};
use crate::unit::Unit;
use model_description::{Causality, Kind, Variable};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

/// The compiled host; `None` without a C compiler, which is printed once.
pub(crate) fn host() -> Option<&'static Path> {
    static HOST: OnceLock<Option<PathBuf>> = OnceLock::new();
    HOST.get_or_init(|| {
        let here = Path::new(env!("CARGO_MANIFEST_DIR"));
        let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join("host");
        let compiled = Command::new("cc")
            .args(["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-O1", "-g", "-I"])
            .arg(here.join("fmi2"))
            .arg(here.join("host.c"))
            .arg("-o")
            .arg(&program)
            .args(["-ldl", "-lm"])
            .output();
        match compiled {
            Ok(output) => {
                let logged = String::from_utf8_lossy(&output.stderr);
                assert!(output.status.success(), "host.c: {logged}");
                Some(program)
            }
            Err(error) => {
                println!("left out: the importer in C, for there is no cc: {error}");
                None
            }
        }
    })
    .as_deref()
}

/// `LIBRARY GUID URI STEP COUNT` of a sample.
fn plain(sample: &Sample, count: u32) -> Vec<String> {
    let step = sample.step().to_string();
    let library = sample.library.display().to_string();
    vec![library, sample.description.guid.clone(), sample.uri(), step, count.to_string()]
}

/// The steering inputs of a sample, and its outputs.
fn words(sample: &Sample) -> Vec<String> {
    let mut words = Vec::new();
    for (i, input) in sample.of(Kind::Real, Causality::Input).enumerate() {
        // A speed stays positive: it is set once.
        let word = if is_speed(input) { "=14.5".into() } else { format!("~{}", amplitude(i)) };
        words.push(format!("{}{word}", input.reference));
    }
    words.extend(outputs(sample).map(|output| match output.kind {
        Kind::Boolean => format!("b{}", output.reference),
        Kind::Integer => format!("i{}", output.reference),
        _ => output.reference.to_string(),
    }));
    words
}

fn is_speed(input: &Variable) -> bool {
    input.min == Some(0.0)
}

/// Each input has its own: a controller steers by the difference of two.
fn amplitude(input: usize) -> f64 {
    0.125 / (1 + input) as f64
}

fn outputs(sample: &Sample) -> impl Iterator<Item = &Variable> {
    sample.variables().iter().filter(|v| v.causality == Causality::Output)
}

fn run(program: &Path, arguments: &[String]) -> Output {
    Command::new(program).args(arguments).output().unwrap()
}

/// The lines of a run that went well.
fn lines(program: &Path, arguments: &[String]) -> Vec<String> {
    let output = run(program, arguments);
    let logged = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {}: {logged}", output.status);
    String::from_utf8(output.stdout).unwrap().lines().map(str::to_owned).collect()
}

/// A number as `host.c` prints it.
fn hexadecimal(value: f64) -> String {
    let bits = value.to_bits();
    let (sign, mantissa) =
        (if value.is_sign_negative() { '-' } else { '+' }, bits & ((1 << 52) - 1));
    match (bits >> 52 & 0x7ff) as i32 {
        0x7ff => format!(" {sign}{}", if mantissa == 0 { "inf" } else { "nan" }),
        0 => format!(" {sign}0x0.{mantissa:013x}p{:+}", if mantissa == 0 { 0 } else { -1022 }),
        exponent => format!(" {sign}0x1.{mantissa:013x}p{:+}", exponent - 1023),
    }
}

/// The expected lines of the C host for the words above.
fn expected(sample: &Sample, count: u32) -> Vec<String> {
    let unit = Unit::initializing(sample);
    let speeds = sample.of(Kind::Real, Causality::Input).filter(|v| is_speed(v));
    speeds.for_each(|v| assert!(unit.set_real(v.reference, 14.5) <= 1));
    assert!(unit.exit_initialization() <= 1);
    let line = |time: f64| {
        let value = |output: &Variable| match output.kind {
            Kind::Real => f64::from_bits(unit.bits(output).1),
            _ => unit.bits(output).1 as i32 as f64,
        };
        let values: String = outputs(sample).map(|v| hexadecimal(value(v))).collect();
        format!("{}{values}", hexadecimal(time))
    };
    let h = sample.step();
    let mut lines = vec![line(0.0)];
    for k in 0..count {
        let phase = k % 64;
        let wave = f64::from(if phase < 32 { phase } else { 64 - phase }) / 16.0 - 1.0;
        let inputs = sample.of(Kind::Real, Causality::Input).enumerate();
        for (i, input) in inputs.filter(|(_, v)| !is_speed(v)) {
            assert!(unit.set_real(input.reference, amplitude(i) * wave) <= 1);
        }
        assert!(unit.step_at(f64::from(k) * h, h) <= 1);
        lines.push(line(f64::from(k + 1) * h));
    }
    lines
}

#[test]
fn c_reads_what_rust_reads() {
    let Some(host) = host() else { return };
    for sample in samples() {
        let arguments = [plain(sample, 300), words(sample)].concat();
        let read = lines(host, &arguments);
        assert_eq!(read, expected(sample, 300), "{}", sample.name());
        let distinct: std::collections::BTreeSet<_> =
            read.iter().map(|line| &line[line.find("p").unwrap()..]).collect();
        // One without memory repeats itself with its inputs, every 64 steps.
        assert!(distinct.len() > 30, "{}: nothing moves", sample.name());
    }
}

#[cfg(all(target_os = "linux", target_env = "gnu"))]
#[test]
fn no_unit_divides_by_zero_or_overflows() {
    let Some(host) = host() else { return };
    for sample in samples() {
        for (speed, scale) in
            [(14.5, 1.0), (14.5, 0.0), (14.5, 40.0), (0.5, 1.0), (0.0, 1.0), (0.0, 0.0)]
        {
            let mut arguments = plain(sample, 300);
            for (i, input) in sample.of(Kind::Real, Causality::Input).enumerate() {
                // Both a wave and what is held: the slope of a command is zero there.
                arguments.push(match is_speed(input) {
                    true => format!("{}={speed}", input.reference),
                    false => format!("{}~{}", input.reference, scale * amplitude(i)),
                });
            }
            arguments.extend(
                outputs(sample).filter(|o| o.kind == Kind::Real).map(|o| o.reference.to_string()),
            );
            arguments.extend(["reset".into(), "calls".into(), "traps".into()]);
            let output = run(host, &arguments);
            // Without a number it was ended by a signal.
            let name = sample.name();
            assert!(
                output.status.code().is_some(),
                "{name} at {speed} m/s, {scale}: {}",
                output.status
            );
        }
    }
}

#[test]
fn c_reads_the_same_after_a_reset() {
    let Some(host) = host() else { return };
    for sample in samples() {
        let arguments = [plain(sample, 100), words(sample), vec!["reset".into()]].concat();
        let read = lines(host, &arguments);
        assert_eq!(read.len(), 202);
        assert_eq!(read[..101], read[101..], "{}", sample.name());
    }
}

/// All 34, each called through its type in the header.
#[test]
fn c_calls_every_function() {
    let Some(host) = host() else { return };
    for sample in samples() {
        let flags = sample.flags();
        let status = |supported| if supported { "0" } else { "3" };
        let serializes = status(flags.can_serialize_fmu_state);
        let logged = lines(host, &[plain(sample, 2), vec!["calls".into()]].concat());
        let logged: Vec<(&str, &str)> = logged
            .iter()
            .filter(|l| l.starts_with("fmi2"))
            .filter_map(|l| l.split_once(' '))
            .collect();
        for (name, got) in &logged {
            let expected = match *name {
                "fmi2GetTypesPlatform" => "default",
                "fmi2GetVersion" => "2.0",
                "fmi2GetStatus" | "fmi2GetIntegerStatus" | "fmi2GetStringStatus" => "2",
                "fmi2CancelStep" => "3",
                "fmi2SerializedFMUstateSize"
                | "fmi2SerializeFMUstate"
                | "fmi2DeSerializeFMUstate" => serializes,
                "fmi2GetDirectionalDerivative" => status(flags.provides_directional_derivative),
                "fmi2SetRealInputDerivatives" => status(flags.can_interpolate_inputs),
                "fmi2GetRealOutputDerivatives" => status(flags.max_output_derivative_order > 0),
                _ => "0",
            };
            assert_eq!(*got, expected, "{} {name}", sample.name());
        }
        let names: Vec<&str> = logged.iter().map(|(name, _)| *name).collect();
        let implied = ["fmi2Instantiate", "fmi2FreeInstance"];
        for name in crate::api::NAMES.iter().filter(|name| !implied.contains(name)) {
            assert!(names.contains(name), "{name} was not called");
        }
    }
}

/// A state saved in one process goes on in another.
#[test]
fn a_serialized_state_is_loaded_in_another_process() {
    let Some(host) = host() else { return };
    for sample in samples() {
        if !sample.flags().can_serialize_fmu_state {
            println!("{}: states are not serialized, as its description says", sample.name());
            continue;
        }
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("state").display().to_string();
        let whole = lines(host, &[plain(sample, 90), words(sample)].concat());
        let save = vec![format!("save={file}")];
        let first = lines(host, &[plain(sample, 37), words(sample), save].concat());
        let load = vec![format!("load={file}"), "first=37".into()];
        let rest = lines(host, &[plain(sample, 53), words(sample), load].concat());
        assert_eq!(first, whole[..38], "{}", sample.name());
        assert_eq!(rest, whole[37..], "{}", sample.name());
    }
}

/// A locale with a decimal comma, installed or made; `None` where neither can be had.
fn with_comma(folder: &Path) -> Option<(String, PathBuf)> {
    let names = ["de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "fr_FR.utf8", "de_DE", "fr_FR"];
    let installed = Command::new("locale").arg("-a").output().ok()?;
    let installed = String::from_utf8_lossy(&installed.stdout).into_owned();
    if let Some(name) = names.iter().find(|name| installed.lines().any(|line| line == **name)) {
        return Some(((*name).into(), PathBuf::new()));
    }
    let made = folder.join("de_DE.UTF-8");
    let define = ["--no-warnings=all", "-f", "UTF-8", "-i", "de_DE"];
    // A warning may be its exit status of 1; the files count.
    Command::new("localedef").args(define).arg(&made).output().ok()?;
    made.join("LC_NUMERIC").is_file().then(|| ("de_DE.UTF-8".into(), folder.to_owned()))
}

/// Numbers in `resources/` are read in any locale of the importer.
#[test]
#[cfg(target_os = "linux")]
fn a_decimal_comma_changes_nothing() {
    let Some(host) = host() else { return };
    let folder = tempfile::tempdir().unwrap();
    let Some((name, place)) = with_comma(folder.path()) else {
        println!("left out: a locale with a decimal comma, for there is none");
        return;
    };
    for sample in samples() {
        let arguments = [plain(sample, 100), words(sample)].concat();
        let with = [arguments.clone(), vec![format!("locale={name}")]].concat();
        let mut command = Command::new(host);
        if place.is_dir() {
            command.env("LOCPATH", &place);
        }
        let output = command.args(with).output().unwrap();
        let logged = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && logged.contains("decimal point ,"), "{logged}");
        let read = String::from_utf8(output.stdout).unwrap();
        assert!(read.lines().eq(lines(host, &arguments)), "{}", sample.name());
    }
}

/// What C does with a message is what `printf` does with a format.
#[test]
fn percent_signs_in_messages_are_text() {
    let Some(host) = host() else { return };
    for sample in samples() {
        let mut arguments = plain(sample, 1);
        arguments[1] = "%s%n%s%n%d%1000000d%%".into();
        let output = run(host, &arguments);
        assert_eq!(output.status.code(), Some(1), "{}", output.status);
        let logged = String::from_utf8_lossy(&output.stderr);
        assert!(logged.contains("the GUID given is \"%s%n%s%n%d%1000000d%%\""), "{logged}");
    }
}

/// Runs the host under valgrind on every FMU: no invalid access, nothing lost.
fn under_valgrind(cycles: u32) {
    let Some(host) = host() else { return };
    if Command::new("valgrind").arg("--version").output().is_err() {
        println!("left out: the run under valgrind, for there is none");
        return;
    }
    let mut children = Vec::new();
    for sample in samples() {
        let mut arguments = [plain(sample, 30), words(sample), vec!["calls".into()]].concat();
        arguments.push(format!("cycles={cycles}"));
        let child = Command::new("valgrind")
            .args(["--quiet", "--error-exitcode=9", "--leak-check=full"])
            .args(["--show-leak-kinds=definite,indirect,possible"])
            .args(["--errors-for-leak-kinds=definite,indirect,possible"])
            .arg(host)
            .args(arguments)
            .output();
        children.push((sample.name(), child.unwrap()));
    }
    for (name, output) in children {
        let logged = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{name}: {}: {logged}", output.status);
        assert!(!logged.contains("=="), "{name}: {logged}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn valgrind_finds_nothing() {
    under_valgrind(20);
}

#[test]
#[ignore = "minutes: cargo xtask stress"]
#[cfg(target_os = "linux")]
fn stress_valgrind_finds_nothing_in_10000_instances() {
    under_valgrind(10_000);
}
