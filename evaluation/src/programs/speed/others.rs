//! Packages other than SLICOT, at sizes they can do.

use super::{HORIZON, NOISE, ORDER, Outcome, drive, fit, ours, timed, white};
use std::path::Path;
use std::process::Command;
use steerwright_evaluation::peers::{Peers, write_signals};
use steerwright_evaluation::{Random, single_threaded};

/// Packages that need far more time, at sizes they can do.
pub(crate) fn others(path: &Path, peers: Option<&mut Peers>, longest: usize) -> Outcome<()> {
    let Some(peers) = peers else { return Ok(()) };
    println!("\nOthers, one run; ms");
    println!("| package | samples | time | here | fit, % | fit here, % |");
    println!("|---|---|---|---|---|---|");
    let all = [("sippy", 1_000), ("sippy", 10_000), ("nfoursid", 1_000)];
    for (name, count) in all.into_iter().filter(|(_, count)| *count <= longest) {
        let mut random = Random(count as u64);
        let u = white(count, &mut random);
        let signals = drive(u, NOISE, &mut random);
        write_signals(path, &signals.u, &signals.y)?;
        peers.load(path, count)?;
        let (here, mine) = timed(5, || ours(&signals.u, &signals.y));
        let mine = fit(&mine?.1.model, &signals);
        match peers.other(name, HORIZON, ORDER) {
            Ok(found) => println!(
                "| {name} | {count} | {:.1} | {:.3} | {:.3} | {mine:.3} |",
                1e3 * found.seconds,
                1e3 * here,
                fit(&found.model.model, &signals)
            ),
            Err(problem) => {
                println!("| {name} | {count} | {problem} | {:.3} | | {mine:.3} |", 1e3 * here)
            }
        }
    }
    Ok(())
}

/// Octave's `n4sid` where Octave and its package `control` are installed.
pub(crate) fn octave(path: &Path) -> Outcome<()> {
    const COUNT: usize = 10_000;
    let mut random = Random(COUNT as u64);
    let u = white(COUNT, &mut random);
    let signals = drive(u, NOISE, &mut random);
    write_signals(path, &signals.u, &signals.y)?;
    let script = format!(
        "pkg load control; f = fopen('{}'); u = fread(f, {COUNT}, 'double'); y = fread(f, {COUNT}, 'double'); d = iddata(y, u, 1); m = n4sid(d, {ORDER}, 's', {HORIZON}); t = cputime; for k = 1:5 m = n4sid(d, {ORDER}, 's', {HORIZON}); end; printf('%g', (cputime - t) / 5)",
        path.display()
    );
    let mut octave = Command::new("octave-cli");
    single_threaded(&mut octave);
    match octave.args(["--quiet", "--norc", "--eval", &script]).output() {
        Ok(output) if output.status.success() => {
            let seconds: f64 = String::from_utf8_lossy(&output.stdout).trim().parse()?;
            let (here, _) = timed(5, || ours(&signals.u, &signals.y));
            println!("| Octave n4sid | {COUNT} | {:.1} | {:.3} | | |", 1e3 * seconds, 1e3 * here);
        }
        Ok(output) => {
            let message = String::from_utf8_lossy(&output.stderr);
            println!("left out: Octave: {}", message.lines().next().unwrap_or("it failed"));
        }
        Err(problem) => println!("left out: Octave (octave-cli): {problem}"),
    }
    Ok(())
}
